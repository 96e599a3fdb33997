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
    Bool,
    Int,
    Real,
    elementary,
    floats,
    integers,
    maximum,
    minimum,
    select,
    sqrt,
)
from linkages.kernel.code.procedure import Procedure, traced
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
NEGLIGIBLE = 1e-12


@traced
def product(code: Procedure, n: Int, size: Int, placed: Int, one: Int, other: Int) -> Real:
    """Scalar product of two tangents at their addresses: places, then n words on their rates.

    Places behind the first `placed` ones mean nothing.
    """
    a, b, total = floats(one), floats(other), code.variable(0.0)
    with code.for_range(placed) as i:
        total.set(total + (a[i] * b[i] + a[n + i] * b[n + i]))
    with code.for_range(size - placed) as k:
        i = placed + k
        total.set(total + a[n + i] * b[n + i])
    return code.value(total)


@traced
def subtract(
    code: Procedure,
    n: Int,
    parts: Int,
    size: Int,
    factor: Real,
    one: Int,
    other: Int,
) -> None:
    """Subtract a multiple of a tangent from another one, with their rates."""
    a, b = floats(one), floats(other)
    with code.for_range(parts) as part, code.for_range(size) as i:
        b[part * n + i] -= factor * a[part * n + i]


@traced
def scale(code: Procedure, n: Int, parts: Int, size: Int, factor: Real, one: Int) -> None:
    """Multiply a tangent with its rates."""
    a = floats(one)
    with code.for_range(parts) as part, code.for_range(size) as i:
        a[part * n + i] *= factor


@traced
def orthogonalise(
    code: Procedure, system: SystemView, tangents: Tangents,
    samples: Int, count: Int, column: Int,
) -> None:  # fmt: skip
    """Subtract from a tangent its parts along those before it, at all samples and in row 0."""
    n, size, memories = system.n, tangents.size, tangents.memories
    begin = WORD * (n - tangents.columns * size)
    here, first = system.rows + begin, samples + begin
    at, own = select(count > 0, first, here), WORD * column * size
    moved = floats(tangents.moved)
    with code.for_range(column) as before:
        other = WORD * before * size
        factor = product(n, size, tangents.placed, at + other, at + own)
        with code.for_range(count) as k:
            later = first + WORD * 2 * n * k
            subtract(n, 2, size, factor, later + other, later + own)
        subtract(n, 3, size, factor, here + other, here + own)
        with code.for_range(memories) as r:
            moved[column * memories + r] -= factor * moved[before * memories + r]


@traced
def shorten(
    code: Procedure, system: SystemView, tangents: Tangents,
    samples: Int, count: Int, column: Int, length: Real,
) -> None:  # fmt: skip
    """Divide a tangent by its length, at all samples and in row 0; by infinity it is taken away."""
    n, size, memories = system.n, tangents.size, tangents.memories
    own = WORD * (n - tangents.columns * size + column * size)
    with code.for_range(count) as k:
        scale(n, 2, size, 1.0 / length, samples + own + WORD * 2 * n * k)
    scale(n, 3, size, 1.0 / length, system.rows + own)
    with code.for_range(memories) as r:
        floats(tangents.moved)[column * memories + r] /= length


@traced
def forget_integrals(code: Procedure, system: SystemView, tangents: Tangents) -> None:
    """Set to zero in row 0 what means nothing: integrals of internal states along tangents.

    They do not shrink with their tangents, so that dividing by lengths would make them overflow.
    """
    n, size, rows = system.n, tangents.size, floats(system.rows)
    with code.for_range(tangents.columns) as column, code.for_range(size - tangents.placed) as i:
        rows[n - (tangents.columns - column) * size + tangents.placed + i] = 0.0


