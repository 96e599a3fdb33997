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
    floats,
    fma,
    integers,
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
    last_row,
    parts_of,
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
from linkages.solvers.loops.memory import (
    ACCEPTED,
    AFTER_SWITCH,
    ATOL,
    BEFORE,
    BEGUN,
    ERROR,
    EVALUATIONS,
    FACTOR,
    FROM,
    HISTORY,
    LENGTH,
    NOT_FINITE,
    REACHED,
    REJECTED_BEFORE,
    RTOL,
    SPAN,
    STATUS,
    STEPS,
    THETA,
    TO,
    WORD,
    CollocationView,
    Record,
    SystemView,
    T,
)
from linkages.solvers.loops.scalar_stages import evaluate_at, finite

# Steps that are longer by more than the one before start from constant accelerations.
MOST_AHEAD = 2.0
# Step control [2]_.
SAFETY, SHRINK_MOST, GROW_MOST = 0.9, 0.2, 10.0
FLAGGED = 1


def carry_of(history: Any) -> Any:
    """What the end of a step is too small by."""
    return floats(history + WORD * HISTORY)


def accelerations_of(history: Any, n: Any) -> Any:
    """Accelerations of the stages of a step; those at its end follow."""
    return floats(history + WORD * (HISTORY + 2 * n))


@traced
def commit_history(code: Procedure, system: SystemView, method: CollocationView, t: Real) -> None:
    """Take the last trial for the step before where the next one begins at its end."""
    tried, committed = floats(method.tried), floats(method.committed)
    with code.if_((tried[REACHED] != t) | (tried[BEGUN] == t)):
        code.return_()
    with code.for_range(HISTORY + (3 + method.stages) * system.n) as i:
        committed[i] = tried[i]


@traced
def write_history(
    code: Procedure, system: SystemView, method: CollocationView, t: Real, h: Real, t_end: Real
) -> None:
    """Note the step in the workspace as the last trial."""
    n, s, rows, tried = system.n, method.stages, floats(system.rows), floats(method.tried)
    tried[BEGUN], tried[REACHED], tried[SPAN] = t, t_end, h
    slopes = accelerations_of(method.tried, n)
    with code.for_range(s + 1) as i, code.for_range(n) as k:
        slopes[i * n + k] = rows[(1 + i) * system.width + 2 * n + k]


@traced
def goes_on(_code: Procedure, system: SystemView, method: CollocationView, k: Int) -> Bool:
    """Whether nothing has changed a coordinate in row 0 since the step before."""
    n = system.n
    end = accelerations_of(method.committed, n)[method.stages * n + k]
    return end == floats(system.rows)[2 * n + k]


@traced
def weigh_ahead(code: Procedure, method: CollocationView, ratio: Real) -> None:
    """Weights of starting values for a step that is so many times as long as the one before."""
    m, x, ahead = method.continued, floats(method.nodes), floats(method.ahead)
    with code.for_range(method.stages) as i:
        at = fma(floats(method.c)[i], ratio, 1.0)
        with code.for_range(m) as j:
            weight = code.variable(1.0)
            with code.for_range(m) as other, code.if_(other != j):
                weight.set(weight * ((at - x[other]) / (x[j] - x[other])))
            ahead[i * m + j] = weight
    floats(method.ratio)[0] = ratio


@traced
def predict(code: Procedure, system: SystemView, method: CollocationView, t: Real, h: Real) -> None:
    """Starting values of a step: the accelerations of the one before, continued."""
    n, s, m, width = system.n, method.stages, method.continued, system.width
    rows, known = floats(system.rows), floats(method.committed)
    slopes, ahead = accelerations_of(method.committed, n), floats(method.ahead)
    ratio = h / known[SPAN]
    near = (known[REACHED] == t) & (ratio >= 0.0) & (ratio <= MOST_AHEAD)
    with code.if_(near & (ratio != floats(method.ratio)[0])):
        weigh_ahead(method, ratio)
    with code.for_range(n) as k:
        follows = near & goes_on(system, method, k)
        with code.for_range(s) as i:
            value = code.variable(rows[2 * n + k])
            with code.if_(follows):
                value.set(select(m > s, value * ahead[i * m + m - 1], 0.0))
                with code.for_range(s) as j:
                    value.set(fma(ahead[i * m + j], slopes[j * n + k], value))
            rows[(1 + i) * width + 2 * n + k] = value


