"""Simulate a mechanism: from its definition to labelled results."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeAlias, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Interrupted
from linkages.interrupts import interrupts_kept
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.reading.wording import TOO_LARGE, listed, suggestion
from linkages.solution.driven import slack_notes
from linkages.solution.evaluation import accelerated, evaluate_variables
from linkages.solution.guards import parse_events
from linkages.solution.interpolated import evaluate_outputs
from linkages.solution.march import compute_motion
from linkages.solution.motion import Motion, Settings, Watch
from linkages.solution.remarks import assumptions, doubts
from linkages.solution.run_options import options_of
from linkages.solution.series import (
    DISSIPATION,
    INTEGRATED,
    OF_CONTACTS,
    PIN,
    REACTION,
    REACTIONS,
    finite_part,
    labelled,
    labelled_arrays,
    requested,
)
from linkages.solution.solution import IncompleteError, Solution
from linkages.solution.stop_messages import block_failure
from linkages.topology.decomposition import shared_pins

if TYPE_CHECKING:
    import xarray as xr

    from linkages.kernel.articulated_bodies import BodyTree


def whole_number(name: str, value: Any) -> int:
    """A whole number; 20.0 is one, and NumPy's are."""
    number = real_number(name, value)
    if not (math.isfinite(number) and number == int(number)):
        raise ValueError(f"{name} must be a whole number, found {value!r}")
    return int(number)


def real_number(name: str, value: Any) -> float:
    """A number."""
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, found {value!r}")
    return float(value)


Floats = NDArray[np.float64]

State: TypeAlias = Mapping[str, tuple[float, float] | float] | ArrayLike
"""Free coordinate → value and rate in SI, and internal state → value; or all integrated
coordinates, then their rates, then internal states."""


def own_times(times: ArrayLike, *, from_zero: bool) -> Floats:
    """Sample times of the caller in s, checked: increasing or decreasing, shape (samples,)."""
    result = _numbers(times)
    if result.ndim != 1 or not result.size or not np.isfinite(result).all():
        raise ValueError(
            f"times must be finite numbers of seconds in one dimension, found {times!r}"
        )
    steps = np.diff(result)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise ValueError("times must increase, or decrease, from each to the next")
    # a motion to one side of t = 0: what lies on the other is another one
    if from_zero and (result[0] * result[-1] < 0 or abs(result[0]) > abs(result[-1])):
        raise ValueError(
            f"times must lead away from t = 0, where the motion starts; found {result[0]:g} s to "
            f"{result[-1]:g} s. With a `state` it starts at the first of them"
        )
    return result


