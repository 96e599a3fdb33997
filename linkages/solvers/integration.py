"""Integrate a flow: the one function that callers of this package need."""

from __future__ import annotations

import difflib
import logging
import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.interrupts import interrupts_kept
from linkages.options.run import MAX_STEPS
from linkages.solvers.explicit_methods import DOP853, RK4, TSIT5, VERN9
from linkages.solvers.flow import Flow, Renormalisation
from linkages.solvers.job import AUTO, Choice, Job, choose
from linkages.solvers.loops.memory import PAUSED
from linkages.solvers.method import GAUSS8, RADAU, Method, MotionLoop
from linkages.solvers.trajectory import Event, Outcome, Trajectory

METHODS: Mapping[str, Method] = MappingProxyType(
    {method.name: method for method in (DOP853, TSIT5, VERN9, RADAU, RK4, GAUSS8)}
)
ADAPTIVE_METHODS = tuple(name for name, method in METHODS.items() if method.adaptive)
FIXED_STEP_METHODS = tuple(name for name, method in METHODS.items() if not method.adaptive)


POLL = 0.05
"""Seconds between two looks at a running loop."""

QUICK = 0.02
"""Seconds for which a loop runs without a thread of its own, which takes 0.1 ms to start: nobody
notices that Ctrl-C waits so long."""


def carried_out_at_once(loop: MotionLoop) -> int:
    """Run a loop for about `QUICK` seconds; returns an `Outcome`, or PAUSED."""
    until = time.perf_counter() + QUICK
    while (outcome := loop(rounds=1)) == PAUSED:
        if time.perf_counter() > until:
            break
    return outcome


def supervise(
    loop: Callable[[], int], stop: Callable[[], None], look: Callable[[], None]
) -> tuple[int, bool]:
    """Run a loop in a thread; Ctrl-C stops it after its present step and keeps what was computed.

    Python handles signals in the main thread, between bytecodes, and a compiled loop has none. The
    loop is compiled and loaded already, because the main thread has the larger stack. A short
    `MotionLoop` runs in this thread: to start another one takes longer. Returns what the loop
    returns, and whether Ctrl-C was pressed, even if the loop had just ended: the caller may have
    more to compute.
    """
    results: list[int] = []
    failures: list[BaseException] = []
    # Not Thread.join: interrupted in the middle, it may take a running thread for ended.
    done = threading.Event()

    def work() -> None:
        try:
            results.append(loop())
        except BaseException as failure:  # handed over to the calling thread
            failures.append(failure)
        finally:
            done.set()

    worker = threading.Thread(target=work, name="linkages-solver", daemon=True)
    interrupted = ended = False
    try:
        with interrupts_kept():
            if isinstance(loop, MotionLoop) and (outcome := carried_out_at_once(loop)) != PAUSED:
                results.append(outcome)
                done.set()
            else:
                worker.start()
            ended = done.wait(POLL)
        look()
        while not ended:
            with interrupts_kept():
                ended = done.wait(POLL)
            look()
    except BaseException as failure:
        if worker.ident is None and not results:  # nothing has begun
            raise
        stop()
        interrupted = isinstance(failure, KeyboardInterrupt)
        if not interrupted:
            done.wait()
            raise
    if not ended:
        done.wait()
    if failures:
        raise failures[0]
    return results[0], interrupted


LOGGER = logging.getLogger(__name__)

# Below this the round-off of a step exceeds what is asked for.
LEAST_RTOL = 1e-14


@dataclass(frozen=True, eq=False)
class IntegrationRequest:
    """An integration that is asked for, after validation."""

    method: Method
    choice: Choice
    job: Job  # what is asked for

    def trajectory(self, outcome: Outcome) -> Trajectory:
        """The results, once the loop has returned."""
        return self.job.trajectory(outcome, self.choice)


def integrate(
    flow: Flow,
    state: ArrayLike,
    times: ArrayLike,
    *,
    watch: Callable[[float], None] | None = None,
    **options: Any,
) -> Trajectory:
    """Integrate the equations of motion and sample the motion at given times.

    Parameters
    ----------
    flow, state, times, options
        As `request` takes them.
    watch
        Called about 20 times a second, and once at the end, with the fraction of simulated time
        that is done.

    Returns
    -------
    Trajectory
        Samples and how the integration ended; a failure is no exception but an `Outcome`.

    Raises
    ------
    ValueError
        For arguments that make no sense.
    """
    return carry_out(request(flow, state, times, **options), watch)


def carry_out(
    asked: IntegrationRequest, watch: Callable[[float], None] | None = None
) -> Trajectory:
    """Integrate what is asked for; see `integrate`."""
    job, clock = asked.job, time.perf_counter()
    loop = asked.method.prepare(job)

    def look() -> None:
        if watch is not None:
            watch(job.fraction)

    result, interrupted = supervise(loop, job.stop, look)
    found = asked.trajectory(Outcome.INTERRUPTED if interrupted else Outcome(result))
    LOGGER.info(
        "%s from t = %g s to %g s: %d evaluations, %.2f s",
        found.method, job.start, job.end, found.evaluations, time.perf_counter() - clock,
    )  # fmt: skip
    return found