@traced
def finish(
    code: Procedure, system: SystemView, method: CollocationView, first: Int, row: Int,
    h: Real, t: Real,
) -> None:  # fmt: skip
    """Write the end of a step to a row, summed with compensation."""
    n, s, width, known = system.n, method.stages, system.width, floats(method.committed)
    rows, b, bA = floats(system.rows), floats(method.b), floats(method.bA)
    carry, following = carry_of(method.committed), carry_of(method.tried)
    with code.for_range(n) as k:
        single, double = code.variable(0.0), code.variable(0.0)
        with code.for_range(s) as j:
            acceleration = rows[(first + j) * width + 2 * n + k]
            single.set(fma(b[j], acceleration, single))
            double.set(fma(bA[j], acceleration, double))
        here, there = code.variable(0.0), code.variable(0.0)
        with code.if_((known[REACHED] == t) & goes_on(system, method, k)):
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
def try_collocation(
    code: Procedure, system: SystemView, method: CollocationView, record: Record
) -> Int:
    """Step from row 0 to the end; returns 0, 1 + block, NOT_FINITE, or NOT_SETTLED."""
    stepper = floats(system.stepper)
    t, h, t_end = stepper[FROM], stepper[LENGTH], stepper[TO]
    commit_history(system, method, t)
    predict(system, method, t, h)
    status = code.variable(0)
    with code.if_(method.newton != 0) as case:
        status.set(solve_by_newton(system, method, record, t, h))
    with case.else_():
        status.set(iterate(system, method, record, 1, t, h))
    with code.if_(status != 0):
        code.return_(status)
    end = method.stages + 1
    finish(system, method, 1, end, h, t)
    integers(record.counters)[EVALUATIONS] += 1
    status.set(evaluate_at(system, t_end, end))
    with code.if_(status != 0):
        code.return_(status)
    with code.if_(~finite(system, end, 3 * system.n)):
        code.return_(NOT_FINITE)
    write_history(system, method, t, h, t_end)
    return code.value(0)


@traced
def attempt(code: Procedure, pointers: Int) -> Int:
    """Step from row 0 to the end, over the time in the stepper; see `try_collocation`."""
    system, record, method = parts_of(code, pointers)
    return try_collocation(system, method, record)


@traced
def further(code: Procedure, pointers: Int) -> Int:  # noqa: ARG001
    """Compute nothing: the dense output needs no further rows."""
    return code.value(0)


@traced
def sum_between(
    code: Procedure, system: SystemView, method: CollocationView, theta: Real, h: Real
) -> None:
    """Write the state at a fraction of the step, by the polynomial of the stages."""
    n, s, width, rows = system.n, method.stages, system.width, floats(system.rows)
    dense, weights = floats(method.dense), floats(method.weights)
    with code.for_range(2 * s) as j:
        weight = code.variable(0.0)
        with code.for_range(s) as i:
            weight.set(fma(weight, theta, dense[j * s + s - 1 - i]))
        weights[j] = weight * theta
    target = last_row(method) * width
    with code.for_range(n) as k:
        single, double = code.variable(0.0), code.variable(0.0)
        with code.for_range(s) as j:
            acceleration = rows[(1 + j) * width + 2 * n + k]
            single.set(fma(weights[j], acceleration, single))
            double.set(fma(weights[s + j], acceleration, double))
        moved = fma(h, double, rows[n + k])
        rows[target + k] = fma(h * theta, moved, rows[k])
        rows[target + n + k] = fma(h, single, rows[n + k])


