"""Figures 3–11 of the paper: the slider, the torques, the phase diagram and the section."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import linkages
from linkages.plots.chaos import sections
from linkages.plots.motion import phase, time_figures
from linkages.plots.prefixes import scale_of
from linkages.plots.style import BLACK, panels, styled
from reproduction.maxima import SAMPLES
from reproduction.reported import STARTS, press

if TYPE_CHECKING:
    import xarray as xr

PHASE_PERIODS = 1
SECTION_POINTS = 500
ROWS = ("position", "velocity", "acceleration")
ROOM, SAVED = 0.36, 0.22
"""Space above a panel, and what is saved below one without a label, in inches."""


def runs() -> dict[str, xr.Dataset]:
    """One period from each of our starts."""
    return {name: linkages.simulate(press(name), samples=SAMPLES).data for name in STARTS}


@styled
def slider_figure(data: xr.Dataset, start: str) -> Figure:
    """Figs. 3–8: motion of the slider on the left, its errors on the right."""
    figure, axes = panels(3, 2, 1.55, ROOM)
    _closer(figure, axes)
    for row, name in enumerate(ROWS):
        left, right = axes[2 * row : 2 * row + 2]
        values, error = data[f"slider_{name}"], data[f"slider_{name}_error"]
        _draw_with_ideal(left, data, f"slider_{name}", (values - error).to_numpy()[:, 0])
        time_figures.draw(right, data, f"slider_{name}_error")
        left.set_title(f"{start} start; dashed: ideal")
        right.set_title("error against the ideal mechanism")
        _finish(left, row == 2)
        _finish(right, row == 2)
    return figure


@styled
def torque_figure(data: dict[str, xr.Dataset]) -> Figure:
    """Fig. 9, for both starts."""
    figure, axes = panels(2, 2, 2.0, ROOM)
    _closer(figure, axes)
    ideal = linkages.simulate(press().ideal(), samples=SAMPLES, outputs=["drive_effort"]).data
    for row, (name, run) in enumerate(data.items()):
        for column, crank in enumerate(("crank1", "crank4")):
            ax = axes[2 * row + column]
            torque = ideal.drive_effort.sel(drive=crank).to_numpy()
            _draw_with_ideal(ax, run.sel(drive=[crank]), "drive_effort", torque)
            ax.set_title(f"crank {crank[-1]}, {name} start; dashed: ideal")
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


def _closer(figure: Figure, axes: list[Axes]) -> None:
    """Only the last row has labels below: the others use that room."""
    height = figure.get_size_inches()[1]
    for ax in axes[:-2]:
        box = ax.get_position()
        ax.set_position([box.x0, box.y0 - SAVED / height, box.width, box.height + SAVED / height])


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


@styled
def phase_figure() -> Figure:
    """Fig. 10: angle against speed of the clearance over some periods."""
    figure, axes = panels(1, 2, 2.6)
    for ax, name in zip(axes, STARTS, strict=True):
        mechanism = press(name)
        solution = linkages.simulate(
            mechanism,
            end=2.0 * PHASE_PERIODS,
            samples=4000 * PHASE_PERIODS + 1,
            outputs=["clearance_angle", "clearance_speed", "clearance_acceleration"],
        )
        (coordinate,) = phase.coordinates(solution.data, mechanism)
        phase.draw(ax, solution.data, coordinate)
        for line in ax.lines[:-1]:
            line.set_linewidth(0.25)
        ax.set_title(f"{name} start")
    axes[1].set_ylabel("")
    return figure


@styled
def section_figure() -> Figure:
    """Fig. 11: the Poincaré section at the period of the cranks."""
    figure, axes = panels(1, 2, 2.6)
    for ax, name in zip(axes, STARTS, strict=True):
        data = linkages.poincare(press(name), periods=SECTION_POINTS)
        (coordinate,) = sections.free_coordinates(data)
        sections.draw(ax, data, coordinate)
        ax.set_title(f"{name} start")
    axes[1].set_ylabel("")
    return figure
