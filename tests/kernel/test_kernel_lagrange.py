"""The kernel satisfies Lagrange's equations of the first kind, derived with SymPy.

The symbolic road shares no formula with the kernel: T and V of all bodies in absolute coordinates,
centres of mass instead of pin masses, loops as constraints with multipliers instead of dyads.
Clearances are given a variable length, held constant by a force: that is the force in the link.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
import sympy as sp

from linkages.components.definition import from_document
from linkages.equations.derivation import derive
from linkages.equations.energies import kinetic_energy, time_derivative
from linkages.equations.places import Places
from linkages.equations.polar import components
from linkages.kernel.model import Model
from linkages.kernel.scalars import Evaluator
from linkages.reading.document import parse
from linkages.topology.topology import build_topology

STATES = 40
SMALLEST_MARGIN = 0.1  # of the largest possible: errors grow like its inverse
TOLERANCE = 1e-9

NINE_BAR = """
gravity: [9.81, 0]
joints: {O: [0, 0], D: [1.100, 0]}
bars:
  crank1:  {joints: [O, A], length: 0.300, mass: 0.985, inertia: 8.390e-3}
  link2:   {joints: [A, B], length: 0.893, mass: 2.836, inertia: 1.957e-1}
  link3:   {joints: [C, B], length: 0.962, mass: 3.051, inertia: 2.437e-1}
  crank4:  {joints: [D, C], length: 0.100, mass: 0.361, inertia: 4.774e-4}
  rocker6: {joints: [O, E], length: 0.850, mass: 2.701, inertia: 1.693e-1}
  link7:   {joints: [E, B], length: 0.623, mass: 1.993, inertia: 6.818e-2}
  link8:   {joints: [E, F], length: 0.850, mass: 2.701, inertia: 1.693e-1}
sliders: {slider9: {joint: F, through: O, angle: 0, mass: 4.288}}
clearances: {r1: {joint: C, bar: link3, size: 0.15 mm}}
drives: {crank1: {angle: 0.5, speed: -pi}, crank4: {angle: 1.0, speed: pi}}
loads: [{slider: slider9, force: -100}]
"""

SLIDER_CRANK = """
gravity: [1.2, -9.81]
joints: {{O: [0.1, -0.2]}}
bars:
  crank: {{joints: [O, A], length: 0.2, mass: 0.8, center: 0.07}}
  rod: {{joints: [B, A], length: 0.5, mass: 1.3, center: [0.2, 0.06], inertia: 0.04}}
sliders: {{piston: {{joint: B, through: [0.3, 0.02], angle: 0.3, mass: 0.9}}}}
clearances: {{{clearances}}}
drives: {{crank: {{angle: 0.5, speed: 12}}}}
loads: [{{slider: piston, force: -40}}]
"""
CLEARANCES = {
    "O": "rO: {joint: O, bar: crank, size: 1 mm}",
    "A": "rA: {joint: A, bar: rod, size: 0.8 mm}",
    "B": "rB: {joint: B, bar: rod, size: 0.5 mm}",
}

FOUR_BAR = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.5, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.15, mass: 0.5}
  coupler: {joints: [A, B], length: 0.55, mass: 1.1, center: 0.4}
  rocker: {joints: [C, B], length: 0.35, mass: 0.7, center: [0.1, -0.03]}
clearances:
  rA: {joint: A, bar: coupler, size: 0.5 mm}
  rC: {joint: C, bar: rocker, size: 0.3 mm}
drives: {crank: {angle: 0, speed: 9}}
"""

PLATES = """
gravity: [2, -9]
joints: {{O: [0, 0], C: [0.6, 0]}}
bars:
  crank:
    points: {{O: [0.02, 0.01], A: [0.15, -0.05]}}
    mass: 0.4
    center: [0.1, 0.06]
    inertia: 3e-3
  plate:
    points: {{P: [0.1, 0.2], A: [0.01, 0.02], B: [0.45, 0]}}
    mass: 1.4
    center: [0.2, 0.15]
    inertia: 0.05
  rocker: {{joints: [B, C], length: 0.4, mass: 0.6}}
  rod: {{joints: [P, F], length: 0.7, mass: 0.3, center: [0.1, 0.02]}}
sliders: {{slider: {{joint: F, through: [-0.2, 0.4], angle: 40 deg, mass: 0.9}}}}
loads: [{{slider: slider, force: 25}}, {{slider: slider, force: -7}}]
{known}
"""

