"""Between which values the laws of drives and loads stay, and what a file hardly means."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import TIME, Function, Measured, Table
from linkages.components.contributed.interpolation import extremes
from linkages.components.contributed.measures import Turn
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import Path
from linkages.components.laws.table import WHOLE
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.numbers.laws import law_values
from linkages.reading.paths import dotted

SAMPLES = 4001
"""Times at which the extremes of a formula are looked for."""

ROUNDS, FINER = 4, 41
"""How often they are looked for again around the best time, and at how many times."""

OVERSHOOT = 1e-3
"""Part of the range of values that a spline may leave it by without a note.

A cosine leaves the range of its values by less if there are 50 of them in a period.
"""


@dataclass(frozen=True)
class LawRange:
    """Least and largest value of a law, in SI units.

    Parameters
    ----------
    low, high
        Values that are not finite are passed over; nan if there is no other.
    period
        Seconds, of a table that repeats; None for all others.
    """

    low: float
    high: float
    period: float | None = None


def law_range(function: Function, end: float) -> LawRange:
    """The range of a law from t = 0 to `end`; of a table that repeats, over its period."""
    begin, last = sorted((0.0, end))
    if isinstance(function, Table) and function.over == TIME:
        period = function.places[-1] - function.places[0] if function.periodic else None
        return LawRange(*extremes(function, begin, last), period)
    times = np.linspace(begin, last, SAMPLES)
    return LawRange(0.0 - _largest(function, times, -1.0), 0.0 + _largest(function, times, 1.0))


def _largest(function: Function, times: NDArray[np.float64], sign: float) -> float:
    best = -np.inf
    for _ in range(1 + ROUNDS):
        values = sign * law_values(function, times)
        values = np.where(np.isfinite(values), values, -np.inf)
        place = int(np.argmax(values))
        best = max(best, float(values[place]))
        times = np.linspace(times[max(place - 1, 0)], times[min(place + 1, len(times) - 1)], FINER)
    return best if np.isfinite(best) else np.nan


def law_notes(mechanism: Mechanism) -> list[str]:
    """A sentence for each table that leaves the range of its values, or jumps as a drive.

    And for one over an angle that repeats after no part of a turn: degrees read as radians.
    """
    found = []
    for path, law, unit in _tables(mechanism):
        if law.interpolation == "spline":
            found += _outside(law, unit)
        if path[0] == "drives" and law.interpolation == "pchip":
            found.append(
                f"{dotted(path)}: the acceleration of a table with 'pchip' jumps at its times, and "
                "with it driving efforts and joint forces; 'spline' keeps it continuous"
            )
    return [*found, *_odd_turns(mechanism)]


def _tables(mechanism: Mechanism) -> Iterator[tuple[Path, Table, str]]:
    """All tables of drives and loads: path, table, and SI unit (none of a factor)."""
    for name, drive in mechanism.prescribed.items():
        unit = "rad" if mechanism.bodies[name].rotates else "m"
        yield from ((drive.path, t, unit) for t in leaves(drive.law) if isinstance(t, Table))
    for load in mechanism.loads:
        unit = load.unit if isinstance(load.law, Table) else ""
        yield from ((load.path, t, unit) for t in leaves(load.law) if isinstance(t, Table))


def _odd_turns(mechanism: Mechanism) -> Iterator[str]:
    """Tables that repeat over an angle alone, but not as a turn does."""
    for load in mechanism.loads:
        for table in (t for t in leaves(load.law) if isinstance(t, Table) and t.periodic):
            over, period = table.over, table.places[-1] - table.places[0]
            if not isinstance(over, Measured) or over.order:
                continue
            turns = period / (2 * np.pi)
            whole = any(abs(part - round(part)) < WHOLE for part in (turns, 1 / turns))
            if isinstance(over.measure or load.measure, Turn) and not whole:
                yield (
                    f"{dotted(table.path)} repeats every {period:g} rad, which is no whole number "
                    "of turns, nor a part of one; numbers without a unit are radians, not degrees"
                )


def _outside(table: Table, unit: str) -> list[str]:
    least, most = min(table.values), max(table.values)
    unit = unit and f" {unit}"
    low, high = extremes(table, table.places[0], table.places[-1])
    excess = max(least - low, high - most)
    if excess <= OVERSHOOT * (most - least):
        return []
    return [
        f"{dotted(table.path)}: the spline leaves the range of its values by {excess:.2g}{unit}, "
        f"{100 * excess / (most - least):.3g} % of this range; 'interpolation: pchip' never leaves "
        "it, and more times beside a step bend a spline less"
    ]
