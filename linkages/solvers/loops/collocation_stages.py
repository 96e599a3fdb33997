"""Stages of collocation methods: fixed-point iteration and Newton's method.

The accelerations of the stages are the unknowns, see `collocation_steps`, also for references.
Newton's method takes the derivatives at the start of a step, and eliminates coordinates and speeds.
"""

from __future__ import annotations

import math

from linkages.kernel.code.operands import Int, IntArray, Real, RealArray, fma, maximum, select, sqrt
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.memory import NOT_SETTLED, Motion
from linkages.solvers.loops.scalar_stages import call_clock, call_rates, evaluate, finite

# Of Gauss's iteration, which ends where changes cease to shrink [1]_. A change that does so above
# this fraction of the accelerations is no round-off: the iteration does not converge.
ITERATIONS = 50
SETTLED = 1e-9
# Of Newton's iteration, with the derivatives at the start of the step.
NEWTON_ITERATIONS = 7
# Derivatives by differences: a change relative to the larger of an entry of the state and 1.
DIFFERENCE = 1.5e-8


@traced
def set_clocks(code: Procedure, motion: Motion, t: Real, h: Real) -> Int:
    """Evaluate what depends on time alone at every stage; iterations do not change it."""
    method = motion.collocation
    with code.for_range(method.stages) as i:
        timed = method.timed.after(i * method.timed_size)
        status = motion.clock(Int, fma(motion.c[1 + i], h, t), motion.parameters, timed)
        code.return_if(status != 0, status)
    return code.value(0)


@traced
def place_stages(code: Procedure, motion: Motion, first: Int, h: Real) -> None:
    """Write the coordinates and speeds of all stages, from their accelerations."""
    method = motion.collocation
    n, s, width = motion.n, method.stages, motion.width
    rows, A, AA, c = motion.rows, method.A, method.AA, motion.c.after(1)
    with code.for_range(s) as i:
        row = (first + i) * width
        with code.for_range(n) as k:
            single, double = code.variable(0.0), code.variable(0.0)
            with code.for_range(s) as j:
                acceleration = rows[(first + j) * width + 2 * n + k]
                single.set(fma(A[i * s + j], acceleration, single))
                double.set(fma(AA[i * s + j], acceleration, double))
            moved = fma(h, double, c[i] * rows[n + k])
            rows[row + k] = fma(h, moved, rows[k])
            rows[row + n + k] = fma(h, single, rows[n + k])


@traced
def evaluate_stages(code: Procedure, motion: Motion, first: Int) -> Int:
    """Evaluate all stages; returns the status.

    `kept` takes their accelerations before, `changes` the largest change of one, and the largest.
    """
    method, n, width = motion.collocation, motion.n, motion.width
    rows, kept = motion.rows, method.kept
    change, largest = code.variable(0.0), code.variable(0.0)
    with code.for_range(method.stages) as i:
        state = motion.row(first + i)
        base = (first + i) * width + 2 * n
        with code.for_range(n) as k:
            kept[i * n + k] = rows[base + k]
        motion.counters.evaluations += 1
        timed = method.timed.after(i * method.timed_size)
        status = motion.rates(Int, state, motion.parameters, timed, state.after(2 * n))
        code.return_if(~finite(motion, first + i, select(status == 0, 3 * n, 2 * n)), NOT_SETTLED)
        code.return_if(status != 0, status)
        with code.for_range(n) as k:
            change.set(maximum(change, abs(rows[base + k] - kept[i * n + k])))
            largest.set(maximum(largest, abs(rows[base + k])))
    result = method.changes
    result[0], result[1] = change, largest
    return code.value(0)


@traced
def iterate(code: Procedure, motion: Motion, first: Int, t: Real, h: Real) -> Int:
    """Solve the stages in rows first, first + 1, … of a step from row 0 by fixed-point iteration.

    They start from the accelerations there. Returns 0, 1 + block, NOT_FINITE, or NOT_SETTLED.
    """
    method, status = motion.collocation, set_clocks(motion, t, h)
    code.return_if(status != 0, status)
    before = code.variable(math.inf)
    with code.for_range(ITERATIONS):
        place_stages(motion, first, h)
        status = evaluate_stages(motion, first)
        code.return_if(status != 0, status)
        change, largest = method.changes[0], method.changes[1]
        settled = ~(change < before) & (change <= SETTLED * largest)
        code.return_if((change == 0.0) | settled, 0)
        before.set(change)
    return code.value(NOT_SETTLED)