def request(
    flow: Flow,
    state: ArrayLike,
    times: ArrayLike,
    *,
    start: float | None = None,
    method: str = "dop853",
    rtol: float = 1e-10,
    atol: ArrayLike | None = None,
    step: float | None = None,
    max_steps: int = MAX_STEPS,
    events: Sequence[Event] = (),
    angles: NDArray[np.float64] | None = None,
    tangents: Renormalisation | None = None,
    holds: NDArray[np.float64] | None = None,
) -> IntegrationRequest:
    """Ask for an integration of the equations of motion.

    `state` has coordinates and speeds at `start`, shape (2n,). `times` increase, or decrease to
    integrate backward in time, and the integration ends at the last one. The error of a step is
    kept below ``atol + rtol·|state|``, angles within one turn; `atol` is one number or one for each
    entry, by default `rtol`. A fixed `step` is shortened so that a whole number of steps reaches
    the end. Methods that are not adaptive need one. `angles` says about where dependent angles
    whose turns are counted are at the start, shape (d,); by default within one turn.
    """
    # deviation vectors that are damped at once take short steps anyway
    stiff = flow.stiff and tangents is None
    choice = choose(rtol, stiff=stiff) if method == AUTO else Choice(method, "asked for")
    chosen = _method(choice.name)
    samples = _times(times)
    begin = float(samples[0]) if start is None else float(start)
    _require_monotonic(begin, samples)
    if not chosen.adaptive and step is None:
        raise ValueError(f"method '{method}' needs a step in seconds")
    if step is not None and not (math.isfinite(step) and step > 0):
        raise ValueError(f"step must be a number of seconds > 0, found {step}")
    if step is not None and step > flow.longest_step:
        raise ValueError(
            f"step must be at most {flow.longest_step:g} s, for states are updated within a step "
            f"otherwise, found {step:g}"
        )
    if max_steps < 1:
        raise ValueError(f"max_steps must be at least 1, found {max_steps}")
    if max_steps >= 2**63:
        raise ValueError(f"max_steps must be less than 2**63, found {max_steps}")
    job = Job(
        flow=flow,
        start=begin,
        times=samples,
        state=_state(flow, state),
        rtol=_rtol(rtol),
        atol=_atol(flow, rtol if atol is None else atol),
        step=step,
        max_steps=max_steps,
        events=tuple(events),
        begun=angles,
        tangents=tangents,
        holds=_holds(flow, holds),
    )
    return IntegrationRequest(chosen, choice, job)


def _method(name: str) -> Method:
    if name in METHODS:
        return METHODS[name]
    known = ", ".join(f"'{known}'" for known in METHODS)
    near = difflib.get_close_matches(str(name), METHODS, n=1, cutoff=0.5)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    raise ValueError(f"unknown method '{name}'; known are {known}{hint}")


def _state(flow: Flow, state: ArrayLike) -> NDArray[np.float64]:
    found = np.array(state, dtype=np.float64)
    if found.shape != (2 * flow.coordinates,):
        raise ValueError(
            f"state must hold {flow.coordinates} coordinates and as many speeds, "
            f"found shape {found.shape}"
        )
    if not np.isfinite(found).all():
        raise ValueError(f"state must be finite, found {found}")
    return found


def _holds(flow: Flow, holds: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
    if flow.switching is None:
        return None
    if holds is None or holds.shape != (flow.held,):
        raise ValueError(f"holds must have shape ({flow.held},), found {holds!r}")
    return holds


def _times(times: ArrayLike) -> NDArray[np.float64]:
    found = np.array(times, dtype=np.float64, ndmin=1)
    if found.ndim != 1 or not found.size:
        raise ValueError(f"times must be a list of at least one time, found shape {found.shape}")
    if not np.isfinite(found).all():
        raise ValueError("times must be finite")
    return found


def _require_monotonic(start: float, times: NDArray[np.float64]) -> None:
    if not math.isfinite(start):
        raise ValueError(f"start must be finite, found {start}")
    before, after = times[:-1], times[1:]
    # Only the first sample may fall together with the time before it.
    if times[0] >= start and (after > before).all():
        return
    if times[0] <= start and (after < before).all():
        return
    raise ValueError("times must increase, or decrease, from start to the last one")


def _rtol(rtol: float) -> float:
    if not LEAST_RTOL <= rtol < 1:
        raise ValueError(f"rtol must be from {LEAST_RTOL} to 1, found {rtol}")
    return float(rtol)


def _atol(flow: Flow, atol: ArrayLike) -> NDArray[np.float64]:
    found = np.array(atol, dtype=np.float64)
    if found.shape not in ((), (2 * flow.coordinates,)):
        raise ValueError(
            f"atol must be one number or one for each entry of the state, found shape {found.shape}"
        )
    if not ((found > 0).all() and np.isfinite(found).all()):
        raise ValueError(f"atol must be > 0, found {found}")
    return np.full(2 * flow.coordinates, found)
