"""Joint reactions from the Newton–Euler equations of every body.

The accelerations are known, so the forces at all pins, the forces and moments of the guides, the
torques of welds and gears, and the efforts of the drives follow from one linear system per sample.
It shares no formula with the reduced equations of the kernel, so the drive efforts are a check.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.load_measures import GROUND
from linkages.components.contributed.terms import GUIDED, Body, Parameter
from linkages.components.point_drives import axis_names
from linkages.kernel.forces.generalised_forces import Acting
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, Vector
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Motion, Piece
from linkages.solution.series import GUIDE, MOMENT, PIN, REACTION, Series
from linkages.topology.decomposition import pairs, shared_pins, solid
from linkages.topology.topology import Topology

_CHUNK = 1024
_NO_RESIDUE = 1e-6
Floats = NDArray[np.float64]


def reactions(motion: Motion) -> dict[str, Floats]:
    """Forces at joints and in guides, in newtons and newton metres, by the name of the output.

    ``joint_reaction``, shape (samples, joints, 2), is the force that the first body at each joint
    exerts on the others: the ground, or the first in the order of the mechanism, which also has the
    loads and masses at the joint. ``pin_reaction``, shape (samples, pins, 2), is the force of the
    others on each body where three or more meet; their sum is zero. ``guide_reaction`` and
    ``guide_moment``, shape (samples, sliders), are the force of a guide on its slider across the
    axis, through its joint, and the moment about that. Redundant constraints have the reactions
    with the least sum of squares.
    """
    parts = [part for piece in motion.pieces for part in _of_piece(piece)]
    topology = motion.pieces[0].system.topology
    joints, pins = len(topology.joints), len(shared_pins(topology.mechanism))
    result = np.concatenate([np.zeros((0, joints + pins + len(_guided(topology)), 2)), *parts])
    guides = result[:, joints + pins :]
    return {
        REACTION: result[:, :joints],
        PIN: result[:, joints : joints + pins],
        GUIDE: np.ascontiguousarray(guides[..., 0]),
        MOMENT: np.ascontiguousarray(guides[..., 1]),
    }


def _guided(topology: Topology) -> list[str]:
    """Sliders, whose guides have outputs."""
    return [name for name, body in topology.mechanism.bodies.items() if body.kind == "slider"]


def row_of(series: Series, model: Model) -> int:
    """Place of a component of a reaction among those of all joints, pins, then guides."""
    joints, index = 2 * len(model.topology.joints), series.index(model)
    if series.variable in (GUIDE, MOMENT):
        before = joints + 2 * len(shared_pins(model.mechanism))
        return before + 2 * index + (series.variable == MOMENT)
    return index + (joints if series.variable == PIN else 0)


def _of_piece(piece: Piece) -> Iterator[Floats]:
    if piece.samples is not None:
        yield _across(piece, statics_of(replace(piece, samples=None)).reactions())
        return
    for start in range(0, len(piece.time), _CHUNK):
        yield statics_of(piece.part(slice(start, start + _CHUNK))).reactions()


def _across(piece: Piece, reactions: Floats) -> Floats:
    """Reactions at the wanted times of a passage, from those at its times.

    In a change point the linear system is singular: a reaction is the sum of a smooth part and one
    like the reciprocal of the time from it.
    """
    assert piece.samples is not None
    rows = reactions.transpose(1, 2, 0)
    place, wanted = piece.time - piece.crossing, piece.samples - piece.crossing
    scaled = rows * place
    at_crossing = replace(piece, samples=np.array([piece.crossing]))
    residue = at_crossing.interpolated(scaled)
    largest = np.abs(scaled).max(axis=-1, keepdims=True, initial=0.0)
    residue[np.abs(residue) <= _NO_RESIDUE * largest] = 0.0
    regular = piece.interpolated((scaled - residue) / place)
    with np.errstate(divide="ignore", invalid="ignore"):
        unbounded = np.where(residue == 0.0, 0.0, residue / wanted)
    return (regular + unbounded).transpose(2, 0, 1)


def reaction_nodes(model: Model) -> list[Scalar]:
    """What reactions follow from: accelerations, and all loads."""
    vectors = [*model.accelerations.joints.values()]
    vectors += [force for load in model.acting for _, _, force in load.forces()]
    torques = [torque for load in model.acting for _, torque in load.torques()]
    return [*(node for v in vectors for node in (v.x, v.y)), *torques]


def statics_of(piece: Piece) -> Statics:
    """The forces at the samples of a piece."""
    system = piece.system
    return Statics(system.model, system.topology, len(piece.time), partial(evaluate_nodes, piece))


class Statics:
    """The linear system of forces at some samples: three equations per body, in any arithmetic.

    `evaluate` maps nodes to values of shape (nodes, samples), `number` converts one of the
    definition.
    """

    def __init__(
        self,
        model: Model,
        topology: Topology,
        samples: int,
        evaluate: Callable[[Sequence[Scalar]], NDArray],
        number: Callable[[Parameter], Any] = operator.attrgetter("value"),
    ) -> None:
        self._values, self._number = evaluate, number
        self._model, self._samples = model, samples
        self._topology, self._mechanism = topology, topology.mechanism
        own = solid(self._mechanism, self._mechanism.bodies)
        self._bodies = [self._mechanism.bodies[name] for name in own]
        self._pairs = [pair for pair in pairs(self._mechanism) if pair.second in own]
        self._joint = {joint: index for index, joint in enumerate(self._topology.joints)}
        self._row = {body.name: 3 * index for index, body in enumerate(self._bodies)}
        self._evaluate()

    def _evaluate(self) -> None:
        """Places and accelerations of joints, directions and angular accelerations of bodies."""
        model, joints, bodies = self._model, self._topology.joints, self._bodies
        places = [model.positions.joints[joint] for joint in joints]
        moved = [model.accelerations.joints[joint] for joint in joints]
        units = [model.positions.unit(body.name) for body in bodies]
        spins = [model.accelerations.turning(body.name) for body in bodies]
        rates = [model.velocities.turning(body.name) for body in bodies]
        vectors = [node for v in (*places, *moved, *units) for node in (v.x, v.y)]
        nodes = [*vectors, *spins, *rates]
        values = self._values(nodes)
        self._type = values.dtype
        split = 2 * np.cumsum([len(places), len(moved), len(units)])
        result = np.split(values, [*split, split[-1] + len(spins)])
        self._places, self._accelerations, self._units = (
            part.reshape(len(part) // 2, 2, self._samples).transpose(0, 2, 1) for part in result[:3]
        )
        self._spins, self._rates = result[3], result[4]
        self._index = {body.name: index for index, body in enumerate(bodies)}

    def reactions(self) -> Floats:
        """Solve, and add the pairs of each joint and of each body at a shared pin."""
        if self._model.tree is not None:
            return self.at_places(self._along_tree(self._inertia() - self._applied()))
        return self.at_places(_solved(*self.equations()))

    def _along_tree(self, needed: Floats) -> Floats:
        """Forces of pairs where bodies hang from one another: what all beyond a pair needs."""
        carried = needed.reshape(self._samples, len(self._bodies), 3)[:, :, :2].copy()
        number = {frozenset((p.first, p.second)): k for k, p in enumerate(self._pairs)}
        result = np.zeros((self._samples, 2 * len(self._pairs)), dtype=self._type)
        edges = list(nx.bfs_edges(self._topology.graph, GROUND))
        for parent, child in reversed(edges):
            place, force = number[frozenset((parent, child))], carried[:, self._index[child]]
            forward = self._pairs[place].second == child
            result[:, 2 * place : 2 * place + 2] = force if forward else -force
            if parent != GROUND:
                carried[:, self._index[parent]] += force
        return result

    def equations(self) -> tuple[NDArray, NDArray]:
        """Matrix and right-hand side, shapes (samples, 3 bodies, unknowns) and (…, 3 bodies)."""
        columns = [*self._pair_columns(), *self._guide_columns(), *self._effort_columns()]
        matrix = np.stack(columns, axis=-1) if columns else np.zeros((self._samples, 0, 0))
        return matrix, self._inertia() - self._applied()

    def at_places(self, forces: Floats) -> Floats:
        """Reactions of joints, of bodies at shared pins, then force and moment of each guide.

        Shape (samples, joints + pins + sliders, 2).
        """
        count, shared = len(self._joint), shared_pins(self._mechanism)
        pins = {pin: count + index for index, pin in enumerate(shared)}
        sliders, guides = (
            _guided(self._topology),
            [b.name for b in self._bodies if b.guide is not None],
        )
        rows = count + len(pins) + len(sliders)
        result = np.zeros((self._samples, rows, 2), dtype=forces.dtype)
        for place, name in enumerate(sliders, count + len(pins)):
            first = 2 * (len(self._pairs) + guides.index(name))
            result[:, place] = forces[:, first : first + 2]
            for unknown, sign in self._welded(name):
                result[:, place, 1] += sign * forces[:, unknown]
        for index, pair in enumerate(self._pairs):
            force = forces[:, 2 * index : 2 * index + 2]
            result[:, self._joint[pair.joint]] += force
            if (pair.joint, pair.second) in pins:
                result[:, pins[pair.joint, pair.second]] += force
                result[:, pins[pair.joint, pair.first]] -= force
        return result

    def _welded(self, slider: str) -> Iterator[tuple[int, float]]:
        """Torques that hold what is fixed to a slider, and that its guide therefore transmits.

        A weld at its joint is to the body that carries its axis, or to the ground.
        """
        body = self._mechanism.bodies[slider]
        joint, carrier = next(iter(body.points)), self._mechanism.bearing(body)
        relations = self._mechanism.relations
        first = len(self._effort_names) + 2 * len(self._pairs)
        first += 2 * sum(own.guide is not None for own in self._bodies)
        for unknown, relation in enumerate(relations, first):
            others = [name for name, _ in relation.parts]
            if relation.path != ("welds", joint):
                continue
            if others == ([] if carrier is None else [carrier]):
                yield unknown, 1.0
            elif relation.body == carrier:
                yield unknown, -1.0

    @property
    def _effort_names(self) -> tuple[str, ...]:
        """What has an effort of its own: actuators, or drives, and free coordinates."""
        driven = tuple(self._mechanism.actuations) or self._topology.driven
        return (*driven, *self._topology.free)

    def _applied(self) -> Floats:
        """Forces and moments of all loads on each body."""
        rows = self._column()
        for load in self._model.acting:
            self._add_load(rows, load)
        return rows

    def _add_load(self, rows: Floats, load: Acting) -> None:
        self._add_all(rows, load.forces(), load.torques())

    def _add_all(
        self,
        rows: Floats,
        forces: Iterable[tuple[str | None, str, Vector]],
        torques: Iterable[tuple[str | None, Scalar]],
    ) -> None:
        for body, joint, force in forces:
            if body is not None:
                self._add(rows, body, joint, self._values([force.x, force.y]).T)
        for body, torque in torques:
            if body is not None:
                self._add_torque(rows, body, self._values([torque])[0])

    def changed_by(self, load: Acting) -> Floats:
        """Changes of reactions by a further load at the same accelerations, as `at_places`."""
        rows = self._column()
        self._add_load(rows, load)
        return self.at_places(_solved(self.equations()[0], -rows))

    def _column(self) -> Floats:
        return np.zeros((self._samples, 3 * len(self._bodies)), dtype=self._type)

    def _add(self, rows: Floats, body: str, joint: str, force: Floats) -> None:
        """Add a force on a body at a joint to its equations, shape (samples, 2)."""
        row = self._row[body]
        arm = self._places[self._joint[joint]] - self._reference(body)
        rows[:, row : row + 2] += force
        rows[:, row + 2] += arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]

    def _pair_columns(self) -> Iterator[Floats]:
        for pair in self._pairs:
            for direction in ((1.0, 0.0), (0.0, 1.0)):
                column, force = self._column(), np.tile(direction, (self._samples, 1))
                self._add(column, pair.second, pair.joint, force)
                if pair.first != GROUND:
                    self._add(column, pair.first, pair.joint, -force)
                yield column

    def _guide_columns(self) -> Iterator[Floats]:
        """A force across the axis and a moment."""
        for body in self._bodies:
            if body.guide is None:
                continue
            yield self._along_guide(body, across=True)
            column = self._column()
            self._add_torque(column, body.name, 1.0)
            if body.guide.body is not None:
                self._add_torque(column, body.guide.body, -1.0)
            yield column

    def _along_guide(self, body: Body, across: bool) -> Floats:
        """A unit force between a slider and its carrier, across the axis or along it."""
        column, axis = self._column(), self._units[self._index[body.name]]
        force = np.stack([-axis[:, 1], axis[:, 0]], axis=1) if across else axis
        pin, bearing = next(iter(body.points), body.axis), self._mechanism.bearing(body)
        self._add(column, body.name, pin, force)
        if bearing is not None:
            self._add(column, bearing, pin, -force)
        return column

    def _add_torque(self, rows: Floats, body: str, torque: float | Floats) -> None:
        rows[:, self._row[body] + 2] += torque

    def _effort_columns(self) -> Iterator[Floats]:
        """Efforts of drives (of free coordinates too, which come out as zero) and of relations."""
        for actuator in self._model.actuators:  # of unit effort
            column = self._column()
            self._add_load(column, actuator)
            yield column
        driven = () if self._model.actuators else self._topology.driven
        for name in (*driven, *self._topology.free):
            yield self._effort(name)
        graph = self._model.graph
        for relation in self._mechanism.relations:
            cam = None if relation.profile is None else self._model.cam(relation.body)
            if cam is not None and cam.pivot is not None:
                column, unit = self._column(), (graph.one, graph.zero)
                self._add_all(column, cam.forces(*unit), cam.torques(*unit))
                yield column
                continue
            column = self._effort(relation.body)
            slope = 1.0 if cam is None else self._values([cam.slope]).T
            for other, ratio in relation.parts:
                column -= self._effort(other) * (slope * self._number(ratio))
            yield column

    def _effort(self, name: str) -> Floats:
        """A unit torque on a body that turns, or force along the axis of one that slides."""
        body = self._mechanism.bodies[name]
        if body.kind == GUIDED:
            return self._at_point(name)
        if not body.rotates:
            return self._along_guide(body, across=False)
        column = self._column()
        self._add_torque(column, name, 1.0)
        return column

    def _at_point(self, name: str) -> Floats:
        """A unit force at a point that a drive moves, along x or y."""
        joint, column = name.rpartition(".")[0], self._column()
        carrier, (along, _) = self._mechanism.carrier(joint), axis_names(joint)
        assert carrier is not None
        force = np.tile((1.0, 0.0) if name == along else (0.0, 1.0), (self._samples, 1))
        self._add(column, carrier, joint, force)
        return column

    def _reference(self, body: str) -> Floats:
        """The point that moments of a body are taken about: its first joint."""
        return self._places[self._first(body)]

    def _first(self, body: str) -> int:
        moved = self._mechanism.bodies[body]
        return self._joint[next(iter(moved.points), moved.axis)]

    def _inertia(self) -> Floats:
        """Mass times acceleration less weight, and rates of angular momentum."""
        rows = self._column()
        gravity = self._mechanism.gravity
        g = np.array([self._number(gravity.x), self._number(gravity.y)])
        for body in self._bodies:
            row, spin = self._row[body.name], self._spins[self._index[body.name]]
            arm, acceleration = self._centre(body)
            force = (acceleration - g) * self._number(body.mass)
            rows[:, row : row + 2] += force
            rows[:, row + 2] += arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
            rows[:, row + 2] += spin * self._number(body.inertia)
        for mass in self._mechanism.point_masses:
            carrier = self._mechanism.carrier(mass.joint)
            if carrier is not None:
                acceleration = self._accelerations[self._joint[mass.joint]]
                self._add(rows, carrier, mass.joint, (acceleration - g) * self._number(mass.mass))
        return rows

    def _centre(self, body: Body) -> tuple[Floats, Floats]:
        """Centre of mass relative to the first joint, and its acceleration."""
        index, first = self._index[body.name], self._first(body.name)
        origin = next(iter(body.points.values()), body.centre)
        pairs = zip(body.centre, origin, strict=True)
        x, y = (self._number(c) - self._number(o) for c, o in pairs)
        if body.guide is not None:
            x = y = 0.0
        unit = self._units[index]
        arm = unit * x + np.stack([-unit[:, 1], unit[:, 0]], axis=1) * y
        spin, rate = self._spins[index][:, None], self._rates[index][:, None]
        turned = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        return arm, self._accelerations[first] + turned * spin - arm * (rate * rate)


def _solved(matrix: Floats, right: Floats) -> Floats:
    """Solutions of linear systems; with the least sum of squares where they are not unique."""
    if matrix.shape[1] == matrix.shape[2]:
        try:
            return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        except np.linalg.LinAlgError:  # a sample lies exactly in a singular position
            pass
    return np.asarray((np.linalg.pinv(matrix, rcond=1e-11) @ right[..., None])[..., 0])
