"""Largest and least values of all outputs of a motion, located between its samples."""

from __future__ import annotations

import math
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, labels
from linkages.solution.measuring.dense import Dense
from linkages.solution.measuring.located import Extremes, largest_between
from linkages.solution.values.peaks import ROUND_OFF, even, largest
from linkages.solution.values.requests import PIN, REACTION

Floats = NDArray[np.float64]

ALIKE = 1e-7
"""Part by which a largest and a least value must differ in size for the later one to be larger."""

LEAST = 1e-9
"""Part of the size of a series by which it must exceed a sample for a peak between samples."""


class Extreme(NamedTuple):
    """A value and its time, in SI."""

    value: float
    time: float


def extreme_rows(dense: Dense, name: str) -> list[dict[str, Any]]:
    """A row for each series of a variable, as `Solution.maxima` describes them."""
    if name not in dense.rows:
        rows = _rows(dense, name)
        dense.rows[name] = _of_largest(dense, rows) if name == REACTION else rows
    return dense.rows[name]


def _of_largest(dense: Dense, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of joints; where three bodies or more meet that of the body with the largest force."""
    found = {row["element"]: row for row in rows}
    for row in extreme_rows(dense, PIN):
        joint = row["element"].rpartition(".")[0]
        if found[joint]["element"] == joint or row["value"] > found[joint]["value"]:
            found[joint] = row | {"variable": REACTION, "long_name": found[joint]["long_name"]}
    return [*found.values()]


def _rows(dense: Dense, name: str) -> list[dict[str, Any]]:
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


def series_of(dense: Dense, name: str) -> tuple[Floats, list[str]]:
    """Series of a variable, shape (samples, elements), and their names: magnitudes of vectors."""
    dims = [dim for dim in VARIABLES[name].dims if dim != "axis"]
    names = [", ".join(place) for place in product(*(labels(dense.system.model, d) for d in dims))]
    return _magnitudes(name, dense.values(name)), names


def _magnitudes(name: str, values: Floats) -> Floats:
    if VARIABLES[name].magnitude:
        with np.errstate(over="ignore"):  # where it is infinite; squares overflow much sooner
            values = np.hypot.reduce(values, axis=-1)
    return values.reshape(len(values), math.prod(values.shape[1:]))


def _located(
    dense: Dense, name: str, table: Floats, scale: float
) -> tuple[list[Extreme], list[Extreme], list[float]]:
    """Least and largest values, and by what part the motion may exceed them."""
    finite = np.isfinite(table).all(axis=0)
    spread = np.ptp(np.where(finite, table, 0.0), axis=0)
    lively = np.flatnonzero(finite & (spread > ROUND_OFF * scale))
    steady = finite & (spread <= ROUND_OFF * scale)
    found = [_sampled(sign * table, steady) for sign in (-1.0, 1.0)]
    missed = np.zeros(table.shape[1])
    variable = VARIABLES[name]
    if not dense.close:
        smooth = variable.smooth and even(dense.time)
        missed[:] = [largest(row, scale if smooth else np.inf).missed for row in table.T]
    elif len(lively) and not variable.noise:
        for sign, extremes in zip((-1.0, 1.0), found, strict=True):

            def between(which: NDArray[np.int64], places: Floats, sign: float = sign) -> Floats:
                values = _magnitudes(name, dense.between(name, places))
                return sign * values[np.arange(len(places)), lively[which]]

            better = largest_between(sign * table[:, lively].T, between)
            sizes = np.abs(table[:, lively]).max(axis=0)
            higher = better.value > extremes.value[lively] + LEAST * sizes
            extremes.value[lively[higher]] = better.value[higher]
            extremes.place[lively[higher]] = better.place[higher]
    count = np.arange(len(dense.time))
    least, greatest = (
        [
            Extreme(float(sign * value) + 0.0, float(np.interp(place, count, dense.time)))
            for value, place in zip(*extremes, strict=True)
        ]
        for sign, extremes in zip((-1.0, 1.0), found, strict=True)
    )
    return least, greatest, missed.tolist()


def _sampled(table: Floats, steady: NDArray[np.bool_]) -> Extremes:
    """Largest samples; of series that are steady but for round-off, or no numbers, the first."""
    known = np.where(np.isnan(table), -np.inf, table)
    place = np.where(steady, 0, np.argmax(known, axis=0))
    return Extremes(table[place, np.arange(table.shape[1])], place.astype(float))


def _scale(dense: Dense, name: str, table: Floats) -> float:
    """Size of which small parts are round-off.

    A steady motion has accelerations that are round-off alone: they are small beside speeds over
    the time between samples.
    """
    variable = VARIABLES[name]
    size = float(np.max(np.abs(table), initial=0.0, where=np.isfinite(table)))
    rates = {found.rate: speed for speed, found in VARIABLES.items() if found.rate}
    speed = rates.get(variable.compared or name)
    if speed is None or speed not in rates or len(dense.time) < 2:
        return size
    spacing = abs(float(dense.time[1] - dense.time[0]))
    values = dense.values(speed)
    return max(size, float(np.nanmax(np.abs(values), initial=0.0)) / spacing)