def started(mechanism: Mechanism, state: State | None, time: float) -> System:
    """The mechanism at the start of a simulation, in the assembly branch of the definition.

    What a `state` does not name has the value of the definition.
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
    result: dict[str, Any] = {}
    if times is not None:
        result["times"] = times.tolist()
    if isinstance(state, Mapping):
        result["state"] = {name: np.asarray(at, dtype=float).tolist() for name, at in state.items()}
    elif state is not None:
        result["state"] = np.asarray(state, dtype=float).tolist()
    return result | ({"events": dict(events)} if events else {})


def at(system: System, time: float, state: Floats) -> System:
    """A system in another state in the same assembly branch; ValueError if it does not close."""
    result = system.at(time, state)
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
    return result


def _numbers(given: ArrayLike) -> Floats:
    """An array, or one of no numbers at all for what is none."""
    try:
        return np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.array(np.nan)


def _whole(system: System, state: ArrayLike) -> Floats:
    result, layout = _numbers(state), system.layout
    if result.shape != layout.state_rows.shape or not np.isfinite(result).all():
        names = ", ".join(layout.bodies)
        internal = "".join(f", then {name}" for name in layout.internal)
        raise ValueError(
            f"state must be {len(layout.state_rows)} finite numbers: {names}, then their rates"
            f"{internal}; found {state!r}"
        )
    return layout.moving(result)


def _filled(system: System, state: Mapping[str, object]) -> dict[str, tuple[float, float]]:
    """Value and rate of every free coordinate."""
    free = system.topology.free
    for name in state:
        if name not in free:
            known = (*free, *system.topology.internal)
            near = suggestion(str(name), known) or f"; expected {' or '.join(known)}"
            raise ValueError(f"state: {name!r} is no free coordinate{near}")
    given = system.mechanism.initial
    result = {name: (given[name].position, given[name].speed) for name in free}
    for name, pair in state.items():
        if not isinstance(pair, tuple | list | np.ndarray) or len(pair) != 2:
            raise ValueError(f"state: expected the value and the rate of {name}, found {pair!r}")
        value, rate = (real_number(f"state of {name}", number) for number in pair)
        result[name] = value, rate
    return result


LEAST_INERTIA = 1e-14
"""Least eigenvalue of J_ij, scaled to ones on its diagonal, of which some inertia is left."""

LATE = "interrupted after the motion was computed, before all of its outputs were"


@takes(SimulationOptions)
def simulate(
    mechanism: Mechanism,
    *,
    times: ArrayLike | None = None,
    state: State | None = None,
    events: Mapping[str, str] | None = None,
    outputs: Iterable[str] | None = None,
    watch: Watch | None = None,
    throw: bool = True,
    **options: Unpack[SimulationKeywords],
) -> Solution:
    """Compute the motion of a mechanism from t = 0.

    Whatever is None is taken from the `simulate` section of the definition file.

    Parameters
    ----------
    mechanism
        From `linkages.load`, or built in Python.
    times : (m,)
        Sample times in seconds instead of `end` and `samples`, increasing or decreasing; they may
        begin later than the motion, which starts at t = 0 if no `state` is given.
    state
        Where the motion starts instead of where the definition says: free coordinate → value and
        rate, such as ``{"crank": (0.1, 2.0)}``, or all integrated coordinates and then their rates,
        shape (2n,), as `linkages.compile` has them. It is the state at the first of `times`, else
        at t = 0, in the assembly mode of the definition.
    events
        Series → how it crosses its value: ``{"piston.velocity": "up"}``, ``"down"`` or ``"both"``.
        A value other than 0 stands behind it: ``"crank.angle=90 deg"``. The crossings are in
        `Solution.events`; a zero at the start is none.
    outputs
        Names of variables of the result, also as one text with commas between them, or ``"all"``;
        kinematics and efforts if not given.
        Only what is asked for is computed.
    watch
        Called about 20 times a second with the fraction of simulated time done.
    throw
        Whether a motion that cannot go on raises, or returns what was computed.
    options
        As `SimulationOptions` describes them.

    Raises
    ------
    InputError
        If the mechanism cannot be assembled or its mobility does not match its drives.
    ValueError
        For arguments that make no sense.
    IncompleteError
        If the motion could not be computed to its end; its `solution` has the samples so far.
    Interrupted
        After Ctrl-C, whatever `throw` says; its `solution` has the samples so far.
    """
    given = None if times is None else own_times(times, from_zero=state is None)
    if given is not None and not (options.get("end") is None and options.get("samples") is None):
        raise ValueError("end and samples do not go with times, which say both")
    system = started(mechanism, state, 0.0 if given is None else float(given[0]))
    names = requested(system, outputs)
    run = options_of(SimulationOptions, mechanism, options)
    settings = Settings(
        times=np.linspace(0.0, run.end, run.samples) if given is None else given,
        run=run,
        work="energy_residual" in names,
        losses=any(name in names for name in INTEGRATED),
        counting=any(VARIABLES[name].angle for name in names),
        watch=watch,
        events=parse_events(system, events or {}),
    )
    require_inertia(system)
    notes = [*assumptions(system), *doubts(mechanism)]
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is found at the end
        motion = compute_motion(system, settings)
        plain = [name for name in names if not VARIABLES[name].whole]
        notes += motion.notes
        interrupted = str(motion.failure) if motion.interrupted else ""
        try:
            with interrupts_kept():  # else the motion would be lost
                values = evaluate_variables(motion, plain)
                if mechanism.contacts or mechanism.ends:
                    from linkages.solution.contact_notes import contact_notes

                    notes += contact_notes(motion)
                notes += slack_notes(motion)
            if motion.failure is None or len(motion.time):
                _add_derived(system, settings, motion, names, values, notes)
        except KeyboardInterrupt:
            interrupted = interrupted or LATE
    motion, values = finite_part(system, motion, values)
    solution = Solution(
        data=labelled_arrays(system, motion, {n: values[n] for n in names if n in values}),
        mechanism=system.mechanism,
        system=system,
        motion=motion,
        settings=settings,
        notes=tuple(notes),
        events=_labelled_events(motion.crossings, names),
        asked=asked_for(times=given, state=state, events=events),
    )
    if interrupted:
        raise Interrupted(interrupted, time=motion.stop_time, solution=solution)
    if motion.failure is not None and throw:
        raise IncompleteError(solution)
    return solution


def have_inertia(systems: Sequence[System]) -> NDArray[np.bool_]:
    """Which systems of one structure `require_inertia` certainly lets pass, shape (systems,)."""
    first = systems[0]
    size = len(first.topology.free)
    if first.model.tree is not None:
        return np.zeros(len(systems), dtype=bool)
    nodes = [node for row in first.model.mass_matrix for node in row]
    if not size or first.model.evaluator(nodes).switched:
        return np.zeros(len(systems), dtype=bool)
    numbers = np.array([system.parameters for system in systems]).T
    states = np.array([system.state for system in systems]).T
    times = np.array([system.time for system in systems])
    matrices = np.zeros((len(systems), size, size))
    rows, columns = np.tril_indices(size)
    with np.errstate(all="ignore"):
        matrices[:, rows, columns] = first.evaluate(nodes, times, states, further={"p": numbers}).T
        sizes = np.sqrt(np.diagonal(matrices, axis1=1, axis2=2))
        scaled = matrices / sizes[:, None, :] / sizes[:, :, None]
    finite = np.asarray(np.isfinite(scaled).all(axis=(1, 2)))
    least = np.linalg.eigvalsh(np.where(finite[:, None, None], scaled, np.eye(size)))[:, 0]
    return np.asarray(finite & (least > 10.0 * LEAST_INERTIA))


def require_inertia(system: System) -> None:
    """A free coordinate whose motion moves no mass has no equation of motion."""
    free, tree = system.topology.free, system.model.tree
    if tree is not None:
        _require_pivots(system, tree)
        return
    matrix = np.zeros((len(free), len(free)))
    if free:
        nodes = [node for row in system.model.mass_matrix for node in row]
        matrix[np.tril_indices(len(free))] = system.evaluate(nodes)[:, 0]
    diagonal = np.diag(matrix)
    unsound = [name for name, row in zip(free, matrix, strict=True) if not np.isfinite(row).all()]
    if unsound:
        raise _overflowing(system, unsound[0])
    idle = [name for name, value in zip(free, diagonal, strict=True) if value == 0]
    if not idle and len(free):
        sizes = np.sqrt(diagonal)
        scaled = matrix / sizes / sizes[:, None]
        values, vectors = np.linalg.eigh(scaled, UPLO="L")
        if values[0] < LEAST_INERTIA:
            idle = [name for name, part in zip(free, vectors[:, 0], strict=True) if abs(part) > 0.1]
    if idle:
        raise _massless(system, idle)


def _require_pivots(system: System, tree: BodyTree) -> None:
    """The same of a tree: what a body has to turn, beside what it has with all joints held."""
    free = system.topology.free
    nodes = [tree.articulated[name] for name in free]
    values = system.evaluate([n for own in nodes for n in (own.inertia, own.bound)])[:, 0]
    inertia, bound = values.reshape(-1, 2).T
    sound = np.isfinite(bound)
    idle = sound & (inertia <= LEAST_INERTIA * bound)  # what carries these has no inertia either
    if idle.any():
        raise _massless(system, [free[place] for place in np.flatnonzero(idle)])
    if not sound.all():
        raise _overflowing(system, free[int(np.argmin(sound))])


def _overflowing(system: System, name: str) -> InputError:
    message = f"the inertia of {name} at t = 0 is not a finite number. {TOO_LARGE}"
    return system.mechanism.error([(system.mechanism.initial[name].path, message)])


def _massless(system: System, idle: list[str]) -> InputError:
    message = f"no mass moves with {' and '.join(idle)} at t = 0; expected a mass or an inertia"
    return system.mechanism.error([(system.mechanism.initial[idle[0]].path, message)])


def _labelled_events(
    crossings: Mapping[str, Motion], names: Sequence[str]
) -> dict[str, xr.Dataset]:
    """Event → outputs at its crossings, as a solution has them at its samples."""
    known = [name for name in names if not VARIABLES[name].whole or name in REACTIONS]
    result = {}
    for event, met in crossings.items():
        motion = Motion(pieces=tuple(accelerated(piece) for piece in met.pieces))
        values = evaluate_outputs(motion, known)
        system = motion.pieces[0].system
        result[event] = labelled(system, motion, values).assign_attrs(event=event)
    return result


def _add_derived(
    system: System,
    settings: Settings,
    motion: Motion,
    names: list[str],
    values: dict[str, NDArray[Any]],
    notes: list[str],
) -> None:
    """Outputs that need more than the motion at one time."""
    errors = [name for name in names if VARIABLES[name].compared]
    if errors:
        _add_errors(system, settings, motion, errors, values, notes)
    if "energy_residual" in names:
        from linkages.solution.contact_episodes import energy_of_impacts

        energies = ("kinetic_energy", "potential_energy")
        parts = evaluate_variables(motion, energies)
        energy = parts["kinetic_energy"] + parts["potential_energy"]
        work = motion.work
        assert work is not None
        # the first sample may be taken later than the motion starts
        nodes = [node for name in energies for node in VARIABLES[name].evaluated(system.model)]
        work = work + energy_of_impacts(motion)
        values["energy_residual"] = energy - system.evaluate(nodes).sum() - work
    if not {*OF_CONTACTS}.isdisjoint(names):
        from linkages.solution.contact_notes import CONTACT_OUTPUTS, dissipated

        if not {*DISSIPATION}.isdisjoint(names):
            values |= zip(DISSIPATION, dissipated(motion), strict=True)
        wanted = [name for name in names if name in OF_CONTACTS and name not in DISSIPATION]
        values |= {name: CONTACT_OUTPUTS[name](motion) for name in wanted}
    if not {*REACTIONS}.isdisjoint(names):
        from linkages.solution.joint_reactions import reactions

        result = reactions(motion)
        values |= {name: result[name] for name in REACTIONS if name in names}
        if REACTION in names and PIN in names:
            shared = dict.fromkeys(joint for joint, _ in shared_pins(system.mechanism))
            notes.append(
                f"three bodies or more meet at {listed(shared, 'and')}: pin_reaction has the force "
                "on each of them, joint_reaction the force of the first one on all others"
            )
        if system.topology.redundant:
            joints = system.topology.redundant_places
            notes.append(
                f"constraints at {joints} are redundant: rigid bodies do not determine all joint "
                "reactions; those with the least sum of squares are given"
            )


def _add_errors(
    system: System,
    settings: Settings,
    motion: Motion,
    errors: list[str],
    values: dict[str, NDArray[np.float64]],
    notes: list[str],
) -> None:
    """Differences of slider motions against the same mechanism without clearances."""
    wanted = [VARIABLES[name].compared for name in errors]
    try:
        ideal = System(system.mechanism.ideal())
    except InputError as error:
        notes.append(f"no errors against the ideal mechanism: {error}")
        return
    if ideal.topology.free and system.time:
        notes.append("no errors against the ideal mechanism: its motion starts at t = 0")
        return
    followed = compute_motion(ideal, replace(settings.plain(motion.time), counting=False))
    if followed.interrupted:
        raise KeyboardInterrupt
    if followed.failure is not None:
        notes.append(f"no errors against the ideal mechanism: {followed.failure}")
        return
    ideal_values = evaluate_variables(followed, wanted)
    missing = [name for name in wanted if name not in values]
    own = {**values, **evaluate_variables(motion, missing)}
    for output, name in zip(errors, wanted, strict=True):
        values[output] = own[name] - ideal_values[name]
