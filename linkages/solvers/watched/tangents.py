"""Tangents that are made orthonormal, or of length one, at some of the samples of a run.

The steps go on: nothing ends at such a time. Tangents obey linear equations, so what is done to
them at a sample within a step may as well be done to those at its end. In between they are brought
back at the end of a step wherever they have come so far apart that errors of a step would show in
the shortest of them, so that exponents do not depend on how far samples are apart. Compiled by the
first run that has tangents.

References
----------
.. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21.
.. [2] Å. Björck, Numer. Math. 51 (1987): Gram–Schmidt; twice is enough.
"""

from __future__ import annotations

import math

from linkages.solvers.renormalisation import MOST_DOUBT
from linkages.solvers.steps.compiled import compiled, floats, integers, tuple_at
from linkages.solvers.steps.stages import evaluate, set_clock
from linkages.solvers.steps.views import EVALUATIONS, SAMPLES, WORD, Record, SystemView, Tangents

system_at, record_at, tangents_at = tuple_at(SystemView), tuple_at(Record), tuple_at(Tangents)
SYSTEM_WORDS, RECORD_WORDS = len(SystemView._fields), len(Record._fields)

# What is left of a tangent that has shrunk this far beside others is their round-off to so many
# digits. Accelerations would keep the round-off of theirs, which fits no step: they are new then.
MOST_LOST = 1e-8
# A contact that closes takes directions away: what is left of a tangent there is this small beside
# its length before, and round-off alone. Such a tangent is zero from then on.
TAKEN = 1e-7


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
def renormalise(system: SystemView, tangents: Tangents, samples: int, count: int) -> float:
    """Renormalise tangents at the first of some samples, in row 0 where there are none.

    Those at the other samples and in row 0 follow. Adds the logarithms of their lengths to what
    they have grown by, −∞ where a contact has taken a tangent away; returns the least length.
    """
    least = math.inf
    n, size, placed = system.n, tangents.size, tangents.placed
    begin = WORD * (n - tangents.columns * size)
    stride = WORD * 2 * n
    here, first = system.rows + begin, samples + begin
    at = first if count > 0 else here
    grown = floats(tangents.grown)
    # of what is remembered: it belongs to the state, but has no part in lengths
    memories, moved = tangents.memories, floats(tangents.moved)
    for column in range(tangents.columns):
        own = WORD * column * size
        total = 1.0
        whole = product(n, size, placed, at + own, at + own) if tangents.loses > 0 else 0.0
        for _ in range(1 + tangents.orthogonal):
            for before in range(column * tangents.orthogonal):
                other = WORD * before * size
                factor = product(n, size, placed, at + other, at + own)
                for k in range(count):
                    later = first + stride * k
                    subtract(n, 2, size, factor, later + other, later + own)
                subtract(n, 3, size, factor, here + other, here + own)
                for r in range(memories):
                    moved[column * memories + r] -= factor * moved[before * memories + r]
            length = math.sqrt(product(n, size, placed, at + own, at + own))
            total *= length
            taken = tangents.loses > 0 and total <= TAKEN * max(1.0, math.sqrt(whole))
            factor = 0.0 if taken else 1.0 / length
            for k in range(count):
                scale(n, 2, size, factor, first + stride * k + own)
            scale(n, 3, size, factor, here + own)
            for r in range(memories):
                place = column * memories + r
                moved[place] = 0.0 if taken else moved[place] / length
            if taken:
                total = 0.0
                break
        if total > 0.0:
            grown[column] += math.log(total)
            least = min(least, total)
        else:
            grown[column] = -math.inf
    return least


@compiled
def stretched(system: SystemView, tangents: Tangents) -> bool:
    """Whether errors of the next steps would show in the shortest tangent in row 0."""
    n, size, columns = system.n, tangents.size, tangents.columns
    here, width = floats(system.rows + WORD * (n - columns * size)), columns * size
    copy = floats(tangents.copy)
    for i in range(width):
        copy[i], copy[width + i] = here[i], here[n + i]
    least, longest = math.inf, 0.0
    for column in range(columns):
        own = tangents.copy + WORD * column * size
        for before in range(column * tangents.orthogonal):
            other = tangents.copy + WORD * before * size
            square = product(width, size, tangents.placed, other, other)
            if square > 0.0:
                factor = product(width, size, tangents.placed, other, own) / square
                subtract(width, 2, size, factor, other, own)
        length = math.sqrt(product(width, size, tangents.placed, own, own))
        longest = max(longest, length)
        if length > 0.0 or tangents.loses == 0:
            least = min(least, length)
    rtol, atol = floats(tangents.tolerances)[0], floats(tangents.tolerances)[1]
    return least > 0.0 and max(rtol * longest, atol) > MOST_DOUBT * least


@compiled
def renew(system: SystemView, record: Record, t: float) -> None:
    """Evaluate row 0 again."""
    integers(record.counters)[EVALUATIONS] += 1
    set_clock(system, t)
    evaluate(system, 0)


@compiled
def watch_tangents(context: int, t: float, h: float, t_end: float) -> float:  # noqa: ARG001
    """Renormalise the tangents at samples that were taken since the last call, and if need be."""
    system = system_at(context)
    record = record_at(context + WORD * SYSTEM_WORDS)
    tangents = tangents_at(context + WORD * (SYSTEM_WORDS + RECORD_WORDS))
    seen, samples = integers(tangents.seen), integers(record.counters)[SAMPLES]
    grown, columns = floats(tangents.grown), tangents.columns
    while seen[0] < samples:
        number = seen[0] + tangents.offset + 1
        if number % tangents.every == 0:
            state = record.state + WORD * seen[0] * 2 * system.n
            least = renormalise(system, tangents, state, samples - seen[0])
            row = number // tangents.every - 1
            for column in range(columns):
                floats(tangents.lengths)[row * columns + column] = grown[column]
                grown[column] = 0.0
            if least < MOST_LOST:
                renew(system, record, t_end)
        seen[0] += 1
    if stretched(system, tangents) and renormalise(system, tangents, 0, 0) < MOST_LOST:
        renew(system, record, t_end)
    return 0.0
