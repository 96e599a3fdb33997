"""Extremes of series, located between samples."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, labels
from linkages.solution.dense import DenseMotion
from linkages.solution.series import PIN, REACTION
from linkages.solvers.tableau import cardinals

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

SAME_HEIGHT = 1e-9
"""Part by which peaks must differ to be told apart: the first of those alike is given."""

_PARTS = 16
"""Parts on each side of a place that are looked at; each look is so many times as close."""

_FEWEST, _LOOKS = 4, 9
"""Looks at a smooth peak, which is then found to round-off, and at one with a kink."""

_SETTLED = 1e-12
"""Part of the size of a series by which a look must raise its peak for another one to follow."""


class Extremes(NamedTuple):
    """Largest values and where they are, in samples from the first one, shape (n,) each."""

    value: Floats
    place: Floats


def largest_between(samples: Floats, between: Callable[[Whole, Floats], Floats]) -> Extremes:
    """The largest value of every row of samples (rows, samples), located between them.

    `between` takes rows and places in them, shape (n,) each. A row that is not finite has none.
    """
    finite = np.asarray(np.isfinite(samples).all(axis=1))
    values = samples if finite.all() else np.where(finite[:, None], samples, 0.0)
    best = np.argmax(values, axis=1)
    top, bottom = values[np.arange(len(values)), best], values.min(axis=1)
    rows, starts = _candidates(values, best)
    kept = (finite & (bottom < top))[rows]
    rows, starts = rows[kept], starts[kept]
    place = best.astype(float)
    if len(rows):
        sizes = np.maximum(top, -bottom)
        heights, places = _looked_at(values, sizes, rows, starts.astype(float), between)
        top, place = _first_of_highest(top, place, rows, heights, places)
    return Extremes(np.where(finite, top, np.nan), place)


def _candidates(values: Floats, best: Whole) -> tuple[Whole, Whole]:
    """Rows and samples near which the curvature allows the largest value; one if a series rests."""
    count = values.shape[1]
    if count < 3:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    higher = np.ones_like(values, dtype=bool)
    higher[:, 1:] &= values[:, 1:] >= values[:, :-1]
    higher[:, :-1] &= values[:, :-1] >= values[:, 1:]
    rows, starts = np.nonzero(higher)
    inner = np.clip(starts, 1, count - 2)
    with np.errstate(over="ignore"):  # beside an infinite bend every peak is looked at
        bend = 2 * values[rows, inner] - values[rows, inner - 1] - values[rows, inner + 1]
        # an inner peak exceeds its sample by an eighth of that, one beside an end by up to a half
        most = values[rows, starts] + 0.5 * np.abs(bend)
    result = (most >= values[rows, best[rows]]) & ((bend != 0.0) | (starts == best[rows]))
    return rows[result], starts[result]


def _looked_at(
    values: Floats,
    sizes: Floats,
    rows: Whole,
    places: Floats,
    between: Callable[[Whole, Floats], Floats],
) -> tuple[Floats, Floats]:
    """Peaks beside samples, closer and closer: heights and places, shape (peaks,).

    Peaks that the curvature keeps below the highest one of their row are left as they are.
    """
    last = values.shape[1] - 1.0
    heights = values[rows, places.astype(int)].copy()
    highest = values.max(axis=1)
    size = sizes[rows]
    reach, parts = 1.0, np.arange(-_PARTS, _PARTS + 1) / _PARTS
    open_ = np.arange(len(rows))
    for look in range(_LOOKS):
        around = np.clip(places[open_, None] + reach * parts, 0.0, last)
        which = np.repeat(rows[open_], len(parts))
        result = np.broadcast_to(between(which, around.ravel()), which.shape)
        result = result.reshape(around.shape)
        result = np.where(np.isfinite(result), result, -np.inf)
        at = np.argmax(result, axis=1)
        each = np.arange(len(open_))
        before = heights[open_].copy()
        raised = result[each, at] > before
        heights[open_] = np.where(raised, result[each, at], before)
        places[open_] = np.where(raised, around[each, at], places[open_])
        reach /= _PARTS
        np.maximum.at(highest, rows, heights)
        inner = np.clip(at, 1, len(parts) - 2)
        with np.errstate(over="ignore", invalid="ignore"):  # an infinite bend excludes nothing
            bend = 2 * result[each, inner] - result[each, inner - 1] - result[each, inner + 1]
            lowest = highest * (1.0 - SAME_HEIGHT * np.sign(highest))
            done = heights[open_] + np.abs(bend) < lowest[rows[open_]]
        if look + 1 >= _FEWEST:
            done |= heights[open_] - before <= _SETTLED * size[open_]
        open_ = open_[~done]
        if not len(open_):
            break
    return heights, places


def _first_of_highest(
    top: Floats, place: Floats, rows: Whole, heights: Floats, places: Floats
) -> tuple[Floats, Floats]:
    """Of all peaks of a row the first of those that are as high as the highest."""
    highest = top.copy()
    np.maximum.at(highest, rows, heights)
    alike = heights >= highest[rows] - SAME_HEIGHT * np.abs(highest[rows])
    first = np.full(len(top), np.inf)
    np.minimum.at(first, rows[alike], places[alike])
    return highest, np.where(np.isfinite(first), first, place)


def local_maxima(values: Floats, between: Callable[[Floats], Floats]) -> Extremes:
    """Local maxima of a series with given samples, ends included, in the order of time."""
    last = len(values) - 1
    higher = np.isfinite(values)
    higher[1:] &= values[1:] >= values[:-1]
    higher[:-1] &= values[:-1] >= values[1:]
    tops = np.flatnonzero(higher)
    if last < 2 or not len(tops):
        return Extremes(values[tops], tops.astype(float))
    first = np.clip(tops - 1, 0, last - 2)
    windows = values[first[:, None] + np.arange(3)]
    result = largest_between(windows, lambda which, places: between(first[which] + places))
    known = np.isfinite(result.value)
    places, kept = np.unique(np.where(known, first + result.place, tops), return_index=True)
    return Extremes(np.where(known, result.value, values[tops])[kept], places)


ROUND_OFF = 1e-9
"""Part of the scale of a series below which its values are round-off, and have no peaks."""

_TRUSTED = 0.01
"""Part of a peak up to which polynomials must agree on it; else the largest sample is given."""

_ALIKE = 1e-7
"""Part by which peaks must differ to be told apart: the first of those alike is given."""

_PLACES = np.linspace(-1.0, 1.0, 41)
"""Where a peak is looked for, in samples from the largest one nearby."""

_FIVE, _BEFORE, _BEHIND = (-2, -1, 0, 1, 2), (-2, -1, 0, 1), (-1, 0, 1, 2)
"""Samples that a polynomial goes through; the two shorter rows say how well it is determined."""


class Peak(NamedTuple):
    """A largest absolute value, its time in samples, and by which part the motion may exceed it."""

    value: float
    time: float
    missed: float


def even(time: Floats) -> bool:
    """Whether samples are equally spaced, so that polynomials through them locate peaks."""
    steps = np.abs(np.diff(time))
    spread = steps.max(initial=0.0) - steps.min(initial=np.inf)
    return bool(spread <= 1e-6 * steps.max(initial=0.0))  # times are read from texts as well


def largest(series: Floats, scale: float) -> Peak:
    """The largest absolute value of evenly spaced samples, between them where they resolve it.

    The polynomial of degree 4 through five samples locates it; those of degree 3 through four of
    them give the error.
    """
    sizes = np.abs(series)
    index = int(np.argmax(sizes))
    sampled = Peak(float(series[index]), float(index), 0.0)
    if not ROUND_OFF * scale < sizes[index] < np.inf:
        return sampled
    bound = _bound(series, index)
    peaks = _tops(sizes)
    if not peaks.size:
        return sampled._replace(missed=bound)
    places, heights = _through(series, peaks, _FIVE)
    missed = np.max(
        [np.abs(_through(series, peaks, stencil)[1] - heights) for stencil in (_BEFORE, _BEHIND)],
        axis=0,
    )
    best = int(np.argmax(heights >= heights.max() * (1 - _ALIKE)))  # the first of those alike
    # the largest sample may be an end, or the peak; one or two samples do not resolve a peak
    higher = heights[best] > sizes[index] * (1 + _ALIKE)
    if not higher or missed[best] > _TRUSTED * heights[best]:
        return sampled._replace(missed=min(1.2 * bound, _excess(heights + missed, sizes[index])))
    sign = np.sign(series[peaks[best]])
    value, time = float(sign * heights[best]), float(peaks[best] + places[best])
    return Peak(value, time, min(bound, _excess(heights + missed, heights[best])))


def _excess(most: Floats, found: float) -> float:
    return max(0.0, float(most.max() / found - 1.0))


def _bound(series: Floats, index: int) -> float:
    """Part by which a motion may exceed its largest sample.

    A peak half way between two samples at a distance h is h²|f″|/8 above both. Of m equal peaks,
    one is likely to be m times as close to a sample.
    """
    if not 0 < index < len(series) - 1:
        return 0.0
    bend = series[index - 1] - 2 * series[index] + series[index + 1]
    single = float(abs(bend / (8 * series[index])))
    sizes = np.abs(series)
    inner = sizes[1:-1]
    peaks = (inner >= sizes[:-2]) & (inner > sizes[2:]) & (inner >= (1 - single) * sizes[index])
    return single / max(1, int(peaks.sum())) ** 2


def _tops(sizes: Floats) -> NDArray[np.int64]:
    """Samples that are larger than their neighbours, if a peak near them may be the largest."""
    if len(sizes) < 5:
        return np.zeros(0, dtype=np.int64)
    inner = sizes[2:-2]
    tops = (inner >= sizes[1:-3]) & (inner > sizes[3:-1])
    bends = 2 * inner - sizes[1:-3] - sizes[3:-1]
    reach = inner + np.where(tops, 0.5 * bends, 0.0)
    return np.flatnonzero(tops & (reach >= sizes.max())) + 2


def _through(
    series: Floats, peaks: NDArray[np.int64], stencil: tuple[int, ...]
) -> tuple[Floats, Floats]:
    """Where polynomials through samples beside peaks are largest, and how large, (peaks,) each."""
    nodes = np.array(stencil, dtype=float)
    samples = series[peaks[:, None] + np.array(stencil)] * np.sign(series[peaks])[:, None]
    values = samples @ cardinals(nodes, _PLACES).T
    at = np.clip(np.argmax(values, axis=1), 1, len(_PLACES) - 2)
    before, here, after = (values[np.arange(len(peaks)), at + k] for k in (-1, 0, 1))
    bend = before - 2 * here + after
    moved = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1.0), 0.0)
    moved = np.clip(moved, -1.0, 1.0)
    return _PLACES[at] + moved * (_PLACES[1] - _PLACES[0]), here - 0.25 * (before - after) * moved


ALIKE = 1e-7
"""Part by which a largest and a least value must differ in size for the later one to be larger."""

LEAST = 1e-9
"""Part of the size of a series by which it must exceed a sample for a peak between samples."""


class Extreme(NamedTuple):
    """A value and its time, in SI."""

    value: float
    time: float


def extreme_rows(dense: DenseMotion, name: str) -> list[dict[str, Any]]:
    """A row for each series of a variable, as `Solution.maxima` describes them."""
    if name not in dense.rows:
        rows = _rows(dense, name)
        dense.rows[name] = _of_largest(dense, rows) if name == REACTION else rows
    return dense.rows[name]


def _of_largest(dense: DenseMotion, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of joints; where three bodies or more meet that of the body with the largest force."""
    result = {row["element"]: row for row in rows}
    for row in extreme_rows(dense, PIN):
        joint = row["element"].rpartition(".")[0]
        if result[joint]["element"] == joint or row["value"] > result[joint]["value"]:
            result[joint] = row | {"variable": REACTION, "long_name": result[joint]["long_name"]}
    return [*result.values()]


