"""Equilibria over each other, vibration modes as drawings and films, and frequency responses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from linkages.equilibria.equilibrium import swing
from linkages.plots.films.animation import stage_palette, write_gif
from linkages.plots.films.film import Film
from linkages.plots.films.stage import Stage
from linkages.plots.mechanism.annotations import Labels
from linkages.plots.mechanism.drawing import reach, under
from linkages.plots.mechanism.inked_shapes import Inked, points_per_unit
from linkages.plots.mechanism.plane_view import Box, blank, frame, picture, small_pictures
from linkages.plots.mechanism.pose import Pose, Poses
from linkages.plots.panels import chart, labelled, legend_above, mosaic
from linkages.plots.style import (
    BLACK,
    PALETTE,
    figure_of,
    line_style,
    name_of,
    set_heading,
    set_title,
    show_powers,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr

    from linkages.components.mechanisms.mechanism import Mechanism

Array = NDArray[np.float64]

MOST_PANELS, ACROSS = 9, 3  # modes that a figure shows, and how many are beside each other
FRAMES, FPS = 40, 25.0  # of a film of a mode, which shows one period
ROWS = 1.9  # inches of the height of an amplitude diagram; half of it for the phase


def equilibrium_figures(data: xr.Dataset, mechanism: Mechanism) -> dict[str, Figure | None]:
    """Name → figure: positions, modes, and the frequency response of each equilibrium.

    `data`: as `linkages.equilibrium` returns it.
    """
    figures: dict[str, Figure | None] = {
        "equilibria": figure_of(equilibria(data, mechanism)),
        "modes": mode_figure(data, mechanism),
    }
    for k in data["equilibrium"].values.tolist():
        several = data.sizes["equilibrium"] > 1
        if data.sizes["input"] and data.sizes["output"]:
            figures[f"bode_{k}" if several else "bode"] = figure_of(bode(data, k))
    return figures


def poses_of(data: xr.Dataset, mechanism: Mechanism, dim: str) -> list[Pose]:
    """Positions along a dimension."""
    names = [name for name in ("joint_position", "bar_angle") if name in data]
    renamed = {} if dim == "time" else {dim: "time"}
    shown = data[names].drop_vars("time", errors="ignore").rename(renamed)
    places = shown["joint_position"].transpose("time", "joint", "axis").to_numpy()
    made = Poses(shown, mechanism, float(np.ptp(places.reshape(-1, 2), axis=0).max()) or None)
    poses = [made.at(k) for k in range(len(places))]
    travel = {}  # guides are drawn for all positions
    for name in mechanism.bodies:
        reaches = [axis.reach for pose in poses if (axis := pose.axis(name)) is not None]
        if reaches:
            travel[name] = min(reaches), max(reaches)
    return [replace(pose, travel=travel) for pose in poses]


def _around(poses: list[Pose]) -> Box:
    return Box.joined([reach(pose) for pose in poses])


@chart
def equilibria(data: xr.Dataset, mechanism: Mechanism, ax: Axes | None = None) -> Axes:
    """All positions of rest of `linkages.equilibrium` over each other, stable ones in full colours.

    Each has its number at the joint that moves most.

    `mechanism`: What rests there.
    """
    poses = poses_of(data, mechanism, "equilibrium")
    around = _around(poses)
    ax = picture(around)[1] if ax is None else ax
    scale = frame(ax, around, mechanism)
    stable = data["stable"].to_numpy() > 0
    moving = bool(data.attrs["moving"])
    full = stable if stable.any() else np.ones(len(poses), dtype=bool)
    labels = Labels(ax)
    shapes = under(poses[int(full.argmax())], points_per_unit(ax) * scale.factor)
    for own in (False, True):
        for pose, solid in zip(poses, full, strict=True):
            if solid == own:
                Inked(ax, shapes, pose.scaled(scale.factor), pale=not own)
    places = data["joint_position"].to_numpy() * scale.factor
    apart = np.ptp(places, axis=0).max(axis=1)
    joint = int(apart.argmax()) if apart.max() > 0 else -1
    for k, (own, solid) in enumerate(zip(places[:, joint], stable, strict=True), 1):
        if np.isfinite(own).all():
            colour = PALETTE[0] if solid else PALETTE[1]
            labels.beside_point(str(k), own, 6.0, fontsize=9, color=colour, weight="bold")
    words = f"{len(poses)} equilibri{'um' if len(poses) == 1 else 'a'}, {stable.sum()} stable"
    text = f"t = {data.attrs['time']:g} s" if moving else words
    set_title(ax, mechanism.name)
    ax.text(0.99, 0.01, text, transform=ax.transAxes, ha="right", va="bottom", color=BLACK)
    return ax


def _swinging(data: xr.Dataset) -> list[tuple[int, int]]:
    """Numbers of equilibria and of their modes that are drawn, stable equilibria first."""
    stable = data["stable"].to_series()
    result = []
    for k in sorted(stable.index, key=lambda k: -stable[k]):
        for m in data["mode"].values.tolist():
            one = data.sel(equilibrium=k, mode=m)
            dies = one["frequency"] == 0.0 and one["eigenvalue"].sel(part="real") < 0.0
            if np.isfinite(one["frequency"]) and not dies and one["mode_shape"].any():
                result.append((int(k), m))
    return result


@styled
def mode_figure(data: xr.Dataset, mechanism: Mechanism) -> Figure | None:
    """Modes of all equilibria: both ends of a swing, the one in full colours over the other."""
    chosen = _swinging(data)
    if not chosen:
        return None
    shown = chosen[:MOST_PANELS]
    columns = min(len(shown), ACROSS)
    phases = np.array([0.0, np.pi])
    each = [poses_of(swing(mechanism, data, k, m, phases), mechanism, "time") for k, m in shown]
    boxes = [_around(poses) for poses in each]
    heading = f"{mechanism.name}: vibration modes"
    if len(chosen) > len(shown):
        heading += f" ({len(shown)} of {len(chosen)})"
    shape = max(float(box.size[1] / max(box.size[0], 1e-9)) for box in boxes)
    result, axes = small_pictures(len(shown), columns, shape, heading)
    for ax, (k, m), poses, box in zip(axes, shown, each, boxes, strict=True):
        scale = frame(ax, box, mechanism, 0.25)
        blank(ax)
        ax.set_title("", loc="right")
        shapes = under(poses[0], points_per_unit(ax) * scale.factor)
        for pose, pale in ((poses[1], True), (poses[0], False)):
            Inked(ax, shapes, pose.scaled(scale.factor), pale=pale, size=0.8)
        ax.set_title(_mode_words(data, k, m), pad=3)
    return result


def _mode_words(data: xr.Dataset, k: int, m: int) -> str:
    """Whose mode it is, and how fast it is."""
    one = data.sel(equilibrium=k, mode=m)
    whose = f"{k}.{m}" if data.sizes["equilibrium"] > 1 else f"{m}"
    if float(one["frequency"]) == 0.0:
        rate = float(one["eigenvalue"].sel(part="real"))
        return f"{whose}  {one['mode_kind'].item()!s}" + (f", {rate:.4g} /s" if rate else "")
    words = f"{whose}  {float(one['frequency']):.4g} Hz"
    ratio = float(one["damping_ratio"])
    return words if abs(ratio) < 1e-7 else f"{words}, {100 * ratio:.3g} % damping"


def write_film(data: xr.Dataset, mechanism: Mechanism, k: int, m: int, path: Path) -> None:
    """Write one period of a vibration mode as an animation that repeats (GIF)."""
    period = 1.0 / float(data["frequency"].sel(equilibrium=k, mode=m))
    phases = 2 * np.pi * np.arange(FRAMES) / FRAMES
    scenes = swing(mechanism, data, k, m, phases)
    scenes = scenes.assign_coords(time=("time", period * np.arange(FRAMES) / FRAMES))
    film = Film(0.0, period / FRAMES, FRAMES, FPS)
    stage = Stage(scenes, mechanism, film)
    palette = stage_palette(stage, range(FRAMES), range(FRAMES))
    write_gif(path, map(stage.picture, range(FRAMES)), palette, FPS)


@chart
def bode(data: xr.Dataset, number: int = 1) -> Axes:
    """Frequency response of one of `linkages.equilibrium`, magnitudes above and phases below.

    `number`: Of the equilibrium.
    """
    count = data.sizes["input"]
    columns, rows = min(count, 3), -(-count // min(count, 3))
    places = [
        [
            k if k < 2 * count else -1
            for k in range(2 * row * columns + part, 2 * (row + 1) * columns, 2)
        ]
        for row in range(rows)
        for part in (0, 1)
    ]
    result, axes = mosaic(places, [ROWS, 0.5 * ROWS] * rows, joined=True)
    for index in range(count):
        _draw_response(axes[2 * index], axes[2 * index + 1], data, number, index)
    whose = f", equilibrium {number}" if data.sizes["equilibrium"] > 1 else ""
    set_heading(result, f"{name_of(data)}{whose}")
    return axes[0]


def _draw_response(upper: Axes, lower: Axes, data: xr.Dataset, k: int, index: int) -> None:
    """Draw the response of all outputs to one input."""
    name = str(data["input"].values[index])
    unit = str(data["input_unit"].values[index]).replace("^2", "²").replace(" ", "·")
    response = data["response"].sel(equilibrium=k).isel(input=index)
    frequency = data["response_frequency"].to_numpy()
    values = response.transpose("response_frequency", "output", "part").to_numpy() @ [1.0, 1.0j]
    for place, output in enumerate(data["output"].values):
        own = str(data["output_unit"].values[place])
        label = f"{output} [{own}/({unit})]"
        upper.plot(frequency, np.abs(values[:, place]), **line_style(place), label=label)
        phase = np.degrees(np.unwrap(np.angle(values[:, place])))
        lower.plot(frequency, phase, **line_style(place))
    upper.set(xscale="log")
    if np.abs(values).max() > 0:
        upper.set(yscale="log")
    legend_above(upper, labelled(upper.lines), f"to {name}")
    for axis in (upper.yaxis, lower.xaxis):
        show_powers(axis)
    lower.set_xlabel("frequency [Hz]")
    if index == 0:
        upper.set_ylabel("magnitude")
        lower.set_ylabel("phase [°]")
    low, high = lower.get_ylim()
    lower.set_yticks(np.arange(90 * np.floor(low / 90), 90 * np.ceil(high / 90) + 1, 90))