@traced
def differentiate(code: Procedure, motion: Motion) -> None:
    """Derivatives of the accelerations in row 0 by differences, away from what is out of reach."""
    n, width, rows = motion.n, motion.width, motion.rows
    slopes, aside = motion.collocation.slopes, motion.scratch
    with code.for_range(2 * n) as j:
        with code.for_range(n) as k:
            slopes[2 * n * k + j] = code.value(0.0)
        with code.for_range(2) as side:
            motion.row(aside).take(rows, 2 * n)
            length = DIFFERENCE * maximum(abs(rows[j]), code.value(1.0))
            rows[aside * width + j] += select(side == 0, length, -length)
            motion.counters.evaluations += 1
            status = evaluate(motion, aside)
            with code.if_((status == 0) & finite(motion, aside, 3 * n)):
                change = rows[aside * width + j] - rows[j]
                with code.for_range(n) as k:
                    moved = rows[aside * width + 2 * n + k] - rows[2 * n + k]
                    slopes[2 * n * k + j] = moved / change
                code.break_()


@traced
def linearise(code: Procedure, motion: Motion, t: Real) -> Int:
    """Derivatives of the accelerations in row 0, unless they are those of the last trial."""
    method = motion.collocation
    start, rows, held = method.start, motion.rows, motion.held
    modes, known = start.after(1 + 3 * motion.n), code.variable(start[0] == t)
    with code.for_range(3 * motion.n) as i:
        known.set(known & (start[1 + i] == rows[i]))
    with code.for_range(motion.holding) as i:
        known.set(known & (modes[i] == held[i]))
    code.return_if(known, 0)
    linear, status = method.linear, code.variable(0)
    with code.if_(linear.clock.exists) as case:
        status.set(call_clock(linear, t))
        with code.if_(status == 0):
            status.set(call_rates(linear, motion.rows, method.slopes))
    with case.else_():
        status.set(call_clock(motion, t))
        differentiate(motion)
    start[0] = select(status == 0, t, math.nan)
    start.after(1).take(rows, 3 * motion.n)
    modes.take(held, motion.holding)
    return code.value(status)


@traced
def factorise(code: Procedure, size: Int, m: RealArray, pivots: IntArray) -> None:
    """Factors L and U of a matrix, in its place, with partial pivoting."""
    with code.for_range(size) as c:
        best, most = code.variable(c), code.variable(abs(m[c * size + c]))
        with code.for_range(size - c - 1) as below:
            row = c + 1 + below
            with code.if_(abs(m[row * size + c]) > most):
                most.set(abs(m[row * size + c]))
                best.set(row)
        pivots[c] = best
        with code.if_(best != c), code.for_range(size) as k:
            one, other = m[c * size + k], m[best * size + k]
            m[c * size + k], m[best * size + k] = other, one
        with code.for_range(size - c - 1) as below:
            row = (c + 1 + below) * size
            factor = m[row + c] / m[c * size + c]
            m[row + c] = factor
            with code.if_(factor != 0.0), code.for_range(size - c - 1) as further:
                k = c + 1 + further
                m[row + k] = fma(-factor, m[c * size + k], m[row + k])


@traced
def solve(code: Procedure, size: Int, m: RealArray, pivots: IntArray, x: RealArray) -> None:
    """Solve linear equations whose matrix has been factorised, in the place of the right side."""
    with code.for_range(size) as c:
        chosen = pivots[c]
        one, other = x[c], x[chosen]
        x[c], x[chosen] = other, one
    with code.for_range(size) as row, code.for_range(row) as k:
        x[row] = fma(-m[row * size + k], x[k], x[row])
    with code.for_range(size) as above:
        row = size - 1 - above
        with code.for_range(above) as further:
            k = row + 1 + further
            x[row] = fma(-m[row * size + k], x[k], x[row])
        x[row] = x[row] / m[row * size + row]


