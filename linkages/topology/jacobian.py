"""The closure equations' Jacobian at a given position, and what its rank says about mobility."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from linkages.topology.blocks import Block, Loop, Step
from linkages.topology.topology import Topology

Places = Mapping[str, NDArray[np.float64]]


def ground_loop(topology: Topology, loop: Loop) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """Both ways from the ground to the apex of a loop, without the steps that they share."""
    apex_at = next(i for i, step in enumerate(loop.steps) if step.end == loop.apex)
    out = [*_way(topology, loop.start), *loop.steps[: apex_at + 1]]
    back = [*_way(topology, loop.end), *(s.reversed for s in reversed(loop.steps[apex_at + 1 :]))]
    shared = 0
    while shared < min(len(out), len(back)) and out[shared] == back[shared]:
        shared += 1
    return tuple(out[shared:]), tuple(back[shared:])


def _way(topology: Topology, joint: str | None) -> list[Step]:
    return [] if joint is None else topology.path(joint)[0]


def closure_jacobian(topology: Topology, places: Places, axes: Places) -> NDArray[np.float64]:
    """∂Φ/∂q with all columns scaled to unit length.

    Parameters
    ----------
    topology
        The mechanism.
    places
        Joint → position, shape (2,).
    axes
        Slider → unit vector of its axis, shape (2,).

    Returns
    -------
    Shape (2·loops, bodies): two rows per loop in the order of the blocks, a column per body in
    the order of the mechanism. A column of a body that no loop contains is zero.
    """
    column = {body: index for index, body in enumerate(topology.mechanism.bodies)}
    loops = [loop for block in topology.solved_blocks for loop in block.loops]
    jacobian = np.zeros((2 * len(loops), len(column)))
    for row, loop in enumerate(loops):
        for sign, way in zip((1.0, -1.0), ground_loop(topology, loop), strict=True):
            for step in way:
                rows = slice(2 * row, 2 * row + 2)
                jacobian[rows, column[step.body]] += sign * _derivative(step, places, axes)
    norms = np.linalg.norm(jacobian, axis=0)
    return jacobian / np.where(norms > 0, norms, 1.0)


def _derivative(step: Step, places: Places, axes: Places) -> NDArray[np.float64]:
    """Derivative of a link's vector with respect to its coordinate."""
    if step.start is None:
        return axes[step.body]
    if step.end is None:
        return -axes[step.body]
    x, y = places[step.end] - places[step.start]
    return np.array([-y, x])


def numerical_mobility(jacobian: NDArray[np.float64]) -> int:
    """Number of coordinates minus the rank of the closure Jacobian."""
    if jacobian.size == 0:
        return jacobian.shape[1]
    return jacobian.shape[1] - int(np.linalg.matrix_rank(jacobian, tol=1e-9))


def block_condition(
    topology: Topology, jacobian: NDArray[np.float64], block: Block, index: int
) -> float:
    """Condition number of the 2×2 system that a block solves for its unknown rates.

    Parameters
    ----------
    topology, jacobian
        The mechanism and its closure Jacobian.
    block
        A block with unknowns.
    index
        Its place among them.
    """
    order = list(topology.mechanism.bodies)
    columns = [order.index(body) for body in block.unknowns]
    return float(np.linalg.cond(jacobian[2 * index : 2 * index + 2, columns]))