DOUBLE_PENDULUM = """
gravity: [0.3, -9.81]
joints: {O: [0.2, 0]}
bars:
  upper: {joints: [O, A], length: 0.6, mass: 1.2, center: [0.2, 0.05]}
  lower: {joints: [A, tip], length: 0.4, mass: 0.7}
free: {upper: {angle: 1, speed: 0}, lower: {angle: 0, speed: 0}}
"""

CART = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  arm: {joints: [H, tip], length: 0.6, mass: 1.2, center: 0.5}
  disc: {points: {H: [0.1, 0.1]}, mass: 0.5, center: [0.15, 0.02], inertia: 0.01}
sliders: {cart: {joint: H, through: O, angle: 15 deg, mass: 2}}
free: {cart: {position: 0.1, speed: 0}, arm: {angle: 0, speed: 0}, disc: {angle: 0, speed: 0}}
loads: [{slider: cart, force: 3}]
"""

TRAMMEL = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {bar: {joints: [P, Q], length: 0.6, mass: 1.2, center: [0.25, 0.03]}}
sliders:
  across: {joint: P, through: O, angle: 10 deg, mass: 0.4}
  up: {joint: Q, through: [0.1, 0], angle: 90 deg, mass: 0.7}
clearances: {r1: {joint: Q, bar: bar, size: 2 mm}}
free: {bar: {angle: 0.4, speed: 0}}
loads: [{slider: up, force: 3}]
"""

DRIVEN = "drives: {crank: {angle: 0.5, speed: 3}}"
FREE = "free: {crank: {angle: 0.5, speed: 3}}"
LOOSE = "clearances: {rB: {joint: B, bar: plate, size: 0.6 mm}}\n" + DRIVEN

MECHANISMS = {
    "nine-bar": NINE_BAR,
    **{
        f"slider-crank-{'-'.join(joints) or 'ideal'}": SLIDER_CRANK.format(
            clearances=", ".join(CLEARANCES[joint] for joint in joints)
        )
        for joints in ("", "O", "A", "B", "OAB")
    },
    "four-bar-two-clearances": FOUR_BAR,
    "plates-driven": PLATES.format(known=DRIVEN),
    "plates-free": PLATES.format(known=FREE),
    "plates-loose": PLATES.format(known=LOOSE),
    "double-pendulum": DOUBLE_PENDULUM,
    "cart-with-pendulum-and-disc": CART,
    "trammel": TRAMMEL,
}


@dataclass
class State:
    """What the kernel says about one state, by body and joint."""

    position: dict[str, float]
    rate: dict[str, float]
    acceleration: dict[str, float]
    effort: dict[str, float]
    link_force: dict[str, float]
    x: dict[str, float]
    y: dict[str, float]
    energy: dict[str, float]


@dataclass
class Answer:
    """What Lagrange's equations say about it, in the order of the coordinates."""

    closure: np.ndarray
    closure_rate: np.ndarray
    joints: np.ndarray
    energies: np.ndarray
    acceleration: np.ndarray
    efforts: np.ndarray
    largest_terms: np.ndarray