@traced
def write_scale(code: Procedure, motion: Motion) -> None:
    """Errors of coordinates and speeds that are allowed at row 0."""
    rtol, rows = motion.stepper.rtol, motion.rows
    with code.for_range(2 * motion.n) as i:
        motion.collocation.scale[i] = fma(rtol, abs(rows[i]), motion.atol[i])


@traced
def write_matrix(code: Procedure, motion: Motion, h: Real) -> None:
    """The matrix of Newton's method, ``1 - h A ∂a/∂v - h² A² ∂a/∂q``."""
    method = motion.collocation
    n, s = motion.n, method.stages
    size, m, slopes = s * n, method.matrix, method.slopes
    with code.for_range(s) as i, code.for_range(s) as j:
        single = -h * method.A[i * s + j]
        double = -h * (h * method.AA[i * s + j])
        with code.for_range(n) as k, code.for_range(n) as column:
            unit = select((i == j) & (k == column), code.value(1.0), 0.0)
            by_place, by_speed = slopes[2 * n * k + column], slopes[2 * n * k + n + column]
            entry = fma(single, by_speed, fma(double, by_place, unit))
            m[(i * n + k) * size + j * n + column] = entry


@traced
def correct(code: Procedure, motion: Motion, h: Real) -> Real:
    """Correct the accelerations once; returns the mean change of states over what is allowed."""
    method = motion.collocation
    n, s, width, rows = motion.n, method.stages, motion.width, motion.rows
    residual, kept, scale = method.residual, method.kept, method.scale
    with code.for_range(s) as i, code.for_range(n) as k:
        residual[i * n + k] = rows[(1 + i) * width + 2 * n + k] - kept[i * n + k]
    solve(s * n, method.matrix, method.pivots, method.residual)
    total = code.variable(0.0)
    with code.for_range(s) as i, code.for_range(n) as k:
        change = residual[i * n + k]
        rows[(1 + i) * width + 2 * n + k] = kept[i * n + k] + change
        gained, moved = h * change / scale[n + k], h * (h * change) / scale[k]
        total.set(total + (gained * gained + moved * moved))
    return sqrt(total / maximum(2 * s * n, code.value(1)).to_real)


@traced
def evaluate_switches(code: Procedure, motion: Motion) -> Int:
    """Evaluate stages again where modes change: what was written belongs to the last iterate."""
    method = motion.collocation
    code.return_if(motion.holding == 0, 0)
    n, rows = motion.n, motion.rows
    status = evaluate_stages(motion, 1)
    with code.for_range(method.stages) as i, code.for_range(n) as k:
        rows[(1 + i) * motion.width + 2 * n + k] = method.kept[i * n + k]
    return status


@traced
def solve_by_newton(code: Procedure, motion: Motion, t: Real, h: Real) -> Int:
    """Solve the stages of a step from row 0 by Newton's method; returns as `iterate`.

    The stages are left with accelerations that fit their states: those that the kernel computes
    for stiff equations are amplified round-off.
    """
    method, status = motion.collocation, code.variable(linearise(motion, t))
    with code.if_(status == 0):
        status.set(set_clocks(motion, t, h))
    code.return_if(status != 0, status)
    write_scale(motion)
    write_matrix(motion, h)
    factorise(method.stages * motion.n, method.matrix, method.pivots)
    tolerance, before = method.newton_tolerance[0], code.variable(math.inf)
    iterations = method.newton_tolerance
    with code.for_range(NEWTON_ITERATIONS) as made:
        place_stages(motion, 1, h)
        status.set(evaluate_stages(motion, 1))
        code.return_if(status != 0, status)
        size = correct(motion, h)
        iterations[1] = (made + 1).to_real
        rate = size / before
        left = select(made > 0, rate / (1.0 - rate) * size, 10.0 * size)
        settled = (rate < 1.0) & (left < tolerance)
        # round-off does not shrink
        settled = settled | (size == 0.0) | ((rate > 0.5) & (size < tolerance))
        with code.if_(settled):
            place_stages(motion, 1, h)
            code.return_(evaluate_switches(motion))
        code.return_if(~(rate < 1.0), NOT_SETTLED)
        before.set(size)
    return code.value(NOT_SETTLED)
