"""Wear over revolutions, depth around journal and bearing, lives; and a film of the depth."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from linkages.plots.films.animation import palette_of, write_gif
from linkages.plots.panels import axes_for, chart, joined, labelled, legend_above, named, panels
from linkages.plots.style import (
    BLACK,
    GREY,
    PALE,
    PALETTE,
    RAISED,
    WIDTH,
    Page,
    filled,
    line_style,
    name_of,
    path_words,
    scale_for,
    set_heading,
    show_powers,
    style,
    styled,
    title,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

SIDES = ("journal", "bearing")

FRAMES, FPS = 48, 12.0  # of a film; the last frame stays for a second
SMALL, SIDE = 4.4, 3.0  # inches: width of a film of one clearance, and of each polar diagram in it


def wear_figures(data: xr.Dataset) -> dict[str, Figure | None]:
    """Name → figure: sizes and work over revolutions, and depth around each journal.

    `data`: as `linkages.wear` returns it.
    """
    names = _turning(data)
    figures: dict[str, Figure | None] = {"wear": wear_figure(data)}
    figures["wear_depth"] = depth_figure(data, names, data.sizes["jump"] - 1.0) if names else None
    if "profile" in data:
        figures["wear_profile"] = profile_figure(data)
    return figures


@styled
def wear_figure(data: xr.Dataset) -> Figure:
    """Radial clearance with its error, and work of sliding, over revolutions."""
    result, (above, below) = panels(2, 1, 1.9, joined=True)
    wear(data, above)
    count = data["revolutions"].to_numpy()
    scale, words = _revolutions(count)
    for k, name in enumerate(data["clearance"].values):
        own = data.sel(clearance=name)
        below.errorbar(
            count * scale, own["work"], yerr=2 * own["work_error"], marker="o", markersize=2.5,
            capsize=2.0, elinewidth=0.8, **line_style(k), label=str(name),
        )  # fmt: skip
    below.set(xlabel=words, ylabel="work of sliding\nper revolution [J]")
    below.set_ylim(0.0, 1.1 * float((data["work"] + 2 * data["work_error"]).max()) or 1.0)
    joined(above)
    return result


@chart
def wear(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Radial clearances of `linkages.wear` over revolutions, with bands of their errors."""
    ax, count = axes_for(ax), data["revolutions"].to_numpy()
    factor, words = _revolutions(count)
    scale = scale_for(float(data["size"].max()), "m")
    for k, name in enumerate(data["clearance"].values):
        own = data.sel(clearance=name)
        size, error = (own[key].to_numpy() * scale.factor for key in ("size", "error"))
        look = line_style(k)
        ax.plot(count * factor, size, marker="o", markersize=2.5, **look, label=str(name))
        ax.fill_between(count * factor, size - error, size + error, color=look["color"], alpha=0.2,
                        linewidth=0)  # fmt: skip
    ax.set_xlim(0.0, count[-1] * factor)
    ax.set(xlabel=words, ylabel=scale.label("radial clearance"))
    ax.set_title(title(name_of(data), "wear"))
    if data.sizes["clearance"] > 1:
        ax.legend()
    return ax


def _revolutions(count: Array) -> tuple[float, str]:
    """Factor and words of an axis of revolutions."""
    for power, word in ((9, "billions of "), (6, "millions of "), (3, "thousands of ")):
        if count[-1] >= 10.0**power:
            return 10.0**-power, f"{word}revolutions"
    return 1.0, "revolutions"


def _turning(data: xr.Dataset) -> list[str]:
    """Clearances of journals; blocks have no angle."""
    worn = (data["depth"].isel(jump=-1) > 0.0).any(["side", "angle"])
    return [str(name) for name in data["clearance"].values[worn.values]]


@styled
def depth_figure(
    data: xr.Dataset, names: Sequence[str], place: float, width: float = WIDTH
) -> Figure:
    """Depth around journal and bearing, a row for each clearance, at a place among the jumps."""
    result = Page(len(names) * width / 2, width)
    axes = result.subplots(len(names), 2, squeeze=False)
    for row, name in zip(axes, names, strict=True):
        for ax, of in zip(row, SIDES, strict=True):
            _draw_depth(ax, data.sel(clearance=name), of, place)
    count = _spoken(_at(data["revolutions"].to_numpy(), place))
    set_heading(result, f"{name_of(data)}: depth after {count} revolutions")
    return result


def _spoken(count: float) -> str:
    power = int(np.floor(np.log10(count))) if count >= 1e6 else 0
    if not power:
        return f"{count:.0f}"
    return f"{count / 10.0**power:.2f}·10{str(power).translate(RAISED)}"


def _at(values: Array, place: float) -> Any:
    """Values at a place among the jumps, linearly between them."""
    before = min(int(place), len(values) - 1)
    after = min(before + 1, len(values) - 1)
    return values[before] + (place - before) * (values[after] - values[before])


