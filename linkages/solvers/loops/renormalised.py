"""Renormalisation of deviation vectors at samples of a run.

Tangents obey linear equations, so what is done to them at a sample within a step may as well be
done at its end. They are also renormalised at the end of a step wherever errors of steps would show
in the shortest of them or one is very long, so that exponents do not depend on the samples.

References
----------
.. [1] G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21.
.. [2] Å. Björck, Numer. Math. 51 (1987): Gram–Schmidt; twice is enough.
"""

from __future__ import annotations

import math

from linkages.kernel.code.elementary_functions import elementary
from linkages.kernel.code.operands import Bool, Int, Real, RealArray, maximum, minimum, sqrt
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.flow import LONGEST, MOST_DOUBT
from linkages.solvers.loops.memory import BEFORE_CHANGE, BEHIND_CHANGE, START, Motion
from linkages.solvers.loops.scalar_stages import evaluate_at

# What is left of a tangent that has shrunk this far beside others is their round-off to so many
# digits. Accelerations would keep the round-off of theirs, which fits no step: they are new then.
MOST_LOST = 1e-8
# Sticking and contacts that close take directions away. How many is known from modes; but of one
# that was lost before no more than this is left, round-off alone. It is zero from then on.
NEGLIGIBLE = 1e-12


@traced
def product(
    code: Procedure, n: Int, size: Int, placed: Int, one: RealArray, other: RealArray
) -> Real:
    """Scalar product of two tangents: `placed` places, then n words on their rates."""
    total = code.variable(0.0)
    with code.for_range(placed) as i:
        total.set(total + (one[i] * other[i] + one[n + i] * other[n + i]))
    with code.for_range(size - placed) as k:
        i = placed + k
        total.set(total + one[n + i] * other[n + i])
    return code.value(total)


@traced
def subtract(
    code: Procedure, n: Int, parts: Int, size: Int, factor: Real, one: RealArray, other: RealArray
) -> None:
    """Subtract a multiple of a tangent from another one, with their rates."""
    with code.for_range(parts) as part, code.for_range(size) as i:
        other[part * n + i] -= factor * one[part * n + i]


@traced
def scale(code: Procedure, n: Int, parts: Int, size: Int, factor: Real, one: RealArray) -> None:
    """Multiply a tangent with its rates."""
    with code.for_range(parts) as part, code.for_range(size) as i:
        one[part * n + i] *= factor


def first_tangent(motion: Motion, state: RealArray) -> RealArray:
    """The first tangent in a state; the others follow."""
    return state.after(motion.n - motion.tangents.columns * motion.tangents.size)


@traced
def orthogonalise(
    code: Procedure, motion: Motion, samples: RealArray, count: Int, column: Int
) -> None:
    """Subtract from a tangent its parts along those before it, at all samples and in row 0."""
    tangents = motion.tangents
    n, size, memories = motion.n, tangents.size, tangents.memories
    here, first = first_tangent(motion, motion.rows), first_tangent(motion, samples)
    own, moved = column * size, tangents.moved
    with code.for_range(column) as before:
        other = before * size
        factor = product(n, size, tangents.placed, first.after(other), first.after(own))
        with code.for_range(count) as k:
            later = first.after(2 * n * k)
            subtract(n, 2, size, factor, later.after(other), later.after(own))
        subtract(n, 3, size, factor, here.after(other), here.after(own))
        with code.for_range(memories) as r:
            moved[column * memories + r] -= factor * moved[before * memories + r]


@traced
def shorten(
    code: Procedure, motion: Motion, samples: RealArray, count: Int, column: Int, length: Real
) -> None:
    """Divide a tangent by its length, at all samples and in row 0; by infinity it is taken away."""
    tangents = motion.tangents
    n, size, memories = motion.n, tangents.size, tangents.memories
    own, first = column * size, first_tangent(motion, samples)
    with code.for_range(count) as k:
        scale(n, 2, size, 1.0 / length, first.after(own + 2 * n * k))
    scale(n, 3, size, 1.0 / length, first_tangent(motion, motion.rows).after(own))
    with code.for_range(memories) as r:
        tangents.moved[column * memories + r] /= length