def _rows(dense: DenseMotion, name: str) -> list[dict[str, Any]]:
    variable = VARIABLES[name]
    if variable.flags or variable.reciprocal:  # states have no size, what has poles no largest one
        return []
    if variable.dims[-1:] == ("axis",) and not variable.magnitude:
        return []
    table, names = series_of(dense, name)
    if not len(table):
        return []
    units, long_name = variable.described(dense.system.model)
    rows = []
    for element, least, greatest, missed in zip(
        names, *_located(dense, name, table, _scale(dense, name, table)), strict=True
    ):
        value, time = farthest(least, greatest)
        rows.append(
            {
                "variable": name,
                "element": element,
                "value": value,
                "time": time,
                "least": least.value,
                "least_time": least.time,
                "greatest": greatest.value,
                "greatest_time": greatest.time,
                "units": units,
                "long_name": long_name,
                "missed": missed,
            }
        )
    return rows


def farthest(least: Extreme, greatest: Extreme) -> Extreme:
    """Which of two is farther from zero; of two alike the earlier one."""
    size = max(abs(least.value), abs(greatest.value))
    if abs(abs(least.value) - abs(greatest.value)) > ALIKE * size:
        return max(least, greatest, key=lambda found: abs(found.value))
    return min(least, greatest, key=lambda found: (abs(found.time), -found.value))


