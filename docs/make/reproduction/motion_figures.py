"""Figures 3–11 of the paper: the slider, the torques, the phase diagram and the section."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import linkages
from linkages.plots.chaos.chaos_figures import section
from linkages.plots.motion import time_figures
from linkages.plots.motion.phase_diagrams import coordinates, draw
from linkages.plots.panels import panels
from linkages.plots.style import BLACK, scale_of
from make.reproduction.maxima import SAMPLES
from make.reproduction.reported import STARTS, press

if TYPE_CHECKING:
    import xarray as xr

PERIOD = 2.0
"""Of the cranks, in seconds."""

SECTION_POINTS = 2000
ROWS = ("position", "velocity", "acceleration")
ZOOM = 0.02
"""Of a phase diagram: a few librations or rotations of the link, in seconds."""

FINE = 20
"""Samples for a phase curve, in units of those of the other figures."""


def runs() -> dict[str, xr.Dataset]:
    """One period from each of our initial conditions."""
    return {name: linkages.simulate(press(name), samples=SAMPLES).data for name in STARTS}


def slider_figure(data: xr.Dataset, start: str) -> Figure:
    """Figs. 3–8: motion of the slider on the left, its deviation from the ideal on the right."""
    figure, axes = panels(3, 2, 1.55)
    for row, name in enumerate(ROWS):
        left, right = axes[2 * row : 2 * row + 2]
        values, error = data[f"slider_{name}"], data[f"slider_{name}_error"]
        _draw_with_ideal(left, data, f"slider_{name}", (values - error).to_numpy()[:, 0])
        time_figures.draw(right, data, f"slider_{name}_error")
        for ax in (left, right):
            ax.set_title("")
            _finish(ax, row == len(ROWS) - 1)
    axes[0].set_title(f"{start}; dashed: ideal mechanism")
    axes[1].set_title("deviation from the ideal mechanism")
    return figure


def torque_figure(data: dict[str, xr.Dataset]) -> Figure:
    """Fig. 9, for both initial conditions."""
    figure, axes = panels(2, 2, 2.0)
    ideal = linkages.simulate(press().ideal(), samples=SAMPLES, outputs=["drive_effort"]).data
    for row, (name, run) in enumerate(data.items()):
        for column, crank in enumerate(("crank1", "crank4")):
            ax = axes[2 * row + column]
            torque = ideal.drive_effort.sel(drive=crank).to_numpy()
            _draw_with_ideal(ax, run.sel(drive=[crank]), "drive_effort", torque)
            ax.set_title(f"crank {crank[-1]}, {name} (dashed: ideal)")
            _finish(ax, row == 1)
            if column:
                ax.set_ylabel("")
    return figure


def _draw_with_ideal(ax: Axes, data: xr.Dataset, variable: str, ideal: np.ndarray) -> None:
    """A curve with clearance, and the one without on top of it."""
    time_figures.draw(ax, data, variable)
    factor = scale_of(data[variable].to_numpy(), str(data[variable].attrs["units"])).factor
    look = {"color": BLACK, "linewidth": 0.9, "linestyle": (0, (4, 2))}
    ax.plot(data.time, factor * ideal, **look)


def _finish(ax: Axes, last: bool) -> None:
    """Room for the text at the peak, which stays inside the axes."""
    ax.margins(y=0.22)
    if not last:
        ax.set_xlabel("")
    low, high = ax.get_xlim()
    for text in ax.texts:
        place = (text.xy[0] - low) / (high - low)
        text.set_horizontalalignment(
            "left" if place < 0.4 else "right" if place > 0.6 else "center"
        )


def phase_figure() -> Figure:
    """Fig. 10: angle against speed of the clearance, over a crank period and over a few turns."""
    figure, axes = panels(2, 2, 2.4)
    for column, name in enumerate(STARTS):
        mechanism = press(name)
        outputs = ["clearance_angle", "clearance_speed", "clearance_acceleration"]
        run = linkages.simulate(mechanism, samples=FINE * SAMPLES, outputs=outputs).data
        (coordinate,) = coordinates(run, mechanism)
        above, below = axes[column], axes[2 + column]
        draw(above, run, coordinate)
        above.set_title(f"{name}, one crank period")
        time, middle = run.time, PERIOD / 2
        part = run.isel(time=(time >= middle) & (time <= middle + ZOOM))
        draw(below, part, coordinate, start=False)
        below.set_title(f"{name}, {1e3 * ZOOM:.0f} ms at mid-period")
        below.set_xticks(above.get_xticks())
        below.set_xlim(above.get_xlim())
        below.set_ylim(above.get_ylim())
        above.set_xlabel("")
    for ax in (axes[1], axes[3]):
        ax.set_ylabel("")
    return figure


def section_figure() -> Figure:
    """Fig. 11: the Poincaré section at the period of the cranks."""
    figure, axes = panels(1, 2, 2.6)
    for ax, name in zip(axes, STARTS, strict=True):
        data = linkages.poincare(press(name), periods=SECTION_POINTS)
        section(data, ax=ax)
        ax.set_title(name)
    axes[1].set_ylabel("")
    return figure
