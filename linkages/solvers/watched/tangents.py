"""Tangents that are made orthonormal, or of length one, at some of the samples of a run.

The steps go on: nothing ends at such a time. Tangents obey linear equations, so what is done to
them at a sample within a step may as well be done to those at its end. Compiled by the first run
that has tangents.

References
----------
.. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21.
.. [2] Å. Björck, Numer. Math. 51 (1987): Gram–Schmidt; twice is enough.
"""

from __future__ import annotations

import math

from linkages.solvers.steps.compiled import compiled, floats, integers, tuple_at
from linkages.solvers.steps.stages import evaluate, set_clock
from linkages.solvers.steps.views import EVALUATIONS, SAMPLES, WORD, Record, System, Tangents

system_at, record_at, tangents_at = tuple_at(System), tuple_at(Record), tuple_at(Tangents)
SYSTEM_WORDS, RECORD_WORDS = len(System._fields), len(Record._fields)

# What is left of a tangent that has shrunk this far beside others is their round-off to so many
# digits. Accelerations would keep the round-off of theirs, which fits no step: they are new then.
MOST_LOST = 1e-8


@compiled
def product(n: int, size: int, placed: int, one: int, other: int) -> float:
    """Scalar product of two tangents at their addresses: places, then n words on their rates.

    Places behind the first `placed` ones mean nothing.
    """
    a, b = floats(one), floats(other)
    total = 0.0
    for i in range(placed):
        total += a[i] * b[i] + a[n + i] * b[n + i]
    for i in range(placed, size):
        total += a[n + i] * b[n + i]
    return total


@compiled
def subtract(n: int, parts: int, size: int, factor: float, one: int, other: int) -> None:
    """Subtract a multiple of a tangent from another one, with their rates."""
    a, b = floats(one), floats(other)
    for part in range(parts):
        for i in range(size):
            b[part * n + i] -= factor * a[part * n + i]


@compiled
def scale(n: int, parts: int, size: int, factor: float, one: int) -> None:
    """Multiply a tangent with its rates."""
    a = floats(one)
    for part in range(parts):
        for i in range(size):
            a[part * n + i] *= factor


@compiled
def renormalise(system: System, record: Record, tangents: Tangents, sample: int, row: int) -> float:
    """Renormalise tangents at a sample; those at later samples and in row 0 follow.

    Writes the logarithms of their lengths into a row of the record; returns the least length.
    """
    least = math.inf
    n, size, placed = system.n, tangents.size, tangents.placed
    begin = WORD * (n - tangents.columns * size)
    state = record.state + WORD * sample * 2 * n + begin
    here, lengths = system.rows + begin, floats(tangents.lengths)
    samples = integers(record.counters)[SAMPLES]
    # of what is remembered: it belongs to the state, but has no part in lengths
    memories, moved = tangents.memories, floats(tangents.moved)
    for column in range(tangents.columns):
        own = WORD * column * size
        total = 1.0
        for _ in range(1 + tangents.orthogonal):
            for before in range(column * tangents.orthogonal):
                other = WORD * before * size
                factor = product(n, size, placed, state + other, state + own)
                subtract(n, 2, size, factor, state + other, state + own)
                for k in range(1, samples - sample):
                    later = state + WORD * k * 2 * n
                    subtract(n, 2, size, factor, later + other, later + own)
                subtract(n, 3, size, factor, here + other, here + own)
                for r in range(memories):
                    moved[column * memories + r] -= factor * moved[before * memories + r]
            length = math.sqrt(product(n, size, placed, state + own, state + own))
            total *= length
            scale(n, 2, size, 1.0 / length, state + own)
            for k in range(1, samples - sample):
                scale(n, 2, size, 1.0 / length, state + WORD * k * 2 * n + own)
            scale(n, 3, size, 1.0 / length, here + own)
            for r in range(memories):
                moved[column * memories + r] /= length
        lengths[row * tangents.columns + column] = math.log(total)
        least = min(least, total)
    return least


@compiled
def watch_tangents(context: int, t: float, h: float, t_end: float) -> float:  # noqa: ARG001
    """Renormalise the tangents at samples that were taken since the last call."""
    system = system_at(context)
    record = record_at(context + WORD * SYSTEM_WORDS)
    tangents = tangents_at(context + WORD * (SYSTEM_WORDS + RECORD_WORDS))
    seen = integers(tangents.seen)
    while seen[0] < integers(record.counters)[SAMPLES]:
        number = seen[0] + tangents.offset + 1
        if number % tangents.every == 0:
            row = number // tangents.every - 1
            least = renormalise(system, record, tangents, seen[0], row)
            if least < MOST_LOST:
                integers(record.counters)[EVALUATIONS] += 1
                set_clock(system, t_end)
                evaluate(system, 0)
        seen[0] += 1
    return 0.0