@chart
def wear_depth(
    data: xr.Dataset, name: str | None = None, side: str = "bearing", ax: Axes | None = None
) -> Axes:
    """Depth around a journal or a bearing at the end of `linkages.wear`.

    `name`: The clearance; the first one if not given.
    `side`: ``journal`` or ``bearing``.
    """
    own = _clearance(data, name)
    return _draw_depth(axes_for(ax), own, side, data.sizes["jump"] - 1.0)


def _clearance(data: xr.Dataset, name: str | None) -> xr.Dataset:
    """Data of the clearance named, or of the first one."""
    known = [str(each) for each in data["clearance"].values]
    return data.sel(clearance=named(name, known, "clearance"))


def _draw_depth(ax: Axes, data: xr.Dataset, side: str, place: float) -> Axes:
    """Draw the depth of one clearance, enlarged, and what uniform wear would take."""
    own = data["depth"].sel(side=side)
    depths = own.transpose("jump", "angle").to_numpy()
    depth, largest = np.asarray(_at(depths, place)), float(depths[-1].max())
    closed = _closed(data["angle"].to_numpy())
    inward = -1.0 if side == "journal" else 1.0
    base, room = (1.0, 0.45) if side == "journal" else (0.62, 0.38)
    shown = base + inward * room * _closed(depth) / max(largest, 1e-300)
    mean = base + inward * room * float(depth.mean()) / max(largest, 1e-300)
    x, y = shown * np.cos(closed), shown * np.sin(closed)
    around = base * np.exp(1j * closed)
    ax.fill(
        np.concatenate([x, around.real[::-1]]), np.concatenate([y, around.imag[::-1]]),
        color=PALETTE[1], alpha=0.35, linewidth=0,
    )  # fmt: skip
    ax.plot(x, y, color=PALETTE[1], linewidth=1.2)
    ax.add_patch(Circle((0, 0), base, facecolor="none", edgecolor=BLACK, linewidth=0.8))
    ax.add_patch(
        Circle((0, 0), mean, facecolor="none", edgecolor=GREY, linewidth=0.8, linestyle="--")
    )
    name, most, mean_depth = data["clearance"].item(), depth.max(), depth.mean()
    ax.text(0.0, 0.0, f"{name}\n{side}", ha="center", va="center")
    return _around(ax, f"deepest {_length(most)}, all around {_length(mean_depth)}")


def _around(ax: Axes, said: str) -> Axes:
    """Directions around a picture of radius 1, without axes, and a text below it."""
    for turn in (0, 90, 180, 270):
        x, y = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        ax.text(1.13 * x, 1.13 * y, f"{turn}°", ha="center", va="center", color=GREY)
        ax.plot([0, 1.03 * x], [0, 1.03 * y], color=PALE, linewidth=0.5, zorder=0)
    ax.set(xlim=(-1.3, 1.3), ylim=(-1.4, 1.25), aspect="equal")
    ax.axis("off")
    ax.text(0.0, -1.36, said, ha="center")
    return ax


def _closed(around: Array) -> Array:
    """Values around a circle, the first one again at the end."""
    return np.append(around, around[:1])


@styled
def profile_figure(data: xr.Dataset) -> Figure:
    """Bearings that wear out of round, over revolutions."""
    names = [str(name) for name in data["clearance"].values]
    rows, columns = (len(names) + 1) // 2, min(len(names), 2)
    result = Page(rows * WIDTH / 2)
    for k, name in enumerate(names):
        wear_profile(data, name, result.add_subplot(rows, columns, k + 1))
    count = _spoken(float(data["revolutions"][-1]))
    set_heading(result, f"{name_of(data)}: bearing over {count} revolutions")
    return result


JOURNAL = 0.4
"""Radius of the journal in such a picture, over the largest one of its bearing."""

OUTLINES = 5
"""Profiles over revolutions in one picture, besides the first one."""


