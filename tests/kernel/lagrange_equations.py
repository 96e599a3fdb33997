"""Lagrange's equations of the first kind, derived with SymPy, against the kernel.

`assert_satisfies_lagrange` takes any mechanism. The symbolic road shares no formula with the
kernel: T and V of all bodies in absolute coordinates, centres of mass instead of pin masses, loops
as constraints with multipliers instead of dyads. Clearances are given a variable length, held
constant by a force: that is the force in the link.
"""

from dataclasses import dataclass

import numpy as np
import sympy as sp
from lagrange_states import Kernel, analysed

from linkages.equations import render
from linkages.equations.derivation import derive, kinetic_energy, time_derivative
from linkages.equations.expressions import components
from linkages.equations.vector_loops import Places

TOLERANCE = 5e-12
"""Round-off, 2e-16, grows with the inverse of every margin on the way (10 at most for a dyad); the
largest difference seen in 10 000 states of all kinds is 4e-13."""


@dataclass
class Answer:
    """What Lagrange's equations say about a state, in the order of the coordinates."""

    closure: np.ndarray
    closure_rate: np.ndarray
    laws: np.ndarray
    joints: np.ndarray
    energies: np.ndarray
    acceleration: np.ndarray
    efforts: np.ndarray
    largest_terms: np.ndarray
    followers: np.ndarray


class Lagrange:
    """M q̈ + h = Φ_qᵀ λ + efforts, and Φ̈ = 0, solved for q̈, λ and efforts together."""

    def __init__(self, topology):
        self.redundant = any(block.surplus for block in topology.solved_blocks)
        self.equations = equations = derive(topology)
        self.symbols = symbols = equations.symbols
        self.sizes = [
            symbols.parameter(list(body.points.values())[1][0])
            for body in topology.mechanism.bodies.values()
            if body.kind == "clearance"
        ]
        self.names = {coordinate: name for name, coordinate in symbols.coordinates.items()}
        symbols.rates |= {size: symbols.dotted(size) for size in self.sizes}
        self.q, dq = list(symbols.rates), list(symbols.rates.values())
        self.held = [*equations.driven, *self.sizes]  # each by an effort of its own
        places = Places(topology, symbols)
        joints = [components(places.joint(joint)) for joint in topology.joints]
        energy = kinetic_energy(equations.bodies, symbols.rates)
        forces = equations.loads.generalised_forces({})
        results = [
            *self._dynamics(energy, forces),
            *self._constraints(),
            sp.Matrix(joints),
            sp.Matrix([energy, equations.potential_energy]),
            sp.Matrix([d.value for d in equations.followers]),
            sp.Matrix([[sp.diff(d.value, q) for q in self.q] for d in equations.followers]),
            sp.Matrix([self._bent(d.value) for d in equations.followers]),
            sp.Matrix(len(equations.drives), 3, self._laws()),
        ]
        self.parameters = [symbol for symbol in symbols.values if symbol not in self.sizes]
        self.evaluate = sp.lambdify(
            (symbols.time, self.q, dq, self.parameters), results, [self._functions(), "numpy"],
            cse=True,
        )  # fmt: skip

    def _bent(self, value):
        """The part of a second derivative that is quadratic in rates."""
        return time_derivative(time_derivative(value, self.symbols.rates), self.symbols.rates)

    def _functions(self):
        """What SymPy does not know. Splines are computed by the printed module."""
        module = {}
        exec(compile(render(self.equations, "python"), "equations.py", "exec"), module)
        return {
            "Select": lambda condition, first, other: first if condition >= 0 else other,
            "Spline": lambda number, order, time: module["spline"](
                *module["TABLES"][number - 1], time, order
            ),
        }

    def _laws(self):
        time = self.symbols.time
        return [sp.diff(law, time, n) for law in self.equations.drives.values() for n in range(3)]

    def _dynamics(self, energy, forces):
        """Mass matrix, and everything else in d/dt ∂T/∂q̇ − ∂T/∂q + ∂V/∂q − Q but drives."""
        rates, expanded = self.symbols.rates, self.equations.expanded
        momenta = [sp.diff(energy, rate) for rate in rates.values()]
        mass = sp.Matrix([[sp.diff(p, rate) for rate in rates.values()] for p in momenta])
        force = [
            time_derivative(p, rates)
            - sp.diff(energy - self.equations.potential_energy, q)
            - expanded(sp.sympify(forces.get(q, 0)))
            for p, q in zip(momenta, rates, strict=True)
        ]
        return mass, sp.Matrix(force)

    def _constraints(self):
        """Φ, Φ_q, and Φ̈ without its terms in q̈."""
        closure, rates = self.equations.closure, self.symbols.rates
        jacobian = sp.Matrix(len(closure), len(rates), lambda i, j: sp.diff(closure[i], self.q[j]))
        slip = jacobian * sp.Matrix(list(rates.values()))
        bias = slip.applyfunc(lambda value: time_derivative(value, rates))
        return sp.Matrix(len(closure), 1, closure), jacobian, bias

    def solve(self, state):
        """The answer at the kernel's positions and rates."""
        symbols, numbers = self.symbols, self.symbols.values
        given = [state.parameters.get(symbols.paths[s], numbers[s]) for s in self.parameters]
        q = [state.position[self.names[c]] if c in self.names else numbers[c] for c in self.q]
        dq = [state.rate[self.names[c]] if c in self.names else 0.0 for c in self.q]
        with np.errstate(all="ignore"):  # in the branches of a law that are not taken
            results = self.evaluate(state.time, q, dq, given)
        mass, force, closure, jacobian, bias, joints, energies, *turned, laws = results
        force, closure, bias, energies = map(np.ravel, (force, closure, bias, energies))
        laws = np.reshape(laws, (-1, 3))
        ratios = np.reshape(turned[1], (-1, len(q)))
        jacobian = np.reshape(jacobian, (len(closure), len(q)))
        held = np.array([[c is other for c in self.q] for other in self.held], dtype=float)
        constraints = np.concatenate([jacobian, held.reshape(len(self.held), len(q))])
        right = np.concatenate([-bias, laws[:, 2], np.zeros(len(self.sizes))])
        acceleration, multipliers = saddle(mass, constraints, -force, right, self.redundant)
        terms = [force, *(mass * acceleration).T, *(constraints.T * multipliers).T]
        return Answer(
            closure=closure,
            closure_rate=jacobian @ dq,
            laws=laws,
            joints=joints,
            energies=energies,
            acceleration=acceleration,
            efforts=multipliers[len(closure) :],
            largest_terms=np.abs(terms).max(axis=0),
            followers=np.array(
                [np.ravel(turned[0]), ratios @ dq, ratios @ acceleration + np.ravel(turned[2])]
            ),
        )


