"""Equilibria of a mechanism, its vibration modes and its linear equations about them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.equilibria.ports import Channels, Outputs, input_channels
from linkages.equilibria.resting import Rest, Search, solved_numbers
from linkages.equilibria.statics import Places, Statics
from linkages.equilibria.vibration import (
    ON_AXIS,
    LinearModel,
    VibrationMode,
    linear_model,
    no_model,
    responses,
    verdict,
    vibration_modes,
)
from linkages.errors import ComputationError, UnfinishedError
from linkages.options.analysis_options import EquilibriumKeywords, EquilibriumOptions, OrbitOptions
from linkages.options.option import OptionError, takes
from linkages.orbits.orbit import require_isolated
from linkages.orbits.shooting import Shooting
from linkages.orbits.starting_states import read_states
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.joint_reactions import reactions
from linkages.solution.motion import Motion
from linkages.solution.rhs import Equations
from linkages.solution.run_options import options_of
from linkages.solution.series import REACTION, labelled, requested

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

FROZEN = "frozen coefficients, no statement on stability"
"""What is said of vibration about a motion, whose equations change with time."""

AROUND = 10.0
"""Factor below the lowest and above the highest natural frequency to which responses reach."""

FREQUENCIES = 400
"""Of a frequency response, if they are not said."""

SHOWN = ("joint_position", "bar_angle", "slider_position", "clearance_offset")
"""What drawings of modes need."""

HALVINGS = 20
"""Of amplitudes at which a mode cannot be assembled."""

SWING, TURN = 0.08, 0.35
"""Largest displacement of a joint in drawings of modes, in sizes of the mechanism, and angle."""


@takes(EquilibriumOptions)
def equilibrium(
    mechanism: Mechanism,
    *,
    time: float = 0.0,
    state: Mapping[str, float] | Sequence[str] = (),
    solve: Sequence[str] = (),
    inputs: Sequence[str] = (),
    observed: Sequence[str] = (),
    frequencies: str | Sequence[float] | None = None,
    watch: Callable[[float], None] | None = None,
    **options: Unpack[EquilibriumKeywords],
) -> xr.Dataset:
    """Find positions in which a mechanism rests, and how it vibrates about each of them.

    Newton's method from many positions within reach, on exact derivatives: springs, gravity, laws
    of position, contacts and stops; where dry friction holds, the interval that it holds. Nothing
    is divided by the inertia, so that bodies may be massless.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    time
        Drives stand still where they are at this time in seconds; loads are those of that time.
    state
        Coordinate → value in SI where the search begins, or texts such as ``"rod.angle=10 deg"``;
        others are those of the definition.
    solve
        Paths of numbers of the definition, such as ``springs[0].length``, to be found such that the
        coordinates of `state` are an equilibrium: as many as coordinates are given.
    inputs
        Of the linear equations: ``rod.torque``, ``piston.force``, ``P.x force``, ``loads[0]``, or
        the acceleration of a drive, ``crank.acceleration``; default: torques and forces on all free
        coordinates, and the accelerations of all drives.
    observed
        Outputs of the linear equations: any output at one time, such as ``rod.angle``, ``P.x
        position``, ``M.x reaction`` or the effort of a drive, ``crank.effort``; default: all free
        coordinates.
    frequencies
        Of the frequency response in Hz, numbers or text ``"FROM:TO:COUNT"``; default: from a tenth
        of the lowest to ten times the highest natural frequency.
    watch
        Called with the fraction of equilibria that are done.
    options
        As `EquilibriumOptions` describes them.

    Returns
    -------
    Dataset along the dimension `equilibrium`, lowest potential energy first: `state` (coordinate)
    and `interval` (coordinate, end), nan where dry friction holds nothing; `stable`, `reason`,
    `neutral`, `potential_energy`, `joint_position`, `bar_angle`, `joint_reaction`, `drive_effort`;
    of each mode `frequency` in Hz, `damping_ratio`, `eigenvalue` (part), `mode_kind` and
    `mode_shape` (coordinate, part); the linear equations ``A``, ``B``, ``C``, ``D`` with
    `state_name`, and `response` (frequency, output, input, part). What an equilibrium has fewer of
    than others is nan. `linkages.state_space` takes the equations of one of them.

    Raises
    ------
    InputError
        If nothing is free to move, or a state is sampled.
    ComputationError
        If no equilibrium is found, or the linear equations do not determine what moves.
    """
    run = options_of(EquilibriumOptions, mechanism, options)
    given = read_states(mechanism, state)
    if run.moving and (given or solve):
        raise OptionError("moving", "expected neither a state nor 'solve' with the motion itself")
    if mechanism.sampled:
        message = (
            "it changes at multiples of a period alone, and linear equations are continuous; "
            "expected a state with a 'rate', or 'orbit' for where the motion repeats"
        )
        raise mechanism.error((each.path, message) for each in mechanism.sampled.values())
    solved: dict[str, float] = {}
    notes: list[str] = []
    motion = None
    if run.moving:
        statics = Statics(mechanism, time)
        rest, rates, accelerations = _moving(mechanism, statics, run)
        motion = rates, accelerations
        found = [rest]
    else:
        statics, found, solved, notes = _rests(mechanism, run, time, given, solve)
    if not found:
        raise ComputationError(
            f"no equilibrium was found from {run.starts} starts; there may be none, or none within "
            "reach: try other initial coordinates, or more starts",
            time=time,
        )
    channels, wanted = input_channels(statics, inputs), Outputs(statics, observed)
    result = []
    for number, rest in enumerate(found, 1):
        result.append(_one(statics, rest, channels, wanted, motion))
        if watch is not None:
            watch(number / len(found))
    result.sort(key=lambda each: float(each["energy"]))
    shown = _frequencies(frequencies, [one["modes"] for one in result])
    data = _dataset(statics, result, channels, wanted, shown)
    said = {"solved": json.dumps(solved), "notes": json.dumps([*dict.fromkeys(notes)])}
    data.attrs.update(name=mechanism.name, source=mechanism.file_name, time=time,
                      moving=int(run.moving), **said, **run.how)  # fmt: skip
    failures = [one["failure"] for one in result if one["failure"] is not None]
    if failures:
        raise UnfinishedError(str(failures[0]), {"equilibrium": data}, time=time)
    return data


def _rests(
    mechanism: Mechanism,
    run: EquilibriumOptions,
    time: float,
    given: Mapping[str, float],
    solve: Sequence[str],
) -> tuple[Statics, list[Rest], dict[str, float], list[str]]:
    """The equations, equilibria, numbers that were solved for, and what there is to say."""
    statics = Statics(mechanism, time, solve)
    wanted = _wanted(statics, given)
    solved: dict[str, float] = {}
    if solve:
        if len(solve) != len(wanted):
            count = f"{len(solve)} number{'s' * (len(solve) != 1)}"
            message = f"found {count} and {len(wanted)} coordinates; expected as many 'state'"
            raise OptionError("solve", message)
        solved = solved_numbers(statics, solve, wanted)
        statics = Statics(mechanism.with_values(solved), time)
    for place, value in wanted.items():
        statics.start.z[statics.own[place]] = value
    search = Search(statics, run.starts, run.seed)
    return statics, search.found(), solved, search.notes


def _wanted(statics: Statics, given: Mapping[str, float]) -> dict[int, float]:
    """Place among the own coordinates → value."""
    names = list(statics.names[: len(statics.own)])
    result = {}
    for name, value in given.items():
        if name not in names:
            message = f"found no coordinate {name!r}; expected one of: {', '.join(names)}"
            raise OptionError("state", message)
        result[names.index(name)] = value
    return result


def _moving(
    mechanism: Mechanism, statics: Statics, run: EquilibriumOptions
) -> tuple[Rest, Floats, Floats]:
    """The state of the motion at a time: position, rates and accelerations."""
    own = OrbitOptions.like(run)
    shooting = Shooting(mechanism, (), own)
    state, n = shooting.initial(()), len(statics.own)
    if statics.time:
        shot = shooting.shoot((), state, statics.time, start=0.0, tangents=False)
        state, changes = shot.end, shot.flow
        held = {name: float(values[0]) for name, values in shot.held.items()}
    else:
        equations = Equations(shooting.system_at((), state))
        kept = np.delete(np.arange(len(equations.state)), shooting.carried_rows)
        changes = equations(0.0, equations.state)[kept]
        held = equations.held(0.0, equations.state)
    switches = statics.model.switches.switches
    sigma = np.array([held[f"mode {switches[k].name}"] for k in statics.nodes.sticky])
    closed = [c.name for c in statics.nodes.contacts if held.get(f"mode {c.touch}", -1.0) > 0.0]
    require_isolated(mechanism, shooting)
    if closed or (sigma == 0.0).any():
        raise ComputationError(
            f"a rigid contact or dry friction holds at t = {statics.time:g} s; expected a time at "
            "which nothing sticks",
            time=statics.time,
        )
    z, branch = statics.start.z.copy(), statics.start.branch.copy()
    z[statics.own, 0], z[statics.n :, 0] = state[:n], state[2 * n :]
    rates, accelerations = np.zeros(statics.n), np.zeros(statics.n)
    rates[statics.own], rates[statics.held] = state[n : 2 * n], statics.drive_rates
    accelerations[statics.own] = changes[n : 2 * n]
    accelerations[statics.held] = statics.drive_accelerations
    names = statics.system.topology.carried
    there = shooting.system_at((), state)
    nodes = [there.model.positions.coordinate(name) for name in names]
    branch[: len(names)] = there.evaluate(nodes, statics.time)
    return Rest(Places(z, branch), sigma), rates, accelerations


def _one(
    statics: Statics,
    rest: Rest,
    channels: Channels,
    outputs: Outputs,
    motion: tuple[Floats, Floats] | None,
) -> dict[str, Any]:
    """Everything about one equilibrium."""
    rates, accelerations = motion or (None, None)
    forces = channels.forces(statics, rest)
    failure = None
    try:
        model = linear_model(
            statics, rest, forces, channels.drives, rates=rates, accelerations=accelerations
        )
    except ComputationError as error:
        failure, many = error, forces.shape[1] + len(channels.drives)
        model = no_model(statics.n, statics.m, many)
    modes = vibration_modes(model, ON_AXIS * statics.swiftness if rest.neutral else 0.0)
    stable, reason = False, FROZEN if failure is None else str(failure)
    if failure is None and motion is None:
        stable, reason = verdict(model, modes, rest)
    given = [None if each is None else each[:, None] for each in (rates, accelerations)]
    piece = statics.piece(rest.place, rest.sigma[:, None], rest.pressed, *given)
    whole = Motion(pieces=(piece,))
    system = statics.system
    names = requested(system, ["joint_position"])
    names += [n for n in ("bar_angle", "slider_position") if _has(system, n)]
    values = evaluate_variables(whole, names)
    values |= {REACTION: reactions(whole)[REACTION]}
    data = labelled(system, whole, values).isel(time=0, drop=True)
    energy = statics.values([statics.model.potential_energy], rest.place, rest.sigma[:, None])
    effort = _efforts(statics, rest, rates, accelerations)
    return {
        "rest": rest, "model": model, "modes": modes, "stable": stable, "reason": reason,
        "data": data, "energy": float(energy[0, 0]), "effort": effort, "rates": rates,
        "c": outputs.rows(piece, model, channels, forces), "failure": failure,
    }  # fmt: skip


def _has(system: Any, name: str) -> bool:
    try:
        return bool(requested(system, [name]))
    except ValueError:
        return False


def _efforts(
    statics: Statics, rest: Rest, rates: Floats | None, accelerations: Floats | None
) -> Floats:
    """Efforts of drives, shape (drives,)."""
    given = [None if each is None else each[:, None] for each in (rates, accelerations)]
    forces = statics.values(
        statics.nodes.forces, rest.place, rest.sigma[:, None],
        rates=given[0], accelerations=given[1],
    )[:, 0]  # fmt: skip
    if rest.pressed:
        at = statics.at(rest.place, rest.sigma[:, None])
        for k, force in rest.pressed.items():
            part = rest.rubbed.get(k, 0.0)
            forces[: statics.n] -= force * (at.normals[k] - part * at.slips[k])[:, 0]
    return np.asarray(0.0 - forces[statics.held])


def _frequencies(
    asked: str | Sequence[float] | None, modes: Sequence[Sequence[VibrationMode]]
) -> Floats:
    """Frequencies of the response in Hz."""
    if isinstance(asked, str):
        parts = asked.split(":")
        try:
            low, high, count = float(parts[0]), float(parts[1]), int(parts[2])
            if len(parts) != 3 or not 0.0 < low < high < np.inf or count < 2:
                raise ValueError
        except (ValueError, IndexError):
            message = f"expected FROM:TO:COUNT in Hz, such as 0.1:100:401, found {asked!r}"
            raise OptionError("frequencies", message) from None
        return np.geomspace(low, high, count)
    if asked is not None:
        result = np.asarray(asked, dtype=float)
        if result.ndim != 1 or not (np.isfinite(result) & (result >= 0.0)).all():
            raise OptionError("frequencies", f"expected frequencies in Hz, found {asked!r}")
        return result
    sizes = [abs(each.eigenvalue) / (2 * np.pi) for own in modes for each in own
             if each.kind != "neutral"]  # fmt: skip
    low, high = (min(sizes), max(sizes)) if sizes else (1.0, 1.0)
    return np.geomspace(low / AROUND, high * AROUND, FREQUENCIES)


def _padded(each: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays as one, with nan (or empty text) where one is smaller than others."""
    shape = np.max([one.shape for one in each], axis=0)
    blank: Any = "" if each[0].dtype == object else np.nan
    result = np.full((len(each), *shape), blank, dtype=each[0].dtype)
    for row, one in zip(result, each, strict=True):
        row[tuple(map(slice, one.shape))] = one
    return result


