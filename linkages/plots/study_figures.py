"""Figures of sweeps, sensitivities, tolerances, optimisation and benchmarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.benchmark.work_precision import Point
from linkages.plots import style
from linkages.plots.chaos.diagrams import show_path, shown_values
from linkages.plots.style import (
    BLACK,
    GREY,
    PALETTE,
    TOP,
    WIDTH,
    Scale,
    diagrams,
    fitted,
    legend_above,
    line_style,
    panels,
    scale_of,
    show_powers,
    styled,
)

if TYPE_CHECKING:
    import xarray as xr

    from linkages.design.sensitivities import Effect
    from linkages.solution.solution import Solution

MOST_PANELS = 8
"""Series that are drawn, one below the other."""


def _labelled(name: str, units: str, inches: float) -> str:
    return style.fitted(f"{name} [{units}]" if units else name, inches)


@styled
def convergence(data: xr.Dataset) -> Figure:
    """The goal of every run, and the best so far; circles are runs that miss a constraint."""
    figure, (ax,) = panels(1, 1, 3.2, top=0.45)
    run = np.arange(1, data.sizes["run"] + 1)
    holds = data["history_violation"].to_numpy() == 0.0
    values, best = data["history_value"].to_numpy(), data["history"].to_numpy()
    ax.plot(run[holds], values[holds], ".", color=GREY, markersize=3, label="each run")
    if not holds.all():
        look: dict[str, Any] = {"color": GREY, "markersize": 3, "fillstyle": "none"}
        ax.plot(run[~holds], values[~holds], "o", label="constraints not met", **look)
    ax.step(run, best, where="post", color=PALETTE[0], label="best so far")
    known = values[np.isfinite(values)]
    if len(known):
        low = np.quantile(known, 0.05, method="lower")  # a few runs may be far away
        high = np.quantile(known, 0.95, method="higher")
        ends = [low, high, float(data["value"][1]), *best[np.isfinite(best)][:1]]
        middle = 0.5 * (max(ends) + min(ends))
        # ticks of a few digits differ, however little the runs do
        half = max(0.55 * (max(ends) - min(ends)), 0.005 * abs(middle)) or 1.0
        ax.set_ylim(middle - half, middle + half)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_xlabel("run")
    attrs = data["history"].attrs
    ax.set_ylabel(_labelled(str(attrs["long_name"]), str(attrs["units"]), 3.2))
    ax.legend(**legend_above(str(data.attrs["name"])), ncols=3)
    return figure


@styled
def fit_curves(data: xr.Dataset) -> Figure:
    """What goal and constraints reduce, over time, before and after."""
    count = min(data.sizes["series"], MOST_PANELS)
    figure, axes = panels(count, 1, 3.2 if count == 1 else 1.9, top=0.45)
    time = data["time"].to_numpy()
    for place, ax in enumerate(axes):
        before, after = data["curve"].to_numpy()[:, place]
        ax.plot(time, before, color=GREY, linestyle=(0, (5, 1.6)), label="start")
        ax.plot(time, after, color=PALETTE[0], label="optimum")
        name, units = str(data["series"][place].item()), str(data["series_units"][place].item())
        ax.set_ylabel(_labelled(name, units, 3.2 if count == 1 else 1.9))
        ax.margins(x=0)
    axes[-1].set_xlabel("time [s]")
    axes[0].legend(**legend_above(str(data.attrs["name"])), ncols=2)
    return figure


@styled
def fit_figure(data: xr.Dataset) -> Figure:
    """Measurements with the fitted motion, and residuals below, of each output."""
    count = min(data.sizes["series"], MOST_PANELS // 2)
    figure, axes = panels(2 * count, 1, 1.7, top=0.4)
    time = data["time"].to_numpy()
    for place in range(count):
        above, below = axes[2 * place : 2 * place + 2]
        measured, computed, residual = (
            data[name].to_numpy()[place] for name in ("measured", "computed", "residual")
        )
        known = np.isfinite(measured)
        above.plot(time[known], measured[known], ".", color=GREY, markersize=3, label="measured")
        above.plot(time[known], computed[known], color=PALETTE[0], label="fit")
        name, units = str(data["series"][place].item()), str(data["series_units"][place].item())
        above.set_ylabel(_labelled(name, units, 1.7))
        below.axhline(0.0, color=PALETTE[0], linewidth=0.8)
        below.plot(time[known], residual[known], ".", color=GREY, markersize=3)
        below.set_ylabel("residual / sigma" if data.attrs["sigma_known"] else f"residual [{units}]")
        for ax in (above, below):
            ax.set_xlim(time[0], time[-1])
    axes[-1].set_xlabel("time [s]")
    axes[0].legend(**legend_above(str(data.attrs["name"])), ncols=2)
    return figure


MOST_VARIANTS = 3
"""Assembly branches and senses of which paths are drawn."""


def fitted_points(data: xr.Dataset) -> list[str]:
    """Joints of which both coordinates were measured."""
    names = [str(name) for name in data["series"].to_numpy()]
    found = [name.removesuffix(".x position") for name in names if name.endswith(".x position")]
    return [joint for joint in found if f"{joint}.y position" in names]


@styled
def fit_path(data: xr.Dataset, joint: str, found: Mapping[str, Solution]) -> Figure:
    """Measured points of a joint and its path, in the best variants; the links of the best one."""
    figure = Figure(figsize=(WIDTH, 0.75 * WIDTH), layout="constrained")
    ax = figure.add_subplot(aspect="equal")
    points = np.array([data["measured"].sel(series=f"{joint}.{a} position") for a in "xy"])
    best = next(iter(found.values()))
    places = best.data["joint_position"]
    scale = scale_of(places.to_numpy(), "m")
    for body in filter(lambda body: body.points, best.mechanism.bodies.values()):
        outline = [places.sel(joint=name)[0] for name in body.points]
        x, y = scale.factor * np.array([*outline, *outline[: len(outline) > 2]]).T
        ax.plot(x, y, color=GREY, linewidth=2.5, alpha=0.5, marker="o", markersize=4)
    for place, (name, solution) in enumerate(found.items()):
        path = scale.factor * solution.data["joint_position"].sel(joint=joint).to_numpy()
        ax.plot(*path.T, label=name or "fit", **line_style(place), zorder=3 - 0.1 * place)
    ax.plot(*(scale.factor * points), ".", color=BLACK, markersize=6, label="points", zorder=4)
    ax.set(xlabel=f"x [{scale.units}]", ylabel=f"y [{scale.units}]")
    figure.suptitle(f"{data.attrs['name']}: path of {joint}", fontsize="medium", wrap=True)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


MOST_EFFECTS, MOST_CURVES = 12, 5
ROUND_OFF = 1e-9

PATHS, LEGEND = 0.12, 0.7
"""Part of the width that paths take, and inches above curves that names take."""


@styled
def sensitivity_figure(data: xr.Dataset, effects: Mapping[str, Sequence[Effect]]) -> Figure | None:
    """Bars of relative sensitivities, a panel for each measure; None if no number has one."""
    shown = {text: _relative_effects(item) for text, item in effects.items()}
    shown = {text: item for text, item in shown.items() if item}
    if not shown:
        return None
    most = max(map(len, shown.values()))
    result, axes = panels(len(shown), 1, 0.3 + 0.22 * most)
    for ax, (text, found) in zip(axes, shown.items(), strict=True):
        left, bottom, width, height = ax.get_position().bounds
        ax.set_position((left + PATHS, bottom, width - PATHS, height))
        bars(ax, found)
        ax.set_ylim(most - 0.5, -0.5)
        ax.set_title(fitted(f"{data.attrs['name']}: {text}", 4.4))
    return result


def bars(ax: Axes, effects: Sequence[Effect]) -> Axes:
    """Draw how many percent a measure changes for one percent of each number."""
    values = [effect.relative or 0.0 for effect in effects]
    colors = [PALETTE[0] if value >= 0.0 else PALETTE[1] for value in values]
    ax.barh(np.arange(len(effects)), values, color=colors, height=0.7)
    ax.set_yticks(np.arange(len(effects)), [fitted(e.parameter, 1.8) for e in effects])
    ax.set_ylim(len(effects) - 0.5, -0.5)
    ax.axvline(0.0, color="0.3", linewidth=0.8)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("change of the measure for 1 % of the number [%]")
    return ax


@styled
def sensitivity_curves(data: xr.Dataset) -> Figure | None:
    """Changes of series for one percent of the numbers that do most; None without series."""
    series = [str(name) for name, array in data.data_vars.items() if "time" in array.dims]
    if not series:
        return None
    result, axes = panels(len(series), 1, 2.2, LEGEND)
    for ax, name in zip(axes, series, strict=True):
        change(ax, data, name)
    return result


def change(ax: Axes, data: xr.Dataset, name: str) -> Axes:
    """Draw how a series changes with one percent of each of the numbers that do most."""
    changes = 0.01 * data[name].values * data["parameter_value"].values
    sizes = np.abs(np.nan_to_num(changes, nan=0.0)).max(axis=0)
    chosen = [k for k in np.argsort(-sizes, kind="stable")[:MOST_CURVES] if sizes[k] > 0.0]
    for index, k in enumerate(chosen):
        path = str(data["parameter"].values[k])
        ax.plot(data["time"], changes[:, k], label=fitted(path, 2.2), **line_style(index))
    unit = str(data[name].attrs["units"]).partition(" / ")[0]
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"change [{unit}]")
    if chosen:
        ax.legend(**legend_above(f"change of {name} for 1 % of a number"), ncols=3)
    return ax


def _relative_effects(effects: Sequence[Effect]) -> list[Effect]:
    """Those that are more than round-off of the largest one."""
    largest = max((abs(effect.relative or 0.0) for effect in effects), default=0.0)
    return [e for e in effects if abs(e.relative or 0.0) > ROUND_OFF * largest][:MOST_EFFECTS]


DRAW = "draw"
BAND = 0.05, 0.95
"""Quantiles between which a band lies."""

MOST_BINS = 60

FEW = 6
"""Values that are a list and no range: they get a line or a tick each."""

MARKED = 50
"""Points from which on a line needs no marks."""

Array = NDArray[np.float64]


@styled
def sweep_figure(data: xr.Dataset, name: str) -> Figure | None:
    """A measure over its one or two dimensions; None if there are more, or nothing to show."""
    array = data[name]
    if array.ndim > 2 or not np.isfinite(array).any():
        return None
    result, (ax,) = diagrams(1)
    draw_sweep(ax, data, name)
    return result


def draw_sweep(ax: Axes, data: xr.Dataset, name: str) -> Axes:
    """Draw a measure."""
    array = data[name]
    units = str(array.attrs.get("units", ""))
    label = f"{name} [{units}]" if units else name
    title = fitted(str(data.attrs.get("name", "")), 4.4)
    dims = [str(dim) for dim in array.dims]
    if dims == [DRAW]:
        _histogram(ax, array.to_numpy(), label)
    elif DRAW in dims:
        _spread(ax, data, array, label)
    elif len(dims) == 2 and min(array.shape) > FEW:
        up, along = dims
        x, y = show_path(ax, "x", data, along), show_path(ax, "y", data, up)
        image = ax.pcolormesh(x, y, array.to_numpy(), rasterized=True)
        ax.figure.colorbar(image, ax=ax, label=label)
    elif len(dims) == 2:
        several, along = sorted(dims, key=lambda dim: data.sizes[dim])
        across, heading = shown_values(data, several)
        for place, value in enumerate(across):
            _line(ax, data, array.isel({several: place}), label, f"{value:.6g}", place)
        ax.legend(**legend_above(", ".join(filter(None, (title, heading)))), ncols=len(across))
        return ax
    else:
        _line(ax, data, array, label)
    ax.set_title(title)
    return ax


def _histogram(ax: Axes, values: Array, label: str) -> None:
    values = values[np.isfinite(values)]
    bins = min(MOST_BINS, max(1, round(len(values) ** 0.5)))
    ax.hist(values, bins=bins, color=PALETTE[0])
    ax.set_xlabel(label)
    ax.set_ylabel("draws")


def _spread(ax: Axes, data: xr.Dataset, array: xr.DataArray, label: str) -> None:
    """The median of draws, and a band or bars in which most of them lie."""
    (dim,) = (str(dim) for dim in array.dims if dim != DRAW)
    values = _shown_along(ax, data, dim)
    low, middle, high = array.quantile([BAND[0], 0.5, BAND[1]], DRAW).to_numpy()
    if len(values) <= FEW:
        apart = np.stack([middle - low, high - middle])
        ax.errorbar(values, middle, apart, fmt="o", color=PALETTE[0], capsize=4)
    else:
        ax.fill_between(values, low, high, color=PALETTE[0], alpha=0.3, linewidth=0)
        ax.plot(values, middle, color=PALETTE[0])
    ax.set_ylabel(label)


def _line(
    ax: Axes, data: xr.Dataset, array: xr.DataArray, label: str, name: str = "", place: int = 0
) -> None:
    """A measure over one dimension; one of several lines if it has a name."""
    values = _shown_along(ax, data, str(array.dims[0]))
    few = len(values) <= FEW
    look = line_style(place) | {"marker": "o" if few else "." if len(values) < MARKED else ""}
    ax.plot(values, array.to_numpy(), label=name or None, **look)
    ax.set_ylabel(label)


def _shown_along(ax: Axes, data: xr.Dataset, dim: str) -> Array:
    """Values along the axis to the right, which has ticks at them if they are few."""
    values, text = shown_values(data, dim)
    if len(values) <= FEW:
        ax.set_xticks(np.unique(values), [f"{value:.6g}" for value in np.unique(values)])
        ax.margins(x=0.1)
    ax.set_xlabel(text)
    return values


BINS = 60
MOST_BARS = 12
"""Contributors that are drawn: those of the largest shares."""


@styled
def tolerance_figure(data: xr.Dataset, name: str) -> Figure | None:
    """Histogram and contributors of a measure; None if no sample has it."""
    own = data.sel(measure=name)
    if not np.isfinite(own["sample"]).any():
        return None
    result, (left, right) = panels(1, 2, 2.6)
    for ax, (start, width) in ((left, (0.11, 0.38)), (right, (0.71, 0.26))):  # room for paths
        box = ax.get_position()
        ax.set_position((start, box.y0, width, box.height))
    distribution(left, own)
    contributors(right, own)
    left.set_title(fitted(name, 2.4))
    right.set_title(fitted(str(data.attrs.get("name", "")), 1.6))
    return result


def distribution(ax: Axes, own: xr.Dataset) -> Axes:
    """Histogram of the samples, that of the linear ones as a line, the nominal value and limits."""
    values, linear = own["sample"].to_numpy(), own["linear_sample"].to_numpy()
    known = np.isfinite(values)
    values, linear = values[known], linear[known]
    units, nominal = str(own["units"].values), float(own["nominal"])
    scale = _changes(values, nominal, units)
    base = nominal if _relative(values, nominal) else 0.0
    shown, predicted = (values - base) * scale.factor, (linear - base) * scale.factor
    edges = np.histogram_bin_edges(np.concatenate([shown, predicted]), min(BINS, _bins(len(shown))))
    ax.hist(shown, bins=edges.tolist(), color=PALETTE[0], alpha=0.55, label="samples")
    heights, _ = np.histogram(predicted, edges)
    ax.stairs(heights, edges, color=BLACK, linewidth=1.0, label="linear")
    ax.margins(y=0.05)
    ax.axvline((nominal - base) * scale.factor, color=GREY, linewidth=0.8)
    for limit in _limits(own):
        ax.axvline((limit - base) * scale.factor, color=PALETTE[1], linestyle="--")
    quantity = "less the nominal value" if base else "value"
    ax.set_xlabel(scale.label(quantity))
    ax.set_ylabel("draws")
    ax.legend(loc="best")
    return ax


def contributors(ax: Axes, own: xr.Dataset) -> Axes:
    """Shares of the variance, the largest at the top."""
    shares = own["share"].to_numpy()
    order = np.argsort(shares)[-MOST_BARS:]
    ax.barh(np.arange(len(order)), 100.0 * shares[order], color=PALETTE[0], height=0.7)
    names = [fitted(str(path), 1.5, 6.5) for path in own["contributor"].to_numpy()[order]]
    ax.set_yticks(np.arange(len(order)), names, fontsize=6.5)
    ax.set_xlim(0.0, 100.0)
    ax.set_xlabel("share of the variance [%]")
    ax.grid(visible=False, axis="y")
    return ax


def _relative(values: np.ndarray, nominal: float) -> bool:
    """Whether values differ so little from the nominal one that differences are shown."""
    return bool(np.ptp(values) < 0.1 * abs(nominal))


def _changes(values: np.ndarray, nominal: float, units: str) -> Scale:
    return scale_of(values - nominal if _relative(values, nominal) else values, units)


def _bins(count: int) -> int:
    return max(8, round(count**0.5))


def _limits(own: xr.Dataset) -> list[float]:
    if "limited" not in own:
        return []
    mine = own["limited"].to_numpy() == str(own["measure"].values)
    both = np.concatenate([own["limit_low"].to_numpy()[mine], own["limit_high"].to_numpy()[mine]])
    return [float(limit) for limit in np.unique(both) if np.isfinite(limit)]


HEIGHT, MARKER_LEGEND = 3.4, 0.5
MARKERS = "osD^vP*X"


def draw_work_precision(ax: Axes, points: Sequence[Point], heading: str = "") -> Axes:
    """Draw a line per method; a method is better the further it lies to the lower left.

    `points`: runs; those without an error are left out, and so are those that are slower than
    another run of the same method and not more accurate.
    """
    for index, method in enumerate(dict.fromkeys(point.method for point in points)):
        front = _front([p for p in points if p.method == method])
        ax.loglog(
            [error for error, _ in front],
            [seconds for _, seconds in front],
            marker=MARKERS[index % len(MARKERS)],
            markersize=4,
            label=method,
            **line_style(index),
        )
    for axis in (ax.xaxis, ax.yaxis):
        show_powers(axis)
    ax.set_xlabel("error at the end [rad or m]")
    ax.set_ylabel("time of a run [s]")
    ax.legend(**legend_above(heading), ncols=4)
    return ax


def _front(points: Sequence[Point]) -> list[tuple[float, float]]:
    """Errors and seconds of the runs that no other run beats in both, least accurate first."""
    runs = sorted((p.seconds, p.error) for p in points if p.error)
    front: list[tuple[float, float]] = []
    for seconds, error in runs:
        if not front or error < front[-1][0]:
            front.append((error, seconds))
    return front


@styled
def work_precision_figure(points: Sequence[Point], heading: str = "") -> Figure:
    """The figure of `draw`, with room for its legend."""
    result, (ax,) = panels(1, 1, HEIGHT, TOP + MARKER_LEGEND)
    draw_work_precision(ax, points, heading)
    return result


@styled
def duty_figure(data: xr.Dataset) -> Figure:
    """Effort of each drive over its speed in a cycle, its root mean square, and motors."""
    names = [str(name) for name in data["drive"].values]
    figure, axes = diagrams(len(names))
    for ax, name in zip(axes, names, strict=True):
        draw_duty(ax, data, name)
    return figure


def draw_duty(ax: Axes, data: xr.Dataset, name: str) -> Axes:
    """One drive of `linkages.duty`."""
    effort, speed = (data[key].sel(drive=name).to_numpy() for key in ("effort", "speed"))
    turns = bool(data["turns"].sel(drive=name))
    effort_unit, speed_unit = ("N m", "rad/s") if turns else ("N", "m/s")
    line = data.attrs.get(f"motor_{name}")
    reach = np.abs(speed).max()
    rms = float(data["effort_rms"].sel(drive=name))
    y = scale_of(np.append(effort, rms), effort_unit)
    if line is not None:
        stall, no_load, ratio = map(float, line)
        y = scale_of(np.append(effort, stall * ratio), effort_unit)
        at = np.linspace(-1.0, 1.0, 401) * max(no_load / ratio, 1.1 * reach)
        fall = stall * ratio * ratio / no_load
        most = np.minimum(stall * ratio, stall * ratio - fall * at)
        ax.plot(at, most * y.factor, color=GREY, label="motor")
        ax.plot(at, -most[::-1] * y.factor, color=GREY)
    ax.plot(speed, effort * y.factor, color=PALETTE[0], label="cycle")
    root: dict[str, Any] = {"color": PALETTE[1], "linestyle": "--", "linewidth": 1.0}
    ax.axhline(rms * y.factor, label="rms", **root)
    ax.set_xlabel(f"speed [{speed_unit}]")
    ax.set_ylabel(y.label("effort"))
    ax.legend(**legend_above(name), ncols=3)
    return ax
