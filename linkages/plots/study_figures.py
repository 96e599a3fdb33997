"""Figures of sweeps, sensitivities, tolerances, optimisation and benchmarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from linkages.benchmark.work_precision import Point
from linkages.plots.panels import (
    axes_for,
    cell_borders,
    diagram_each,
    draw_cells,
    labelled,
    legend_above,
    not_computed,
    panels,
    shade,
    shown_values,
    time_axis,
    with_bar,
)
from linkages.plots.style import (
    BLACK,
    GREY,
    PALE,
    PALETTE,
    WIDTH,
    Scale,
    axis_scale,
    figure_of,
    filled,
    line_style,
    measure_words,
    name_of,
    path_words,
    scale_of,
    set_heading,
    set_title,
    show_powers,
    styled,
    title,
)

if TYPE_CHECKING:
    import xarray as xr

    from linkages.design.sensitivities import Effect
    from linkages.solution.solution import Solution

Array = NDArray[np.float64]

MOST_PANELS = 8  # series that are drawn, one below the other
TALL, LOW = 3.2, 1.9  # inches: a panel over time that stands alone, and one of several


def _quantity(name: object, units: object, *values: Array) -> tuple[Scale, str]:
    """How a measure or a series is shown, and the label of its axis."""
    shown = "" if str(units) == "1" else str(units)
    scale = axis_scale(np.concatenate([np.ravel(own) for own in values]), shown)
    return scale, scale.label(measure_words(str(name), shown))


@styled
def convergence(data: xr.Dataset) -> Figure:
    """The goal of every run, and the best so far; circles are runs that miss a constraint."""
    ax = axes_for(None, TALL)
    run, attrs = np.arange(1, data.sizes["run"] + 1), data["history"].attrs
    holds = data["history_violation"].to_numpy() == 0.0
    values, best = data["history_value"].to_numpy(), data["history"].to_numpy()
    scale, label = _quantity(attrs["long_name"], attrs["units"], values, best)
    values, best = scale.factor * values, scale.factor * best
    ax.plot(run[holds], values[holds], ".", color=GREY, markersize=3, label="each run")
    if not holds.all():
        look: dict[str, Any] = {"color": GREY, "markersize": 3, "fillstyle": "none"}
        ax.plot(run[~holds], values[~holds], "o", label="constraints not met", **look)
    ax.step(run, best, where="post", color=PALETTE[0], label="best so far")
    known = values[np.isfinite(values)]
    if len(known):
        low = np.quantile(known, 0.05, method="lower")  # a few runs may be far away
        high = np.quantile(known, 0.95, method="higher")
        ends = [low, high, scale.factor * float(data["value"][1]), *best[np.isfinite(best)][:1]]
        middle = 0.5 * (max(ends) + min(ends))
        # ticks of a few digits differ, however little the runs do
        half = max(0.55 * (max(ends) - min(ends)), 0.005 * abs(middle)) or 1.0
        ax.set_ylim(middle - half, middle + half)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(xlabel="run", ylabel=label)
    legend_above(ax, labelled(ax.lines), name_of(data))
    return figure_of(ax)


@styled
def fit_curves(data: xr.Dataset) -> Figure:
    """What goal and constraints reduce, over time, before and after."""
    count = min(data.sizes["series"], MOST_PANELS)
    height = TALL if count == 1 else LOW
    figure, axes = panels(count, 1, height, joined=True)
    time, curves = data["time"].to_numpy(), data["curve"].to_numpy()
    clock = scale_of(time, "s").factor
    for place, ax in enumerate(axes):
        name, units = data["series"][place].item(), data["series_units"][place].item()
        scale, label = _quantity(name, units, curves[:, place])
        before, after = scale.factor * curves[:, place]
        ax.plot(clock * time, before, color=GREY, linestyle=(0, (5, 1.6)), label="start")
        ax.plot(clock * time, after, color=PALETTE[0], label="optimum")
        ax.set_ylabel(filled(label, height))
        time_axis(ax, time)
    legend_above(axes[0], labelled(axes[0].lines), name_of(data))
    return figure


@styled
def fit_figure(data: xr.Dataset) -> Figure:
    """Measurements over the fitted motion, and residuals below, of each output."""
    count = min(data.sizes["series"], MOST_PANELS // 2)
    figure, axes = panels(2 * count, 1, LOW, joined=True)
    time = data["time"].to_numpy()
    clock = scale_of(time, "s").factor * time
    dots: dict[str, Any] = {"color": "0.35", "markersize": 2.5, "alpha": 0.6, "zorder": 3}
    for place in range(count):
        above, below = axes[2 * place : 2 * place + 2]
        measured, computed, residual = (
            data[name].to_numpy()[place] for name in ("measured", "computed", "residual")
        )
        known = np.isfinite(measured)
        name, units = data["series"][place].item(), data["series_units"][place].item()
        scale, label = _quantity(name, units, measured)
        above.plot(clock[known], scale.factor * measured[known], ".", label="measured", **dots)
        above.plot(clock[known], scale.factor * computed[known], color=PALETTE[0], label="fit")
        above.set_ylabel(filled(label, 1.7))
        known_sigma = bool(data.attrs["sigma_known"])
        own = Scale(1.0, "σ") if known_sigma else axis_scale(residual, str(units))
        below.axhline(0.0, color=PALETTE[0], linewidth=0.8)
        below.plot(clock[known], own.factor * residual[known], ".", **dots)
        below.set_ylabel(own.label("residual"))
        for ax in (above, below):
            time_axis(ax, time)
    legend_above(axes[0], labelled(axes[0].lines), name_of(data))
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
    ax = axes_for(None, 0.6 * WIDTH)
    ax.set_aspect("equal", adjustable="datalim")
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
    legend_above(ax, labelled(ax.lines), title(name_of(data), f"path of {joint}"))
    return figure_of(ax)


MOST_EFFECTS, MOST_CURVES = 12, 5
ROUND_OFF = 1e-9


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
        values = [effect.relative or 0.0 for effect in found]
        colours = [PALETTE[value < 0.0] for value in values]
        draw_bars(ax, [path_words(effect.parameter) for effect in found], values, color=colours)
        ax.set_ylim(most - 0.5, -0.5)
        ax.axvline(0.0, color="0.3", linewidth=0.8)
        ax.set_xlabel("change of the measure for 1 % of the number [%]")
        set_title(ax, title(name_of(data), measure_words(text)))
    return result


@styled
def sensitivity_curves(data: xr.Dataset) -> Figure | None:
    """Changes of series for one percent of the numbers that do most; None without series."""
    series = [str(name) for name, array in data.data_vars.items() if "time" in array.dims]
    if not series:
        return None
    result, axes = panels(len(series), 1, 2.2)
    for ax, name in zip(axes, series, strict=True):
        changes = 0.01 * data[name].values * data["parameter_value"].values
        sizes = np.abs(np.nan_to_num(changes, nan=0.0)).max(axis=0)
        chosen = [k for k in np.argsort(-sizes, kind="stable")[:MOST_CURVES] if sizes[k] > 0.0]
        unit = str(data[name].attrs["units"]).partition(" / ")[0]
        clock, scale = time_axis(ax, data["time"]), axis_scale(changes[:, chosen], unit)
        for index, k in enumerate(chosen):
            words = path_words(str(data["parameter"].values[k]))
            x, y = clock.factor * data["time"], scale.factor * changes[:, k]
            ax.plot(x, y, label=words, **line_style(index))
        ax.set_ylabel(scale.label("change"))
        if chosen:
            words = f"change of {measure_words(name, unit)} for 1 % of a number"
            legend_above(ax, labelled(ax.lines), words)
    return result


def _relative_effects(effects: Sequence[Effect]) -> list[Effect]:
    """Those that are more than round-off of the largest one."""
    largest = max((abs(effect.relative or 0.0) for effect in effects), default=0.0)
    return [e for e in effects if abs(e.relative or 0.0) > ROUND_OFF * largest][:MOST_EFFECTS]


DRAW = "draw"
BAND = 0.05, 0.95  # quantiles between which a band lies
MOST_BINS = 60

FEW = 6  # values that are a list and no range: they get a line or a tick each
MARKED = 50  # points from which on a line needs no marks


@styled
def sweep_figure(data: xr.Dataset, name: str) -> Figure | None:
    """A measure over its one or two dimensions; None if there are more, or nothing to show."""
    array = data[name]
    if array.ndim > 2 or not np.isfinite(array).any():
        return None
    ax = axes_for(None)
    scale, label = _quantity(name, data[name].attrs.get("units", ""), data[name].to_numpy())
    array, heading = scale.factor * data[name], name_of(data)
    dims = [str(dim) for dim in array.dims]
    entries = not_computed(int((~np.isfinite(data[name])).sum()))
    if dims == [DRAW]:
        values = array.to_numpy()[np.isfinite(array)]
        ax.hist(values, bins=min(MOST_BINS, max(1, round(len(values) ** 0.5))), color=PALETTE[0])
        ax.set_xlabel(label)
        ax.set_ylabel("draws")
    elif DRAW in dims:
        _spread(ax, data, array, label)
    elif len(dims) == 2 and min(array.shape) > FEW:
        up, along = dims
        draw_cells(ax, data, array.to_numpy(), colormaps["viridis"], Normalize(), (along, up))
        with_bar(ax, label)
    elif len(dims) == 2:
        several, along = sorted(dims, key=lambda dim: data.sizes[dim])
        across, words = shown_values(data, several)
        heading = ", ".join(filter(None, (heading, words)))
        entries = {
            f"{value:.6g}": _line(ax, data, array.isel({several: place}), label, place)
            for place, value in enumerate(across)
        } | entries
    else:
        _line(ax, data, array, label)
        values, _ = shown_values(data, dims[0])
        order = np.argsort(values)
        failed = ~np.isfinite(array.to_numpy()[order])
        if failed.any() and len(values) > 1:
            shade(ax, cell_borders(values[order]), failed, color=PALE, linewidth=0, zorder=0.5)
    legend_above(ax, entries, heading)
    return figure_of(ax)


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


def _line(ax: Axes, data: xr.Dataset, array: xr.DataArray, label: str, place: int = 0) -> Artist:
    """A measure over one dimension."""
    values = _shown_along(ax, data, str(array.dims[0]))
    marker = "o" if len(values) <= FEW else "." if len(values) < MARKED else ""
    (line,) = ax.plot(values, array.to_numpy(), marker=marker, **line_style(place))
    ax.set_ylabel(label)
    return line


def _shown_along(ax: Axes, data: xr.Dataset, dim: str) -> Array:
    """Values along the axis to the right, which has ticks at them if they are few."""
    values, text = shown_values(data, dim)
    if len(values) <= FEW:
        ax.set_xticks(np.unique(values), [f"{value:.6g}" for value in np.unique(values)])
        ax.margins(x=0.1)
    ax.set_xlabel(text)
    return values


BINS = 60
MOST_BARS = 12  # contributors that are drawn: those of the largest shares


@styled
def tolerance_figure(data: xr.Dataset, name: str) -> Figure | None:
    """Histogram and contributors of a measure; None if no sample has it."""
    own = data.sel(measure=name)
    if not np.isfinite(own["sample"]).any():
        return None
    result, (left, right) = panels(1, 2, 2.6, widths=(0.55, 0.45))
    _draw_samples(left, own)
    shares = own["share"].to_numpy()
    order = np.argsort(shares)[-MOST_BARS:]
    names = [filled(path_words(str(p)), 1.5) for p in own["contributor"].to_numpy()[order]]
    draw_bars(right, names, 100.0 * shares[order], color=PALETTE[0])
    right.set_xlim(0.0, 100.0)
    right.set_xlabel("share of the variance [%]")
    set_heading(result, title(name_of(data), measure_words(name, str(own["units"].values))))
    return result


def draw_bars(ax: Axes, names: Sequence[str], values: Sequence[float] | Array, **look: Any) -> None:
    """Draw a bar to the right for each name, the first one at the bottom."""
    places = np.arange(len(names))
    ax.barh(places, values, height=0.7, **look)
    ax.set_yticks(places, names)
    ax.grid(axis="y", visible=False)


def _draw_samples(ax: Axes, own: xr.Dataset) -> None:
    """Histogram of the samples, that of the linear ones as a line, the nominal value and limits."""
    values, linear = own["sample"].to_numpy(), own["linear_sample"].to_numpy()
    known = np.isfinite(values)
    values, linear = values[known], linear[known]
    units, nominal = str(own["units"].values), float(own["nominal"])
    # values that differ little from the nominal one are shown by their differences
    base = nominal if np.ptp(values) < 0.1 * abs(nominal) else 0.0
    scale = scale_of(values - base, units)
    shown, predicted = (values - base) * scale.factor, (linear - base) * scale.factor
    bins = min(BINS, max(8, round(len(shown) ** 0.5)))
    edges = np.histogram_bin_edges(np.concatenate([shown, predicted]), bins)
    ax.hist(shown, bins=edges.tolist(), color=PALETTE[0], alpha=0.55, label="samples")
    heights, _ = np.histogram(predicted, edges)
    ax.stairs(heights, edges, color=BLACK, linewidth=1.0, label="linear")
    ax.margins(y=0.05)
    ax.axvline((nominal - base) * scale.factor, color=GREY, linewidth=0.8, label="nominal")
    for limit in _limits(own):
        words = f"limit {scale_of([limit], units).text(limit)}"
        place = (limit - base) * scale.factor
        ax.axvline(place, color=PALETTE[1], linestyle="--", label=words)
    words = measure_words(str(own["measure"].values), units)
    ax.set_xlabel(filled(scale.label(f"{words}, less the nominal value" if base else words), 3.2))
    ax.set_ylabel("draws")
    legend_above(ax, labelled([*ax.containers, *ax.patches, *ax.lines]))


def _limits(own: xr.Dataset) -> list[float]:
    if "limited" not in own:
        return []
    mine = own["limited"].to_numpy() == str(own["measure"].values)
    both = np.concatenate([own["limit_low"].to_numpy()[mine], own["limit_high"].to_numpy()[mine]])
    return [float(limit) for limit in np.unique(both) if np.isfinite(limit)]


MARKERS = "osD^vP*X"


@styled
def work_precision_figure(points: Sequence[Point], heading: str = "") -> Figure:
    """A line per method; a method is better the further it lies to the lower left.

    `points`: runs; those without an error are left out, and so are those that are slower than
    another run of the same method and not more accurate.
    """
    ax = axes_for(None)
    for index, method in enumerate(dict.fromkeys(point.method for point in points)):
        front = _front([p for p in points if p.method == method])
        ax.loglog(
            *np.reshape(front, (-1, 2)).T, marker=MARKERS[index % len(MARKERS)], markersize=4,
            label=method, **line_style(index),
        )  # fmt: skip
    for axis in (ax.xaxis, ax.yaxis):
        show_powers(axis)
    ax.set_xlabel("error at the end [rad or m]")
    ax.set_ylabel("time of a run [s]")
    legend_above(ax, labelled(ax.lines), heading)
    return figure_of(ax)


def _front(points: Sequence[Point]) -> list[tuple[float, float]]:
    """Errors and seconds of the runs that no other run beats in both, least accurate first."""
    runs = sorted((p.seconds, p.error) for p in points if p.error)
    front: list[tuple[float, float]] = []
    for seconds, error in runs:
        if not front or error < front[-1][0]:
            front.append((error, seconds))
    return front


@styled
def duty_figure(data: xr.Dataset) -> Figure | None:
    """Effort of each drive over its speed in a cycle, its root mean square, and motors."""
    names = [str(name) for name in data["drive"].values]
    return diagram_each(names, lambda ax, name, of: _draw_duty(ax, data, name, of), name_of(data))


def _draw_duty(ax: Axes, data: xr.Dataset, name: str, heading: str) -> None:
    """One drive of `linkages.duty`."""
    effort, speed = (data[key].sel(drive=name).to_numpy() for key in ("effort", "speed"))
    turns = bool(data["turns"].sel(drive=name))
    effort_unit, speed_unit = ("N m", "rad/s") if turns else ("N", "m/s")
    line = data.attrs.get(f"motor_{name}")
    rms = float(data["effort_rms"].sel(drive=name))
    y, label = _quantity(f"{name}.effort", effort_unit, effort, np.array([rms]))
    if line is not None:
        stall, no_load, ratio = map(float, line)
        y, label = _quantity(f"{name}.effort", effort_unit, effort, np.array([stall * ratio]))
        at = np.linspace(-1.0, 1.0, 401) * max(no_load / ratio, 1.1 * np.abs(speed).max())
        fall = stall * ratio * ratio / no_load
        most = np.minimum(stall * ratio, stall * ratio - fall * at)
        ax.plot(at, most * y.factor, color=GREY, label="motor")
        ax.plot(at, -most[::-1] * y.factor, color=GREY)
    ax.plot(speed, effort * y.factor, color=PALETTE[0], label="cycle")
    ax.axhline(rms * y.factor, color=PALETTE[1], linestyle="--", linewidth=1.0, label="rms")
    ax.set(xlabel=f"speed of {name} [{speed_unit}]", ylabel=label)
    legend_above(ax, labelled(ax.lines), title(heading, name))
