"""Forces of a mechanism as functions of its positions, its rates and its accelerations.

Drives become free coordinates whose values are known, so that derivatives by them are known as
well. With coordinates q, rates v, accelerations a and internal states s the equations are

    F(q, v, a, s, σ) − Σ λ_k (N_k − μ_k σ_k T_k) = 0,    ds/dt = G(q, v, s)

where F has −M(q) a in it, λ_k ≥ 0 presses a rigid contact of gap g_k with N_k = ∂g_k/∂q, and σ from
−1 to 1 says which part of the largest force of a dry friction acts. Nothing is divided by the
inertia M, which may be singular.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.component import Component
from linkages.components.contributed.normal_forces import CornerAtWall, PinInHole
from linkages.components.contributed.terms import GUIDED, Prescribed
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.differentiation import derivative, derivative_along
from linkages.kernel.forces.reaction_friction import ReactionFrictions
from linkages.kernel.forces.rigid_impacts import Unilateral
from linkages.kernel.inputs import Effects
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, components
from linkages.kernel.system import System
from linkages.solution.motion import Piece
from linkages.solution.rhs import Equations

Floats = NDArray[np.float64]

FAR = 2.0
"""Sizes of the mechanism that something slides at most in a search."""

BESIDE = 0.5
"""Sizes of coordinates about the start within which the sizes of forces are looked for."""

LEAST_MODE = 1e-300
"""What a friction that holds with no force has as its mode: 0 stands for what motion needs."""


@dataclass(frozen=True, eq=False)
class Places:
    """Positions of a mechanism, N of them along the last axis."""

    z: Floats  # coordinates, then internal states, shape (n + m, N)
    # Coordinates from which iterations start, then sides on which blocks are assembled, (c + b, N)
    branch: Floats

    @property
    def count(self) -> int:
        """Number of positions."""
        return self.z.shape[1]

    def at(self, chosen: NDArray[Any] | slice | list[int]) -> Places:
        """Some of them."""
        return Places(self.z[:, chosen], self.branch[:, chosen])

    def where(self, chosen: NDArray[np.bool_], others: Places) -> Places:
        """These, with others in the place of some."""
        return Places(
            np.where(chosen, others.z, self.z), np.where(chosen, others.branch, self.branch)
        )

    def with_z(self, z: Floats) -> Places:
        """Others near them, of which there may be more than one."""
        return Places(z, np.broadcast_to(self.branch, (len(self.branch), z.shape[1])))


@dataclass(frozen=True, eq=False)
class At:
    """The equations at N positions; the last axis is that of the positions."""

    forces: Floats  # F then G, shape (n + m, N)
    by_state: Floats  # their derivatives by q and s, shape (n + m, n + m, N)
    by_friction: Floats  # their derivatives by σ, shape (n + m, frictions, N)
    gaps: Floats  # g, positive where bodies overlap, shape (contacts, N)
    normals: Floats  # N, shape (contacts, n, N)
    bends: Floats  # derivatives of N by q, shape (contacts, n, n, N)
    slips: Floats  # μ T, zero without friction, shape (contacts, n, N)
    slip_bends: Floats  # derivatives of that by q, shape (contacts, n, n, N)


@dataclass(frozen=True, eq=False)
class Linearised:
    """Derivatives of the equations at one position, with n coordinates and m internal states."""

    by_coordinates: Floats  # of F and G by q, shape (n + m, n)
    by_rates: Floats  # by v, shape (n + m, n)
    by_internal: Floats  # by s, shape (n + m, m)
    inertia: Floats  # M, shape (n, n)
    sticking: Floats  # derivatives of slip rates of dry frictions by v, shape (frictions, n)


class _Nodes:
    """Nodes of the equations of a model, made once for it."""

    def __init__(self, model: Model) -> None:
        inputs, topology = model.inputs, model.topology
        n, m = len(topology.free), len(topology.internal)
        _ = model.changes  # which forces have modes
        acting = [each for each in model.acting if not isinstance(each, Unilateral)]
        pressed = [load for load in model.loads if load.load.bearing is not None]
        accelerations, partials = model.accelerations, model.partials
        plain = [each for each in acting if each not in pressed]
        forces = [-model.required_of(accelerations, partial, plain) for partial in partials]
        if pressed:
            pressing = ReactionFrictions(model, pressed, accelerated=False)
            for load, push in pressing.forces(accelerations).items():
                rates = [load.rate(partial) for partial in partials]
                forces = [f + push * rate for f, rate in zip(forces, rates, strict=True)]
        self.forces = [*forces, *model.internal_rates]
        self.coordinates = [inputs.coordinate(i) for i in range(n)]
        self.rates = [inputs.rate(i) for i in range(n)]
        self.internal = model.internal
        self.joints = components(model.positions.joints.values())
        self.sticky = [*model.switches.equivalent]
        self.contacts = model.rigid
        self.slips = [contact.rubbing for contact in self.contacts]
        modes = [inputs.mode(number) for number in self.sticky]
        gaps = [contact.gap.indentation for contact in self.contacts]
        normals = derivative(gaps, self.coordinates)
        zero = [model.graph.zero] * n
        slips = [zero if r is None else [r.friction * t for t in r.along_slip] for r in self.slips]
        self.parts = (
            self.forces,
            _flat(derivative(self.forces, [*self.coordinates, *self.internal])),
            _flat(derivative(self.forces, modes)),
            gaps,
            _flat(normals),
            _flat(derivative(_flat(normals), self.coordinates)),
            _flat(slips),
            _flat(derivative(_flat(slips), self.coordinates)),
        )
        k, c = len(modes), len(gaps)
        self.shapes = (
            (n + m,), (n + m, n + m), (n + m, k), (c,), (c, n), (c, n, n), (c, n), (c, n, n),
        )  # fmt: skip
        functions = [model.switches.switches[number].function for number in self.sticky]
        slopes = _flat(derivative(functions, self.rates))
        lower = [node for row in model.mass_matrix for node in row]
        self.linear = (
            self.parts[1], _flat(derivative(self.forces, self.rates)), lower, slopes,
        )  # fmt: skip


def _flat(rows: Sequence[Sequence[Scalar]]) -> list[Scalar]:
    return [node for row in rows for node in row]


class Statics:
    """The equations of a mechanism whose drives stand still at a time, or move.

    `mechanism`: some of its coordinates are free.
    `time`: at which drives and loads are taken, in seconds.
    `paths`: of numbers that may change, dotted.
    Raises InputError if the mechanism cannot be assembled, or nothing is free.
    """

    def __init__(self, mechanism: Mechanism, time: float = 0.0, paths: Sequence[str] = ()) -> None:
        self.mechanism, self.time = mechanism, time
        driven = System(mechanism)
        topology, model = driven.topology, driven.model
        self.driven = topology.driven
        self.own_names = topology.free
        if not self.own_names:
            message = "nothing is free: drives determine all positions, so that nothing can rest"
            raise mechanism.error([((), f"{message} or vibrate")])
        standing = [own.path for own in driven.mechanism.actuations.values()]
        bodies = driven.mechanism.bodies.values()
        standing += [body.path for body in bodies if body.kind == GUIDED]
        if standing:
            message = "positions of rest are not searched for with drives of points or actuators"
            raise mechanism.error([(standing[0], f"{message}; expected drives of bars or sliders")])
        laws = [model.positions.laws[name] for name in self.driven]
        nodes = [node for law in laws for node in (law.value, law.rate, law.acceleration)]
        values = driven.evaluate(nodes, time)[:, 0].reshape(-1, 3)
        begun = driven.evaluate(nodes, driven.time)[:, 0].reshape(-1, 3)
        self.drive_values, self.drive_rates, self.drive_accelerations = values.T
        initial = driven.mechanism.initial
        state = {name: (initial[name].position, initial[name].speed) for name in self.own_names}
        state |= {n: (float(v[0]), 0.0) for n, v in zip(self.driven, begun, strict=True)}
        released = replace(driven.mechanism, components=tuple(_undriven(driven.mechanism)))
        self.released = released.keeping(paths).with_state(state)
        self.take(System(self.released, near=driven.places()))

    def take(self, system: System) -> None:
        """The equations of the same mechanism with other numbers."""
        self.system = system
        topology = system.topology
        self.n, self.m = len(topology.free), len(topology.internal)
        free = {name: row for row, name in enumerate(topology.free)}
        self.own = np.array([free[name] for name in self.own_names])
        self.held = np.array([free[name] for name in self.driven], dtype=int)

    @property
    def model(self) -> Model:
        """Its equations as a graph."""
        return self.system.model

    @cached_property
    def nodes(self) -> _Nodes:
        """Nodes of the equations."""
        return _Nodes(self.model)

    @property
    def adhesions(self) -> Floats:
        """Largest tensile forces of rigid contacts, shape (contacts,)."""
        nodes = [contact.adhesion for contact in self.nodes.contacts]
        return np.asarray(self.system.evaluate(nodes)[:, 0]) if nodes else np.empty(0)

    def listed(self, rows: Iterable[int]) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names and units of coordinates, of their rates, and of internal states."""
        equations = Equations(self.system)
        bodies = self.n + len(self.system.topology.carried)
        order = [*rows]
        order += [bodies + row for row in order] + [2 * bodies + k for k in range(self.m)]
        each = equations.names, equations.units
        return tuple(each[0][k] for k in order), tuple(each[1][k] for k in order)

    def units_of_effort(self, name: str) -> str:
        """Unit of the effort of a drive."""
        return "N m" if self.system.mechanism.bodies[name].rotates else "N"

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of a state: coordinates that no drive holds, their rates, internal states."""
        return self.listed(self.own.tolist())[0]

    @cached_property
    def sizes(self) -> Floats:
        """What is much for each coordinate and internal state, shape (n + m,).

        That is a radian, the size of the mechanism, a clearance, or what an internal state says.
        """
        topology, bodies = self.system.topology, self.system.mechanism.bodies
        places = np.array([*self.system.places().values()])
        extent = float(np.ptp(places, axis=0).max()) or 1.0
        clear: dict[str, float] = {}
        for contact in self.system.mechanism.contacts:
            geometry = contact.geometry
            if isinstance(geometry, PinInHole):
                clear |= dict.fromkeys(geometry.axes, geometry.size.value)
            if isinstance(geometry, CornerAtWall):
                size, length = geometry.size.value, geometry.length.value
                clear |= {geometry.play.offset: size, geometry.play.tilt: 2 * size / length}
        own = [clear.get(n, 1.0 if bodies[n].rotates else extent) for n in topology.free]
        inner = [state.scale for state in self.system.mechanism.internal.values()]
        return np.array([*own, *inner])

    @cached_property
    def reaches(self) -> Floats:
        """How far each coordinate goes from its start in a search, shape (n,)."""
        topology, bodies = self.system.topology, self.system.mechanism.bodies
        rotates = [bodies[n].rotates and bodies[n].kind != "tilt" for n in topology.free]
        return np.where(rotates, np.pi, FAR * self.sizes[: self.n])

    @cached_property
    def winding(self) -> NDArray[np.bool_]:
        """Which coordinates are angles whose whole turns count, shape (n,)."""
        topology, bodies = self.system.topology, self.system.mechanism.bodies
        return np.array([bodies[n].rotates and topology.unwrapped(n) for n in topology.free])

    @cached_property
    def turning(self) -> NDArray[np.bool_]:
        """Which coordinates and internal states have the same meaning a turn later, (n + m,)."""
        topology, bodies = self.system.topology, self.system.mechanism.bodies
        rotates = [bodies[n].rotates and not topology.unwrapped(n) for n in topology.free]
        return np.array([*rotates, *[False] * self.m])

    @cached_property
    def start(self) -> Places:
        """The position of the definition, with drives at their time."""
        layout, state = self.system.layout, self.system.state
        half = len(layout.coordinates)
        z = np.concatenate([state[: self.n], state[half + self.n : half + self.n + self.m]])
        z[self.held] = self.drive_values
        carried = state[layout.carried_rows[: self._iterated]]
        branch = np.concatenate([carried, self.system.parameters[self.sides]])
        return Places(z[:, None], branch[:, None])

    @cached_property
    def sides(self) -> list[int]:
        """Parameters that choose one of two ways in which a block is assembled."""
        return [k for path, k in self.model.inputs.parameters.items() if path[0] == "side"]

    @cached_property
    def swiftness(self) -> float:
        """The rate at which forces of the usual size move the lightest coordinate, in 1/s."""
        lower = [node for row in self.model.mass_matrix for node in row]
        inertia = np.zeros((self.n, self.n))
        inertia[np.tril_indices(self.n)] = self.values(lower, self.start)[:, 0]
        heavy = np.diag(inertia)[self.own] * self.sizes[self.own]
        pushes = self.force_sizes[self.own][heavy > 0.0] / heavy[heavy > 0.0]
        return float(np.sqrt(pushes.max(initial=0.0)))

    @property
    def _iterated(self) -> int:
        return len(self.system.topology.carried)

    def motions(self, places: Places, rates: Floats | None = None) -> Floats:
        """Integrated coordinates and rates, shape (2·coordinates, N); `rates`: shape (n, N)."""
        half, n = len(self.system.layout.coordinates), self.n
        result = np.zeros((2 * half, places.count))
        result[:n] = places.z[:n]
        result[half + n : half + n + self.m] = places.z[n:]
        if rates is not None:
            result[half : half + n] = rates
        count = self._iterated
        result[self.system.layout.carried_rows[:count]] = places.branch[:count]
        return result

    def flipped(self, places: Places, blocks: Sequence[int]) -> Places:
        """The same with some blocks, by their place among `sides`, in their other assembly."""
        branch = places.branch.copy()
        branch[[self._iterated + k for k in blocks]] *= -1.0
        return Places(places.z, branch)

    def settled(self, places: Places) -> Places:
        """The same with what iterations start from as the positions determine it."""
        count = self._iterated
        if not count:
            return places
        before, bodies = places.branch[:count], self.system.mechanism.bodies
        values = self.values(self.model.settled[:count], places)
        turns = np.round((before - values) / (2 * np.pi))
        turning = np.array([bodies[name].rotates for name in self.system.topology.carried])
        values = values + np.where(turning[:, None], 2 * np.pi * turns, 0.0)
        return Places(places.z, np.concatenate([values, places.branch[count:]]))

    def values(
        self,
        nodes: Sequence[Scalar],
        places: Places,
        sigma: Floats | None = None,
        *,
        rates: Floats | None = None,
        accelerations: Floats | None = None,
        effects: Effects | None = None,
    ) -> Floats:
        """Values of nodes, shape (nodes, N).

        `sigma`: of the frictions, shape (frictions, N); zero if not given.
        `rates`, `accelerations`: of all coordinates, shape (n, N); zero if not given.
        """
        inputs = self._inputs(places, rates)
        inputs |= self.modes(places, sigma, rates)
        if accelerations is not None:
            inputs["a"][: self.n] = accelerations
        if effects is not None:
            inputs["slope"] = effects.slopes[:, None]
        result = np.empty((len(nodes), places.count))
        found = self.model.evaluator(nodes)(**inputs)
        for row, value in zip(result, found, strict=True):
            row[:] = value
        return result

    def _inputs(self, places: Places, rates: Floats | None) -> dict[str, Floats]:
        moved = np.zeros((len(self.system.topology.coordinates), places.count))
        numbers = np.repeat(self.system.parameters[:, None], places.count, axis=1)
        numbers[self.sides] = places.branch[self._iterated :]
        motions = self.motions(places, rates)
        return {"t": np.full((1, 1), self.time), "y": motions, "a": moved, "p": numbers}

    def modes(
        self, places: Places, sigma: Floats | None = None, rates: Floats | None = None
    ) -> dict[str, Floats]:
        """Modes by the signs of their functions, of frictions σ; and what motions remember."""
        nodes = self.nodes
        with np.errstate(invalid="ignore"):
            result = self.model.switches.signed(self._inputs(places, rates))
        for row, number in enumerate(nodes.sticky):
            result["mode"][number] = 0.0 if sigma is None else sigma[row]
        return result

    def at(self, places: Places, sigma: Floats | None = None) -> At:
        """The equations at positions at rest."""
        values = self.values(_flat(self.nodes.parts), places, sigma)
        sizes = [int(np.prod(shape)) for shape in self.nodes.shapes]
        parts = np.split(values, np.cumsum(sizes)[:-1])
        pairs = zip(parts, self.nodes.shapes, strict=True)
        return At(*(part.reshape(*shape, places.count) for part, shape in pairs))

    def linearised(
        self,
        place: Places,
        sigma: Floats,
        rates: Floats | None = None,
        accelerations: Floats | None = None,
    ) -> Linearised:
        """Derivatives of the equations at one position; rates and accelerations of shape (n, 1)."""
        n, m, k = self.n, self.m, len(self.nodes.sticky)
        count = n + m
        values = self.values(
            _flat(self.nodes.linear), place, sigma, rates=rates, accelerations=accelerations
        )[:, 0]
        sizes = [count * count, count * n, n * (n + 1) // 2, k * n]
        by_state, by_rates, lower, slopes = np.split(values, np.cumsum(sizes)[:-1])
        inertia = np.zeros((n, n))
        inertia[np.tril_indices(n)] = lower
        inertia += np.tril(inertia, -1).T
        by_state = by_state.reshape(count, count)
        return Linearised(
            by_state[:, :n], by_rates.reshape(count, n), by_state[:, n:], inertia,
            slopes.reshape(k, n),
        )  # fmt: skip

    def along(self, effects: Effects, place: Places) -> Floats:
        """Derivatives of F and G by numbers of the definition at one position, (n + m, P)."""
        rows = derivative_along(self.nodes.forces, self.model.inputs.fed(effects.fed))
        values = self.values(_flat(rows), place, effects=effects)
        return values.reshape(len(rows), -1)

    @cached_property
    def force_sizes(self) -> Floats:
        """Sizes of the single forces in F about the start, and of the rates G, shape (n + m,)."""
        model, bodies = self.model, [*self.model.loads, *self.model.contacts]
        plain = [each for each in bodies if not isinstance(each, Unilateral)]
        nodes = []
        for partial in model.partials:
            weight = model.inertia.product(model.bias, partial, model.gravity)
            nodes += [weight, *(each.power(partial) for each in plain)]
        around = np.diag(self.sizes[: self.n] * BESIDE)
        moves = np.hstack([np.zeros((self.n, 1)), around, -around])
        z = np.repeat(self.start.z, moves.shape[1], axis=1)
        z[: self.n] += moves
        places = Places(z, np.repeat(self.start.branch, moves.shape[1], axis=1))
        values = np.nan_to_num(np.abs(self.values(nodes, self.settled(places))))
        sums = values.reshape(self.n, -1, values.shape[1]).sum(axis=1)
        each = (sums * self.sizes[: self.n, None]).max(axis=0)
        # neither that of a stiff stop at one of them, nor nothing where all are in line
        energy = float(np.median(each) or each.max()) or 1.0
        return np.append(energy / self.sizes[: self.n], self.sizes[self.n :])

    def piece(
        self,
        places: Places,
        sigma: Floats | None = None,
        pressed: Container[int] = (),
        rates: Floats | None = None,
        accelerations: Floats | None = None,
    ) -> Piece:
        """Positions as a piece of a motion, of which outputs are evaluated.

        `pressed`: numbers of the rigid contacts that press.
        """
        if sigma is None:
            sigma = np.zeros((len(self.nodes.sticky), places.count))
        modes = self.modes(places, np.where(sigma == 0.0, LEAST_MODE, sigma), rates)
        switches = self.model.switches
        for number, contact in enumerate(self.nodes.contacts):
            for mode in (contact.touching, contact.pressing):
                modes["mode"][switches.number(mode)] = 1.0 if number in pressed else -1.0
        inputs = self._inputs(places, rates)
        if accelerations is not None:
            inputs["a"][: self.n] = accelerations
        turned = places.branch[self._iterated :] != self.start.branch[self._iterated :]
        numbers = [path[1] for path in self.model.inputs.parameters if path[0] == "side"]
        return Piece(
            system=self.system,
            time=np.full(places.count, self.time),
            state=inputs["y"],
            turns=np.zeros_like(inputs["a"]),
            acceleration=inputs["a"],
            flipped={int(n): row for n, row in zip(numbers, turned, strict=True) if row.any()},
            held=np.concatenate([modes["mode"], modes["memory"]]),
        )


def _undriven(mechanism: Mechanism) -> Iterator[Component]:
    """Components that prescribe no motion."""
    for component, terms in zip(mechanism.components, mechanism.term_groups, strict=True):
        if not any(isinstance(term, Prescribed) for term in terms):
            yield component
