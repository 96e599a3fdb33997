"""Path of a pin in its hole, and of a block in its guide."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from numpy.typing import NDArray

from linkages.components.contributed.normal_forces import Contact, CornerAtWall
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.motion.compared import resolved, with_samples
from linkages.plots.panels import axes_for, chart, diagram_each, legend_above, named, time_axis
from linkages.plots.style import (
    BLACK,
    PALETTE,
    axis_scale,
    figure_of,
    name_of,
    scale_for,
    styled,
    title,
)

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

Array = NDArray[np.float64]

ROUND = 1e-6  # part of its radius by which the border of a hole may differ from a circle
ROOM = 1.12  # half the picture over the largest offset and the largest angle


def corners_of(mechanism: Mechanism) -> dict[str, tuple[str, ...]]:
    """Clearance of a guide → its corners, as results name them."""
    result: dict[str, tuple[str, ...]] = {}
    for contact in mechanism.contacts:
        if isinstance(contact.geometry, CornerAtWall):
            name = contact.geometry.play.name
            result[name] = (*result.get(name, ()), contact.name)
    return result


def free_offset(contact: Contact, angle: Array) -> Array:
    """Largest offset in metres at which a block at some angles in its guide touches no wall."""
    corner = contact.geometry
    assert isinstance(corner, CornerAtWall)
    length, height = corner.length.value, corner.height.value
    reach = 0.5 * (length * np.abs(np.sin(angle)) + height * np.cos(angle))
    return np.asarray(corner.size.value + 0.5 * height - reach)


def draw_path(ax: Axes, data: xr.Dataset, contact: Contact, corners: Sequence[str]) -> Array:
    """Draw the border within which no corner touches; return the way in units of the axes.

    Returns: shape (time, 2): angles, and offsets of the middle of the block.
    """
    size, corner = contact.size.value, contact.geometry
    assert isinstance(corner, CornerAtWall)
    across = data["clearance_offset"].sel(clearance=list(corners), axis="y")
    rear, front, _, opposite = np.asarray(across.transpose("clearance", "time"), dtype=float)
    angle, offset = np.arcsin((front - rear) / corner.length.value), 0.5 * (rear + opposite)
    scale = scale_for(size, "m")
    widest = 2.0 * size / corner.length.value
    while free_offset(contact, np.array(widest)) > 0.0:
        widest *= 1.05
    border = np.linspace(-widest, widest, 801)
    border = border[free_offset(contact, border) >= 0.0]
    limit = free_offset(contact, border) * scale.factor
    turn = axis_scale(border, "rad")
    for sign in (-1.0, 1.0):
        ax.plot(turn.factor * border, sign * limit, color=BLACK, linewidth=1.0, zorder=3)
    tilted = float(np.abs(angle).max())
    # an orbit that hardly tilts would be a hair in the middle: the border is cut off then
    half = turn.factor * max(tilted, min(widest, 4.0 * tilted) if tilted else widest) * ROOM
    reach = scale.factor * max(size, float(np.abs(offset).max())) * ROOM
    ax.set(xlim=(-half, half), ylim=(-reach, reach), aspect="auto")
    ax.set_xlabel(turn.label("angle in the guide"))
    ax.set_ylabel(scale.label("offset"))
    return np.stack([turn.factor * angle, scale.factor * offset], axis=1)


SHOWN = ("clearance_offset", "clearance_indentation", "clearance_state")
"""What figures need of the data."""

STATES = ("free flight", "impact", "following contact")  # by the values of ``clearance_state``
COLOURS = ("#B4B4B4", PALETTE[1], PALETTE[0])

LINE = {0: 0.6, 1: 1.4, 2: 1.4}
STRIP = 0.36  # inches: height of a strip of states


@styled
def orbit_figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """A picture for each clearance whose contact may open; None if there is none."""
    corners = corners_of(mechanism)
    at_blocks = {corner for item in corners.values() for corner in item}
    names = [name for name in holes(data) if name not in at_blocks]
    names += [name for name, item in corners.items() if set(item) <= {*opening(data)}]

    def draw(ax: Axes, name: str, heading: str) -> None:
        whose = title(heading, name)
        if name in corners:
            _draw_block(ax, data, mechanism, corners[name], whose)
        else:
            _draw_pin(ax, data.sel(clearance=name), whose)

    return diagram_each(names, draw, mechanism.name)


def opening(data: xr.Dataset) -> list[str]:
    """Clearances whose contact may open, if there are samples; massless links have no offset."""
    if "clearance_offset" not in data or not data.sizes["time"]:
        return []
    known = data["clearance_offset"].notnull().any(["time", "axis"])
    return [str(name) for name in known["clearance"].values[known.values]]


def holes(data: xr.Dataset) -> list[str]:
    """Those in which nothing touches within a circle: not corners of blocks, nor straight walls."""
    if not opening(data):
        return []
    rims = {name: _rims(data.sel(clearance=name)) for name in opening(data)}
    return [name for name, rim in rims.items() if np.ptp(rim) <= ROUND * abs(float(rim[0]))]


def _rims(data: xr.Dataset) -> Array:
    """How far from the middle something touches, at each sample, in the direction of the offset."""
    offset = np.asarray(data["clearance_offset"].transpose("time", "axis"), dtype=float)
    indentation = np.asarray(data["clearance_indentation"], dtype=float)
    return np.asarray(np.hypot(*offset.T) - indentation)


@chart
def clearance_orbit(
    source: Solution | xr.Dataset, name: str | None = None, ax: Axes | None = None
) -> Axes:
    """The way of a pin in its hole, where contact may open: of the clearance named, or the first.

    `name`: The clearance.
    """
    data = resolved(source, SHOWN)
    own = named(name, holes(data), "clearance whose contact may open")
    return _draw_pin(axes_for(ax), data.sel(clearance=own), own)


def _draw_pin(ax: Axes, data: xr.Dataset, heading: str) -> Axes:
    """Draw the offset of one clearance in the circle in which nothing touches."""
    offset = np.asarray(data["clearance_offset"].transpose("time", "axis"), dtype=float)
    size = float(np.median(_rims(data)))
    scale = scale_for(size, "m")
    ax.add_patch(Circle((0, 0), size * scale.factor, facecolor="none", edgecolor=BLACK, zorder=3))
    ax.add_collection(_segments(offset * scale.factor, np.asarray(data["clearance_state"])))
    reach = scale.factor * max(ROOM * size, 1.02 * float(np.hypot(*offset.T).max()))
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    ax.set_xlabel(scale.label("offset x"))
    ax.set_ylabel(scale.label("offset y"))
    _legend(ax, heading, float(data["clearance_indentation"].max()))
    return ax


def _draw_block(
    ax: Axes, data: xr.Dataset, mechanism: Mechanism, corners: Sequence[str], heading: str
) -> None:
    """Draw offset over angle of a block in its guide, within the border where a corner touches."""
    contact = next(contact for contact in mechanism.contacts if contact.name == corners[0])
    here = data.sel(clearance=list(corners))
    state = np.asarray(here["clearance_state"].max("clearance"))
    ax.add_collection(_segments(draw_path(ax, data, contact, corners), state))
    _legend(ax, heading, float(here["clearance_indentation"].max()))


def _legend(ax: Axes, heading: str, deepest: float) -> None:
    """The states, below what touches and how deep."""
    said = "no contact"
    if deepest > 0:
        result = scale_for(deepest, "m")
        said = f"deepest {result.factor * deepest:.3g} {result.units}"
    handles = [Line2D([], [], color=c, linewidth=1.6) for c in COLOURS]
    entries = dict(zip(STATES, handles, strict=True))
    legend_above(ax, entries, f"{heading}, {said}", handlelength=1.2)


def _segments(offset: Array, state: NDArray) -> LineCollection:
    """From sample to sample, in the colour of where they lead from; contact lies on top."""
    pairs = np.stack([offset[:-1], offset[1:]], axis=1)
    begun = np.asarray(state[:-1], dtype=int)
    order = np.argsort(begun, kind="stable")
    return LineCollection(
        list(pairs[order]),
        colors=[COLOURS[k] for k in begun[order]],
        linewidths=[LINE[int(k)] for k in begun[order]],
        capstyle="round",
        zorder=2,
    )


@styled
def state_figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """Free flight, impacts and following contact over time; None if no contact may open."""
    if not opening(data) or data.sizes["time"] < 2:
        return None
    return figure_of(_draw_states(None, data, mechanism.name))


@chart
def clearance_state(source: Solution | xr.Dataset, ax: Axes | None = None) -> Axes:
    """Free flight, impacts and following contact over time, where contact may open."""
    data = with_samples(resolved(source, SHOWN), "clearance_state")
    return _draw_states(ax, data, name_of(data))


def _draw_states(ax: Axes | None, data: xr.Dataset, heading: str) -> Axes:
    """Draw a strip for each clearance whose contact may open."""
    names = opening(data)
    ax = axes_for(ax, STRIP * len(names))
    scale = time_axis(ax, data["time"])
    time = np.asarray(data["time"], dtype=float) * scale.factor
    for row, name in enumerate(reversed(names)):
        state = np.asarray(data["clearance_state"].sel(clearance=name), dtype=int)
        edges = np.flatnonzero(np.diff(state)) + 1  # a state lasts until the next sample
        first, last = np.append(0, edges), np.append(edges, len(time) - 1)
        for value, colour in enumerate(COLOURS):
            own = state[first] == value
            begin, end = time[first[own]], time[last[own]]
            spans = list(zip(begin, end - begin, strict=True))
            ax.broken_barh(spans, (row - 0.32, 0.64), facecolor=colour, linewidth=0)
    name_rows(ax, names)
    result = zip(STATES, shares(data, names), strict=True)
    entries = [f"{state}: {100 * share:.3g} %" for state, share in result]
    said = "share of time" if len(names) == 1 else "mean share of time"
    handles = [Patch(color=colour) for colour in COLOURS]
    legend_above(ax, dict(zip(entries, handles, strict=True)), title(heading, said))
    return ax


def name_rows(ax: Axes, names: Sequence[str]) -> None:
    """Name rows of strips at the left, from the top."""
    ax.set_ylim(-0.6, len(names) - 0.4)
    ax.set_yticks(range(len(names)), [name.replace(".", "\n") for name in reversed(names)])
    ax.tick_params(axis="y", length=0)
    ax.grid(visible=False, axis="y")


def shares(data: xr.Dataset, names: list[str]) -> list[float]:
    """Part of the time in each state, over all clearances named."""
    time = np.asarray(data["time"], dtype=float)
    state = np.asarray(data["clearance_state"].sel(clearance=names).transpose("time", "clearance"))
    weight = np.diff(time)[:, None] / (time[-1] - time[0]) / len(names)
    return [float((weight * (state[:-1] == value)).sum()) for value in range(len(STATES))]
