"""Renormalisation of deviation vectors at samples of a run.

The steps go on: nothing ends at such a time. Tangents obey linear equations, so what is done to
them at a sample within a step may as well be done to those at its end. In between they are brought
back at the end of a step wherever they have come so far apart that errors of a step would show in
the shortest of them or one has become very long, so that exponents do not depend on how far samples
are apart.

References
----------
.. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21.
.. [2] Å. Björck, Numer. Math. 51 (1987): Gram–Schmidt; twice is enough.
"""

from __future__ import annotations

import math
from typing import Any

from linkages.kernel.code.operands import (
    Real,
    Truth,
    Whole,
    choose,
    elementary,
    floats,
    integers,
    larger_of,
    root_of,
    smaller_of,
)
from linkages.kernel.code.procedure import Procedure, printed
from linkages.solvers.flow import LONGEST, MOST_DOUBT
from linkages.solvers.loops.memory import (
    BEFORE_CHANGE,
    BEHIND_CHANGE,
    EVALUATIONS,
    SAMPLES,
    START,
    WORD,
    Record,
    SystemView,
    Tangents,
)
from linkages.solvers.loops.scalar_stages import call_hook, evaluate_at

SYSTEM_WORDS, RECORD_WORDS = len(SystemView._fields), len(Record._fields)

# What is left of a tangent that has shrunk this far beside others is their round-off to so many
# digits. Accelerations would keep the round-off of theirs, which fits no step: they are new then.
MOST_LOST = 1e-8
# Sticking and contacts that close take directions away. How many is known from modes; but of one
# that was lost before no more than this is left, round-off alone. It is zero from then on.
TAKEN = 1e-12


@printed
def product(
    code: Procedure, n: Whole, size: Whole, placed: Whole, one: Whole, other: Whole
) -> Real:
    """Scalar product of two tangents at their addresses: places, then n words on their rates.

    Places behind the first `placed` ones mean nothing.
    """
    a, b, total = floats(one), floats(other), code.variable(0.0)
    with code.count(placed) as i:
        total.set(total + (a[i] * b[i] + a[n + i] * b[n + i]))
    with code.count(size - placed) as k:
        i = placed + k
        total.set(total + a[n + i] * b[n + i])
    return code.value(total)


@printed
def subtract(
    code: Procedure, n: Whole, parts: Whole, size: Whole, factor: Real, one: Whole, other: Whole
) -> None:
    """Subtract a multiple of a tangent from another one, with their rates."""
    a, b = floats(one), floats(other)
    with code.count(parts) as part, code.count(size) as i:
        b[part * n + i] -= factor * a[part * n + i]


@printed
def scale(code: Procedure, n: Whole, parts: Whole, size: Whole, factor: Real, one: Whole) -> None:
    """Multiply a tangent with its rates."""
    a = floats(one)
    with code.count(parts) as part, code.count(size) as i:
        a[part * n + i] *= factor


@printed
def orthogonalise(
    code: Procedure, system: SystemView, tangents: Tangents,
    samples: Whole, count: Whole, column: Whole,
) -> None:  # fmt: skip
    """Subtract from a tangent its parts along those before it, at all samples and in row 0."""
    n, size, memories = system.n, tangents.size, tangents.memories
    begin = WORD * (n - tangents.columns * size)
    here, first = system.rows + begin, samples + begin
    at, own = choose(count > 0, first, here), WORD * column * size
    moved = floats(tangents.moved)
    with code.count(column) as before:
        other = WORD * before * size
        factor = product(n, size, tangents.placed, at + other, at + own)
        with code.count(count) as k:
            later = first + WORD * 2 * n * k
            subtract(n, 2, size, factor, later + other, later + own)
        subtract(n, 3, size, factor, here + other, here + own)
        with code.count(memories) as r:
            moved[column * memories + r] -= factor * moved[before * memories + r]


@printed
def shorten(
    code: Procedure, system: SystemView, tangents: Tangents,
    samples: Whole, count: Whole, column: Whole, length: Real,
) -> None:  # fmt: skip
    """Divide a tangent by its length, at all samples and in row 0; by infinity it is taken away."""
    n, size, memories = system.n, tangents.size, tangents.memories
    own = WORD * (n - tangents.columns * size + column * size)
    with code.count(count) as k:
        scale(n, 2, size, 1.0 / length, samples + own + WORD * 2 * n * k)
    scale(n, 3, size, 1.0 / length, system.rows + own)
    with code.count(memories) as r:
        floats(tangents.moved)[column * memories + r] /= length