def saddle(mass, constraints, force, right, redundant=False):
    """Solve M x − Cᵀ λ = force, C x = right.

    Rows and columns are scaled alike: inertia terms of clearances are 1e-8 of the others. The
    multipliers of redundant constraints are not unique; accelerations and efforts are.
    """
    count = len(constraints)
    matrix = np.block([[mass, -constraints.T], [constraints, np.zeros((count, count))]])
    scale = 1.0 / np.sqrt(np.abs(matrix).max(axis=1))
    scaled, values = matrix * scale[:, None] * scale, scale * np.concatenate([force, right])
    if redundant:
        solution = np.linalg.lstsq(scaled, values, rcond=1e-11)[0]
    else:
        solution = np.linalg.solve(scaled, values)
    solution = scale * solution
    return solution[: len(mass)], solution[len(mass) :]


def agree(kernel_values, values, scales, tolerance=TOLERANCE):
    """Whether values agree to the tolerance, relative to the scale of each."""
    scales = np.broadcast_to(scales, np.shape(values))
    np.testing.assert_array_less(np.abs(np.subtract(kernel_values, values)), tolerance * scales)


def assert_agrees(lagrange, state, tolerance=TOLERANCE):
    """The kernel's positions, rates, accelerations, energies and efforts are right at a state."""

    def same(kernel_values, values):
        agree(kernel_values, values, 1.0 + np.abs(values), tolerance)

    answer, names = lagrange.solve(state), list(lagrange.names.values())
    size = max([1.0, *np.abs(answer.joints).ravel()])
    speed = max([1.0, *(abs(rate) for rate in state.rate.values())])
    # Angles come from atan2: a few units in the last place of lengths and speeds.
    np.testing.assert_allclose(answer.closure, 0.0, atol=1e-13 * size)
    np.testing.assert_allclose(answer.closure_rate, 0.0, atol=1e-13 * size * speed)
    places = np.transpose([[*state.x.values()], [*state.y.values()]])
    np.testing.assert_allclose(places, answer.joints, atol=1e-13 * size)
    same([*state.energy.values()], answer.energies)
    driven = [lagrange.names[coordinate] for coordinate in lagrange.equations.driven]
    followers = list(lagrange.symbols.followers)
    for order, known in enumerate((state.position, state.rate, state.acceleration)):
        same([known[name] for name in driven], answer.laws[:, order])
        same([known[name] for name in followers], answer.followers[order])
    same([state.acceleration[name] for name in names], answer.acceleration[: len(names)])
    efforts = [*state.effort.values(), *(-force for force in state.link_force.values())]
    rows = [lagrange.q.index(coordinate) for coordinate in lagrange.held]
    agree(efforts, answer.efforts, answer.largest_terms[rows], tolerance)


def assert_satisfies_lagrange(mechanism, count=100, least=40, tolerance=TOLERANCE):
    """Check the kernel of a mechanism at random states.

    Parameters
    ----------
    mechanism
        As `linkages.load` returns it.
    count
        States to check, if as many can be found.
    least
        Fewer than these are an error.
    tolerance
        Relative to the largest term of each equation.
    """
    topology = analysed(mechanism)
    kernel, lagrange = Kernel(topology), Lagrange(topology)
    states = kernel.random_states(count)
    assert len(states) >= least
    for state in states:
        assert_agrees(lagrange, state, tolerance)
