"""The assembly mode at t = 0: the side of every dyad."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from linkages.errors import InputError
from linkages.kernel.dyads import LinkAndSlider, TwoLinks
from linkages.kernel.model import Model
from linkages.kernel.scalars import Evaluator, Scalar
from linkages.topology.blocks import Block

Evaluate = Callable[[list[Scalar], int], list[float]]
"""Nodes and the side of the block under consideration → values at t = 0."""


def assemble(model: Model, state: np.ndarray) -> tuple[dict[int, int], tuple[int, ...]]:
    """Choose the side of each block from the hints of the definition file.

    Parameters
    ----------
    model
        The equations.
    state
        Free coordinates and their rates at t = 0.

    Returns
    -------
    Block index → +1 or −1, and the blocks for which no hint was given (a slider then lies
    forward of its link along the axis).

    Raises
    ------
    InputError
        For dyads that cannot be assembled, and joints that could be in two places.
    """
    sides: dict[int, int] = {}
    assumed: list[int] = []
    _check_hints(model)
    for block in model.topology.solved_blocks:

        def evaluate(nodes: list[Scalar], side: int, index: int = block.index) -> list[float]:
            return _values(model, nodes, state, sides | {index: side})

        _check_reach(model, block, evaluate)
        if model.positions.dyads[block.index].radicand is None:
            continue
        side = _hinted_side(model, block, evaluate)
        if side is None:
            if block.kind == "RRR":
                raise _missing_hint(model, block, evaluate)
            side = 1
            assumed.append(block.index)
        sides[block.index] = side
    return sides, tuple(assumed)


def parameter_values(model: Model, sides: dict[int, int]) -> np.ndarray:
    """The parameter array of a model, shape (parameters,)."""
    values = dict(model.inputs.parameters)
    values |= {
        ("side", block): float(side) for block, side in sides.items() if ("side", block) in values
    }
    return np.array(list(values.values()), dtype=float)


def _values(
    model: Model, nodes: list[Scalar], state: np.ndarray, sides: dict[int, int]
) -> list[float]:
    found = Evaluator(nodes)(t=np.zeros(1), y=state, p=parameter_values(model, sides))
    return [float(value) for value in found]


def _joints(model: Model, block: Block) -> list[str]:
    bodies = {body for body, _ in block.placements}
    placed = model.topology.placing
    return [joint for joint in model.topology.joints if placed.get(joint) in bodies]


def _place_nodes(model: Model, joints: list[str]) -> list[Scalar]:
    places = model.positions.joints
    return [node for joint in joints for node in (places[joint].x, places[joint].y)]


def _check_reach(model: Model, block: Block, evaluate: Evaluate) -> None:
    dyad = model.positions.dyads[block.index]
    if dyad.radicand is None:
        return
    radicand, bridge, first, second = _reach_numbers(dyad, evaluate)
    if radicand >= 0.0:
        return
    loop = block.loops[0]
    path = model.mechanism.bodies[block.unknowns[0]].path
    names = " and ".join(block.unknowns)
    if isinstance(dyad, TwoLinks):
        message = (
            f"{names} ({first:.6g} m and {second:.6g} m) cannot meet at {loop.apex}: their other "
            f"ends {loop.start} and {loop.end} are {bridge:.6g} m apart at t = 0; expected between "
            f"{abs(first - second):.6g} m and {first + second:.6g} m"
        )
    else:
        message = (
            f"{block.unknowns[0]} ({first:.6g} m) cannot reach the axis of {block.unknowns[1]}: "
            f"{loop.start} is {bridge:.6g} m away from it at t = 0; expected at most {first:.6g} m"
        )
    raise model.mechanism.error([(path, f"cannot be assembled: {message}")])


def _reach_numbers(dyad: object, evaluate: Evaluate) -> tuple[float, float, float, float]:
    """Radicand, distance to bridge, lengths of the links (the second 0 for a slider)."""
    if isinstance(dyad, TwoLinks):
        nodes = [dyad.radicand, dyad.gap_square, dyad.first_square, dyad.second_square]
        radicand, gap, first, second = evaluate(nodes, 1)
        return radicand, gap**0.5, first**0.5, second**0.5
    assert isinstance(dyad, LinkAndSlider)
    radicand, across, length = evaluate([dyad.radicand, dyad.across, dyad.margin_scale], 1)
    return radicand, abs(across), length, 0.0


def _hinted_side(model: Model, block: Block, evaluate: Evaluate) -> int | None:
    hints = [
        hint for joint, hint in model.mechanism.hints.items() if joint in _joints(model, block)
    ]
    sides = [hint.side for hint in hints if hint.side is not None]
    if sides:
        return sides[0]
    if not hints:
        return None
    nodes = _place_nodes(model, [hint.joint for hint in hints])
    wanted = np.array([hint.position for hint in hints], dtype=float).ravel()
    left, right = (float(np.linalg.norm(np.array(evaluate(nodes, s)) - wanted)) for s in (1, -1))
    size = float(np.linalg.norm(np.array(evaluate(nodes, 1)) - np.array(evaluate(nodes, -1))))
    if abs(left - right) <= 1e-6 * size:
        message = "lies as near to one possible place as to the other; expected nearer to one"
        raise model.mechanism.error([(hints[0].path, message)])
    return 1 if left < right else -1


def _check_hints(model: Model) -> None:
    """A side makes sense only where two links meet."""
    apexes = {j: b for b in model.topology.solved_blocks for j in _joints(model, b)}
    found = []
    for joint, hint in model.mechanism.hints.items():
        block = apexes.get(joint)
        if hint.side is None or (
            block is not None and block.kind == "RRR" and _meets(joint, block)
        ):
            continue
        found.append((hint.path, _no_sides(model, joint, block)))
    if found:
        raise model.mechanism.error(found)


def _meets(joint: str, block: Block) -> bool:
    """Whether a joint lies between the two unknown links of a block."""
    inner = {step.end for step in block.loops[0].steps[:-1]}
    return joint in inner


def _meeting_joint(model: Model, block: Block) -> str:
    """The joint between two unknown links, by a name that a definition file can use.

    A clearance there displaces one of the links; its displaced point has no name in the file.
    """
    loop = block.loops[0]
    displaced = {[*b.points][1] for b in model.mechanism.bodies.values() if b.kind == "clearance"}
    inner = [step.end for step in loop.steps[:-1] if step.end is not None]
    return next((joint for joint in (loop.apex, *inner) if joint not in displaced), loop.apex)


def _no_sides(model: Model, joint: str, block: Block | None) -> str:
    if block is None:
        return f"joint {joint} has one possible place only; expected no side"
    if block.kind == "RRR":
        meeting = _meeting_joint(model, block)
        return f"left or right is said of joint {meeting}, where the two links meet"
    return f"joint {joint} moves along an axis; expected about where it is, such as [0.5, 0]"


def _missing_hint(model: Model, block: Block, evaluate: Evaluate) -> InputError:
    joint = _meeting_joint(model, block)
    nodes = _place_nodes(model, [joint])
    places = [", ".join(f"{value:.4g}" for value in evaluate(nodes, side)) for side in (1, -1)]
    message = (
        f"joint {joint} can be in two places; expected '{joint}: left' (at [{places[0]}]) or "
        f"'{joint}: right' (at [{places[1]}])"
    )
    return model.mechanism.error([(("assembly",), message)])
