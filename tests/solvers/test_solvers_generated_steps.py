"""Generated steps against the same formulas in NumPy, and their bits over numbers of lanes."""

import math

import numpy as np
import pytest
from lane_kernels import QUIET, duffing, duffing_code
from solver_kernels import SIZE, chain_rates, flow

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import RealArray
from linkages.kernel.code.writer import Module
from linkages.solvers.integration import METHODS, request
from linkages.solvers.loops.control import (
    GROW_MOST,
    SAFETY,
    SHRINK_MOST,
    binary_logarithm,
    binary_power,
)
from linkages.solvers.loops.explicit_steps import compiled_step
from linkages.solvers.loops.memory import STEPPER_SIZE, Pointers, Stepper
from linkages.solvers.loops.row_layout import RowLayout

ADAPTIVE = ["dop853", "vern9", "tsit5"]


def prepared(asked):
    return asked.method.motions(asked.job.batch)[0]


def chain_slopes(states):
    q, v = states[:SIZE], states[SIZE:]
    around = np.concatenate([[0.0], q, [0.0]])
    return np.concatenate([v, -np.sin(q) + 0.5 * (around[:-2] + around[2:] - 2.0 * q)])


def duffing_slopes(states, t):
    q, v = states
    return np.array([v, q - q**3 - QUIET[0] * v + QUIET[1] * math.cos(t)])


def numpy_step(tableau, slopes, state, t, h):
    """Slopes of all rows of a step, and the states in them."""
    A, c = tableau.extended_A, tableau.extended_c
    states, found = [state], [slopes(state, t)]
    for row in range(1, len(A)):
        states.append(state + h * sum(A[row, j] * found[j] for j in range(row)))
        found.append(slopes(states[-1], t + c[row] * h))
    return np.array(states), np.array(found)


@pytest.mark.parametrize("method", [*ADAPTIVE, "rk4"])
@pytest.mark.parametrize("large", [False, True])
def test_rows_are_those_of_the_tableau(method, large):
    """To round-off: coefficients of size 100 at most, states of size 1."""
    tableau, t, h = METHODS[method].tableau, 0.3, 0.05
    rng = np.random.default_rng(3)
    if large:
        own, state = flow(chain_rates, rotates=[False] * SIZE), rng.normal(size=2 * SIZE)
        slopes = lambda y, _: chain_slopes(y)  # noqa: E731
    else:
        own, state, slopes = duffing(*QUIET), np.array([0.4, -0.2]), duffing_slopes
    options = {"step": 0.1} if method == "rk4" else {}
    asked = request(own, state, [1.0], start=t, method=method, **options)
    motion = prepared(asked)
    stepper, rows, n = motion.stepper, motion.rows, own.coordinates
    rows[0, 2 * n : 3 * n] = slopes(state, t)[n:]
    stepper[[Stepper.start, Stepper.length, Stepper.stop]] = t, h, t + h
    code = compiled_step(tableau, RowLayout.of(own), METHODS[method].memory)
    assert code.function("attempt")(motion.address) == 0
    assert code.function("further")(motion.address) == 0
    states, found = numpy_step(tableau, slopes, state, t, h)
    assert rows[:-1, : 2 * n] == pytest.approx(states, abs=1e-14)
    assert rows[:-1, n : 3 * n] == pytest.approx(found, abs=1e-13)


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("h", [0.02, 0.4, 2.0])
def test_error_and_factor_are_those_of_their_formulas(method, h):
    """The error to the cancellation in its sum, a millionth of it here; the factor to 1e-8."""
    tableau, state, rtol = METHODS[method].tableau, np.array([0.4, -0.2]), 1e-6
    asked = request(duffing(*QUIET), state, [100.0], start=0.0, method=method, rtol=rtol)
    motion = prepared(asked)
    stepper, rows = motion.stepper, motion.rows
    rows[0, 2:5] = [*duffing_slopes(state, 0.0)[1:], QUIET[3] - state[0], -state[1]]
    begun = {
        "t": 0.0, "end": 100.0, "h": h, "first": h, "sample": 100.0, "rtol": rtol, "active": 1.0,
        "before": 1.0,  # the error of the step before
    }  # fmt: skip
    for name, value in begun.items():
        stepper[getattr(Stepper, name)] = value
    code = compiled_step(tableau, RowLayout.of(asked.job.flow), METHODS[method].memory)
    code.function("advance")(motion.address, 1)
    states, found = numpy_step(tableau, duffing_slopes, state, 0.0, h)
    end = tableau.stages
    noise = h * 0.05 * np.finfo(float).eps
    steepest = np.maximum(abs(found[0]), abs(found[end]))
    unit = rtol * (1.0 + np.maximum(abs(state), abs(states[end]))) + noise * steepest
    squares = [(((weights @ found[: end + 1]) / unit) ** 2).sum() for weights in tableau.error]
    low = squares[1] if len(squares) > 1 else 0.0
    error = h * squares[0] / math.sqrt((squares[0] + 0.01 * low) * 2)
    memory = METHODS[method].memory
    exponent = 1.0 / (tableau.error_order + 1)
    factor = SAFETY * error ** -(exponent - 0.75 * memory)
    assert stepper[Stepper.error] == pytest.approx(error, rel=1e-6)
    assert stepper[Stepper.factor] == pytest.approx(
        min(GROW_MOST, max(SHRINK_MOST, factor)), rel=1e-6
    )


