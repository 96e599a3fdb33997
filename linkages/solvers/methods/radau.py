"""Radau's method of order 5 for stiff equations, stepped by SciPy with exact derivatives.

References
----------
.. [1] E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
       section IV.8.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from linkages.kernel.dyads import LEAST_MARGIN
from linkages.solvers.flow import Companion
from linkages.solvers.job import Job
from linkages.solvers.methods.method import Method
from linkages.solvers.steps.memory import BLOCK, EVALUATIONS, NOW, SAMPLES, STEPS, STOP
from linkages.solvers.trajectory import Outcome


@dataclass(frozen=True, kw_only=True)
class Radau(Method):
    """The implicit method of SciPy, over compiled right-hand sides."""

    def prepare(self, job: Job) -> Callable[[], int]:
        """Bind the loop, whose steps run in Python; a fixed step is none of its abilities."""
        if job.step is not None:
            raise ValueError(f"method '{self.name}' finds its steps itself: leave out the step")
        if job.events:
            raise ValueError(f"method '{self.name}' locates no events: take an explicit method")

        return StiffRun(job).run


RADAU = Radau(
    name="radau",
    order=5,
    adaptive=True,
    summary="Radau IIA of order 5, implicit, adaptive; for stiff springs, dampers and oil films",
)


POINTER = ctypes.POINTER(ctypes.c_double)
CLOCK = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, POINTER, POINTER)
RATES = ctypes.CFUNCTYPE(ctypes.c_int64, POINTER, POINTER, POINTER, POINTER)


class Kernel(Protocol):
    """What `Flow` and `Companion` have in common."""

    @property
    def clock(self) -> int: ...  # noqa: D102
    @property
    def rates(self) -> int: ...  # noqa: D102
    @property
    def parameters(self) -> NDArray[np.float64]: ...  # noqa: D102
    @property
    def timed_size(self) -> int: ...  # noqa: D102


def caller(kernel: Kernel, size: int) -> Callable[[float, NDArray], tuple[int, NDArray]]:
    """A function of time and state that returns the status and `size` numbers of a kernel."""
    clock, rates = CLOCK(kernel.clock), RATES(kernel.rates)
    parameters, timed = kernel.parameters, np.zeros(max(1, kernel.timed_size))

    def evaluate(t: float, y: NDArray) -> tuple[int, NDArray]:
        state, out = np.ascontiguousarray(y, dtype=np.float64), np.zeros(size)
        status = clock(t, _address(parameters), _address(timed))
        if status == 0:
            status = rates(_address(state), _address(parameters), _address(timed), _address(out))
        return status, out

    return evaluate


def _address(array: NDArray) -> Any:
    return array.ctypes.data_as(POINTER)


LARGEST = 1e150
BISECTIONS = 60
EARLY_BISECTIONS = 12
DIFFERENCE = 1.5e-8
QUADRATURE = leggauss(4)  # a step is a polynomial of degree 3
TWO_PI = 2 * math.pi
TWO_PI_TAIL = 2.4492935982947064e-16  # see `turns`


class StiffRun:
    """One integration by SciPy's ``Radau``.

    Parameters
    ----------
    job
        What is asked for; its arrays take the results.
    """

    def __init__(self, job: Job) -> None:
        flow = job.flow
        self.job, self.n, self.blocks = job, flow.coordinates, len(flow.margin_scale)
        self.kernel = caller(flow, flow.written)
        self.linear: Companion | None = flow.linearise() if flow.linearise else None
        self.status = self.seen = 0
        if self.linear is not None:
            size = 2 * self.n * self.n + 2 * self.blocks + 2 * flow.carried
            self.slopes = caller(self.linear, size)

    def evaluate(self, t: float, y: NDArray) -> NDArray:
        """Output of the kernel; nan, which makes SciPy try a shorter step, where it fails."""
        self.job.counters[EVALUATIONS] += 1
        status, out = self.kernel(t, y)
        if status != 0 or not (np.abs(y) < LARGEST).all():
            self.status = status
            return np.full(len(out), math.nan)
        return out

    def _margins(self, t: float, y: NDArray) -> NDArray:
        """Margins of the blocks, then their rates."""
        return self.evaluate(t, y)[self.n : self.n + 2 * self.blocks]

    def derivative(self, t: float, y: NDArray) -> NDArray:
        """Derivative of the state."""
        return np.concatenate([y[self.n :], self.evaluate(t, y)[: self.n]])

    def jacobian(self, t: float, y: NDArray) -> NDArray:
        """Derivatives of `derivative` with respect to the state."""
        n = self.n
        upper = np.hstack([np.zeros((n, n)), np.eye(n)])
        if self.linear is None:
            return np.vstack([upper, self._differences(t, y)])
        _, out = self.slopes(t, y)
        return np.vstack([upper, out[: 2 * n * n].reshape(n, 2 * n)])

    def _differences(self, t: float, y: NDArray) -> NDArray:
        """Derivatives of the accelerations by differences, away from what is out of reach."""
        n, status = self.n, self.status
        here = self.evaluate(t, y)[:n]
        result = np.zeros((n, 2 * n))
        for j, step in enumerate(DIFFERENCE * np.maximum(1.0, np.abs(y))):
            for side in (step, -step):
                aside = y.copy()
                aside[j] += side
                column = (self.evaluate(t, aside)[:n] - here) / (aside[j] - y[j])
                if np.isfinite(column).all():
                    result[:, j] = column
                    break
        self.status = status
        return result

    def run(self) -> int:
        """Integrate to the end or to what comes before it; returns an `Outcome`."""
        # Overflows on the way to a shorter step are no news.
        with np.errstate(all="ignore"):
            return int(self._begin() or self._steps())

    def _begin(self) -> Outcome:
        """Evaluate the start and take a sample there."""
        job = self.job
        self.margins = self._margins(job.start, job.state)
        if self.status != 0:
            return self._blocked()
        self._wrap(job.state)
        job.final_angles[:] = self._counted(job.start, job.state, job.final_angles)
        self._sample(job.start, job.start, lambda _time: job.state)
        return self._close_to_singular()

    def _steps(self) -> Outcome:
        from scipy.integrate import Radau

        job = self.job
        if job.start == job.end:
            return Outcome.DONE
        if self.n == 0:
            self._sample(job.start, job.end, lambda _time: job.state)
            job.control[NOW] = job.end
            return Outcome.DONE
        solver = Radau(
            self.derivative,
            job.start,
            job.state.copy(),
            job.end,
            rtol=max(job.rtol, 100 * np.finfo(float).eps),  # the least that SciPy takes
            atol=job.atol,
            jac=self.jacobian,
        )
        while solver.status == "running":
            if job.control[STOP] != 0.0:
                return Outcome.INTERRUPTED
            if job.counters[STEPS] >= job.max_steps:
                return Outcome.STEP_BUDGET
            self.status = 0
            solver.step()
            if solver.status == "failed":
                return self._blocked() if self.status else Outcome.STEP_TOO_SMALL
            outcome = self._accept(solver)
            if outcome != Outcome.DONE:
                return outcome
        return Outcome.DONE

    def _accept(self, solver: Any) -> Outcome:
        """Take the samples of a step and make its end the start of the next one."""
        job, dense = self.job, solver.dense_output()
        start, end = solver.t_old, solver.t
        margins = self._margins(end, solver.y)
        part = self._part_before_singular(margins, dense, start, end - start)
        outcome = Outcome.DONE
        if part < 1.0:
            end, outcome = start + part * (end - start), Outcome.SINGULAR
        self._sample(start, end, dense)
        job.final_angles[:] = self._turned(start, end, dense)
        job.state[:] = solver.y if part == 1.0 else dense(end)
        changed = self._wrap(job.state)
        if self._renormalised():
            changed = True
            solver.f = self.derivative(end, job.state)
            # the Jacobian contains the tangents, too
            solver.J, solver.LU_real, solver.LU_complex = solver.jac(end, job.state), None, None
        if changed and part == 1.0:
            solver.y = job.state.copy()
            # SciPy would predict the next step from the state before.
            solver.sol = None
        job.control[NOW] = end
        job.counters[STEPS] += 1
        self.margins = margins
        return outcome if part < 1.0 else self._close_to_singular()

    def _wrap(self, state: NDArray) -> bool:
        """Bring rotating coordinates into [-π, π]; whether any was outside."""
        q, rotates = state[: self.n], self.job.flow.rotates
        whole = np.where(rotates & (np.abs(q) > math.pi), np.rint(q / (2 * math.pi)), 0.0)
        q -= whole * TWO_PI
        q -= whole * TWO_PI_TAIL
        self.job.final_turns[:] += whole.astype(np.int64)
        return bool(whole.any())

    def _counted(self, t: float, y: NDArray, expected: NDArray) -> NDArray:
        """Dependent angles with the turns that bring them closest to where they are expected."""
        if not len(expected):
            return expected
        cosine, sine, _ = self.evaluate(t, y)[-3 * len(expected) :].reshape(3, -1)
        angles = np.arctan2(sine, cosine)
        return angles + TWO_PI * np.rint((expected - angles) / TWO_PI)

    def _turned(self, start: float, end: float, dense: Callable[[float], NDArray]) -> NDArray:
        """Dependent angles at a time within a step, from those at its start; see `counting`."""
        expected, half = self.job.final_angles.copy(), 0.5 * (end - start)
        if not len(expected):
            return expected
        for node, weight in zip(*QUADRATURE, strict=True):
            time = start + half * (1.0 + node)
            expected += half * weight * self.evaluate(time, dense(time))[-len(expected) :]
        return self._counted(end, dense(end), expected)

    def _sample(self, start: float, end: float, dense: Callable[[float], NDArray]) -> None:
        """Take the samples up to a time; turns count from the start of the step."""
        job, n = self.job, self.n
        sign = 1.0 if job.end >= job.start else -1.0
        turns = job.final_turns.copy()
        while (k := int(job.counters[SAMPLES])) < len(job.times):
            time = float(job.times[k])
            if sign * (time - end) > 0.0:
                break
            state = np.array(dense(time))
            job.accelerations[k] = self.evaluate(time, state)[:n]
            job.angles[k] = self._turned(start, time, dense)
            job.final_turns[:] = turns
            self._wrap(state)
            job.states[k], job.turns[k] = state, job.final_turns
            job.counters[SAMPLES] += 1
        job.final_turns[:] = turns

    @property
    def _tangents(self) -> NDArray[np.intp]:
        """Places of what tangents are lengths of in a state, shape (placed + size, columns)."""
        tangents = self.job.tangents
        assert tangents is not None
        first = self.n - tangents.columns * tangents.size
        places = first + np.arange(tangents.columns) * tangents.size
        places = places + np.arange(tangents.size)[:, None]
        return np.concatenate([places[: tangents.placed], self.n + places])

    def _renormalised(self) -> bool:
        """Renormalise tangents at new samples, and if need be behind; whether any are."""
        tangents, job = self.job.tangents, self.job
        if tangents is None:
            return False
        samples = int(job.counters[SAMPLES])
        new = job.states[self.seen : samples, self._tangents]
        lengths, after, factor = tangents.undone(new, job.grown, self.seen)
        done, self.seen = tangents.count(self.seen), samples
        job.lengths[done : done + len(lengths)] = lengths
        first = tangents.every - 1 - (samples - len(new) + tangents.offset) % tangents.every
        for place, values in zip(
            range(samples - len(new) + first, samples, tangents.every), after, strict=True
        ):
            job.states[place, self._tangents] = values
        here = job.state[self._tangents] @ factor
        stretched = tangents.stretched(here, job.rtol, float(job.atol[-1]))
        if stretched:
            further, factor = tangents.factors(here)
            here = here @ factor
            job.grown[:] += further
        job.state[self._tangents] = here
        return stretched or len(lengths) > 0

    def _part_before_singular(
        self, margins: NDArray, dense: Callable[[float], NDArray], start: float, h: float
    ) -> float:
        """Fraction of a step before its first singular position, or 1; see `margins`."""
        b, part = self.blocks, 1.0
        side = np.where(self.margins[:b] >= 0.0, 1.0, -1.0)
        ahead = side * (self.margins[:b] + h * self.margins[b:])
        behind = side * (margins[:b] - h * margins[b:])
        for block in np.flatnonzero((ahead < 0.0) & (behind < 0.0)):
            least, before, after = math.inf, 0.0, 1.0
            for _ in range(BISECTIONS):
                middle = 0.5 * (before + after)
                time = start + middle * h
                here = self._margins(time, dense(time))
                # Round-off puts aligned links out of reach: nan counts as aligned.
                least = min(least, np.nan_to_num(abs(here[block]), nan=0.0))
                if side[block] * h * here[b + block] < 0.0:
                    before = middle
                else:
                    after = middle
            if least < self.job.flow.smallest_margins[block]:
                before = self._early_fraction(int(block), dense, start, h, before)
                if before < part:
                    part = before
                    self.job.counters[BLOCK] = block
        return part

    def _early_fraction(
        self, block: int, dense: Callable[[float], NDArray], start: float, h: float, after: float
    ) -> float:
        """Fraction of a step before a margin is the smallest allowed; it is less at `after`."""
        flow = self.job.flow
        if flow.smallest_margins[block] <= 2.0 * LEAST_MARGIN * flow.margin_scale[block]:
            return after
        before = 0.0
        for _ in range(EARLY_BISECTIONS):
            middle = 0.5 * (before + after)
            time = start + middle * h
            if self._too_small(self._margins(time, dense(time)))[block]:
                after = middle
            else:
                before = middle
        return before

    def _too_small(self, margins: NDArray) -> NDArray[np.bool_]:
        """Blocks that are singular, or closer to it than a run allows and coming closer."""
        flow, values = self.job.flow, margins[: self.blocks]
        falling = values * margins[self.blocks :] * (self.job.end - self.job.start) < 0.0
        singular = ~(np.abs(values) >= LEAST_MARGIN * flow.margin_scale)
        return singular | (falling & (np.abs(values) < flow.smallest_margins))

    def _close_to_singular(self) -> Outcome:
        small = self._too_small(self.margins)
        if not small.any():
            return Outcome.DONE
        self.job.counters[BLOCK] = int(np.argmax(small))
        return Outcome.SINGULAR

    def _blocked(self) -> Outcome:
        self.job.counters[BLOCK] = self.status - 1
        return Outcome.UNREACHABLE