class Kernel:
    """The kernel's graph, evaluated with NumPy."""

    def __init__(self, topology):
        self.topology = topology
        self.model = model = Model(topology)
        bodies = topology.mechanism.bodies
        clearances = [name for name, body in bodies.items() if body.kind == "clearance"]
        turning = [name for name, body in bodies.items() if body.rotates]
        joints = {name: model.positions.joints[name] for name in topology.joints}
        self.first = {
            "free": dict(zip(topology.free, model.free_accelerations, strict=True)),
            "rate": model.velocities.bodies,
            "cos": {name: model.positions.unit(name).x for name in turning},
            "sin": {name: model.positions.unit(name).y for name in turning},
            "position": model.positions.displacements,
            "margin": dict(enumerate(model.margins)),
            "scale": dict(enumerate(model.margin_scales)),
            "x": {name: place.x for name, place in joints.items()},
            "y": {name: place.y for name, place in joints.items()},
            "energy": {
                "kinetic": 0.5 * model.inertia.product(model.velocities, model.velocities),
                "potential": -model.gravity.dot(model.inertia.moment_of_mass()),
            },
        }
        self.second = {
            "acceleration": model.accelerations.bodies,
            "effort": {
                name: model.required_force(model.accelerations, model.partial(name))
                for name in topology.driven
            },
            "link_force": {
                name: -model.required_force(model.accelerations, model.partial(name, stretch=name))
                for name in clearances
            },
        }

    @staticmethod
    def _evaluate(groups, **inputs):
        nodes = [node for group in groups.values() for node in group.values()]
        values = iter(Evaluator(nodes)(**inputs))
        return {key: {name: next(values) for name in group} for key, group in groups.items()}

    def states(self, seed):
        """Random states far enough from singular positions."""
        rng = np.random.default_rng(seed)
        parameters = {path: np.full(STATES, v) for path, v in self.model.inputs.parameters.items()}
        for path in parameters:
            if path[0] == "side":
                parameters[path] = rng.choice([-1.0, 1.0], STATES)
            elif path[0] == "drives":
                parameters[path] = rng.uniform(-6, 6, STATES)
        count = len(self.topology.free)
        positions, rates = rng.uniform(-3, 3, (count, STATES)), rng.normal(0, 5, (count, STATES))
        inputs = {
            "t": rng.uniform(0, 2, (1, STATES)),
            "y": np.concatenate([positions, rates]),
            "p": np.array(list(parameters.values())).reshape(len(parameters), STATES),
        }
        values = self._evaluate(self.first, **inputs)
        acceleration = np.array([*values["free"].values()]).reshape(count, STATES)
        values |= self._evaluate(self.second, a=acceleration, **inputs)
        values["position"] |= {
            name: np.arctan2(values["sin"][name], values["cos"][name]) for name in values["cos"]
        }
        values = {
            k: {n: np.broadcast_to(v, STATES) for n, v in g.items()} for k, g in values.items()
        }
        usable = np.full(STATES, True)
        for block, margin in values["margin"].items():
            usable &= np.abs(margin) > SMALLEST_MARGIN * values["scale"][block]  # False for nan
        return [
            State(
                **{
                    key: {name: float(value[i]) for name, value in values[key].items()}
                    for key in State.__dataclass_fields__
                }
            )
            for i in np.flatnonzero(usable)
        ]


class Lagrange:
    """M q̈ + h = Φ_qᵀ λ + efforts, and Φ̈ = 0, solved for q̈, λ and efforts together."""

    def __init__(self, topology):
        self.equations = equations = derive(topology)
        symbols = equations.symbols
        sizes = [
            symbols.parameter(list(body.points.values())[1][0])
            for body in topology.mechanism.bodies.values()
            if body.kind == "clearance"
        ]
        rates = symbols.rates | {size: symbols.dotted(size) for size in sizes}
        self.q, dq = list(rates), list(rates.values())
        self.held = [*equations.driven, *sizes]  # each by an effort of its own
        self.names = {coordinate: name for name, coordinate in symbols.coordinates.items()}
        places = Places(topology, symbols)
        joints = [components(places.joint(joint)) for joint in topology.joints]
        energy = kinetic_energy(equations.bodies, rates)
        results = [
            *self._dynamics(energy, rates),
            *self._constraints(rates),
            sp.Matrix(joints),
            sp.Matrix([energy, equations.potential_energy]),
        ]
        parameters = [symbol for symbol in symbols.values if symbol not in sizes]
        self.values = [symbols.values[symbol] for symbol in parameters]
        self.evaluate = sp.lambdify((self.q, dq, parameters), results, cse=True)

    def _dynamics(self, energy, rates):
        """Mass matrix, and everything else in d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q − Q but drives."""
        equations = self.equations
        no_drives = dict.fromkeys(equations.efforts.values(), 0)
        momenta = [sp.diff(energy, rate) for rate in rates.values()]
        mass = sp.Matrix([[sp.diff(p, rate) for rate in rates.values()] for p in momenta])
        force = [
            time_derivative(p, rates)
            - sp.diff(energy - equations.potential_energy, q)
            - sp.sympify(equations.forces.get(q, 0)).subs(no_drives)
            for p, q in zip(momenta, rates, strict=True)
        ]
        return mass, sp.Matrix(force)

    def _constraints(self, rates):
        """Φ, Φ_q, and Φ̈ without its terms in q̈."""
        closure = self.equations.closure
        jacobian = sp.Matrix(len(closure), len(rates), lambda i, j: sp.diff(closure[i], self.q[j]))
        slip = jacobian * sp.Matrix(list(rates.values()))
        bias = slip.applyfunc(lambda value: time_derivative(value, rates))
        return sp.Matrix(len(closure), 1, closure), jacobian, bias

    def solve(self, state):
        """The answer at the kernel's positions and rates."""
        sizes = self.equations.symbols.values
        q = [state.position[self.names[c]] if c in self.names else sizes[c] for c in self.q]
        dq = [state.rate[self.names[c]] if c in self.names else 0.0 for c in self.q]
        mass, force, closure, jacobian, bias, joints, energies = self.evaluate(q, dq, self.values)
        force, closure, bias, energies = map(np.ravel, (force, closure, bias, energies))
        jacobian = np.reshape(jacobian, (len(closure), len(q)))
        held = np.array([[c is other for c in self.q] for other in self.held], dtype=float)
        constraints = np.concatenate([jacobian, held.reshape(len(self.held), len(q))])
        right = np.concatenate([-bias, np.zeros(len(self.held))])
        acceleration, multipliers = saddle(mass, constraints, -force, right)
        terms = [force, *(mass * acceleration).T, *(constraints.T * multipliers).T]
        return Answer(
            closure=closure,
            closure_rate=jacobian @ dq,
            joints=joints,
            energies=energies,
            acceleration=acceleration,
            efforts=multipliers[len(closure) :],
            largest_terms=np.abs(terms).max(axis=0),
        )