def test_powers():
    """Against the C library: right to 1e-9, which is plenty for the length of a step."""
    module = Module()
    code = module.instructions()
    x = RealArray(code, "%x")
    x[2] = binary_power(x[1] * binary_logarithm(x[0]))
    code.return_(0)
    module.define("i64 @power(ptr %x)", code)
    compiled = MachineCode(module.text)
    power, numbers = compiled.function("power"), np.zeros(3)
    rng = np.random.default_rng(5)
    for base in [1.0, 2.0, 0.5, math.sqrt(0.5), *10.0 ** rng.uniform(-30, 140, 500)]:
        for exponent in (-0.125, -1 / 9, -0.185, 0.02):
            numbers[:2] = base, exponent
            power(numbers.ctypes.data)
            assert numbers[2] == pytest.approx(base**exponent, rel=1e-9)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_bits_do_not_depend_on_the_number_of_lanes(method):
    """Twenty trials, from states of which some are wrapped and some steps rejected."""
    tableau, gain = METHODS[method].tableau, METHODS[method].memory
    layout, count = RowLayout.of(duffing(*QUIET)), 16
    starts = [[0.2 * k - 1.5 if k else 3.1415, 0.3 * k] for k in range(count)]
    lengths = [0.01 * 2.0**k for k in range(count)]
    found = {lanes: advanced(lanes, starts, lengths, tableau, gain, layout) for lanes in (1, 4, 16)}
    assert len(np.unique(found[1][0])) > count
    for lanes in (4, 16):
        for one, other in zip(found[lanes], found[1], strict=True):
            assert np.array_equal(one, other)


def advanced(lanes, starts, lengths, tableau, gain, layout):
    """Steppers and states of all motions after some ticks, so many motions at a time."""
    code, kernel = compiled_step(tableau, layout, gain, lanes), duffing_code(lanes)
    steppers, states = [], []
    for first in range(0, len(starts), lanes):
        rows = (tableau.stages + 1) * layout.width
        sizes = {"parameters": 5, "timed": 1, "rows": rows, "stepper": STEPPER_SIZE,
                 "atol": 2, "scale": 1, "smallest": 1, "turns": 1}  # fmt: skip
        memory = {name: np.zeros((size, lanes)) for name, size in sizes.items()}
        memory["parameters"][:] = np.array([*QUIET, 1e300])[:, None]
        memory["atol"][:], memory["scale"][:], memory["smallest"][:] = 1e-8, 1.0, 1e-6
        stepper, rows = memory["stepper"], memory["rows"]
        own = np.array(starts[first : first + lanes]).T
        rows[:2] = own
        slopes = np.array([duffing_slopes(state, 0.0) for state in own.T]).T
        rows[2:5] = slopes[1], QUIET[3] - own[0], -own[1]
        stepper[[Stepper.end, Stepper.sample]] = 1e9
        stepper[[Stepper.h, Stepper.first]] = lengths[first : first + lanes]
        stepper[[Stepper.rtol, Stepper.before]] = [[1e-8], [1.0]]
        stepper[Stepper.active] = 1.0
        places = {name: array.ctypes.data for name, array in memory.items()}
        places = dict.fromkeys(Pointers.places(), 0) | places
        places |= {"clock": kernel.address("clock"), "rates": kernel.address("rates")}
        pointers = np.array([places[name] for name in Pointers.places()])
        for _ in range(20):
            code.function("advance")(pointers.ctypes.data, 1)
        steppers.append(
            stepper[Stepper.t :]
        )  # before are results of trials, of which some have none
        states.append(np.concatenate([rows[:5], memory["turns"]]))
    return np.concatenate(states, axis=1), np.concatenate(steppers, axis=1)