@traced
def forget_integrals(code: Procedure, motion: Motion) -> None:
    """Set to zero in row 0 what means nothing: integrals of internal states along tangents.

    They do not shrink with their tangents, so that dividing by lengths would make them overflow.
    """
    tangents = motion.tangents
    n, size, rows = motion.n, tangents.size, motion.rows
    with code.for_range(tangents.columns) as column, code.for_range(size - tangents.placed) as i:
        rows[n - (tangents.columns - column) * size + tangents.placed + i] = 0.0


@traced
def renormalise(
    code: Procedure, motion: Motion, samples: RealArray, count: Int, most: Int, round_off: Real
) -> Real:
    """Renormalise tangents at the first of some samples, or in row 0 if their number is 0.

    Those at other samples and in row 0 follow, and so do those of latched values, which have no
    part in lengths. At most `most` are left, of lengths above `round_off`: the others are zero.
    Adds the logarithms of lengths (−∞ of zeros) to what tangents have grown by; returns the least
    length.
    """
    tangents = motion.tangents
    n, size, placed = motion.n, tangents.size, tangents.placed
    first = first_tangent(motion, samples)
    least, grown = code.variable(math.inf), tangents.grown
    forget_integrals(motion)
    left = code.variable(most)
    with code.for_range(tangents.columns) as column:
        own = first.after(column * size)
        total, whole = code.variable(1.0), product(n, size, placed, own, own)
        with code.for_range(1 + tangents.orthogonal):
            with code.if_(tangents.orthogonal != 0):
                orthogonalise(motion, samples, count, column)
            length = code.variable(sqrt(product(n, size, placed, own, own)))
            total.set(total * length)
            taken = (left == 0) | (total <= round_off * maximum(sqrt(whole), 1.0))
            with code.if_(taken):
                total.set(0.0)
                length.set(math.inf)
            shorten(motion, samples, count, column, length)
            code.break_if(taken)
        with code.if_(total > 0.0) as case:
            grown[column] += elementary("log", total)
            least.set(minimum(least, total))
            left.set(left - 1)
        with case.else_():
            grown[column] = -math.inf
    return code.value(least)


@traced
def stretched(code: Procedure, motion: Motion) -> Bool:
    """Whether errors would show in the shortest tangent in row 0, or one is too long."""
    tangents = motion.tangents
    n, size, columns = motion.n, tangents.size, tangents.columns
    here, width = first_tangent(motion, motion.rows), columns * size
    copy, placed = tangents.copy, tangents.placed
    with code.for_range(width) as i:
        copy[i], copy[width + i] = here[i], here[n + i]
    least, longest = code.variable(math.inf), code.variable(0.0)
    with code.for_range(columns) as column:
        own = copy.after(column * size)
        with code.for_range(column * tangents.orthogonal) as before:
            other = copy.after(before * size)
            square = product(width, size, placed, other, other)
            with code.if_(square > 0.0):
                factor = product(width, size, placed, other, own) / square
                subtract(width, 2, size, factor, other, own)
        length = sqrt(product(width, size, placed, own, own))
        longest.set(maximum(longest, length))
        with code.if_(length > 0.0):
            least.set(minimum(least, length))
    rtol, atol = tangents.tolerances[0], tangents.tolerances[1]
    doubt = maximum(rtol * longest, atol)
    return (longest > LONGEST) | (doubt > MOST_DOUBT * least)


def renew(motion: Motion, t: Real) -> None:
    """Evaluate row 0 again."""
    motion.counters.evaluations += 1
    evaluate_at(motion, t, 0)


def constrain(code: Procedure, motion: Motion, t: Real, behind: bool) -> Int:
    """Project tangents in row 0 as modes want it; returns how many directions are left of all."""
    rank = motion.tangents.project(Int, motion, t, code.value(int(behind)))
    return motion.tangents.size + motion.tangents.placed - rank