def saddle(mass, constraints, force, right):
    """Solve M x − Cᵀ λ = force, C x = right.

    Rows and columns are scaled alike: inertia terms of clearances are 1e-8 of the others.
    """
    count = len(constraints)
    matrix = np.block([[mass, -constraints.T], [constraints, np.zeros((count, count))]])
    scale = 1.0 / np.sqrt(np.abs(matrix).max(axis=1))
    scaled = matrix * scale[:, None] * scale
    values = scale * np.linalg.solve(scaled, scale * np.concatenate([force, right]))
    return values[: len(mass)], values[len(mass) :]


@cache
def roads(name):
    topology = build_topology(from_document(parse(MECHANISMS[name], f"{name}.yaml")))
    return Kernel(topology), Lagrange(topology)


def agree(kernel_values, values, scales):
    """Whether values agree to the tolerance, relative to the scale of each."""
    scales = np.broadcast_to(scales, np.shape(values))
    np.testing.assert_array_less(np.abs(np.subtract(kernel_values, values)), TOLERANCE * scales)


@pytest.mark.parametrize("name", MECHANISMS)
def test_kernel_satisfies_lagrange_equations(name):
    kernel, lagrange = roads(name)
    states = [state for seed in (1, 2, 3) for state in kernel.states(seed)]
    assert len(states) >= 2 * STATES
    for state in states:
        answer = lagrange.solve(state)
        # Angles come from atan2, lengths are of order 1: a few units in the last place.
        np.testing.assert_allclose(answer.closure, 0.0, atol=1e-13)
        np.testing.assert_allclose(answer.closure_rate, 0.0, atol=1e-12)
        places = np.transpose([[*state.x.values()], [*state.y.values()]])
        np.testing.assert_allclose(places, answer.joints, atol=1e-13)
        agree([*state.energy.values()], answer.energies, 1.0 + np.abs(answer.energies))
        accelerations = [state.acceleration[body] for body in lagrange.names.values()]
        bodies = answer.acceleration[: len(accelerations)]
        agree(accelerations, bodies, 1.0 + np.abs(bodies))
        efforts = [*state.effort.values(), *(-force for force in state.link_force.values())]
        rows = [lagrange.q.index(coordinate) for coordinate in lagrange.held]
        agree(efforts, answer.efforts, answer.largest_terms[rows])


def test_assembly_modes_and_drives_differ_between_states():
    kernel, _ = roads("nine-bar")
    states = kernel.states(1)
    first = {round(state.rate["crank1"], 9) for state in states}
    assert len(first) == len(states)
    # both sides of E: E is left or right of the line from O to B
    sides = {np.sign(s.x["B"] * s.y["E"] - s.y["B"] * s.x["E"]) for s in states}
    assert sides == {-1.0, 1.0}
