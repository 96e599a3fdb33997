"""Steps of collocation methods: Gauss's by fixed-point iteration, Radau's by Newton's method.

With ``q' = v, v' = a`` the accelerations of the stages are the unknowns::

    V_i = v + h Σ_j A_ij a_j,    Q_i = q + h c_i v + h² Σ_j (A²)_ij a_j

They start from the polynomial through those of the step before, and the end of a step is summed
with compensation [1]_.

References
----------
.. [1] E. Hairer, R. I. McLachlan, A. Razakarivony, "Achieving Brouwer's law with implicit
       Runge–Kutta methods", BIT 48 (2008), 231–243.
.. [2] E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
       section IV.8.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    RealArray,
    fma,
    maximum,
    minimum,
    select,
    sqrt,
)
from linkages.kernel.code.procedure import Procedure, traced
from linkages.solvers.loops.collocation_stages import (
    NEWTON_ITERATIONS,
    factorise,
    iterate,
    solve,
    solve_by_newton,
)
from linkages.solvers.loops.control import (
    LEAST_ERROR,
    MOST_CHANGE,
    SHRINK_TURNING,
    begin_trial,
    finest_step,
)
from linkages.solvers.loops.memory import BEGUN, HISTORY, NOT_FINITE, REACHED, SPAN, Motion
from linkages.solvers.loops.scalar_stages import evaluate_at, finite

# Steps that are longer by more than the one before start from constant accelerations.
MOST_AHEAD = 2.0
# Step control [2]_.
SAFETY, SHRINK_MOST, GROW_MOST = 0.9, 0.2, 10.0
FLAGGED = 1


def carry_of(history: RealArray) -> RealArray:
    """What the end of a step is too small by."""
    return history.after(HISTORY)


def accelerations_of(history: RealArray, n: Int) -> RealArray:
    """Accelerations of the stages of a step; those at its end follow."""
    return history.after(HISTORY + 2 * n)


@traced
def commit_history(code: Procedure, motion: Motion, t: Real) -> None:
    """Take the last trial for the step before where the next one begins at its end."""
    method = motion.collocation
    tried, committed = method.tried, method.committed
    code.return_if((tried[REACHED] != t) | (tried[BEGUN] == t))
    committed.take(tried, HISTORY + (3 + method.stages) * motion.n)


@traced
def write_history(code: Procedure, motion: Motion, t: Real, h: Real, t_end: Real) -> None:
    """Note the step in the workspace as the last trial."""
    method = motion.collocation
    n, s, rows, tried = motion.n, method.stages, motion.rows, method.tried
    tried[BEGUN], tried[REACHED], tried[SPAN] = t, t_end, h
    slopes = accelerations_of(method.tried, n)
    with code.for_range(s + 1) as i, code.for_range(n) as k:
        slopes[i * n + k] = rows[(1 + i) * motion.width + 2 * n + k]


@traced
def goes_on(_code: Procedure, motion: Motion, k: Int) -> Bool:
    """Whether nothing has changed a coordinate in row 0 since the step before."""
    method, n = motion.collocation, motion.n
    end = accelerations_of(method.committed, n)[method.stages * n + k]
    return end == motion.rows[2 * n + k]


@traced
def weigh_ahead(code: Procedure, motion: Motion, ratio: Real) -> None:
    """Weights of starting values for a step that is so many times as long as the one before."""
    method = motion.collocation
    m, x, ahead = method.continued, method.nodes, method.ahead
    with code.for_range(method.stages) as i:
        at = fma(motion.c[1 + i], ratio, 1.0)
        with code.for_range(m) as j:
            weight = code.variable(1.0)
            with code.for_range(m) as other, code.if_(other != j):
                weight.set(weight * ((at - x[other]) / (x[j] - x[other])))
            ahead[i * m + j] = weight
    method.ratio[0] = ratio


@traced
def predict(code: Procedure, motion: Motion, t: Real, h: Real) -> None:
    """Starting values of a step: the accelerations of the one before, continued."""
    method = motion.collocation
    n, s, m, width = motion.n, method.stages, method.continued, motion.width
    rows, known = motion.rows, method.committed
    slopes, ahead = accelerations_of(method.committed, n), method.ahead
    ratio = h / known[SPAN]
    near = (known[REACHED] == t) & (ratio >= 0.0) & (ratio <= MOST_AHEAD)
    with code.if_(near & (ratio != method.ratio[0])):
        weigh_ahead(motion, ratio)
    with code.for_range(n) as k:
        follows = near & goes_on(motion, k)
        with code.for_range(s) as i:
            value = code.variable(rows[2 * n + k])
            with code.if_(follows):
                value.set(select(m > s, value * ahead[i * m + m - 1], 0.0))
                with code.for_range(s) as j:
                    value.set(fma(ahead[i * m + j], slopes[j * n + k], value))
            rows[(1 + i) * width + 2 * n + k] = value


@traced
def finish(code: Procedure, motion: Motion, first: Int, row: Int, h: Real, t: Real) -> None:
    """Write the end of a step to a row, summed with compensation."""
    method = motion.collocation
    n, s, width, known = motion.n, method.stages, motion.width, method.committed
    rows, b, bA = motion.rows, method.b, method.bA
    carry, following = carry_of(method.committed), carry_of(method.tried)
    with code.for_range(n) as k:
        single, double = code.variable(0.0), code.variable(0.0)
        with code.for_range(s) as j:
            acceleration = rows[(first + j) * width + 2 * n + k]
            single.set(fma(b[j], acceleration, single))
            double.set(fma(bA[j], acceleration, double))
        here, there = code.variable(0.0), code.variable(0.0)
        with code.if_((known[REACHED] == t) & goes_on(motion, k)):
            here.set(carry[k])
            there.set(carry[n + k])
        # The carry of the speed moves the coordinate as well.
        speed = rows[n + k] + fma(h, double, there)
        moved, gained = fma(h, speed, here), fma(h, single, there)
        rows[row * width + k] = rows[k] + moved
        rows[row * width + n + k] = rows[n + k] + gained
        with code.if_(row == s + 1):
            following[k] = (rows[k] - rows[row * width + k]) + moved
            following[n + k] = (rows[n + k] - rows[row * width + n + k]) + gained


@traced
def attempt(code: Procedure, motion: Motion) -> Int:
    """Step from row 0 to the end; returns 0, 1 + block, NOT_FINITE, or NOT_SETTLED."""
    stepper = motion.stepper
    t, h, t_end = stepper.start, stepper.length, stepper.stop
    commit_history(motion, t)
    predict(motion, t, h)
    status = code.variable(0)
    with code.if_(motion.collocation.newton != 0) as case:
        status.set(solve_by_newton(motion, t, h))
    with case.else_():
        status.set(iterate(motion, 1, t, h))
    code.return_if(status != 0, status)
    finish(motion, 1, motion.end, h, t)
    motion.counters.evaluations += 1
    status.set(evaluate_at(motion, t_end, motion.end))
    code.return_if(status != 0, status)
    code.return_if(~finite(motion, motion.end, 3 * motion.n), NOT_FINITE)
    write_history(motion, t, h, t_end)
    return code.value(0)


@traced
def further(code: Procedure, motion: Motion) -> Int:  # noqa: ARG001
    """Compute nothing: the dense output needs no further rows."""
    return code.value(0)


@traced
def interpolate(code: Procedure, motion: Motion) -> Int:
    """Write the state at the fraction `THETA` of a step into the last row, by a polynomial."""
    method, theta, h = motion.collocation, motion.stepper.theta, motion.stepper.length
    n, s, width, rows = motion.n, method.stages, motion.width, motion.rows
    dense, weights = method.dense, method.weights
    with code.for_range(2 * s) as j:
        weight = code.variable(0.0)
        with code.for_range(s) as i:
            weight.set(fma(weight, theta, dense[j * s + s - 1 - i]))
        weights[j] = weight * theta
    target = motion.scratch * width
    with code.for_range(n) as k:
        single, double = code.variable(0.0), code.variable(0.0)
        with code.for_range(s) as j:
            acceleration = rows[(1 + j) * width + 2 * n + k]
            single.set(fma(weights[j], acceleration, single))
            double.set(fma(weights[s + j], acceleration, double))
        moved = fma(h, double, rows[n + k])
        rows[target + k] = fma(h * theta, moved, rows[k])
        rows[target + n + k] = fma(h, single, rows[n + k])
    return code.value(0)


@traced
def between(code: Procedure, motion: Motion) -> Int:
    """Write the same by a step of its own, which has the order of the method; as `iterate`."""
    n, width, stepper = motion.n, motion.width, motion.stepper
    rows, first = motion.rows, motion.scratch + 1
    theta, h = stepper.theta, stepper.length
    with code.for_range(n) as k, code.for_range(motion.collocation.stages) as i:
        begun = rows[2 * n + k]
        change = rows[(1 + i) * width + 2 * n + k] - begun
        rows[(first + i) * width + 2 * n + k] = fma(theta, change, begun)
    status = iterate(motion, first, stepper.start, theta * h)
    with code.if_(status == 0):
        finish(motion, first, motion.scratch, theta * h, stepper.start)
    return status


@traced
def estimate(code: Procedure, motion: Motion, h: Real, row: Int) -> Real:
    """Error norm of the step in the workspace, with the accelerations of a row at its start.

    Hairer's estimate is ``(γ/h - J)⁻¹ (f + Σ_i e_i (Y_i - y)/h)``, with coordinates eliminated
    [2]_. It is left in `residual`: coordinates, then speeds.
    """
    method = motion.collocation
    n, s, width, rows = motion.n, method.stages, motion.width, motion.rows
    slopes, m, result = method.slopes, method.matrix, method.residual
    per_time = method.error[s] / h
    with code.for_range(n) as k:
        first = row * width + n + k
        place, speed = code.variable(rows[first]), code.variable(rows[first + n])
        with code.for_range(s) as i:
            weight, stage = method.error[i] / h, (1 + i) * width
            place.set(fma(weight, rows[stage + k] - rows[k], place))
            speed.set(fma(weight, rows[stage + n + k] - rows[n + k], speed))
        result[k], result[n + k] = place / per_time, speed
    with code.for_range(n) as k, code.for_range(n) as column:
        by_place, by_speed = slopes[2 * n * k + column], slopes[2 * n * k + n + column]
        unit = select(k == column, per_time, 0.0)
        m[k * n + column] = unit - by_speed - by_place / per_time
        result[n + k] = fma(by_place, result[column], result[n + k])
    factorise(n, method.matrix, method.pivots)
    solve(n, method.matrix, method.pivots, method.residual.after(n))
    rtol, atol = motion.stepper.rtol, motion.atol
    end, total = (s + 1) * width, code.variable(0.0)
    with code.for_range(n) as k:
        result[k] += result[n + k] / per_time
    with code.for_range(2 * n) as i:
        allowed = fma(rtol, maximum(abs(rows[i]), abs(rows[end + i])), atol[i])
        scaled = result[i] / allowed
        total.set(fma(scaled, scaled, total))
    return sqrt(total / maximum(2 * n, code.value(1)).to_real)


@traced
def error_norm(code: Procedure, motion: Motion, t: Real, h: Real) -> Real:
    """Error norm of the step in the workspace.

    Where the first estimate is too large, in a first step or one that has been rejected, it may be
    due to components that are damped at once: it is filtered once more [2]_.
    """
    n, width, rows = motion.n, motion.width, motion.rows
    error, counters = code.variable(estimate(motion, h, 0)), motion.counters
    rejected = motion.stepper.rejected_before != 0.0
    with code.if_((error > 1.0) & (rejected | (counters.steps == 0))):
        aside = motion.scratch
        with code.for_range(2 * n) as i:
            rows[aside * width + i] = rows[i] + motion.collocation.residual[i]
        counters.evaluations += 1
        with code.if_(evaluate_at(motion, t, aside) == 0):
            error.set(estimate(motion, h, aside))
    return code.value(error)


@traced
def turns_too_far(code: Procedure, motion: Motion, h: Real) -> Bool:
    """Whether links turn so far within a step that a singular position could be overlooked."""
    rates = 3 * motion.n + motion.blocks
    with code.for_range(motion.blocks) as block:
        most, limit = code.variable(0.0), MOST_CHANGE * motion.scale[block]
        with code.for_range(motion.collocation.stages + 2) as row:
            rate = motion.rows[row * motion.width + rates + block]
            most.set(maximum(most, abs(rate)))
        code.return_if(abs(h) * most > limit, True)
    return code.value(False)


def fourth_root(x: Any) -> Any:
    """Of a number that is not negative."""
    return sqrt(sqrt(x))


@traced
def judge(code: Procedure, motion: Motion, t: Real, h: Real) -> None:
    """Say what is thought of the step in the workspace, in the stepper."""
    method = motion.collocation
    stepper, known = motion.stepper, method.committed
    error = error_norm(motion, t, h)
    bounded = maximum(error, code.value(LEAST_ERROR))
    factor = code.variable(1.0 / fourth_root(bounded))
    with code.if_((known[REACHED] == t) & (known[SPAN] != 0.0) & (stepper.after_switch == 0.0)):
        before = maximum(stepper.before, code.value(LEAST_ERROR))
        grown = h / known[SPAN] * fourth_root(before / bounded)
        factor.set(factor * minimum(grown, code.value(1.0)))
    iterations = method.newton_tolerance[1]
    safety = SAFETY * (2 * NEWTON_ITERATIONS + 1) / (2 * NEWTON_ITERATIONS + iterations)
    fine = error <= 1.0
    # a step that is accepted does not lead to one that no longer moves time
    least = select(fine, finest_step(stepper, t) / abs(h), 0.0)
    least = maximum(least, code.value(SHRINK_MOST))
    factor.set(minimum(maximum(safety * factor, least), code.value(GROW_MOST)))
    far = fine & turns_too_far(motion, h)
    stepper.error = error
    shorter = minimum(factor, code.value(1.0))
    stepper.factor = select(fine, select(far, SHRINK_TURNING, factor), shorter)
    stepper.accepted = (fine & ~far).to_real


@traced
def advance(code: Procedure, motion: Motion, ticks: Int) -> Int:  # noqa: ARG001
    """Try a step of the length in the stepper, and judge it: the loop finishes it."""
    stepper = motion.stepper
    t, (h, _, _) = stepper.t, begin_trial(stepper)
    stepper.error, stepper.factor, stepper.accepted = 1.0, SHRINK_TURNING, 0.0
    status = attempt(motion)
    motion.stepper.status = status
    with code.if_(status == 0):
        judge(motion, t, h)
    return code.value(FLAGGED)
