"""Traces of moving joints, with marks at equal times."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.inputs import law_values
from linkages.plots.mechanism.annotations import Labels
from linkages.plots.mechanism.drawing import framed, under
from linkages.plots.mechanism.inked_shapes import Inked, points_per_unit
from linkages.plots.mechanism.plane_view import BELOW, Box, frame, picture, room_in
from linkages.plots.mechanism.pose import pose_at
from linkages.plots.mechanism.roles import clearance_ends
from linkages.plots.style import line_style, nice_below, scale_for, styled

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

FEWEST = 12
"""Marks in a turn of the fastest drive, or in a motion without one; 2.5 times as many at most."""

HALF, WIDTH = 2.4, 0.8  # points: half the length of a mark, and how wide it is


def mark_times(data: xr.Dataset, mechanism: Mechanism) -> Array:
    """Times of marks within the first turn of a drive, or the whole motion; at least two samples.

    They are multiples of one, two or five times a power of ten, after the beginning.
    """
    time = np.asarray(data["time"], dtype=float)
    turn = _turn(time, mechanism)
    step = nice_below(turn / FEWEST)
    count = int(np.floor(turn / step * (1.0 + 1e-9)))
    forward = np.sign(time[-1] - time[0])  # a motion may go back in time
    return np.asarray(time[0] + forward * step * np.arange(1, count + 1))


def _turn(time: Array, mechanism: Mechanism) -> float:
    """How long the first turn of a drive takes; as long as the motion if there is none."""
    duration = float(abs(time[-1] - time[0]))
    result = [duration]
    for name, drive in mechanism.prescribed.items():
        if mechanism.bodies[name].rotates:
            gone = np.abs(law_values(drive.law, time) - law_values(drive.law, time[:1]))
            after = np.flatnonzero(gone >= 2.0 * np.pi * (1.0 - 1e-9))
            result += [float(abs(time[after[0]] - time[0]))] if len(after) else []
    return min(result)


def draw_marks(ax: Axes, path: Array, time: Array, at: Array, colour: str) -> None:
    """Draw marks across a path of shape (time, 2); there are none where the joint stands still.

    `path`, `time`: samples in the units of the axes, and their times.
    """
    moving = np.append(True, np.hypot(*np.diff(path, axis=0).T) > 0.0)
    known = np.isfinite(path).all(axis=1) & moving
    if known.sum() < 2:
        return
    path, time = path[known], time[known]
    at = at[(at >= time[0]) & (at <= time[-1])]
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    way = path[after] - path[after - 1]
    across = np.column_stack((-way[:, 1], way[:, 0])) / np.hypot(*way.T)[:, None]
    middle = np.column_stack([np.interp(at, time, column) for column in path.T])
    reach = HALF / points_per_unit(ax) * across
    gap = np.full_like(middle, np.nan)
    ends = np.stack((middle - reach, middle + reach, gap), axis=1).reshape(-1, 2)
    ax.plot(*ends.T, color=colour, linewidth=WIDTH, solid_capstyle="butt", zorder=2.4)


def note_marks(ax: Axes, at: Array) -> None:
    """Say below the axes how far marks are apart."""
    step = float(at[1] - at[0])
    text = f"marks every {scale_for(step, 's').text(step)}"
    below = -BELOW / (ax.bbox.height / ax.figure.dpi)
    ax.text(0.0, below, text, transform=ax.transAxes, va="top", color="0.35", gid="marks")


STILL = 1e-9  # of the picture's size: what moves less is at rest
COUPLER, LED = 1.8, 0.9  # points
DOT, AHEAD, HEAD = 2.6, 26.0, (7.0, 3.0)  # points: radius; from there to an arrow, and its size
SAME = 0.01  # of the picture's size: traces no farther apart look the same


@styled
def figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """Traces over the run; None for data without joint positions."""
    if not pose_at(data, mechanism, 0).positions:
        return None
    result, ax = picture(framed(data, mechanism)[1])
    draw(ax, data, mechanism)
    return result


def moving_joints(data: xr.Dataset, mechanism: Mechanism) -> dict[str, Array]:
    """Joints that move and their places, shape (time, 2), in metres.

    Points beside a pin with clearance are left out where their trace looks like the pin's, and
    places on the axes of blocks that have joints beside them.
    """
    array = data["joint_position"].transpose("time", "joint", "axis")
    places = np.asarray(array, dtype=float)
    size = Box.around(places).extent
    names = [str(name) for name in array["joint"].values]
    paths = {name: places[:, i] for i, name in enumerate(names)}
    hidden = {
        displaced
        for displaced, joint in clearance_ends(mechanism).items()
        if displaced in paths
        and joint in paths
        and not (np.abs(paths[displaced] - paths[joint]) > SAME * size).any()
    }
    hidden.update(mechanism.feet)
    return {
        name: path
        for name, path in paths.items()
        if name not in hidden and Box.around(path).extent > STILL * size
    }


def led_joints(mechanism: Mechanism) -> set[str]:
    """Joints that a pin or a guide on the ground leads along an arc or a line.

    All others draw coupler curves.
    """
    ground = set(mechanism.ground)
    return {
        joint
        for body in mechanism.bodies.values()
        if ground & set(body.points) or (body.guide is not None and body.guide.body is None)
        for joint in body.points
    }


def draw(ax: Axes, data: xr.Dataset, mechanism: Mechanism) -> Axes:
    """Draw the trace of each moving joint over the mechanism at the first sample.

    Coupler curves are thicker than the arcs and lines that the ground leads joints along. A dot
    says where each begins, an arrow which way it goes, and marks where it is at equal times. Every
    sample is a vertex, in vector graphics, too; the name of a joint is that of its path there. The
    data need at least one sample of ``joint_position``; the limits of the axes are set.
    """
    poses, box = framed(data, mechanism, room_in(ax))
    pose, scale = poses.at(0), frame(ax, box, mechanism)
    shapes = under(pose, points_per_unit(ax) * scale.factor)
    Inked(ax, shapes, pose.scaled(scale.factor), pale=True)
    names, led = moving_joints(data, mechanism), led_joints(mechanism)
    time = np.asarray(data["time"], dtype=float)
    at = mark_times(data, mechanism) if len(time) > 1 and names else np.empty(0)
    finite: dict[str, tuple[Array, str]] = {}
    with rc_context({"path.simplify": False}):
        for index, (name, path) in enumerate(names.items()):
            shown, colour = path * scale.factor, str(line_style(index)["color"])
            width = LED if name in led else COUPLER
            (line,) = ax.plot(*shown.T, color=colour, linewidth=width, gid=f"path-{name}")
            line.get_path().should_simplify = False
            known = shown[np.isfinite(shown).all(axis=1)]
            if len(known):
                finite[name] = known, colour
                _beginning(ax, known, colour)
                draw_marks(ax, shown, time, at, colour)
    if len(at):
        note_marks(ax, at)
    labels = Labels(ax)
    for name, (known, colour) in finite.items():
        labels.beside_curve(name, known, color=colour, weight="bold")
    labels.improve()
    return ax


def _beginning(ax: Axes, path: Array, colour: str) -> None:
    """A dot where a path begins, and the head of an arrow a little further on."""
    unit = points_per_unit(ax)
    ax.add_artist(Circle(tuple(path[0]), DOT / unit, facecolor=colour, edgecolor="white",
                         linewidth=0.6, zorder=2.6))  # fmt: skip
    gone = np.append(0.0, np.hypot(*np.diff(path, axis=0).T).cumsum())
    at = int(np.searchsorted(gone, min(AHEAD / unit, 0.5 * gone[-1])))
    if not 0 < at < len(path) or gone[-1] * unit < 3 * DOT:
        return
    way = path[at] - path[at - 1]
    size = np.hypot(*way)
    if size == 0.0:
        return
    way = way / size / unit
    across = np.array([-way[1], way[0]])
    corners = path[at] + np.array([HEAD[0] * way, HEAD[1] * across, -HEAD[1] * across])
    ax.add_artist(Polygon(corners, facecolor=colour, edgecolor="none", zorder=2.6))
