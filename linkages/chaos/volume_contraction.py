"""How fast a mechanism's motion changes volumes of its states, from inertia and loads alone.

In coordinates and momenta only forces that depend on velocities change volumes (Liouville); the
momenta are linear in the rates, with the mass matrix as factor. The variational equations, from
which exponents come, are not used here: the sum of all exponents is compared with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.differentiation import Evaluator, derivative
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, reachable
from linkages.kernel.switches import Switches
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Piece

Floats = NDArray[np.float64]

UNIFORM = 1e-9
"""Relative difference of damping rates below which they count as one."""


@dataclass(frozen=True, eq=False)
class Volumes:
    """What a system's equations say about volumes of states."""

    system: System  # with free coordinates

    @property
    def _model(self) -> Model:
        return self.system.model

    @property
    def _switches(self) -> Switches:
        """Those of the accelerations, which are built first."""
        _ = self._model.free_accelerations
        return self._model.switches

    @property
    def _size(self) -> int:
        return len(self.system.topology.free)

    @cached_property
    def autonomous(self) -> bool:
        """Whether the accelerations do not depend on time, nor what changes modes."""
        model = self._model
        clock = model.inputs.time.index
        needed = [*model.changes, *self._switches.nodes]
        return all(node.index != clock for node in reachable(needed))

    @cached_property
    def told(self) -> bool:
        """Whether mass matrix and loads say all of it.

        Where a mode changes at a place, volumes stay; where it changes at a speed, where rates jump
        and where the motion remembers a number, they may change at once. Damping that a mode turns
        on and off, as in a contact, has no mean that a few samples could tell.
        """
        switches = self._switches
        if any(switch.jump for switch in switches.switches) or switches.memories:
            return False
        if Evaluator(self._damping).switched:
            return False
        rates = [self._model.inputs.rate(i) for i in range(self._size)]
        bends = derivative(switches.functions, rates)
        return all(entry.constant == 0.0 for row in bends for entry in row)

    @cached_property
    def _damping(self) -> list[Scalar]:
        """Minus the derivatives of generalised forces with respect to rates, row by row."""
        model = self._model
        graph = model.graph
        forces = [graph.total(load.power(p) for load in model.acting) for p in model.partials]
        rates = [model.inputs.rate(i) for i in range(self._size)]
        return [-entry for row in derivative(forces, rates) for entry in row]

    @cached_property
    def conservative(self) -> bool:
        """Whether no force depends on velocities or internal states, nor what changes modes."""
        if self.system.topology.internal:
            return False
        return self.told and all(entry.constant == 0.0 for entry in self._damping)

    @cached_property
    def potential(self) -> bool:
        """Whether all forces without rates in them follow from an energy, that of time perhaps.

        Along a single coordinate any force does. Of several, one that turns with a body follows
        from none; nor does one that depends on more than it acts along, unless that is a function
        of time.
        """
        if self.system.topology.internal:
            return False
        if self._size == 1:
            return True
        moving = {m for m, nodes in self._model.sensed.items() if nodes.changing}
        loads = self._model.mechanism.loads
        return not any(load.follows or moving & set(load.sensed) for load in loads)

    def damping_rates(self, piece: Piece) -> Floats:
        """Rates J⁻¹C in 1/s at which momenta decay in a piece of a motion, shape (times, n, n)."""
        size = self._size
        if self.conservative:
            return np.zeros((len(piece.wanted), size, size))
        damping = self._values(self._damping, piece).T.reshape(-1, size, size)
        return np.asarray(np.linalg.solve(self.masses(piece), damping))

    def relaxation(self, piece: Piece) -> Floats:
        """Rates in 1/s at which volumes of internal states shrink, shape (times,)."""
        model = self._model
        rates = model.changes[self._size :]
        pairs = zip(rates, model.internal, strict=True)
        slopes = [derivative([rate], [value])[0][0] for rate, value in pairs]
        return -self._values(slopes, piece).sum(axis=0)

    def uniform(self, damping: Floats) -> float | None:
        """The rate at which all momenta decay, in 1/s; None if they do so at several."""
        mean = float(np.trace(damping, axis1=1, axis2=2).mean()) / self._size
        apart = np.abs(damping - mean * np.eye(self._size)).max()
        return mean if apart <= UNIFORM * np.abs(damping).max() else None

    def logarithm(self, piece: Piece) -> Floats:
        """Logarithm of the volume of momenta per volume of rates, shape (times,)."""
        return np.asarray(np.linalg.slogdet(self.masses(piece))[1])

    def _values(self, nodes: list[Scalar], piece: Piece) -> Floats:
        """Values of nodes, shape (nodes, times)."""
        return piece.interpolated(evaluate_nodes(piece, nodes))

    def masses(self, piece: Piece) -> Floats:
        """The mass matrix in a piece of a motion, shape (times, n, n)."""
        lower = [entry for row in self._model.mass_matrix for entry in row]
        values = self._values(lower, piece)
        masses = np.empty((values.shape[1], self._size, self._size))
        rows, columns = np.tril_indices(self._size)
        masses[:, rows, columns] = masses[:, columns, rows] = values.T
        return masses
