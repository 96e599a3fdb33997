"""Simulate a mechanism: from its definition to labelled results."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.mechanism import Mechanism
from linkages.errors import InputError, Interrupted
from linkages.interrupts import interrupts_kept
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.reading.wording import TOO_LARGE
from linkages.solution.arguments import real_number, whole_number
from linkages.solution.assumptions import assumptions
from linkages.solution.crossings import labelled_events
from linkages.solution.doubts import doubts
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.motion import Motion, Settings, Watch, compute_motion
from linkages.solution.requests import REACTION, requested
from linkages.solution.solution import IncompleteError, Solution, labelled
from linkages.solution.soundness import sound_part
from linkages.solution.starting import State, asked_for, own_times, started
from linkages.solution.surface import parse_events
from linkages.solution.switching import movable
from linkages.solvers.choice import AUTO
from linkages.solvers.integrate import LEAST_RTOL, MAX_STEPS
from linkages.solvers.methods import FIXED_STEP_METHODS, METHODS

MAX_SAMPLES = 10_000_000
"""More would not fit into memory as tables."""

LATE = "interrupted after the motion was computed, before all of its outputs were"


def simulate(
    mechanism: Mechanism,
    *,
    end: float | None = None,
    samples: int | None = None,
    times: ArrayLike | None = None,
    state: State | None = None,
    events: Mapping[str, str] | None = None,
    method: str | None = None,
    rtol: float | None = None,
    atol: float | None = None,
    step: float | None = None,
    max_steps: int = MAX_STEPS,
    change_points: str | None = None,
    outputs: Iterable[str] | None = None,
    watch: Watch | None = None,
    throw: bool = True,
) -> Solution:
    """Compute the motion of a mechanism from t = 0.

    Whatever is None is taken from the `simulate` section of the definition file.

    Parameters
    ----------
    mechanism
        From `linkages.load`, or built in Python.
    end
        Simulated time in seconds; negative to go back in time.
    samples
        Number of equally spaced output times, both ends included.
    times : (m,)
        Sample times in seconds instead of these, increasing or decreasing; they may begin later
        than the motion, which starts at t = 0 if no `state` is given.
    state
        Where the motion starts instead of where the definition says: free coordinate → value and
        rate, such as ``{"crank": (0.1, 2.0)}``, or all integrated coordinates and then their rates,
        shape (2n,), as `linkages.compile` has them. It is the state at the first of `times`, else
        at t = 0, in the assembly mode of the definition.
    events
        Series → how it crosses its value: ``{"piston.velocity": "up"}``, ``"down"`` or ``"both"``.
        A value other than 0 stands behind it: ``"crank.angle=90 deg"``. The crossings are in
        `Solution.events`; a zero at the start is none.
    method
        A solver of `linkages.solvers.methods.METHODS`, such as ``"dop853"`` (adaptive, order 8)
        or ``"rk4"`` (fixed step, order 4), or ``"auto"``, which picks one by the tolerance. Not
        used where nothing is free to move: such a motion is solved without integrating.
    rtol, atol
        Tolerances of an adaptive method; `atol` (rad, m, rad/s, m/s) is `rtol` if not given.
    step
        Step of a fixed-step method in seconds.
    max_steps
        A run that needs more ends with an error, and keeps what it has. Where nothing is
        integrated, places at which the way of the mechanism is looked for count: one per degree.
    change_points
        ``"pass"`` to go on smoothly where the mechanism could go on in two ways, as inertia would
        have it, or ``"stop"``. If neither is said, motions with a free coordinate other than a
        clearance pass, and those that drives impose stop.
    outputs
        Names of variables of the result, or ``"all"``; kinematics and efforts if not given.
        Only what is asked for is computed.
    watch
        Called about 20 times a second with the fraction of simulated time done.
    throw
        Whether a motion that cannot go on raises, or returns what was computed.

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
    if given is not None and not (end is None and samples is None):
        raise ValueError("end and samples do not go with times, which say both")
    system = started(mechanism, state, 0.0 if given is None else float(given[0]))
    names = requested(system, outputs)
    settings = _settings(
        mechanism,
        end,
        samples,
        method,
        rtol,
        atol,
        step,
        max_steps,
        "energy_residual" in names,
        watch,
    )
    counting = any(VARIABLES[name].angle for name in names)
    settings = replace(settings, passing=passes(system, change_points), counting=counting)
    settings = replace(settings, events=parse_events(system, events or {}))
    if given is not None:
        settings = replace(settings, times=given)
    _require_inertia(system)
    notes = [*assumptions(system), *doubts(mechanism)]
    with np.errstate(over="ignore", invalid="ignore"):  # what is not finite is found at the end
        motion = compute_motion(system, settings)
        plain = [name for name in names if not VARIABLES[name].whole]
        notes += motion.notes
        interrupted = str(motion.failure) if motion.interrupted else ""
        try:
            with interrupts_kept():  # else the motion would be lost
                values = evaluate_variables(motion, plain)
            if motion.failure is None or len(motion.time):
                _add_derived(system, settings, motion, names, values, notes)
        except KeyboardInterrupt:
            interrupted = interrupted or LATE
    motion, values = sound_part(system, motion, values)
    solution = Solution(
        data=labelled(system, motion, {name: values[name] for name in names if name in values}),
        mechanism=system.mechanism,
        system=system,
        motion=motion,
        settings=settings,
        notes=tuple(notes),
        events=labelled_events(motion.crossed, names),
        asked=asked_for(times=given, state=state, events=events),
    )
    if interrupted:
        raise Interrupted(interrupted, time=motion.stop_time, solution=solution)
    if motion.failure is not None and throw:
        raise IncompleteError(solution)
    return solution


