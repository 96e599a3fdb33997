"""The closure equations' Jacobian at a given position, and what its rank says about mobility."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from linkages.topology.blocks import Block, Loop, Step
from linkages.topology.topology import Topology

Places = Mapping[str, NDArray[np.float64]]


def ground_loop(topology: Topology, loop: Loop) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """Both ways from the ground to the apex of a loop, without the steps that they share."""
    apex_at = next((i for i, step in enumerate(loop.steps) if step.end == loop.apex), -1)
    out = [*topology.path(loop.start)[0], *loop.steps[: apex_at + 1]]
    back = [
        *topology.path(loop.end)[0],
        *(s.reversed for s in reversed(loop.steps[apex_at + 1 :])),
    ]
    shared = 0
    while shared < min(len(out), len(back)) and out[shared] == back[shared]:
        shared += 1
    return tuple(out[shared:]), tuple(back[shared:])


def owners(topology: Topology) -> tuple[str, ...]:
    """Bodies with a coordinate of their own: all but those that a weld or gear turns."""
    return tuple(b for b in topology.mechanism.bodies if b not in topology.slaves)


def closure_jacobian(topology: Topology, places: Places, axes: Places) -> NDArray[np.float64]:
    """∂Φ/∂q with all columns scaled to unit length.

    Parameters
    ----------
    topology
        The mechanism.
    places
        Point → position, shape (2,).
    axes
        Slider → unit vector of its axis, shape (2,), of a cam's follower times the slope of the
        lift.

    Returns
    -------
    Shape (2·loops, coordinates): two rows per loop in the order of the blocks, those of redundant
    loops that determine nothing last; a column for each of `owners`. A column of a body that no
    loop contains is zero.
    """
    column = {body: index for index, body in enumerate(owners(topology))}
    gradients, moves = turning_gradients(topology), moving_gradients(topology)
    loops = topology.closing
    jacobian = np.zeros((2 * len(loops), len(column)))
    for row, loop in enumerate(loops):
        rows = slice(2 * row, 2 * row + 2)
        for sign, way in zip((1.0, -1.0), ground_loop(topology, loop), strict=True):
            for step in way:
                x, y = places[step.end] - places[step.start]
                for master, ratio in gradients[step.body].items():
                    jacobian[rows, column[master]] += sign * ratio * np.array([-y, x])
                body = topology.mechanism.bodies[step.body]
                own = 0 if body.rotates else (step.start == body.axis) - (step.end == body.axis)
                for master, ratio in moves[step.body].items() if own else ():
                    jacobian[rows, column[master]] += sign * own * ratio * axes[step.body]
    norms = np.linalg.norm(jacobian, axis=0)
    return jacobian / np.where(norms > 0, norms, 1.0)


def turning_gradients(topology: Topology) -> dict[str, dict[str, float]]:
    """Body → how its orientation changes with the angles of the bodies that it depends on."""
    mechanism, moves = topology.mechanism, moving_gradients(topology)

    def gradient(name: str) -> dict[str, float]:
        guide = mechanism.bodies[name].guide
        if guide is None:
            return moves[name]
        return {} if guide.body is None else gradient(guide.body)

    return {name: gradient(name) for name in mechanism.bodies}


def moving_gradients(topology: Topology) -> dict[str, dict[str, float]]:
    """Body → how its own coordinate changes with the coordinates that it depends on."""
    found: dict[str, dict[str, float]] = {}

    def gradient(name: str) -> dict[str, float]:
        if name not in found:
            found[name] = follower(name) if name in topology.slaves else {name: 1.0}
        return found[name]

    def follower(name: str) -> dict[str, float]:
        total: dict[str, float] = {}
        for other, ratio in topology.slaves[name].parts:
            for master, value in gradient(other).items():
                total[master] = total.get(master, 0.0) + ratio.value * value
        return total

    return {name: gradient(name) for name in topology.mechanism.bodies}


def distance_from_singular(
    topology: Topology, jacobian: NDArray[np.float64], free: Collection[str]
) -> float:
    """How well the closure as a whole determines all other coordinates, 0 to 1.

    It is the smallest singular value of its Jacobian over the largest. Redundant equations count:
    they may tell which way a mechanism goes on where the others alone leave it open.

    Parameters
    ----------
    topology, jacobian
        The mechanism and its closure Jacobian.
    free
        The free coordinates.
    """
    known = {*topology.driven, *free}
    columns = [i for i, name in enumerate(owners(topology)) if name not in known]
    if not columns:
        return 1.0
    values = np.linalg.svd(jacobian[:, columns], compute_uv=False)
    return float(values[len(columns) - 1] / values[0])


def numerical_mobility(jacobian: NDArray[np.float64]) -> int:
    """Number of coordinates minus the rank of the closure Jacobian."""
    if jacobian.size == 0:
        return jacobian.shape[1]
    return jacobian.shape[1] - int(np.linalg.matrix_rank(jacobian, tol=1e-9))


def block_condition(topology: Topology, jacobian: NDArray[np.float64], block: Block) -> float:
    """Condition number of the system that a block solves for its unknown rates.

    Parameters
    ----------
    topology, jacobian
        The mechanism and its closure Jacobian.
    block
        A block with unknowns.
    """
    order = owners(topology)
    columns = [order.index(body) for body in block.unknowns]
    first = 2 * sum(len(b.loops) for b in topology.solved_blocks if b.index < block.index)
    rows = slice(first, first + 2 * len(block.loops))
    return float(np.linalg.cond(jacobian[rows, columns]))