@traced
def most_left(code: Procedure, motion: Motion, directions: Int) -> Int:
    """How many tangents are left in so many directions: all that may depend on each other."""
    tangents = motion.tangents
    with code.if_(tangents.orthogonal == 0), code.if_(directions > 0):
        code.return_(tangents.columns)
    return minimum(directions, tangents.columns)


@traced
def begin_tangents(code: Procedure, motion: Motion, t: Real) -> None:
    """Turn tangents at the start into the directions that modes leave them; they do not grow by it.

    Where there are fewer directions than tangents, those that are left are made orthonormal.
    """
    tangents = motion.tangents
    n, size, columns, placed = motion.n, tangents.size, tangents.columns, tangents.placed
    here, kept = first_tangent(motion, motion.rows), tangents.copy
    present, grown = code.variable(0), tangents.grown
    with code.for_range(columns) as column:
        own = here.after(column * size)
        kept[column] = sqrt(product(n, size, placed, own, own))
        present.set(present + (kept[column] > 0.0).to_int)
    directions = constrain(code, motion, t, False)
    code.return_if(directions == size + placed)
    with code.for_range(columns) as column:
        own = here.after(column * size)
        length = sqrt(product(n, size, placed, own, own))
        with code.if_(length > 0.0):
            scale(n, 2, size, kept[column] / length, own)
    most = most_left(motion, directions)
    with code.if_(present > most):
        with code.for_range(columns) as column:
            kept[column] = grown[column]
        renormalise(motion, motion.rows, 0, most, NEGLIGIBLE)
        with code.for_range(columns) as column, code.if_(grown[column] > -math.inf):
            grown[column] = kept[column]
    renew(motion, t)


@traced
def cross_change(code: Procedure, motion: Motion, t: Real, when: Real) -> None:
    """Make tangents orthonormal before a change of a mode, and see behind it which are left."""
    with code.if_(when == BEFORE_CHANGE):
        renormalise(motion, motion.rows, 0, motion.tangents.columns, 0.0)
        code.return_()
    most = most_left(motion, constrain(code, motion, t, True))
    renormalise(motion, motion.rows, 0, most, NEGLIGIBLE)
    renew(motion, t)


@traced
def watch_tangents(code: Procedure, motion: Motion, t: Real, when: Real) -> Int:
    """Renormalise the tangents at samples that were taken since the last call, and if need be."""
    tangents = motion.tangents
    seen, samples = tangents.seen, motion.counters.samples
    grown, columns = tangents.grown, tangents.columns
    with code.if_((when == START) & (tangents.project.exists)):
        begin_tangents(motion, t)
    with code.if_((when == BEFORE_CHANGE) | (when == BEHIND_CHANGE)):
        with code.if_(tangents.project.exists):
            cross_change(motion, t, when)
        code.return_(0)
    least, done = code.variable(math.inf), code.variable(False)
    with code.while_(lambda: seen[0] < samples):
        number = seen[0] + tangents.offset + 1
        with code.if_(number % tangents.every == 0):
            state = motion.states.after(seen[0] * 2 * motion.n)
            later = samples - seen[0]
            shortest = renormalise(motion, state, later, columns, 0.0)
            row = number // tangents.every - 1
            with code.for_range(columns) as column:
                tangents.lengths[row * columns + column] = grown[column]
                grown[column] = 0.0
            least.set(minimum(least, shortest))
            done.set(True)
        seen[0] += 1
    with code.if_(stretched(motion)):
        shortest = renormalise(motion, motion.rows, 0, columns, 0.0)
        least.set(minimum(least, shortest))
        done.set(True)
    with code.if_(done & (tangents.project.exists)):
        directions = constrain(code, motion, t, False)
        with code.if_(directions < tangents.size + tangents.placed):
            least.set(0.0)
    with code.if_(least < MOST_LOST):
        renew(motion, t)
    return code.value(0)