@traced
def renormalise(
    code: Procedure, system: SystemView, tangents: Tangents,
    samples: Int, count: Int, most: Int, round_off: Real,
) -> Real:  # fmt: skip
    """Renormalise tangents at the first of some samples, in row 0 where there are none.

    Those at the other samples and in row 0 follow, and what is remembered, which belongs to the
    state, but has no part in lengths. No more than `most` are left, nor those whose lengths are
    round-off: the others are zero. Adds the logarithms of their lengths to what they have grown by,
    −∞ of those that are zero; returns the least length.
    """
    n, size, placed = system.n, tangents.size, tangents.placed
    at = select(count > 0, samples, system.rows) + WORD * (n - tangents.columns * size)
    least, grown = code.variable(math.inf), floats(tangents.grown)
    forget_integrals(system, tangents)
    left = code.variable(most)
    with code.for_range(tangents.columns) as column:
        own = at + WORD * column * size
        total, whole = code.variable(1.0), product(n, size, placed, own, own)
        with code.for_range(1 + tangents.orthogonal):
            with code.if_(tangents.orthogonal != 0):
                orthogonalise(system, tangents, samples, count, column)
            length = code.variable(sqrt(product(n, size, placed, own, own)))
            total.set(total * length)
            taken = (left == 0) | (total <= round_off * maximum(sqrt(whole), 1.0))
            with code.if_(taken):
                total.set(0.0)
                length.set(math.inf)
            shorten(system, tangents, samples, count, column, length)
            with code.if_(taken):
                code.break_()
        with code.if_(total > 0.0) as case:
            grown[column] += elementary("log", total)
            least.set(minimum(least, total))
            left.set(left - 1)
        with case.else_():
            grown[column] = -math.inf
    return code.value(least)


@traced
def stretched(code: Procedure, system: SystemView, tangents: Tangents) -> Bool:
    """Whether errors of the next steps would show in the shortest tangent in row 0.

    Or the longest one is too long.
    """
    n, size, columns = system.n, tangents.size, tangents.columns
    here, width = floats(system.rows + WORD * (n - columns * size)), columns * size
    copy, placed = floats(tangents.copy), tangents.placed
    with code.for_range(width) as i:
        copy[i], copy[width + i] = here[i], here[n + i]
    least, longest = code.variable(math.inf), code.variable(0.0)
    with code.for_range(columns) as column:
        own = tangents.copy + WORD * column * size
        with code.for_range(column * tangents.orthogonal) as before:
            other = tangents.copy + WORD * before * size
            square = product(width, size, placed, other, other)
            with code.if_(square > 0.0):
                factor = product(width, size, placed, other, own) / square
                subtract(width, 2, size, factor, other, own)
        length = sqrt(product(width, size, placed, own, own))
        longest.set(maximum(longest, length))
        with code.if_(length > 0.0):
            least.set(minimum(least, length))
    rtol, atol = floats(tangents.tolerances)[0], floats(tangents.tolerances)[1]
    doubt = maximum(rtol * longest, atol)
    return (longest > LONGEST) | (doubt > MOST_DOUBT * least)


def renew(system: Any, record: Any, t: Real) -> None:
    """Evaluate row 0 again."""
    integers(record.counters)[EVALUATIONS] += 1
    evaluate_at(system, t, 0)


def constrain(code: Procedure, tangents: Any, t: Real, behind: bool) -> Int:
    """Project tangents in row 0 as modes want it; returns how many directions are left of all."""
    rank = call_hook(tangents.project, tangents.context, t, code.value(float(behind)), t)
    return tangents.size + tangents.placed - rank.to_int


@traced
def most_left(code: Procedure, tangents: Tangents, directions: Int) -> Int:
    """How many tangents are left in so many directions: all that may depend on each other."""
    with code.if_(tangents.orthogonal == 0), code.if_(directions > 0):
        code.return_(tangents.columns)
    return minimum(directions, tangents.columns)