def _both(values: NDArray[Any]) -> Floats:
    """Real and imaginary parts along a last axis."""
    return np.stack([values.real, values.imag], axis=-1).astype(float)


def _dataset(
    statics: Statics,
    each: Sequence[dict[str, Any]],
    channels: Channels,
    outputs: Outputs,
    frequencies: Floats,
) -> xr.Dataset:
    """All equilibria as labelled arrays."""
    import xarray as xr

    n, own = len(statics.own), statics.own
    names, units = statics.listed(own.tolist())
    models: list[LinearModel] = [one["model"] for one in each]
    modes: list[list[VibrationMode]] = [one["modes"] for one in each]
    states, intervals = [], []
    for one in each:
        rest, rates = one["rest"], one["rates"]
        speeds = np.zeros(n) if rates is None else rates[own]
        states.append(np.concatenate([rest.z[own], speeds, rest.z[statics.n :]]))
        ends = np.full((len(names), 2), np.nan)
        if rest.interval is not None:
            ends[:n], ends[2 * n :] = rest.interval[own], rest.interval[statics.n :]
        intervals.append(ends)
    pairs = [(np.hstack([m.a, m.b]), one["c"]) for m, one in zip(models, each, strict=True)]
    size = [len(m.a) for m in models]
    parts = [
        (both[:, :k], both[:, k:], c[:, :k], c[:, k:])
        for (both, c), k in zip(pairs, size, strict=True)
    ]
    answers = [_both(responses(*matrices, frequencies)) for matrices in parts]
    a, b, c, d = (_padded([own[k] for own in parts]) for k in range(4))
    of, mode = "equilibrium", ("equilibrium", "mode")

    def of_modes(value: Callable[[VibrationMode], Any], kind: type = float) -> NDArray[Any]:
        return _padded([np.array([value(one) for one in own], dtype=kind) for own in modes])

    shapes = [
        np.array([_both(m.shape[own]) for m in rows]).reshape(len(rows), n, 2) for rows in modes
    ]
    values = [np.array([m.eigenvalue for m in rows], dtype=complex) for rows in modes]
    data = {
        "state": ((of, "coordinate"), np.array(states), {"long_name": "state"}),
        "interval": (
            (of, "coordinate", "end"), np.array(intervals),
            {"long_name": "interval that dry friction holds"},
        ),
        "unit": ("coordinate", np.array(units, dtype=object)),
        "branch": (
            (of, "branch_entry"), np.array([one["rest"].place.branch[:, 0] for one in each])
        ),
        "stable": (of, np.array([int(one["stable"]) for one in each])),
        "neutral": (of, np.array([one["rest"].neutral for one in each])),
        "reason": (of, np.array([one["reason"] for one in each], dtype=object)),
        "potential_energy": (
            of, np.array([one["energy"] for one in each]),
            {"units": "J", "long_name": "potential energy"},
        ),
        "drive_effort": (
            (of, "drive"), np.array([one["effort"] for one in each]).reshape(len(each), -1),
            {"long_name": "effort of a drive that stands still"},
        ),
        "drive_unit": (
            "drive",
            np.array([statics.units_of_effort(name) for name in statics.driven], dtype=object),
        ),
        "frequency": (mode, of_modes(lambda m: m.frequency), {"units": "Hz"}),
        "damping_ratio": (mode, of_modes(lambda m: m.damping_ratio), {"units": "1"}),
        "eigenvalue": ((*mode, "part"), _padded([_both(v) for v in values]), {"units": "1/s"}),
        "mode_kind": (mode, of_modes(lambda m: m.kind, object)),
        "mode_shape": (
            (*mode, "freedom", "part"), _padded(shapes),
            {"units": "1", "long_name": "deviation of a coordinate, the largest being 1"},
        ),
        "state_name": (
            (of, "row"), _padded([np.array(m.names, dtype=object) for m in models])
        ),
        "state_unit": (
            (of, "row"), _padded([np.array(m.units, dtype=object) for m in models])
        ),
        "A": ((of, "row", "column"), a),
        "B": ((of, "row", "input"), b),
        "C": ((of, "output", "column"), c),
        "D": ((of, "output", "input"), d),
        "response": (
            (of, "response_frequency", "output", "input", "part"), np.array(answers),
            {"long_name": "frequency response"},
        ),
        "input_unit": ("input", np.array(channels.units, dtype=object)),
        "output_unit": ("output", np.array(outputs.units, dtype=object)),
    }  # fmt: skip
    coords = {
        of: np.arange(1, len(each) + 1),
        "coordinate": np.array(names, dtype=object),
        "freedom": np.array(names[:n], dtype=object),
        "end": np.array(["low", "high"], dtype=object),
        "part": np.array(["real", "imaginary"], dtype=object),
        "mode": np.arange(1, max(map(len, modes)) + 1),
        "drive": np.array(statics.driven, dtype=object),
        "input": np.array(channels.names, dtype=object),
        "output": np.array(outputs.names, dtype=object),
        "response_frequency": ("response_frequency", frequencies, {"units": "Hz"}),
    }
    placed = xr.concat([one["data"] for one in each], of).assign_coords({of: coords[of]})
    return xr.Dataset(data, coords=coords).merge(placed, combine_attrs="drop")


