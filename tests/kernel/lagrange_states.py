"""Random states of a mechanism, and what the kernel says about them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from linkages.kernel.assembly_branches import assembled
from linkages.kernel.differentiation import Evaluator
from linkages.kernel.inputs import definition_vector
from linkages.kernel.model import Model
from linkages.kernel.system import System, choose_free
from linkages.topology.assur_groups import ITERATED
from linkages.topology.topology import build_topology

STATES = 40
SMALLEST_MARGIN = 0.1  # of the largest possible: errors grow like its inverse
SMALLEST_DETERMINANT = 0.01  # of more than two equations: far below its bound by Hadamard
MOST_SEEDS = 30
STEPS, LONGEST_STEP = 50, 0.3  # of a walk along the motion


def analysed(mechanism):
    """The topology that a system computes with; redundant blocks must be put together for it."""
    topology = build_topology(choose_free(mechanism))
    return System(topology.mechanism).topology if topology.redundant else topology


@dataclass
class State:
    """What the kernel says about one state, by body and joint."""

    time: float
    parameters: dict[tuple, float]
    position: dict[str, float]
    rate: dict[str, float]
    acceleration: dict[str, float]
    effort: dict[str, float]
    link_force: dict[str, float]
    x: dict[str, float]
    y: dict[str, float]
    energy: dict[str, float]
    more: dict[tuple, float]


class Kernel:
    """The kernel's graph, evaluated with NumPy.

    Parameters
    ----------
    topology
        An analysed mechanism.
    more
        Gives further nodes of the model that states contain.
    """

    def __init__(self, topology, more=lambda _: {}):
        self.topology = topology
        self.model = model = Model(topology)
        bodies = topology.mechanism.bodies
        clearances = [name for name, body in bodies.items() if body.kind == "clearance"]
        followers = list(topology.followers)
        joints = {name: model.positions.joints[name] for name in topology.joints}
        own = {name: model.positions.coordinate(name) for name in bodies if name not in followers}
        turned = {name: model.positions.coordinate(name) for name in followers}
        self.first = {
            "free": dict(zip(topology.free, model.free_accelerations, strict=True)),
            "position": own | turned,
            "rate": self._rates(model.velocities, followers),
            "margin": dict(enumerate(model.margins)),
            "scale": dict(enumerate(model.margin_scales)),
            "reach": {reach.block: reach.radicand for reach in model.reaches},
            "x": {name: place.x for name, place in joints.items()},
            "y": {name: place.y for name, place in joints.items()},
            "energy": {
                "kinetic": 0.5 * model.inertia.product(model.velocities, model.velocities),
                "potential": model.potential_energy,
            },
        }
        self.second = {
            "more": more(model),
            "acceleration": self._rates(model.accelerations, followers),
            "effort": {
                name: model.required_force(model.accelerations, model.partial(name))
                for name in topology.driven
            },
            "link_force": {
                name: -model.required_force(model.accelerations, model.stretched(name))
                for name in clearances
            },
        }

    @staticmethod
    def _rates(field, followers):
        return field.bodies | {name: field.moving(name) for name in followers}

    @staticmethod
    def _evaluate(groups, **inputs):
        nodes = [node for group in groups.values() for node in group.values()]
        values = iter(Evaluator(nodes)(**inputs))
        return {key: {name: next(values) for name in group} for key, group in groups.items()}

    def states(self, seed):
        """Random states far enough from singular positions."""
        rng = np.random.default_rng(seed)
        inputs = self._walked(rng) if self.topology.iterated else self._scattered(rng)
        inputs |= self.model.switches.signed(inputs)
        count = len(self.topology.coordinates)
        free = len(self.topology.free)
        values = self._evaluate(self.first, **inputs)
        acceleration = np.zeros((count, STATES))
        acceleration[:free] = np.reshape([*values["free"].values()], (free, STATES))
        values |= self._evaluate(self.second, a=acceleration, **inputs)
        values = {
            k: {n: np.broadcast_to(v, STATES) for n, v in g.items()} for k, g in values.items()
        }
        parameters = dict(zip(self.model.inputs.parameters, inputs["p"], strict=True))
        values |= {"parameters": parameters}
        groups = [key for key in State.__dataclass_fields__ if key != "time"]
        return [
            State(
                time=float(inputs["t"][0, i]),
                **{key: {n: float(v[i]) for n, v in values[key].items()} for key in groups},
            )
            for i in np.flatnonzero(self._usable(values))
        ]

    def _usable(self, values):
        """False for nan."""
        usable = np.full(STATES, True)
        for block in self.topology.solved_blocks:
            smallest = SMALLEST_MARGIN
            if block.kind == ITERATED:  # redundant equations: the determinant of normal equations
                smallest = SMALLEST_DETERMINANT ** (2 if block.surplus else 1)
            margin, scale = (values[key][block.index] for key in ("margin", "scale"))
            usable &= np.abs(margin) > smallest * scale
        for radicand in values["reach"].values():
            usable &= radicand >= 0
        return usable

    def random_states(self, count):
        """About as many random states as asked for; fewer if most positions cannot be reached."""
        found = []
        for seed in range(MOST_SEEDS):
            found += self.states(seed)
            if len(found) >= count:
                break
        return found[:count]

    def _numbers(self, rng):
        """Numbers of the file, with random sides, and random drives of bars."""
        bodies = self.topology.mechanism.bodies
        paths = self.model.inputs.parameters
        numbers = definition_vector(self.topology.mechanism, paths)
        parameters = {p: np.full(STATES, v) for p, v in zip(paths, numbers, strict=True)}
        for path in parameters:
            if path[0] == "side":
                parameters[path] = rng.choice([-1.0, 1.0], STATES)
            elif path[0] == "drives" and path[2] in ("angle", "speed") and bodies[path[1]].rotates:
                parameters[path] = rng.uniform(-6, 6, STATES)
        return parameters

    def _state(self, positions, rates):
        return np.concatenate([positions, rates]) if len(positions) else np.zeros((0, STATES))

    def _scattered(self, rng):
        """Any values of drives and free coordinates, in any assembly mode."""
        topology, parameters = self.topology, self._numbers(rng)
        positions = rng.uniform(-3, 3, (len(topology.coordinates), STATES))
        for row, name in zip(positions, topology.free, strict=False):
            if not topology.mechanism.bodies[name].rotates:
                row[:] = topology.mechanism.initial[name].position + 0.1 * row
        rates = rng.normal(0, 5, positions.shape)
        return {
            "t": rng.uniform(0, 2, (1, STATES)),
            "y": self._state(positions, rates),
            "p": np.array(list(parameters.values())).reshape(len(parameters), STATES),
        }

    @cached_property
    def _assembled(self):
        """The system at t = 0 and all assembly modes."""
        system = System(self.topology.mechanism)
        return system, system.modes()

    def _walked(self, rng):
        """Positions of all assembly modes at t = 0, moved by random steps.

        Newton's iteration finds nothing that is far from where it starts. A step that it refuses
        is not made.
        """
        topology, paths = self.topology, list(self.model.inputs.parameters)
        system, modes = self._assembled
        start, inputs = system.state, self.model.inputs
        modes = rng.permutation(np.array(modes, dtype=object))
        modes = [modes[i % len(modes)] for i in range(STATES)]
        count = len(topology.coordinates)
        parameters = np.array([assembled(inputs, system.numbers, mode) for mode in modes]).T
        positions = np.repeat(start[:count, None], STATES, axis=1)
        for i, name in enumerate(topology.coordinates):
            if name in topology.iterated:
                positions[i] = [mode.values[name] for mode in modes]
        rates = rng.normal(0, 5, positions.shape)
        angles = [i for i, path in enumerate(paths) if path[0] == "drives" and path[2] == "angle"]
        speeds = [i for i, path in enumerate(paths) if path[0] == "drives" and path[2] == "speed"]
        parameters[speeds] = rng.uniform(-6, 6, (len(speeds), STATES))
        time = np.zeros((1, STATES))
        settled = {"settled": dict(enumerate(self.model.settled))}
        free = len(topology.free)
        for _ in range(STEPS):
            moved, turned, later = positions.copy(), parameters.copy(), time
            if not speeds:  # laws
                later = np.abs(time + LONGEST_STEP * rng.uniform(-0.3, 0.3, time.shape))
            turned[angles] += LONGEST_STEP * rng.uniform(-1, 1, (len(angles), STATES))
            for row, name in zip(moved, topology.free, strict=False):
                size = 1.0 if topology.mechanism.bodies[name].rotates else 0.1
                row += size * LONGEST_STEP * rng.uniform(-1, 1, STATES)
            inputs = {"t": later, "y": self._state(moved, rates), "p": turned}
            values = self._evaluate(settled, **inputs)["settled"]
            for i in range(len(topology.carried)):
                moved[free + i] = values[i]
            sound = np.isfinite(moved).all(axis=0)
            positions = np.where(sound, moved, positions)
            parameters = np.where(sound, turned, parameters)
            time = np.where(sound, later, time)
        return {"t": time, "y": self._state(positions, rates), "p": parameters}