@printed
def forget_integrals(code: Procedure, system: SystemView, tangents: Tangents) -> None:
    """Set to zero in row 0 what means nothing: integrals of internal states along tangents.

    They do not shrink with their tangents, so that dividing by lengths would make them overflow.
    """
    n, size, rows = system.n, tangents.size, floats(system.rows)
    with code.count(tangents.columns) as column, code.count(size - tangents.placed) as i:
        rows[n - (tangents.columns - column) * size + tangents.placed + i] = 0.0


@printed
def renormalise(
    code: Procedure, system: SystemView, tangents: Tangents,
    samples: Whole, count: Whole, most: Whole, round_off: Real,
) -> Real:  # fmt: skip
    """Renormalise tangents at the first of some samples, in row 0 where there are none.

    Those at the other samples and in row 0 follow, and what is remembered, which belongs to the
    state, but has no part in lengths. No more than `most` are left, nor those whose lengths are
    round-off: the others are zero. Adds the logarithms of their lengths to what they have grown by,
    −∞ of those that are zero; returns the least length.
    """
    n, size, placed = system.n, tangents.size, tangents.placed
    at = choose(count > 0, samples, system.rows) + WORD * (n - tangents.columns * size)
    least, grown = code.variable(math.inf), floats(tangents.grown)
    forget_integrals(system, tangents)
    left = code.variable(most)
    with code.count(tangents.columns) as column:
        own = at + WORD * column * size
        total, whole = code.variable(1.0), product(n, size, placed, own, own)
        with code.count(1 + tangents.orthogonal):
            with code.when(tangents.orthogonal != 0):
                orthogonalise(system, tangents, samples, count, column)
            length = code.variable(root_of(product(n, size, placed, own, own)))
            total.set(total * length)
            taken = (left == 0) | (total <= round_off * larger_of(root_of(whole), 1.0))
            with code.when(taken):
                total.set(0.0)
                length.set(math.inf)
            shorten(system, tangents, samples, count, column, length)
            with code.when(taken):
                code.stop()
        with code.when(total > 0.0) as case:
            grown[column] += elementary("log", total)
            least.set(smaller_of(least, total))
            left.set(left - 1)
        with case.otherwise():
            grown[column] = -math.inf
    return code.value(least)


@printed
def stretched(code: Procedure, system: SystemView, tangents: Tangents) -> Truth:
    """Whether errors of the next steps would show in the shortest tangent in row 0.

    Or the longest one is too long.
    """
    n, size, columns = system.n, tangents.size, tangents.columns
    here, width = floats(system.rows + WORD * (n - columns * size)), columns * size
    copy, placed = floats(tangents.copy), tangents.placed
    with code.count(width) as i:
        copy[i], copy[width + i] = here[i], here[n + i]
    least, longest = code.variable(math.inf), code.variable(0.0)
    with code.count(columns) as column:
        own = tangents.copy + WORD * column * size
        with code.count(column * tangents.orthogonal) as before:
            other = tangents.copy + WORD * before * size
            square = product(width, size, placed, other, other)
            with code.when(square > 0.0):
                factor = product(width, size, placed, other, own) / square
                subtract(width, 2, size, factor, other, own)
        length = root_of(product(width, size, placed, own, own))
        longest.set(larger_of(longest, length))
        with code.when(length > 0.0):
            least.set(smaller_of(least, length))
    rtol, atol = floats(tangents.tolerances)[0], floats(tangents.tolerances)[1]
    doubt = larger_of(rtol * longest, atol)
    return (longest > LONGEST) | (doubt > MOST_DOUBT * least)


def renew(system: Any, record: Any, t: Real) -> None:
    """Evaluate row 0 again."""
    integers(record.counters)[EVALUATIONS] += 1
    evaluate_at(system, t, 0)


def constrain(code: Procedure, tangents: Any, t: Real, behind: bool) -> Whole:
    """Project tangents in row 0 as modes want it; returns how many directions are left of all."""
    rank = call_hook(tangents.project, tangents.context, t, code.value(float(behind)), t)
    return tangents.size + tangents.placed - rank.whole