def _settings(
    mechanism: Mechanism,
    end: float | None,
    samples: int | None,
    method: str | None,
    rtol: float | None,
    atol: float | None,
    step: float | None,
    max_steps: int,
    work: bool,
    watch: Watch | None,
) -> Settings:
    """Arguments over the defaults of the file, checked."""
    defaults = mechanism.simulation
    given = {"samples": samples, "rtol": rtol, "method": method, "step": step}

    def refused(key: str, message: str, asked: str = "") -> Exception:
        """What the definition says is an input error at its line, an argument is a ValueError."""
        by_file = given[asked or key] is None
        return _input(mechanism, key, message) if by_file else ValueError(message)

    end = defaults.end if end is None else real_number("end", end)
    samples = defaults.samples if samples is None else whole_number("samples", samples)
    method = defaults.method if method is None else method
    step = defaults.step if step is None else real_number("step", step)
    rtol = defaults.rtol if rtol is None else real_number("rtol", rtol)
    atol = defaults.atol if atol is None else real_number("atol", atol)
    max_steps = whole_number("max_steps", max_steps)
    if not (math.isfinite(end) and end != 0):
        raise ValueError(f"end must be a time in seconds other than 0, found {end}")
    if not 2 <= samples <= MAX_SAMPLES:
        message = f"samples must be at least 2 and at most {MAX_SAMPLES}, found {samples:g}"
        raise refused("samples", message)
    if max_steps < 1:
        raise ValueError(f"max_steps must be at least 1, found {max_steps}")
    if not LEAST_RTOL <= rtol < 1:
        raise refused("rtol", f"rtol must be from {LEAST_RTOL:.3g} to 1, found {rtol:g}")
    if method not in (*METHODS, AUTO):
        known = [*METHODS, AUTO]
        raise refused("method", f"unknown method {method!r}; expected one of: {', '.join(known)}")
    if method in FIXED_STEP_METHODS and step is None:
        message = f"method {method!r} needs a step; expected a time in seconds"
        raise refused("step", message, asked="method")
    if method in FIXED_STEP_METHODS and step is not None and abs(end) > max_steps * step > 0:
        message = f"step {step:g} s needs more than {max_steps} steps to reach {end:g} s"
        raise refused("step", message)
    return Settings(
        times=np.linspace(0.0, end, samples),
        method=method,
        rtol=rtol,
        atol=atol,
        step=step if method in FIXED_STEP_METHODS else None,
        max_steps=max_steps,
        work=work,
        watch=watch,
    )


