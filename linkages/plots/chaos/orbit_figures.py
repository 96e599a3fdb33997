"""Periodic orbits and their multipliers, and branches of orbits and equilibria."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from numpy.typing import NDArray

from linkages.plots.mechanism import branches as small_drawings
from linkages.plots.mechanism.annotations import Labels
from linkages.plots.mechanism.drawing import reach
from linkages.plots.mechanism.plane_view import Box, small_pictures
from linkages.plots.mechanism.pose import Poses
from linkages.plots.motion.clearance_orbit import SHOWN, name_rows
from linkages.plots.motion.clearance_orbit import orbit_figure as journal_figure
from linkages.plots.motion.curves import show_steady
from linkages.plots.panels import (
    axes_for,
    chart,
    diagram_each,
    dot,
    joined,
    labelled,
    legend_above,
    named,
    panels,
    runs,
    show_axis,
    show_degrees,
    time_axis,
)
from linkages.plots.style import (
    BLACK,
    GREY,
    PALETTE,
    Scale,
    axis_scale,
    figure_of,
    name_of,
    path_words,
    scale_for,
    scale_of,
    set_title,
    show_powers,
    styled,
    title,
)

if TYPE_CHECKING:
    import xarray as xr

    from linkages.components.mechanisms.mechanism import Mechanism
    from linkages.design.ranges import Ranges
    from linkages.orbits.shooting import Change

Array = NDArray[np.float64]

SAMPLES = 2000  # of a period in figures
BESIDE = 1e-9
"""Parts of a period before and behind a change of contacts at which states are drawn as well."""

INSIDE, OUTSIDE = PALETTE[0], PALETTE[1]
"""Colours of stable orbits and multipliers inside of the unit circle, and of others."""

ON_CIRCLE = 1e-6  # distance from the unit circle within which a multiplier is on it


def orbit_figures(data: xr.Dataset, mechanism: Mechanism) -> dict[str, Figure | None]:
    """Name → figure of an orbit: phase portraits, multipliers, one period, drawings, journals.

    `data`: as `linkages.orbit` returns it from one start.
    `mechanism`: the same as that of the orbit.
    """
    from linkages.orbits.starting_states import with_first_state
    from linkages.solution.simulate import simulate

    curve, changes = _resolved(data, mechanism)
    names = [str(name) for name in data["coordinate"].values]
    start = with_first_state(mechanism, names, data["state"].to_numpy())
    period = float(data.attrs["period"])
    how = {name: data.attrs[name] for name in ("method", "rtol", "atol")}
    opening = bool(mechanism.opening)
    solution = simulate(
        start, times=np.linspace(0.0, period, SAMPLES + 1),
        outputs=["joint_position", *(SHOWN if opening else ())], throw=False, **how,
    )  # fmt: skip
    return {
        "orbit": portrait_figure(curve),
        "orbit_multipliers": figure_of(multipliers(data)),
        "orbit_time": period_figure(curve, changes),
        "orbit_positions": position_figure(solution.data, start),
        "orbit_clearance": journal_figure(solution.data, start) if opening else None,
    }


def _resolved(data: xr.Dataset, mechanism: Mechanism) -> tuple[xr.Dataset, Sequence[Change]]:
    """The orbit with states on both sides of changes of contacts, and these changes."""
    from linkages.options.analysis_options import OrbitOptions
    from linkages.orbits.shooting import Shooting
    from linkages.solution.run_options import options_of

    how = {name: data.attrs[name] for name in ("method", "rtol", "atol")}
    shooting = Shooting(mechanism, (), options_of(OrbitOptions, mechanism, how))
    state, period = data["state"].to_numpy(), float(data.attrs["period"])
    grid = period * np.arange(1, SAMPLES + 1) / SAMPLES
    changes: Sequence[Change] = ()
    for _ in range(2):
        aside = [change.time + side * BESIDE * period for change in changes for side in (-1, 1)]
        times = np.union1d(grid, [time for time in aside if 0.0 < time < period])
        shot = shooting.shoot(np.zeros(0), state, period, start=0.0, tangents=False, samples=times)
        changes = shot.changes
        if not changes:
            break
    states = np.vstack([state, shooting.states(shot.motion)])
    result = data.drop_vars(["orbit_state", "time"])
    return result.assign(
        time=("time", np.append(0.0, times), {"units": "s"}),
        orbit_state=(("time", "coordinate"), states),
    ), changes


def coordinates_of(data: xr.Dataset) -> int:
    """How many of the entries of a state are coordinates, which are followed by their rates."""
    key = "unit" if "unit" in data and data["unit"].dims == ("coordinate",) else "coordinate_unit"
    units = [str(unit) for unit in data[key].values]
    for count in range(len(units) // 2, 0, -1):
        if all(units[count + k] == f"{units[k]}/s" for k in range(count)):
            return count
    return 0


@styled
def portrait_figure(data: xr.Dataset) -> Figure | None:
    """Rate over value of each free coordinate."""
    count = coordinates_of(data)
    return diagram_each(
        range(count), lambda ax, index, of: _draw_portrait(ax, data, index, of), name_of(data)
    )


@chart
def orbit(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Phase portrait of `linkages.orbit`, of one orbit: of the coordinate named, or the first.

    `data`: As `linkages.orbit` returns it from one start.
    `name`: Of a coordinate, such as ``rod.angle``.
    """
    known = [str(each) for each in data["coordinate"].values[: coordinates_of(data)]]
    index = known.index(named(name, known, "coordinate"))
    return _draw_portrait(axes_for(ax), data, index, name_of(data))