def state_space(data: xr.Dataset, number: int = 1) -> tuple[Floats, Floats, Floats, Floats]:
    """A, B, C and D of one equilibrium, as `scipy.signal.StateSpace` takes them.

    Parameters
    ----------
    data
        As `linkages.equilibrium` returns it.
    number
        Of the equilibrium, from 1.

    Returns
    -------
    Arrays of shapes (states, states), (states, inputs), (outputs, states) and (outputs, inputs), in
    SI. Names are in the coordinates ``input`` and ``output``, and in the variable ``state_name``.

    Raises
    ------
    KeyError
        If there is no equilibrium of that number.
    """
    one = data.sel(equilibrium=number)
    size = int((one["state_name"] != "").sum())
    a, b, c, d = (one[name].to_numpy() for name in "ABCD")
    return a[:size, :size], b[:size], c[:, :size], d


def swing(
    mechanism: Mechanism, data: xr.Dataset, number: int, mode: int, phases: Floats
) -> xr.Dataset:
    """Positions of a vibration mode at phases in radians, as outputs of a motion over time.

    The largest displacement of a joint is some hundredths of the size of the mechanism.

    `data`: as `linkages.equilibrium` returns it; `number`, `mode`: both from 1.
    """
    solved = json.loads(data.attrs["solved"])
    mechanism = mechanism.with_values(solved) if solved else mechanism
    statics = Statics(mechanism, float(data.attrs["time"]))
    one = data.sel(equilibrium=number)
    n, start = len(statics.own), statics.start
    start.z[statics.own, 0] = one["state"].to_numpy()[:n]
    start.z[statics.n :, 0] = one["state"].to_numpy()[2 * n :]
    start.branch[:, 0] = one["branch"].to_numpy()
    shape = one["mode_shape"].sel(mode=mode).to_numpy() @ [1.0, 1.0j]
    moved = np.zeros((statics.n, 2))
    moved[statics.own] = np.stack([shape.real, shape.imag], axis=1)
    joints = statics.model.velocities.joints.values()
    nodes = [node for joint in joints for node in (joint.x, joint.y)]
    vectors = statics.values(nodes, start.at([0, 0]), rates=moved).reshape(-1, 2, 2)
    paths = np.hypot(vectors[:, 0], vectors[:, 1]).reshape(-1, 2)
    places = one["joint_position"].to_numpy()
    extent = float(np.ptp(places, axis=0).max()) or 1.0
    largest = float(np.hypot(*paths.T).max(initial=0.0))
    turned = np.abs(shape[[statics.system.mechanism.bodies[n].rotates for n in statics.own_names]])
    amplitude = min(
        SWING * extent / largest if largest else np.inf,
        TURN / turned.max() if turned.size and turned.max() else np.inf,
    )
    names = [name for name in SHOWN if _has(statics.system, name)]
    for _ in range(HALVINGS):
        z = np.repeat(start.z, len(phases), axis=1)
        z[statics.own] += amplitude * (shape[:, None] * np.exp(1j * phases)).real
        piece = statics.piece(statics.settled(start.with_z(z)))
        values = evaluate_variables(Motion(pieces=(piece,)), names)
        if all(np.isfinite(array).all() for array in values.values()):
            break
        amplitude *= 0.5
    timed = replace(piece, time=phases / (2 * np.pi))
    return labelled(statics.system, Motion(pieces=(timed,)), values)
