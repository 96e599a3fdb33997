"""Where a simulation starts, and when samples are taken, if the caller says so."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.reading.wording import suggestion
from linkages.solution.arguments import real_number
from linkages.solution.remarks.stops import block_failure

Floats = NDArray[np.float64]

State: TypeAlias = Mapping[str, tuple[float, float] | float] | ArrayLike
"""Free coordinate → value and rate in SI, and internal state → value; or all integrated
coordinates, then their rates, then internal states."""


def own_times(times: ArrayLike, *, from_zero: bool) -> Floats:
    """Sample times of the caller, checked, shape (samples,).

    Parameters
    ----------
    times
        Seconds, increasing or decreasing.
    from_zero
        Whether the motion starts at t = 0, so that they must lead away from there.

    Raises
    ------
    ValueError
        If they do not.
    """
    found = _numbers(times)
    if found.ndim != 1 or not found.size or not np.isfinite(found).all():
        raise ValueError(
            f"times must be finite numbers of seconds in one dimension, found {times!r}"
        )
    steps = np.diff(found)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ValueError("times must increase, or decrease, from each to the next")
    # a motion to one side of t = 0: what lies on the other is another one
    if from_zero and (found[0] * found[-1] < 0 or abs(found[0]) > abs(found[-1])):
        raise ValueError(
            f"times must lead away from t = 0, where the motion starts; found {found[0]:g} s to "
            f"{found[-1]:g} s. With a `state` it starts at the first of them"
        )
    return found


def started(mechanism: Mechanism, state: State | None, time: float) -> System:
    """The mechanism at the start of a simulation.

    Parameters
    ----------
    mechanism
        Starts as its definition says at t = 0, if no state is given.
    state
        Where it starts instead, see `State`; what a mapping does not name has the value of the
        definition. The assembly mode is that of the definition.
    time
        When, in seconds.

    Raises
    ------
    InputError
        If the mechanism cannot be assembled.
    ValueError
        If the state does not fit the mechanism, or cannot be assembled.
    """
    system = System(mechanism)
    if state is None:
        return system
    if not system.layout.moved:
        raise ValueError("state: nothing is free to move, drives determine the whole motion")
    if not isinstance(state, Mapping):
        return at(system, time, _whole(system, state))
    known = {name: state[name] for name in state if name in system.topology.internal}
    internal = {name: real_number(f"state of {name}", value) for name, value in known.items()}
    given = _filled(system, {name: state[name] for name in state if name not in known})
    if not time:
        started = System(system.mechanism.with_state(given)) if given else system
        return started.with_internal(internal)
    count, half = len(system.topology.free), len(system.topology.coordinates)
    full = system.with_internal(internal).state.copy()
    full[:count] = [value for value, _ in given.values()]
    full[half : half + count] = [rate for _, rate in given.values()]
    return at(system, time, full)


def asked_for(
    *, times: Floats | None, state: State | None, events: Mapping[str, str] | None
) -> dict[str, Any]:
    """Arguments of a simulation in terms of JSON: those that were given."""
    found: dict[str, Any] = {}
    if times is not None:
        found["times"] = times.tolist()
    if isinstance(state, Mapping):
        found["state"] = {name: np.asarray(at, dtype=float).tolist() for name, at in state.items()}
    elif state is not None:
        found["state"] = np.asarray(state, dtype=float).tolist()
    return found | ({"events": dict(events)} if events else {})


def at(system: System, time: float, state: Floats) -> System:
    """A system in another state at another time, in the same assembly mode.

    Raises
    ------
    ValueError
        If it cannot be assembled there.
    """
    found = system.at(time, state)
    reaches = system.model.reaches
    radicands = system.evaluate([reach.radicand for reach in reaches], time, state[:, None])[:, 0]
    for reach, radicand in zip(reaches, radicands, strict=True):
        if not radicand >= 0:
            text = block_failure(system.model, reach.block, time, False)
            raise ValueError(f"state: {text}")
    positions = system.model.positions.joints.values()
    places = [node for place in positions for node in (place.x, place.y)]
    if not np.isfinite(system.evaluate(places, time, state[:, None])).all():
        raise ValueError(f"state: the mechanism cannot be assembled in it at t = {time:g} s")
    return found


def _numbers(given: ArrayLike) -> Floats:
    """An array, or one of no numbers at all for what is none."""
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.array(np.nan)


def _whole(system: System, state: ArrayLike) -> Floats:
    found, layout = _numbers(state), system.layout
    if found.shape != layout.state_rows.shape or not np.isfinite(found).all():
        names = ", ".join(layout.bodies)
        internal = "".join(f", then {name}" for name in layout.internal)
        raise ValueError(
            f"state must be {len(layout.state_rows)} finite numbers: {names}, then their rates"
            f"{internal}; found {state!r}"
        )
    return layout.moving(found)


def _filled(system: System, state: Mapping[str, object]) -> dict[str, tuple[float, float]]:
    """Value and rate of every free coordinate."""
    free = system.topology.free
    for name in state:
        if name not in free:
            known = (*free, *system.topology.internal)
            near = suggestion(str(name), known) or f"; expected {' or '.join(known)}"
            raise ValueError(f"state: {name!r} is no free coordinate{near}")
    given = system.mechanism.initial
    found = {name: (given[name].position, given[name].speed) for name in free}
    for name, pair in state.items():
        if not isinstance(pair, tuple | list | np.ndarray) or len(pair) != 2:
            raise ValueError(f"state: expected the value and the rate of {name}, found {pair!r}")
        value, rate = (real_number(f"state of {name}", number) for number in pair)
        found[name] = value, rate
    return found