@traced
def begin_tangents(
    code: Procedure, system: SystemView, record: Record, tangents: Tangents, t: Real
) -> None:
    """Turn tangents at the start into the directions that modes leave them; they do not grow by it.

    Where there are fewer directions than tangents, those that are left are made orthonormal.
    """
    n, size, columns, placed = system.n, tangents.size, tangents.columns, tangents.placed
    here, kept = system.rows + WORD * (n - columns * size), floats(tangents.copy)
    present, grown = code.variable(0), floats(tangents.grown)
    with code.for_range(columns) as column:
        own = here + WORD * column * size
        kept[column] = sqrt(product(n, size, placed, own, own))
        present.set(present + (kept[column] > 0.0).to_int)
    directions = constrain(code, tangents, t, False)
    with code.if_(directions == size + placed):
        code.return_()
    with code.for_range(columns) as column:
        own = here + WORD * column * size
        length = sqrt(product(n, size, placed, own, own))
        with code.if_(length > 0.0):
            scale(n, 2, size, kept[column] / length, own)
    most = most_left(tangents, directions)
    with code.if_(present > most):
        with code.for_range(columns) as column:
            kept[column] = grown[column]
        renormalise(system, tangents, code.value(0), code.value(0), most, code.value(NEGLIGIBLE))
        with code.for_range(columns) as column, code.if_(grown[column] > -math.inf):
            grown[column] = kept[column]
    renew(system, record, t)


@traced
def cross_change(
    code: Procedure, system: SystemView, record: Record, tangents: Tangents, t: Real, when: Real
) -> None:
    """Make tangents orthonormal before a change of a mode, and see behind it which are left."""
    nothing, all_of_them = code.value(0), code.value(tangents.columns)
    with code.if_(when == BEFORE_CHANGE):
        renormalise(system, tangents, nothing, nothing, all_of_them, code.value(0.0))
        code.return_()
    most = most_left(tangents, constrain(code, tangents, t, True))
    renormalise(system, tangents, nothing, nothing, most, code.value(NEGLIGIBLE))
    renew(system, record, t)


@traced
def watch_tangents(code: Procedure, context: Int, t: Real, when: Real, t_end: Real) -> Real:  # noqa: ARG001
    """Renormalise the tangents at samples that were taken since the last call, and if need be."""
    system = code.fields_at(context, SystemView)
    record = code.fields_at(context, Record, SYSTEM_WORDS)
    tangents = code.fields_at(context, Tangents, SYSTEM_WORDS + RECORD_WORDS)
    seen, samples = integers(tangents.seen), integers(record.counters)[SAMPLES]
    grown, columns = floats(tangents.grown), tangents.columns
    with code.if_((when == START) & (tangents.project != 0)):
        begin_tangents(system, record, tangents, t)
    with code.if_((when == BEFORE_CHANGE) | (when == BEHIND_CHANGE)):
        with code.if_(tangents.project != 0):
            cross_change(system, record, tangents, t, when)
        code.return_(0.0)
    least, done = code.variable(math.inf), code.variable(False)
    with code.while_(lambda: seen[0] < samples):
        number = seen[0] + tangents.offset + 1
        with code.if_(number % tangents.every == 0):
            state = record.state + WORD * seen[0] * 2 * system.n
            later = samples - seen[0]
            shortest = renormalise(system, tangents, state, later, columns, code.value(0.0))
            row = number // tangents.every - 1
            with code.for_range(columns) as column:
                floats(tangents.lengths)[row * columns + column] = grown[column]
                grown[column] = 0.0
            least.set(minimum(least, shortest))
            done.set(True)
        seen[0] += 1
    with code.if_(stretched(system, tangents)):
        nothing = code.value(0)
        shortest = renormalise(system, tangents, nothing, nothing, columns, code.value(0.0))
        least.set(minimum(least, shortest))
        done.set(True)
    with code.if_(done & (tangents.project != 0)):
        directions = constrain(code, tangents, t, False)
        with code.if_(directions < tangents.size + tangents.placed):
            least.set(0.0)
    with code.if_(least < MOST_LOST):
        renew(system, record, t)
    return code.value(0.0)