def _draw_portrait(ax: Axes, data: xr.Dataset, index: int, heading: str) -> Axes:
    """Draw the rate of a free coordinate over its value, with the points of the section."""
    rate = coordinates_of(data) + index
    names = [str(name) for name in data["coordinate"].values]
    units = [str(unit) for unit in data["unit"].values]
    states, points = data["orbit_state"].to_numpy(), data["section_state"].to_numpy()
    x, y = (
        show_axis(ax, along, states[:, k], units[k], names[k])
        for along, k in (("x", index), ("y", rate))
    )
    colour = INSIDE if data.attrs["stable"] or data.attrs["conservative"] else OUTSIDE
    across, at = states[:, index], points[:, index]
    ax.plot(x.factor * across, y.factor * states[:, rate], color=colour, zorder=2)
    if units[index] == "rad":  # section points have as many turns as the curve
        at = at + 2 * np.pi * np.ceil((np.min(across) - 1e-9 - at) / (2 * np.pi))
    periods = int(data.attrs["periods"])
    words = "beginning" + f"{'s' * (periods > 1)} of a period" * (periods > 0)
    dots: dict[str, Any] = {"color": BLACK, "markersize": 4, "zorder": 3, "label": words}
    ax.plot(x.factor * at, y.factor * points[:, rate], "o", **dots)
    ax.margins(0.06)
    legend_above(ax, labelled(ax.lines), heading, handlelength=1.0)
    return ax


LINEAR = 1.6  # largest magnitude up to which the plane of multipliers is drawn to scale
TINY = 1e-5  # magnitude below which a multiplier is drawn at 0