@traced
def interpolate(code: Procedure, pointers: Int) -> Int:
    """Write the state at the fraction `THETA` of a step into the last row, by a polynomial."""
    system, _, method = parts_of(code, pointers)
    stepper = floats(system.stepper)
    sum_between(system, method, stepper[THETA], stepper[LENGTH])
    return code.value(0)


@traced
def step_between(
    code: Procedure, system: SystemView, method: CollocationView, record: Record, theta: Real
) -> Int:
    """Write the same by a step of its own, which has the order of the method; as `iterate`."""
    n, width, stepper = system.n, system.width, floats(system.stepper)
    rows, first, h = floats(system.rows), last_row(method) + 1, stepper[LENGTH]
    with code.for_range(n) as k, code.for_range(method.stages) as i:
        begun = rows[2 * n + k]
        change = rows[(1 + i) * width + 2 * n + k] - begun
        rows[(first + i) * width + 2 * n + k] = fma(theta, change, begun)
    status = iterate(system, method, record, first, stepper[FROM], theta * h)
    with code.if_(status == 0):
        finish(system, method, first, last_row(method), theta * h, stepper[FROM])
    return status


@traced
def between(code: Procedure, pointers: Int) -> Int:
    """Write the state at the fraction `THETA` of a step into the last row; as `iterate`."""
    system, record, method = parts_of(code, pointers)
    return step_between(system, method, record, floats(system.stepper)[THETA])


@traced
def estimate(
    code: Procedure, system: SystemView, method: CollocationView, h: Real, row: Int
) -> Real:
    """Error norm of the step in the workspace, with the accelerations of a row at its start.

    Hairer's estimate is ``(γ/h - J)⁻¹ (f + Σ_i e_i (Y_i - y)/h)``, with coordinates eliminated
    [2]_. It is left in `residual`: coordinates, then speeds.
    """
    n, s, width, rows = system.n, method.stages, system.width, floats(system.rows)
    slopes, m, result = floats(method.slopes), floats(method.matrix), floats(method.residual)
    per_time = floats(method.error)[s] / h
    with code.for_range(n) as k:
        first = row * width + n + k
        place, speed = code.variable(rows[first]), code.variable(rows[first + n])
        with code.for_range(s) as i:
            weight, stage = floats(method.error)[i] / h, (1 + i) * width
            place.set(fma(weight, rows[stage + k] - rows[k], place))
            speed.set(fma(weight, rows[stage + n + k] - rows[n + k], speed))
        result[k], result[n + k] = place / per_time, speed
    with code.for_range(n) as k, code.for_range(n) as column:
        by_place, by_speed = slopes[2 * n * k + column], slopes[2 * n * k + n + column]
        unit = select(k == column, per_time, 0.0)
        m[k * n + column] = unit - by_speed - by_place / per_time
        result[n + k] = fma(by_place, result[column], result[n + k])
    factorise(n, method.matrix, method.pivots)
    solve(n, method.matrix, method.pivots, method.residual + WORD * n)
    rtol, atol = floats(system.stepper)[RTOL], floats(integers(system.pointers)[ATOL])
    end, total = (s + 1) * width, code.variable(0.0)
    with code.for_range(n) as k:
        result[k] += result[n + k] / per_time
    with code.for_range(2 * n) as i:
        allowed = fma(rtol, maximum(abs(rows[i]), abs(rows[end + i])), atol[i])
        scaled = result[i] / allowed
        total.set(fma(scaled, scaled, total))
    return sqrt(total / maximum(2 * n, code.value(1)).to_real)