@printed
def most_left(code: Procedure, tangents: Tangents, directions: Whole) -> Whole:
    """How many tangents are left in so many directions: all that may depend on each other."""
    with code.when(tangents.orthogonal == 0), code.when(directions > 0):
        code.leave(tangents.columns)
    return smaller_of(directions, tangents.columns)


@printed
def begin_tangents(
    code: Procedure, system: SystemView, record: Record, tangents: Tangents, t: Real
) -> None:
    """Turn tangents at the start into the directions that modes leave them; they do not grow by it.

    Where there are fewer directions than tangents, those that are left are made orthonormal.
    """
    n, size, columns, placed = system.n, tangents.size, tangents.columns, tangents.placed
    here, kept = system.rows + WORD * (n - columns * size), floats(tangents.copy)
    present, grown = code.variable(0), floats(tangents.grown)
    with code.count(columns) as column:
        own = here + WORD * column * size
        kept[column] = root_of(product(n, size, placed, own, own))
        present.set(present + (kept[column] > 0.0).whole)
    directions = constrain(code, tangents, t, False)
    with code.when(directions == size + placed):
        code.leave()
    with code.count(columns) as column:
        own = here + WORD * column * size
        length = root_of(product(n, size, placed, own, own))
        with code.when(length > 0.0):
            scale(n, 2, size, kept[column] / length, own)
    most = most_left(tangents, directions)
    with code.when(present > most):
        with code.count(columns) as column:
            kept[column] = grown[column]
        renormalise(system, tangents, code.value(0), code.value(0), most, code.value(TAKEN))
        with code.count(columns) as column, code.when(grown[column] > -math.inf):
            grown[column] = kept[column]
    renew(system, record, t)


@printed
def cross_change(
    code: Procedure, system: SystemView, record: Record, tangents: Tangents, t: Real, when: Real
) -> None:
    """Make tangents orthonormal before a change of a mode, and see behind it which are left."""
    nothing, all_of_them = code.value(0), code.value(tangents.columns)
    with code.when(when == BEFORE_CHANGE):
        renormalise(system, tangents, nothing, nothing, all_of_them, code.value(0.0))
        code.leave()
    most = most_left(tangents, constrain(code, tangents, t, True))
    renormalise(system, tangents, nothing, nothing, most, code.value(TAKEN))
    renew(system, record, t)


@printed
def watch_tangents(code: Procedure, context: Whole, t: Real, when: Real, t_end: Real) -> Real:  # noqa: ARG001
    """Renormalise the tangents at samples that were taken since the last call, and if need be."""
    system = code.fields_at(context, SystemView)
    record = code.fields_at(context, Record, SYSTEM_WORDS)
    tangents = code.fields_at(context, Tangents, SYSTEM_WORDS + RECORD_WORDS)
    seen, samples = integers(tangents.seen), integers(record.counters)[SAMPLES]
    grown, columns = floats(tangents.grown), tangents.columns
    with code.when((when == START) & (tangents.project != 0)):
        begin_tangents(system, record, tangents, t)
    with code.when((when == BEFORE_CHANGE) | (when == BEHIND_CHANGE)):
        with code.when(tangents.project != 0):
            cross_change(system, record, tangents, t, when)
        code.leave(0.0)
    least, done = code.variable(math.inf), code.variable(False)
    with code.during(lambda: seen[0] < samples):
        number = seen[0] + tangents.offset + 1
        with code.when(number % tangents.every == 0):
            state = record.state + WORD * seen[0] * 2 * system.n
            later = samples - seen[0]
            shortest = renormalise(system, tangents, state, later, columns, code.value(0.0))
            row = number // tangents.every - 1
            with code.count(columns) as column:
                floats(tangents.lengths)[row * columns + column] = grown[column]
                grown[column] = 0.0
            least.set(smaller_of(least, shortest))
            done.set(True)
        seen[0] += 1
    with code.when(stretched(system, tangents)):
        nothing = code.value(0)
        shortest = renormalise(system, tangents, nothing, nothing, columns, code.value(0.0))
        least.set(smaller_of(least, shortest))
        done.set(True)
    with code.when(done & (tangents.project != 0)):
        directions = constrain(code, tangents, t, False)
        with code.when(directions < tangents.size + tangents.placed):
            least.set(0.0)
    with code.when(least < MOST_LOST):
        renew(system, record, t)
    return code.value(0.0)