def require_settings(mechanism: Mechanism) -> None:
    """Make sure that a simulation can run as the definition says.

    Raises
    ------
    InputError
        For a method, tolerance, step or number of samples that `simulate` would refuse.
    """
    nothing = dict.fromkeys(("end", "samples", "method", "rtol", "atol", "step"))
    _settings(mechanism, **nothing, max_steps=MAX_STEPS, work=False, watch=None)


def passes(system: System, change_points: str | None = None) -> bool:
    """Whether a motion goes on through change points, as `simulate` describes it."""
    wanted = change_points or system.mechanism.simulation.change_points
    if wanted not in (None, "pass", "stop"):
        raise ValueError(f"change_points must be 'pass' or 'stop', found {wanted!r}")
    return bool(movable(system)) if wanted is None else wanted == "pass"


def _require_inertia(system: System) -> None:
    """A free coordinate whose motion moves no mass has no equation of motion.

    Raises
    ------
    InputError
        If J_ij of the free coordinates is singular at t = 0.
    """
    free = system.topology.free
    matrix = np.zeros((len(free), len(free)))
    for i, row in enumerate(system.model.mass_matrix):
        matrix[i, : i + 1] = system.evaluate(row)[:, 0]
    diagonal = np.diag(matrix)
    unsound = [name for name, row in zip(free, matrix, strict=True) if not np.isfinite(row).all()]
    if unsound:
        message = f"the inertia of {unsound[0]} at t = 0 is not a finite number. {TOO_LARGE}"
        raise system.mechanism.error([(system.mechanism.initial[unsound[0]].path, message)])
    idle = [name for name, value in zip(free, diagonal, strict=True) if value == 0]
    if not idle and len(free):
        sizes = np.sqrt(diagonal)
        scaled = matrix / sizes / sizes[:, None]
        values, vectors = np.linalg.eigh(scaled, UPLO="L")
        if values[0] < 1e-14:
            idle = [name for name, part in zip(free, vectors[:, 0], strict=True) if abs(part) > 0.1]
    if idle:
        message = f"no mass moves with {' and '.join(idle)} at t = 0; expected a mass or an inertia"
        paths = [system.mechanism.initial[name].path for name in idle]
        raise system.mechanism.error([(paths[0], message)])


def _input(mechanism: Mechanism, key: str, message: str) -> InputError:
    return mechanism.error([(("simulate", key), message)])


def _add_derived(
    system: System,
    settings: Settings,
    motion: Motion,
    names: list[str],
    values: dict[str, NDArray[np.float64]],
    notes: list[str],
) -> None:
    """Outputs that need more than the motion at one time."""
    errors = [name for name in names if VARIABLES[name].compared]
    if errors:
        _add_errors(system, settings, motion, errors, values, notes)
    if "energy_residual" in names:
        energies = ("kinetic_energy", "potential_energy")
        parts = evaluate_variables(motion, energies)
        energy = parts["kinetic_energy"] + parts["potential_energy"]
        work = motion.work
        assert work is not None
        # the first sample may be taken later than the motion starts
        nodes = [node for name in energies for node in VARIABLES[name].evaluated(system.model)]
        values["energy_residual"] = energy - system.evaluate(nodes).sum() - work
    if REACTION in names:
        from linkages.solution.reactions import joint_reactions

        values[REACTION] = joint_reactions(motion)
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
    plain = replace(settings, times=motion.time, work=False, counting=False, watch=None, events=())
    followed = compute_motion(ideal, plain)
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
