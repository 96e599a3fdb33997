"""Messages on where and why a motion stops."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import Function
from linkages.kernel.forces.generalised_forces import LoadNodes
from linkages.kernel.inputs import law_values
from linkages.kernel.model import Model
from linkages.kernel.system import System
from linkages.reading.paths import dotted
from linkages.solvers.trajectory import Outcome, Trajectory
from linkages.topology.assur_groups import ITERATED, Block

NEAR = 1e-9
"""How far beyond a stop a law is looked at, beside the time itself (or one second)."""

WITHOUT_BOUND = 1e6
"""How many times as large as its median until then a law is that grows without bound."""

BEFORE = 401
"""Times before a stop at which the median is taken."""

UNDEFINED_BEYOND = (
    "its active branch is undefined just beyond the condition, where trial steps evaluate it; "
    "expected a branch that is defined there, such as sqrt(abs(x)) instead of sqrt(x)"
)


def undefined_load(system: System, times: NDArray[np.float64]) -> tuple[int, str] | None:
    """The first time at which a load of a driven system has no value, and a sentence about it."""
    if not system.model.loads:
        return None
    result = []
    joints = system.model.positions.joints.values()
    places = system.evaluate([node for joint in joints for node in (joint.x, joint.y)], times)
    reached = np.isfinite(places).all(axis=0)
    for load in system.model.loads:
        lost = _lost(system, load, times, None) & reached
        if lost.any():
            first = int(np.argmax(lost))
            place = f"at t = {times[first]:.9g} s, {dotted(load.load.path)}: {load.undefined}"
            result.append((first, f"{place}. End before, or change the load."))
    return min(result) if result else None


def _lost(
    system: System,
    load: LoadNodes,
    times: NDArray[np.float64] | float,
    state: NDArray[np.float64] | None,
    held: NDArray[np.float64] | None = None,
) -> NDArray[np.bool_]:
    """Where a load has no value though all has one that it depends on; with modes that are held."""
    given, rated = (
        np.isfinite(system.evaluate(nodes, times, state, held=held))
        for nodes in (load.given, load.doubtful)
    )
    lost = ~rated[:1].all(axis=0) & rated[1:].all(axis=0)
    return np.asarray(lost | ~given.all(axis=0))


def loads_at_stop(system: System, trajectory: Trajectory) -> list[str]:
    """Loads that explain why an integration stopped: without a value there, or without bound."""
    time = trajectory.stop_time
    result = [
        dotted(load.path)
        for load in system.mechanism.loads
        if any(_breaks(law, time) for law in load.laws)
    ]
    return [*dict.fromkeys(result), *_springs(system, trajectory)]


def _breaks(law: Function, time: float) -> bool:
    near = NEAR * max(1.0, abs(time))
    around = law_values(law, time + near * np.array([0.0, -1.0, 1.0, -1e-3, 1e-3, 1e-6, -1e-6]))
    if not np.isfinite(around).all():
        return True
    before = np.abs(law_values(law, np.linspace(0.0, time, BEFORE)))
    return bool(np.abs(around).max() > WITHOUT_BOUND * np.median(before) > 0.0)


def _final_state(system: System, trajectory: Trajectory) -> NDArray[np.float64]:
    """The last coordinates and rates of a motion, shape (2n,)."""
    count, total = len(system.topology.coordinates), len(trajectory.final_state) // 2
    rows = trajectory.final_state
    return np.concatenate([rows[:count], rows[total : total + count]])


def _springs(system: System, trajectory: Trajectory) -> Iterator[str]:
    """Springs whose ends meet, and other laws of state without a value, at the last state."""
    count, time = len(system.topology.coordinates), trajectory.stop_time
    state = _final_state(system, trajectory)
    ahead = NEAR * max(1.0, abs(time)) * np.array([0.0, 1e-3, 1.0, 1e3])
    states = np.repeat(state[:, None], len(ahead), axis=1)
    states[:count] += ahead * states[count:]
    held = np.repeat(trajectory.final_held[:, None], len(ahead), axis=1)
    for load in system.model.loads:
        if load.load.given:
            continue
        if _lost(system, load, time + ahead, states).any():
            yield f"{dotted(load.load.path)} ({load.undefined})"
        elif _lost(system, load, time + ahead, states, held).any():
            yield f"{dotted(load.load.path)} ({UNDEFINED_BEYOND})"
    first = count + len(system.topology.free)
    rates = system.evaluate(system.model.internal_rates, time, state[:, None])
    states[first : first + len(rates)] += ahead * rates
    for own, law in system.model.own_laws:
        if not np.isfinite(system.evaluate([law], time + ahead, states)).all():
            yield f"{own.name} (its law has no finite value)"


COULD_PASS = "'change_points: pass' takes the smooth one"
FOUND_NONE = "no smooth way on was found"
"""What is said of the way on from a singular position."""

JAMMED = 1e-6
"""Of W_nn², and of the size: how near to jamming a contact is that is called so."""


def _block(model: Model, index: int) -> Block:
    return next(block for block in model.topology.solved_blocks if block.index == index)


def block_place(model: Model, block: int) -> str:
    """Where something happens to a block."""
    result = _block(model, block)
    names = " and ".join(result.unknowns)
    joint = joint_of(model, result)
    return f"joint {joint}, block {block} ({result.title} of {names})"


def joint_of(model: Model, block: Block) -> str:
    """The joint at which a block closes; the pin of a slider that closes at its axis."""
    apex = block.loops[0].apex
    if apex in model.positions.numbers:
        return apex
    slider = model.mechanism.bodies.get(apex.removesuffix(".axis"))
    return apex if slider is None else next(iter(slider.points), apex)


def block_alignment(model: Model, block: int) -> str:
    """What a block looks like at a singular position."""
    result = _block(model, block)
    one, other = result.unknowns[0], result.unknowns[-1]
    return {
        "RRR": f"{' and '.join(result.unknowns)} are in line",
        "RRP": f"{one} is perpendicular to the axis of {other}",
        "RPR": f"the axis of {other} on {one} passes its pin at right angles",
        "PP": f"the axes of {one} and {other} are parallel",
    }.get(result.kind, "the group has a singular position")


def passed_text(model: Model, time: float, blocks: tuple[int, ...]) -> str:
    """A sentence about a change point that a motion went through."""
    places = [block_place(model, block) for block in blocks[:3]]
    more = f" and {len(blocks) - 3} more" if len(blocks) > 3 else ""
    return (
        f"at t = {time:.6g} s the motion went on smoothly through a change point: "
        f"{'; '.join(places)}{more}, where {block_alignment(model, blocks[0])}"
    )


def block_failure(
    model: Model, block: int, time: float, singular: bool, way_on: str = COULD_PASS
) -> str:
    """A sentence that says when, where and why a motion cannot go on."""
    return f"at t = {time:.9g} s, {block_stop(model, block, singular, way_on)}"


def block_stop(model: Model, block: int, singular: bool, way_on: str = COULD_PASS) -> str:
    """The same without the time."""
    result = _block(model, block)
    place = block_place(model, block)
    aligned = block_alignment(model, block)
    if result.kind == "PP":
        return f"{place}: {aligned}, so nothing determines their positions"
    if singular:
        return (
            f"{place}: {aligned}; this position is singular, from it the mechanism can go on in "
            f"two ways and double precision cannot tell which ({way_on})"
        )
    if result.kind == ITERATED:
        why = "where its constraints contradict each other, or" if result.surplus else "which is"
        return f"{place}: no position closes its loops beyond this one, {why} a limit of its motion"
    return f"{place}: the mechanism cannot be assembled beyond this position, where {aligned}"


def failure_text(system: System, trajectory: Trajectory, way_on: str = COULD_PASS) -> str | None:
    """Why an integration stopped before its end, with the remedy `way_on`; None if it did not."""
    outcome = trajectory.outcome
    if outcome in (Outcome.DONE, Outcome.EVENT):
        return None
    if (jammed := _jammed(system, trajectory)) is not None:
        return jammed
    if trajectory.switch >= 0:
        name = system.model.switches.switches[trajectory.switch].name
        return f"at t = {trajectory.stop_time:.9g} s, {name}: {outcome}"
    if trajectory.block >= len(system.topology.blocks):  # iterations of `ProfiledGap`
        place = trajectory.block - len(system.topology.blocks)
        name = system.mechanism.contacts[place].name
        return (
            f"at t = {trajectory.stop_time:.9g} s, {name}: where its journal touches its bearing "
            "is not found; expected a profile of less depth or fewer harmonics"
        )
    if outcome in (Outcome.UNREACHABLE, Outcome.SINGULAR) and trajectory.block >= 0:
        singular = outcome is Outcome.SINGULAR
        where = (trajectory.block, trajectory.stop_time)
        text = block_failure(system.model, *where, singular, way_on)
        return f"{text}. {outcome.remedy}"
    if outcome in (Outcome.NOT_FINITE, Outcome.STEP_TOO_SMALL):
        names = loads_at_stop(system, trajectory)
        if names:
            has = "has" if len(names) == 1 else "have"
            return (
                f"at t = {trajectory.stop_time:.9g} s: {', '.join(names)} {has} no finite value "
                "there, or none just before or behind. End before, or change the load."
            )
    return f"at t = {trajectory.stop_time:.9g} s: {outcome}"


def _jammed(system: System, trajectory: Trajectory) -> str | None:
    """What is said of a rigid contact that friction jams, at the last state; None if none does."""
    if trajectory.outcome not in (Outcome.NOT_FINITE, Outcome.STEP_TOO_SMALL):
        return None
    state, time = _final_state(system, trajectory), trajectory.stop_time
    touching = []
    for contact in system.model.rigid:
        if (rough := contact.rubbing) is None:
            continue
        nodes = [rough.jamming, rough.normal, contact.gap.indentation, contact.gap.size]
        jam, normal, depth, size = system.evaluate(nodes, time, state[:, None])[:, 0]
        if jam > -JAMMED * normal**2 and depth > -JAMMED * size:
            return (
                f"at t = {time:.9g} s, {contact.name}: friction jams the contact (Painlevé). "
                "Slip presses it more than its normal force pushes it apart, so that no motion "
                "with finite forces goes on; expected less 'friction', or the law of a force"
            )
        if depth > -JAMMED * size:
            touching.append(contact.name)
    if len(touching) > 1:
        return (
            f"at t = {time:.9g} s, {' and '.join(touching)}: no impulses under friction are found "
            "for all that touch at once, where a body comes to rest at several walls; expected "
            "no 'friction', or the law of a force"
        )
    return None