@chart
def multipliers(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Multipliers of `linkages.orbit`, of one orbit, about the unit circle.

    Where one is far outside of it, magnitudes above 1 have a logarithmic scale.
    """
    ax = axes_for(ax)
    values = data["multiplier"].to_numpy() @ [1.0, 1.0j]
    size = np.abs(values)
    largest = float(size.max(initial=1.0))
    scaled = largest <= LINEAR
    # logarithmic outside of the unit circle, where not all are near it
    radii = size if scaled else np.where(size > 1.0, 1.0 + np.log10(np.maximum(size, 1.0)), size)
    radii = np.where(size < TINY, 0.0, radii)
    places = radii * np.exp(1j * np.angle(values))
    half = 1.12 * max(1.0, float(radii.max(initial=1.0)))
    ax.add_patch(Circle((0, 0), 1.0, facecolor="#F2F6FA", edgecolor=BLACK, linewidth=0.9, zorder=1))
    for line in (ax.axhline, ax.axvline):
        line(0.0, color="#D0D0D0", linewidth=0.6, zorder=1.5)
    ax.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
    ax.grid(visible=False)
    if scaled:
        ax.locator_params(nbins=5, steps=[1, 2, 5, 10])
        ax.set(xlabel="real part", ylabel="imaginary part")
    else:
        _rings(ax, half)
    colours = [
        BLACK if abs(one - 1.0) < ON_CIRCLE else OUTSIDE if one > 1.0 else INSIDE for one in size
    ]
    ax.scatter(places.real, places.imag, s=26, c=colours, zorder=4, linewidths=0)
    tiny = f"{(size < TINY).sum()} below 1e−5"
    entries = labelled(
        dot(colour, markersize=5, label=tiny if abs(value) < TINY else _number(value))
        for value, colour in zip(values.tolist(), colours, strict=True)
    )
    ax.legend(
        [*entries.values()], [*entries], title="multipliers", loc="upper left",
        bbox_to_anchor=(1.04, 1.0), borderaxespad=0.0, handlelength=1.0, alignment="left",
    )  # fmt: skip
    set_title(ax, name_of(data))
    return ax


def _number(value: complex) -> str:
    """A multiplier with five digits; conjugate ones are the same text."""
    text = f"{value.real:.5g}" + (f" ± {abs(value.imag):.5g}i" if value.imag else "")
    return text.replace("-", "−")


def _rings(ax: Axes, half: float) -> None:
    """Circles of magnitudes 1, 10, 100, …, of which distances from the first are logarithms."""
    ax.set(xticks=[], yticks=[])
    powers = range(int(np.floor(half - 1.0)) + 1)
    step = 1 + len(powers) // 6
    for power in powers:
        if power:
            ring = Circle((0, 0), 1.0 + power, fill=False, edgecolor="#C8C8C8", linewidth=0.6)
            ax.add_patch(ring)
        if power % step == 0:
            text = "1" if power == 0 else f"1e{power}" if power > 3 else f"{10**power}"
            spot = (1.0 + power) * np.exp(0.25j * np.pi)
            ax.text(
                spot.real, spot.imag, text, color="0.35", ha="center", va="center",
                zorder=3, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8},
            )  # fmt: skip
    above = "magnitudes above 1 on a logarithmic scale"
    ax.set(xlabel=f"real part; {above}", ylabel="imaginary part")


PANEL, STRIP = 1.25, 0.36  # inches: height of a panel over time, and of a contact's strip


@styled
def period_figure(data: xr.Dataset, changes: Sequence[Change] = ()) -> Figure:
    """Each free coordinate over one period of the orbit, and when contacts are closed."""
    count = coordinates_of(data)
    time, states = data["time"].to_numpy(), data["orbit_state"].to_numpy()
    span = float(time[-1])
    names = [str(name) for name in data["coordinate"].values]
    units = [str(unit) for unit in data["unit"].values]
    closed = contact_episodes(changes, span)
    heights = [*[PANEL] * count, *([STRIP * len(closed) + 0.16] if closed else [])]
    result, axes = panels(len(heights), 1, heights, joined=True)
    for ax in axes:
        scale, periods = time_axis(ax, [0.0, span]), int(data.attrs["periods"])
        for k in range(1, periods):  # where periods of the drives begin
            begin = scale.factor * span * k / periods
            ax.axvline(begin, color=GREY, linewidth=0.6, linestyle=(0, (4, 2)))
    for index, ax in enumerate(axes[:count]):
        y = show_axis(ax, "y", states[:, index], units[index], names[index])
        values = y.factor * states[:, index]
        for intervals in closed.values():
            for first, last in intervals:
                ax.axvspan(scale.factor * first, scale.factor * last, color="#EAF1F8", zorder=0)
        ax.plot(scale.factor * time, values, color=PALETTE[index % len(PALETTE)])
        show_steady(ax, values)
        ax.margins(y=0.1)
    if closed:
        _draw_episodes(axes[-1], closed, scale)
    set_title(axes[0], name_of(data))
    return result


def contact_episodes(
    changes: Sequence[Change], span: float
) -> dict[str, list[tuple[float, float]]]:
    """Contact → beginnings and ends of its episodes within a period, in seconds.

    Those that last through the beginning of the period are in two parts; rigid impacts, after which
    the contact is open at once, last no time.
    """
    from linkages.orbits.contact_events import TOUCH

    result: dict[str, list[tuple[float, float]]] = {}
    for name in sorted({c.name for c in changes if c.name.endswith(TOUCH)}):
        own = [change for change in changes if change.name == name]
        episodes = result.setdefault(name.removesuffix(TOUCH), [])
        if not own[0].rises:
            episodes.append((0.0, own[0].time))
        for change, following in zip(own, [*own[1:], own[0]], strict=True):
            if change.rises:
                last = change is own[-1]
                end = change.time if following.rises else span if last else following.time
                episodes.append((change.time, end))
    return result


def _draw_episodes(ax: Axes, closed: dict[str, list[tuple[float, float]]], scale: Scale) -> None:
    """Draw a bar while a contact is closed, and a stroke where it closes."""
    for row, episodes in enumerate(reversed(closed.values())):
        begin, end = scale.factor * np.transpose(episodes)
        ax.broken_barh([*zip(begin, end - begin, strict=True)], (row - 0.2, 0.4), linewidth=0)
        ax.plot(begin, 0.0 * begin + row, "|", color=PALETTE[1], markersize=9, markeredgewidth=1.4)
    name_rows(ax, [*closed])
    ax.set_ylabel("closed")


DRAWN, ACROSS = 8, 4  # drawings of a mechanism over a period, and how many are beside each other


@styled
def position_figure(data: xr.Dataset, mechanism: Mechanism) -> Figure:
    """The mechanism at equal distances of time over a period."""
    poses = Poses(data, mechanism)
    time = data["time"].to_numpy()
    rows = np.linspace(0, len(time) - 1, DRAWN + 1).round().astype(int)[:-1]
    shown = [poses.at(int(row)) for row in rows]
    box = Box.joined([reach(pose) for pose in shown])
    scale = scale_of(time, "s")
    shape = float(box.size[1] / max(box.size[0], 1e-9))
    result, axes = small_pictures(DRAWN, ACROSS, shape, mechanism.name)
    for index, (ax, pose, row) in enumerate(zip(axes, shown, rows, strict=True)):
        mode = small_drawings.Mode(index + 1, pose.positions)
        small_drawings.draw(ax, mechanism, mode, box, small_drawings.MOST, scaled=index == 0)
        ax.set_title(f"t = {scale.text(float(time[row]))}", pad=3)
    return result


# -- branches --------------------------------------------------------------------------------

UPPER, LOWER = 3.0, 1.5  # inches: heights of both panels of branches
UNSTABLE = (0, (4, 2))  # dashes of what is unstable


@dataclass(frozen=True)
class Drawn:
    """What is drawn to the right or upwards: values of all points, shape (point, sections)."""

    values: Array
    label: str
    degrees: bool = False


def branch_figures(
    data: xr.Dataset, ranges: Ranges | None = None, across: str | None = None
) -> dict[str, Figure | None]:
    """Name → figure of branches; of a locus in two parameters one alone.

    `data`: as `linkages.follow` returns it; a variable ``section_state`` (point, section,
    coordinate) has all section points of orbits that last several periods.
    `ranges`: of the parameters, for their units.
    `across`: path of the second parameter of a locus.
    """
    if across is not None:
        return {"follow": locus_figure(data, ranges, across)}
    result: dict[str, Figure | None] = {"follow": branch_figure(data, ranges)}
    periods = data["period"].to_numpy()
    varying = np.isfinite(periods) & (np.array([one["periods"] for one in _described(data)])[
        data["branch"].to_numpy()] == 0)  # fmt: skip
    if varying.any():
        result["follow_period"] = branch_figure(data, ranges, "period")
    return result


def _described(data: xr.Dataset) -> list[dict[str, Any]]:
    return list(json.loads(data.attrs["branches"]))


@styled
def branch_figure(
    data: xr.Dataset, ranges: Ranges | None = None, name: str | None = None
) -> Figure:
    """A coordinate or the period over the parameter, and the largest multiplier below."""
    result, (upper, lower) = panels(2, 1, (UPPER, LOWER), joined=True)
    draw_growth(lower, data, ranges)
    _draw(upper, data, _parameter(data, ranges), _quantity(data, name), labels=True)
    joined(upper)
    legend_above(upper, _legend_of(data), name_of(data))
    return result


@chart
def branches(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Branches of `linkages.follow` over the first parameter: stable solid, unstable dashed.

    `name`: A coordinate or a rate, such as ``rod.angle``, or ``period``; the first coordinate if
    not given. It is drawn at the beginning of the first period of the drives.
    `ax`: Where to draw. A new figure if not given, with the largest multipliers below.
    """
    if ax is None:
        return branch_figure(data, None, name).axes[0]
    _draw(ax, data, _parameter(data, None), _quantity(data, name), labels=True)
    return ax


def draw_growth(ax: Axes, data: xr.Dataset, ranges: Ranges | None = None) -> Axes:
    """Draw the largest multiplier of orbits, or the largest real part of eigenvalues."""
    x, y = _parameter(data, ranges), _growth(data)
    orbits = data.attrs["what"] == "orbits"
    _draw(ax, data, x, y, labels=False)
    ax.axhline(1.0 if orbits else 0.0, color=BLACK, linewidth=0.7, zorder=1)
    if orbits:
        ax.set_yscale("log")
        show_powers(ax.yaxis)
    return ax


def _parameter(data: xr.Dataset, ranges: Ranges | None, path: str | None = None) -> Drawn:
    """Values of a parameter in the unit of its range, or in SI."""
    paths = [str(each) for each in data["path"].values]
    path = paths[0] if path is None else path
    values = data["value"].to_numpy()[:, paths.index(path)][:, None]
    known = {} if ranges is None else {each.path: each for each in ranges.each}
    scale = axis_scale(values, str(data["unit"][paths.index(path)].item()))
    if path in known:
        scale = Scale(known[path].of_si(1.0), scale_for(1.0, known[path].label).units)
    return Drawn(values * scale.factor, scale.label(path_words(path)))


def _quantity(data: xr.Dataset, name: str | None) -> Drawn:
    """Values of a coordinate at all section points, or periods."""
    if name == "period":
        values = data["period"].to_numpy()[:, None]
        scale = scale_of(values, "s")
        return Drawn(scale.factor * values, scale.label("period"))
    names = [str(each) for each in data["coordinate"].values]
    if name is not None and name not in names:
        known = ", ".join([*names, "period"])
        raise ValueError(f"unknown coordinate {name!r}; expected one of: {known}")
    index = 0 if name is None else names.index(name)
    unit = str(data["coordinate_unit"][index].item())
    if "section_state" in data:
        values = data["section_state"].to_numpy()[:, :, index]
    else:
        values = data["state"].to_numpy()[:, index][:, None]
    if unit == "rad":  # all within half a turn of the first
        first = values[0, 0]
        values = first + (values - first + np.pi) % (2 * np.pi) - np.pi
    scale = axis_scale(values, unit)
    return Drawn(scale.factor * values, scale.label(names[index]), unit == "rad")


def _growth(data: xr.Dataset) -> Drawn:
    """Magnitude of the largest multiplier that decides, or the largest real part."""
    spectrum = data["spectrum"].to_numpy() @ [1.0, 1.0j]
    if data.attrs["what"] != "orbits":
        return Drawn(np.nanmax(spectrum.real, axis=1)[:, None], "largest real\npart [1/s]")
    described, period = _described(data), data["period"].to_numpy()
    result = np.full(len(spectrum), np.nan)
    for row, (values, branch) in enumerate(zip(spectrum, data["branch"].to_numpy(), strict=True)):
        own = values[np.isfinite(values)]
        if not np.isfinite(period[row]) or not len(own):
            continue
        if not described[branch]["periods"]:  # without drives one belongs to a shift in time
            own = np.delete(own, np.argmin(np.abs(own - 1.0)))
        result[row] = np.abs(own).max(initial=0.0)
    return Drawn(np.maximum(result, TINY)[:, None], "largest\nmultiplier")


def _draw(
    ax: Axes, data: xr.Dataset, x: Drawn, y: Drawn, *, labels: bool, locus: bool = False
) -> None:
    """Lines of all branches, dashed where these are unstable, and marks of special points.

    On a locus orbits are neither stable nor unstable.
    """
    numbers, names = data["branch"].to_numpy(), data["label"].values
    for branch in range(int(numbers.max(initial=-1)) + 1):
        rows = np.flatnonzero(numbers == branch)
        if not len(rows):
            continue
        colour = PALETTE[branch % len(PALETTE)]
        solid = _stable_steps(data, rows) | locus
        across = x.values[rows, 0]
        for column in y.values[rows].T:
            if not np.isfinite(column).any():
                continue
            turned = y.degrees & (np.abs(np.diff(column)) > 180.0)
            for stable, dashes in ((True, "-"), (False, UNSTABLE)):
                for first, last in runs((solid == stable) & ~turned):
                    part = slice(first, last + 1)
                    ax.plot(
                        across[part], column[part], color=colour, linestyle=dashes,
                        zorder=3 if stable else 2.5,
                    )  # fmt: skip
    special = np.flatnonzero([bool(name) for name in names])
    ax.set_xlabel(x.label)
    ax.set_ylabel(y.label)
    ax.margins(x=0.03, y=0.1)
    for row in special:
        colour = PALETTE[numbers[row] % len(PALETTE)]
        ax.plot(
            np.repeat(x.values[row, 0], y.values.shape[1]), y.values[row], "o", markersize=4.5,
            markerfacecolor="white", markeredgecolor=colour, markeredgewidth=1.2, zorder=4,
        )  # fmt: skip
    if y.degrees:
        show_degrees(ax, y.values[np.isfinite(y.values)], "y")
    if not labels:
        return
    ax.set_xlim(ax.get_xlim())
    ax.set_ylim(ax.get_ylim())
    placing = Labels(ax)
    # a point that several branches meet has one label
    for row in {names[row]: row for row in reversed(special)}.values():
        place = (x.values[row, 0], y.values[row, 0])
        if np.isfinite(place).all():
            placing.beside_point(str(names[row]), place, 5.0)


def _stable_steps(data: xr.Dataset, rows: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Whether the way from each point of a branch to the next one is stable, shape (n − 1,).

    A bifurcation is at the edge of both; whether it counts as stable is round-off.
    """
    stable = data["stable"].to_numpy()[rows] > 0
    special = np.array([bool(label) for label in data["label"].values[rows]])
    first, second = stable[:-1] | special[:-1], stable[1:] | special[1:]
    both = special[:-1] & special[1:]
    return np.where(both, stable[:-1] & stable[1:], first & second)


def _legend_of(data: xr.Dataset) -> dict[str, Artist]:
    """Text → line: branches, then what is stable and what is not."""
    result: dict[str, Artist] = {}
    periods = data["period"].to_numpy()
    numbers = data["branch"].to_numpy()
    for branch, one in enumerate(_described(data)):
        own = np.isfinite(periods[numbers == branch])
        kind = "orbits" if own.any() else "equilibria"
        count = one["periods"]
        lasting = {0: kind, 1: "period 1"}.get(count, f"period {count}")
        text = f"{lasting} from {one['parent']}" if one["parent"] else lasting
        while text in result:
            text += "′"
        result[text] = Line2D([], [], color=PALETTE[branch % len(PALETTE)])
    stable = data["stable"].to_numpy() > 0
    if stable.any() and not stable.all():
        result["stable"] = Line2D([], [], color=BLACK)
        result["unstable"] = Line2D([], [], color=BLACK, linestyle=UNSTABLE)
    return result


@styled
def locus_figure(data: xr.Dataset, ranges: Ranges | None, across: str) -> Figure:
    """A locus in the plane of two parameters."""
    ax = axes_for(None)
    x, y = _parameter(data, ranges), _parameter(data, ranges, across)
    _draw(ax, data, x, y, labels=True, locus=True)
    of = next((one["parent"] for one in _described(data)), "")
    set_title(ax, title(name_of(data), f"locus of {of}"))
    return figure_of(ax)
