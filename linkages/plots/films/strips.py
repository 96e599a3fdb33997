"""Curves over time below a film, with a cursor where the film is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from linkages.plots.films.film import Film
from linkages.plots.prefixes import scale_of
from linkages.plots.style import CLEARANCE, line_style

if TYPE_CHECKING:
    import xarray as xr

ROOM = 0.08
"""Of the height, above and below a curve."""


class Strip:
    """A curve over the time of a film.

    Parameters
    ----------
    ax
        Where to draw.
    name, series
        Of the curve, and its values over ``time``, in SI units.
    film
        Which part is shown.
    """

    def __init__(self, ax: Axes, name: str, series: xr.DataArray, film: Film) -> None:
        time, values = np.asarray(series["time"], float), np.asarray(series, float)
        units = str(series.attrs.get("units", ""))
        if units == "rad":
            values, units = np.rad2deg(values), "°"
        scale, self._scale = scale_of(values, units), scale_of(film.times, "s")
        ax.plot(time * self._scale.factor, values * scale.factor, color=line_style(0)["color"])
        ends = np.sort([film.start, film.start + film.frames * film.step]) * self._scale.factor
        ax.set_xlim(*ends)
        ax.margins(y=ROOM)
        ax.set_xlabel(self._scale.label("time"))
        ax.set_ylabel(f"[{scale.units}]" if scale.units else "")
        ax.set_title(name)
        self._line = ax.axvline(ends[0], color=CLEARANCE, linewidth=1.2)
        self._line.set_animated(True)

    @property
    def cursor(self) -> Line2D:
        """What moves."""
        return self._line

    def show(self, time: float) -> None:
        """Put the cursor at a time in seconds."""
        x = float(time) * self._scale.factor
        self._line.set_xdata([x, x])