@chart
def wear_profile(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """A bearing that wears out of round, over the revolutions of `linkages.wear`.

    `data`: As `linkages.wear` returns it with ``feedback="profile"``.
    `name`: The clearance; the first one if not given.
    """
    if "profile" not in data:
        raise ValueError("bearings stay round here; expected wear with feedback='profile'")
    ax, data = axes_for(ax), _clearance(data, name)
    profile, count = data["profile"].to_numpy(), data["revolutions"].to_numpy()
    closed = _closed(data["angle"].to_numpy())
    largest = float(profile[-1].max())
    last = len(profile) - 1
    wanted = np.linspace(0.0, count[-1], min(OUTLINES, last) + 1)
    for place in np.interp(wanted, count, np.arange(len(count))):
        shown = JOURNAL + (1.0 - JOURNAL) * np.asarray(_at(profile, place)) / largest
        shown = _closed(shown)
        x, y = shown * np.cos(closed), shown * np.sin(closed)
        part = place / max(last, 1)
        if place == last:
            ax.fill(x, y, color=PALETTE[1], alpha=0.12, linewidth=0)
        look = {"color": BLACK if place == 0.0 else PALETTE[1], "linewidth": 0.8 + 0.6 * part}
        ax.plot(x, y, alpha=1.0 if place in (0.0, last) else 0.3 + 0.5 * part, **look)
    ax.add_patch(Circle((0, 0), JOURNAL, facecolor=PALE, edgecolor=GREY, linewidth=0.8))
    ax.text(0.0, 0.0, f"{data['clearance'].item()}\njournal", ha="center", va="center")
    return _around(ax, f"clearance of {_length(profile[0].max())} to {_length(largest)}")


def _length(value: float) -> str:
    return scale_for(value, "m").text(value)


def write_film(data: xr.Dataset, path: Path) -> None:
    """Write the depth around journals and bearings over revolutions as an animation (GIF)."""
    names = _turning(data) or [str(name) for name in data["clearance"].values[:1]]
    count = data["revolutions"].to_numpy()
    wanted = np.linspace(0.0, count[-1], FRAMES)
    places = np.interp(wanted, count, np.arange(len(count)))
    pictures = []
    for place in places:
        canvas = FigureCanvasAgg(depth_figure(data, names, place, SMALL))
        with style():
            canvas.draw()
        pictures.append(np.asarray(canvas.buffer_rgba()).copy())
    palette = palette_of([*pictures[:: FRAMES // 6], pictures[-1]])
    write_gif(path, [*pictures, *[pictures[-1]] * int(FPS)], palette, FPS)


@styled
def life_figure(data: xr.Dataset) -> Figure:
    """Parts of copies that are worn out, over revolutions, and how life depends on numbers.

    `data`: as `linkages.wear_life` returns it.
    """
    names = [str(name) for name in data["parameter"].values]
    height = max(2.0, 0.36 * len(names) + 0.4)
    result, axes = panels(1, 2 if names else 1, height)
    life(data, axes[0])
    if names:
        ends = data["ends"].to_numpy()
        order = np.argsort(np.abs(np.log(np.maximum(ends, 1e-300))).max(axis=1))
        places = np.arange(len(names))
        for k, colour in ((0, PALETTE[0]), (1, PALETTE[1])):
            values = ends[order, k]
            axes[1].barh(places - 0.2, 100 * (values - 1), height=0.4, color=colour,
                         label=("number at −σ", "number at +σ")[k])  # fmt: skip
        axes[1].axvline(0.0, color=BLACK, linewidth=0.8)
        axes[1].set_yticks(places, [filled(path_words(names[k]), 1.2) for k in order])
        axes[1].set_ylim(-0.6, len(names) - 0.4)
        axes[1].grid(visible=False, axis="y")
        axes[1].set_xlabel("change of life [%]")
        legend_above(axes[1], labelled(axes[1].containers))
    return result


@chart
def life(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Parts of copies that are worn out, of `linkages.wear_life`, over revolutions."""
    ax = axes_for(ax)
    relative, nominal = data["relative"].to_numpy(), float(data["nominal"])
    finite = np.sort(relative[~np.isnan(relative)])
    parts = (np.arange(len(finite)) + 0.5) / max(len(finite), 1)
    ax.step(np.append(finite, finite[-1:]) * nominal, 100 * np.append(parts, 1.0), where="post",
            color=PALETTE[0], label="wear rates of the file")  # fmt: skip
    spread = np.log(float(data.attrs["uncertainty"])) / 1.96
    if spread > 0.0 and len(finite):
        from scipy.special import ndtr

        logs = np.log(finite[np.isfinite(finite)] * nominal)
        count = np.geomspace(np.exp(logs.min() - 3 * spread), np.exp(logs.max() + 3 * spread), 300)
        worn = [float(ndtr((np.log(n) - logs) / spread).sum()) / len(finite) for n in count]
        ax.plot(count, 100 * np.array(worn), color=PALETTE[1], label="uncertain wear rates")
    for percent, value in zip(data["percent"].values, data["life_quantile"].values, strict=True):
        if np.isfinite(value):
            ax.plot([value], [percent], "o", color=PALETTE[1], markersize=4)
            ax.annotate(f"P{percent}", (value, percent), (5, -9), textcoords="offset points")
    ax.set(xscale="log", ylim=(0.0, 100.0))
    show_powers(ax.xaxis)
    ax.set_xlabel("revolutions")
    ax.set_ylabel("worn out [%]")
    legend_above(ax, labelled(ax.lines), title(name_of(data), "life"))
    return ax
