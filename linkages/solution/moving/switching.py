"""Other free coordinates where those of a motion become ill-conditioned (partitioning).

Any bodies may be independent whose removal from the closure leaves a regular Jacobian; which ones
are good changes in the course of a motion. At a change point none are.

References
----------
.. [1] R. A. Wehage, E. J. Haug, J. Mech. Design 104, 247 (1982): generalized coordinate
       partitioning.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import PLAYING
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.graph.differentiation import derivative
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Piece
from linkages.topology.jacobian import closure_jacobian, distance_from_singular

BETTER = 2.0
"""How much farther from singular other coordinates must be to be worth a change."""

SAME_PLACE = 1e-6
"""Part of the size of a mechanism by which round-off close to a singular position moves points."""


def movable(system: System) -> tuple[str, ...]:
    """Free coordinates that others could take the place of: all but clearances."""
    bodies = system.model.mechanism.bodies  # what they are is the same in all of a structure
    return tuple(name for name in system.topology.free if bodies[name].kind not in PLAYING)


def passes(system: System, run: RunOptions) -> bool:
    """Whether a motion goes on through change points, as `RunOptions` describes it."""
    return bool(movable(system)) if run.change_points is None else run.change_points == "pass"


def better_system(
    system: System, time: float, state: NDArray[np.float64], flipped: tuple[int, ...]
) -> System | None:
    """The same mechanism at the same place with better free coordinates; None if there are none.

    Parameters
    ----------
    system
        What moves.
    time, state
        When, and its integrated coordinates and rates, shape (2n,).
    flipped
        Blocks that are in the other assembly mode than at the start.
    """
    here = _Configuration(system, time, state, flipped)
    if not here.finite:  # in a change point
        return None
    present = here.distance(system.topology.free)
    best = max(here.choices(), key=here.distance, default=None)
    if best is None or here.distance(best) < BETTER * present:
        return None
    try:
        found = here.wound(System(here.mechanism(best), time, near=here.places))
    except InputError:
        return None
    return found if here.is_place_of(found) else None


def tangent_map(
    system: System,
    free: tuple[str, ...],
    time: float,
    state: NDArray[np.float64],
    flipped: tuple[int, ...],
) -> NDArray[np.float64]:
    """Derivatives of other coordinates and their rates with respect to the free ones.

    Parameters
    ----------
    system, time, state, flipped
        What moves, and where, as `better_system` takes them.
    free
        Bodies whose coordinates are asked for.

    Returns
    -------
    What tangents of shape (x, k) are multiplied by, shape (x, x): internal states stay.
    """
    model, count = system.model, len(free)
    places = [model.positions.coordinate(name) for name in free]
    rates = [model.velocities.bodies[name] for name in free]
    inputs = [model.inputs.coordinate(i) for i in range(count)]
    inputs += [model.inputs.rate(i) for i in range(count)]
    entries = [entry for row in derivative([*places, *rates], inputs) for entry in row]
    where = {block: np.array([True]) for block in flipped}
    values = system.evaluate(entries, time, state[:, None], flipped=where)
    found = np.eye(system.layout.directions)
    found[: 2 * count, : 2 * count] = values.reshape(2 * count, 2 * count)
    return found


def keeps_modes(piece: Piece) -> bool:
    """Whether the functions of all switches keep the signs that they have within a piece."""
    switches = piece.system.model.switches.switches
    if piece.held is None or not len(piece.held):
        return True
    values = evaluate_nodes(piece, [switch.function for switch in switches])
    modes = piece.held[: len(switches)]
    watched = [s.active is None or modes[s.active, 0] > 0.0 for s in switches]
    return bool((values * modes >= 0.0)[watched].all())


class _Configuration:
    """Where everything is, and how fast it moves."""

    def __init__(
        self,
        system: System,
        time: float,
        state: NDArray[np.float64],
        flipped: tuple[int, ...],
    ) -> None:
        self._system = system
        self._topology = system.topology
        where = {block: np.array([True]) for block in flipped}
        model, bodies = system.model, system.mechanism.bodies
        sliders = [name for name, body in bodies.items() if not body.rotates]
        own = [name for name in bodies if name not in self._topology.slaves]
        places = [n for p in model.positions.joints.values() for n in (p.x, p.y)]
        units = [model.positions.travel(name) for name in sliders]
        axes = [n for u in units for n in (u.x, u.y)]
        coordinates = [model.positions.coordinate(name) for name in own]
        rates = [model.velocities.bodies[name] for name in own]
        nodes = [*places, *axes, *coordinates, *rates]
        values = system.evaluate(nodes, time, state[:, None], flipped=where)[:, 0]
        self.finite = bool(np.isfinite(values).all())
        split = np.cumsum([len(places), len(axes), len(coordinates)])
        found = np.split(values, split)
        self.places = dict(zip(model.positions.joints, found[0].reshape(-1, 2), strict=True))
        self._axes = dict(zip(sliders, found[1].reshape(-1, 2), strict=True))
        internal = state[system.layout.internal_rows].tolist()
        self._internal = dict(zip(system.topology.internal, internal, strict=True))
        self._coordinates = dict(zip(own, found[2].tolist(), strict=True))
        self._rates = dict(zip(own, found[3].tolist(), strict=True))
        self._jacobian = closure_jacobian(self._topology, self.places, self._axes)

    def wound(self, other: System) -> System:
        """Another system with the whole turns of this one, where springs and gears count them."""
        other = other.with_internal(self._internal)
        topology, state = other.topology, other.state.copy()
        for index, name in enumerate(topology.coordinates):
            if name in topology.carried:
                state[index] = self._coordinates[name]
        return other.turned(state, self._system.assembly.turns)

    def is_place_of(self, other: System) -> bool:
        """Whether all points of another system are where they are here."""
        joints = other.model.positions.joints
        nodes = [node for name in self.places for node in (joints[name].x, joints[name].y)]
        places = np.array(list(self.places.values()))
        gap = np.abs(other.evaluate(nodes).reshape(-1, 2) - places).max()
        return bool(gap <= SAME_PLACE * np.ptp(places, axis=0).max())

    def choices(self) -> Iterator[tuple[str, ...]]:
        """Sets of free coordinates with one of them exchanged."""
        topology, bodies = self._topology, self._system.mechanism.bodies
        candidates = [
            name
            for name in topology.dependent
            if name not in topology.slaves and bodies[name].kind not in PLAYING
        ]
        for given in movable(self._system):
            for candidate in candidates:
                yield tuple(candidate if name == given else name for name in topology.free)

    def distance(self, free: tuple[str, ...]) -> float:
        """How far the closure is from singular with these coordinates free, 0 to 1."""
        return distance_from_singular(self._topology, self._jacobian, free)

    def mechanism(self, free: tuple[str, ...]) -> Mechanism:
        """The mechanism with other free coordinates, in their present state."""
        state = {name: (self._coordinates[name], self._rates[name]) for name in free}
        return self._system.mechanism.with_state(state)