def series_of(dense: DenseMotion, name: str) -> tuple[Floats, list[str]]:
    """Series of a variable, shape (samples, elements), and their names: magnitudes of vectors."""
    dims = [dim for dim in VARIABLES[name].dims if dim != "axis"]
    names = [", ".join(place) for place in product(*(labels(dense.system.model, d) for d in dims))]
    return _magnitudes(name, dense.values(name)), names


def _magnitudes(name: str, values: Floats) -> Floats:
    if VARIABLES[name].magnitude:
        with np.errstate(over="ignore"):  # where it is infinite; squares overflow much sooner
            values = np.hypot(values[..., 0], values[..., 1])
    return values.reshape(len(values), math.prod(values.shape[1:]))


def _located(
    dense: DenseMotion, name: str, table: Floats, scale: float
) -> tuple[list[Extreme], list[Extreme], list[float]]:
    """Least and largest values, and by what part the motion may exceed them."""
    finite = np.isfinite(table).all(axis=0)
    spread = np.ptp(np.where(finite, table, 0.0), axis=0)
    lively = np.flatnonzero(finite & (spread > ROUND_OFF * scale))
    steady = finite & (spread <= ROUND_OFF * scale)
    result = [_sampled(sign * table, steady) for sign in (-1.0, 1.0)]
    missed = np.zeros(table.shape[1])
    variable = VARIABLES[name]
    if not dense.close:
        smooth = variable.smooth and even(dense.time)
        missed[:] = [largest(row, scale if smooth else np.inf).missed for row in table.T]
    elif len(lively) and not variable.noise:
        half, series = len(lively), table[:, lively].T

        def between(which: NDArray[np.int64], places: Floats) -> Floats:
            values = _magnitudes(name, dense.between(name, places))
            found = values[np.arange(len(places)), lively[which % half]]
            return np.where(which < half, -found, found)

        # both at once: what a look costs hardly depends on the number of places
        better = largest_between(np.concatenate([-series, series]), between)
        sizes = np.abs(series).max(axis=1)
        for part, extremes in zip((slice(half), slice(half, None)), result, strict=True):
            value, place = better.value[part], better.place[part]
            higher = value > extremes.value[lively] + LEAST * sizes
            extremes.value[lively[higher]] = value[higher]
            extremes.place[lively[higher]] = place[higher]
    count = np.arange(len(dense.time))
    least, greatest = (
        [
            Extreme(float(sign * value) + 0.0, float(np.interp(place, count, dense.time)))
            for value, place in zip(*extremes, strict=True)
        ]
        for sign, extremes in zip((-1.0, 1.0), result, strict=True)
    )
    return least, greatest, missed.tolist()


def _sampled(table: Floats, steady: NDArray[np.bool_]) -> Extremes:
    """Largest samples; of series that are steady but for round-off, or no numbers, the first."""
    known = np.where(np.isnan(table), -np.inf, table)
    place = np.where(steady, 0, np.argmax(known, axis=0))
    return Extremes(table[place, np.arange(table.shape[1])], place.astype(float))


def _scale(dense: DenseMotion, name: str, table: Floats) -> float:
    """Scale of round-off: accelerations of a steady motion are compared with speeds."""
    variable = VARIABLES[name]
    size = float(np.max(np.abs(table), initial=0.0, where=np.isfinite(table)))
    rates = {item.rate: speed for speed, item in VARIABLES.items() if item.rate}
    speed = rates.get(variable.compared or name)
    if speed is None or speed not in rates or len(dense.time) < 2:
        return size
    spacing = abs(float(dense.time[1] - dense.time[0]))
    values = dense.values(speed)
    return max(size, float(np.nanmax(np.abs(values), initial=0.0)) / spacing)