@traced
def error_norm(
    code: Procedure, system: SystemView, method: CollocationView, record: Record, t: Real, h: Real
) -> Real:
    """Error norm of the step in the workspace.

    Where the first estimate is too large, in a first step or one that has been rejected, it may be
    due to components that are damped at once: it is filtered once more [2]_.
    """
    n, width, rows = system.n, system.width, floats(system.rows)
    error, counters = code.variable(estimate(system, method, h, 0)), integers(record.counters)
    rejected = floats(system.stepper)[REJECTED_BEFORE] != 0.0
    with code.if_((error > 1.0) & (rejected | (counters[STEPS] == 0))):
        aside = last_row(method)
        with code.for_range(2 * n) as i:
            rows[aside * width + i] = rows[i] + floats(method.residual)[i]
        counters[EVALUATIONS] += 1
        with code.if_(evaluate_at(system, t, aside) == 0):
            error.set(estimate(system, method, h, aside))
    return code.value(error)


@traced
def turns_too_far(code: Procedure, system: SystemView, method: CollocationView, h: Real) -> Bool:
    """Whether links turn so far within a step that a singular position could be overlooked."""
    rates = 3 * system.n + system.blocks
    with code.for_range(system.blocks) as block:
        most, limit = code.variable(0.0), MOST_CHANGE * floats(system.margin_scale)[block]
        with code.for_range(method.stages + 2) as row:
            rate = floats(system.rows)[row * system.width + rates + block]
            most.set(maximum(most, abs(rate)))
        with code.if_(abs(h) * most > limit):
            code.return_(True)
    return code.value(False)


def fourth_root(x: Any) -> Any:
    """Of a number that is not negative."""
    return sqrt(sqrt(x))


@traced
def judge(
    code: Procedure, system: SystemView, method: CollocationView, record: Record, t: Real, h: Real
) -> None:
    """Say what is thought of the step in the workspace, in the stepper."""
    stepper, known = floats(system.stepper), floats(method.committed)
    error = error_norm(system, method, record, t, h)
    bounded = maximum(error, code.value(LEAST_ERROR))
    factor = code.variable(1.0 / fourth_root(bounded))
    with code.if_((known[REACHED] == t) & (known[SPAN] != 0.0) & (stepper[AFTER_SWITCH] == 0.0)):
        before = maximum(stepper[BEFORE], code.value(LEAST_ERROR))
        grown = h / known[SPAN] * fourth_root(before / bounded)
        factor.set(factor * minimum(grown, code.value(1.0)))
    iterations = floats(method.newton_tolerance)[1]
    safety = SAFETY * (2 * NEWTON_ITERATIONS + 1) / (2 * NEWTON_ITERATIONS + iterations)
    fine = error <= 1.0
    # a step that is accepted does not lead to one that no longer moves time
    least = select(fine, finest_step(stepper, t) / abs(h), 0.0)
    least = maximum(least, code.value(SHRINK_MOST))
    factor.set(minimum(maximum(safety * factor, least), code.value(GROW_MOST)))
    far = fine & turns_too_far(system, method, h)
    stepper[ERROR] = error
    shorter = minimum(factor, code.value(1.0))
    stepper[FACTOR] = select(fine, select(far, SHRINK_TURNING, factor), shorter)
    stepper[ACCEPTED] = (fine & ~far).to_real


@traced
def try_by_tolerance(
    code: Procedure, system: SystemView, method: CollocationView, record: Record
) -> None:
    """Try a step of the length in the stepper, and judge it."""
    stepper = floats(system.stepper)
    t, (h, _, _) = stepper[T], begin_trial(stepper)
    stepper[ERROR], stepper[FACTOR], stepper[ACCEPTED] = 1.0, SHRINK_TURNING, 0.0
    status = try_collocation(system, method, record)
    integers(system.stepper)[STATUS] = status
    with code.if_(status == 0):
        judge(system, method, record, t, h)


@traced
def advance(code: Procedure, pointers: Int, ticks: Int) -> Int:  # noqa: ARG001
    """Try one step, which is to be finished in the loop."""
    system, record, method = parts_of(code, pointers)
    try_by_tolerance(system, method, record)
    return code.value(FLAGGED)
