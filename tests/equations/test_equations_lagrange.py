"""Energies against textbook results; the reduced equations against T, V and the kernel."""

import numpy as np
import pytest
import sympy as sp

from linkages.components.definition import from_document
from linkages.equations import derive, render
from linkages.kernel.model import Model
from linkages.kernel.scalars import Evaluator
from linkages.reading.document import parse
from linkages.topology.topology import build_topology

PENDULUM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {bar: {joints: [O, tip], length: 1, mass: 2, center: 0.4, inertia: 0.3}}
free: {bar: {angle: 0}}
"""

NINE_BAR = """
gravity: [9.81, 0]
joints: {O: [0, 0], D: [1.1, 0]}
bars:
  crank1: {joints: [O, A], length: 0.300, mass: 0.985}
  link2: {joints: [A, B], length: 0.893, mass: 2.836}
  link3: {joints: [C, B], length: 0.962, mass: 3.051}
  crank4: {joints: [D, C], length: 0.100, mass: 0.361}
  rocker6: {joints: [O, E], length: 0.850, mass: 2.701}
  link7: {joints: [E, B], length: 0.623, mass: 1.993}
  link8: {joints: [E, F], length: 0.850, mass: 2.701}
sliders: {slider9: {joint: F, through: O, mass: 4.288}}
clearances: {r1: {joint: C, bar: link3, size: 2 cm}}
drives: {crank1: {angle: 0.5, speed: -pi}, crank4: {angle: 1, speed: pi}}
loads: [{slider: slider9, force: -100}]
"""

PLATES = """
gravity: [2, -9]
joints: {O: [0, 0], C: [0.6, 0]}
bars:
  crank: {joints: [O, A], length: 0.13, mass: 0.4, center: [0.1, 0.06]}
  plate:
    points: {P: [0.1, 0.2], A: [0.01, 0.02], B: [0.45, 0]}
    mass: 1.4
    center: [0.2, 0.15]
    inertia: 0.05
  rocker: {joints: [B, C], length: 0.4, mass: 0.6}
  rod: {joints: [P, F], length: 0.7, mass: 0.3}
sliders: {slider: {joint: F, through: [-0.2, 0.4], angle: 40 deg, mass: 0.9}}
clearances: {r1: {joint: B, bar: plate, size: 1 cm}}
loads: [{slider: slider, force: 25}]
drives: {crank: {angle: 0.5, speed: 3}}
"""

MECHANISMS = {"nine-bar": NINE_BAR, "plates": PLATES}


def topology_of(text):
    return build_topology(from_document(parse(text, "test.yaml")))


def module_of(equations):
    module = {}
    exec(compile(render(equations, "python"), "equations.py", "exec"), module)
    return module


@pytest.fixture(scope="module", params=MECHANISMS)
def mechanism(request):
    """Topology, equations, printed module, and states (t, q, q̇, q̈, efforts) of the kernel."""
    topology = topology_of(MECHANISMS[request.param])
    equations = derive(topology)
    return topology, equations, module_of(equations), kernel_states(topology)


def kernel_states(topology, count=6):
    model = Model(topology)
    joined = {}
    for name, body in topology.mechanism.bodies.items():
        unit = model.positions.unit(name) if body.rotates else None
        joined[name] = (unit.y, unit.x) if unit else (model.positions.displacements[name],)
    names = list(joined)
    nodes = [node for nodes in joined.values() for node in nodes]
    nodes += [model.velocities.bodies[name] for name in names]
    nodes += [model.accelerations.bodies[name] for name in names]
    independent = (*topology.driven, *topology.free)
    nodes += [model.required_force(model.accelerations, model.partial(n)) for n in independent]
    evaluate = Evaluator(nodes)
    rng = np.random.default_rng(4)
    states = []
    for _ in range(count):
        free = len(topology.free)
        y, a = rng.uniform(-2, 2, 2 * free), rng.uniform(-9, 9, free)
        t = rng.uniform(0, 2, 1)
        values = iter(evaluate(t=t, y=y, a=a, p=np.array([*model.inputs.parameters.values()])))
        q = [
            np.arctan2(next(values), next(values)) if len(joined[name]) == 2 else next(values)
            for name in names
        ]
        dq, ddq = ([float(next(values)) for _ in names] for _ in range(2))
        states.append((t, np.array(q), np.array(dq), np.array(ddq), [*map(float, values)]))
    return states


def test_pendulum_by_hand():
    equations = derive(topology_of(PENDULUM))
    angle, rate = sp.symbols("theta_bar dtheta_bar", real=True)
    m, c, J, g = sp.symbols("m_bar c_bar J_bar g_y", real=True)
    kinetic = (J + m * c**2) * rate**2 / 2
    assert sp.simplify(equations.kinetic_energy - kinetic) == 0
    assert sp.simplify(equations.potential_energy + m * g * c * sp.sin(angle)) == 0
    reduced = equations.lagrange
    assert reduced.inertia[0, 0].value == reduced.masses[angle, angle].symbol
    assert sp.simplify(reduced.masses[angle, angle].value - (J + m * c**2)) == 0
    assert reduced.forces == (0,)


def test_slider_force_acts_on_the_displacement():
    equations = derive(topology_of(NINE_BAR))
    way = equations.symbols.coordinates["slider9"]
    assert equations.forces[way].name == "F_1"
    crank = equations.symbols.coordinates["crank1"]
    assert equations.forces[crank].name == "M_crank1"
    assert equations.lagrange.forces[2] == equations.forces[way] * sp.Symbol(
        "K_slider9_3", real=True
    )


def test_mass_matrix_is_the_hessian_of_kinetic_energy(mechanism):
    _, equations, module, states = mechanism
    rates = list(equations.symbols.rates.values())
    hessian = sp.hessian(equations.kinetic_energy, rates)
    values = equations.symbols.values
    arguments = (equations.coordinates, list(values))
    evaluate = sp.lambdify(arguments, hessian, cse=True)
    for _, q, *_ in states:
        expected = evaluate(q, list(values.values()))
        np.testing.assert_allclose(module["mass_matrix"](q), expected, rtol=1e-12, atol=1e-15)


def test_velocity_coefficients_keep_the_loops_closed(mechanism):
    _, _, module, states = mechanism
    for _, q, dq, *_ in states:
        coefficients = module["velocity_coefficients"](q)
        slip = module["closure_jacobian"](q) @ coefficients
        np.testing.assert_allclose(slip, 0.0, atol=1e-13 * (1 + np.abs(coefficients).max()))
        independent = [module["COORDINATES"].index(name) for name in module["GENERALISED"]]
        np.testing.assert_allclose(coefficients @ dq[independent], dq, rtol=1e-11, atol=1e-11)


def test_reduced_energy_is_the_kinetic_energy(mechanism):
    _, _, module, states = mechanism
    for _, q, dq, *_ in states:
        rates = dq[[module["COORDINATES"].index(name) for name in module["GENERALISED"]]]
        energy = 0.5 * rates @ module["inertia"](q) @ rates
        assert energy == pytest.approx(module["kinetic_energy"](q, dq), rel=1e-11)


def test_printed_inertia_terms_are_those_of_the_module(mechanism):
    _, equations, module, states = mechanism
    reduced = equations.lagrange
    known = {d.symbol: d.value for d in reduced.masses.values()}
    known |= {d.symbol: d.value for block in reversed(reduced.blocks) for d in block}
    values = equations.symbols.values
    for _, q, *_ in states[:2]:
        numbers = values | dict(zip(equations.coordinates, q, strict=True))
        for block in reduced.blocks:
            numbers |= {d.symbol: float(d.value.subs(numbers)) for d in block}
        numbers |= {d.symbol: float(d.value.subs(numbers)) for d in reduced.masses.values()}
        inertia = module["inertia"](q)
        for (i, j), definition in reduced.inertia.items():
            assert float(definition.value.subs(numbers)) == pytest.approx(inertia[i, j], rel=1e-10)


def test_papers_form_gives_the_kernels_efforts(mechanism):
    """Eq. 4: Σ J_ij q̈_j + Σ (∂J_ij/∂q_k − ½ ∂J_jk/∂q_i) q̇_j q̇_k + ∂V/∂q_i − Q_i."""
    _, equations, module, states = mechanism
    step = 1e-4  # fourth-order differences: 1e-16 of truncation, 1e-12 of rounding
    independent = [module["COORDINATES"].index(name) for name in module["GENERALISED"]]
    no_efforts = np.zeros(len(equations.efforts))
    for _, q, dq, ddq, efforts in states:
        coefficients = module["velocity_coefficients"](q)
        inertia = module["inertia"]
        slopes = np.array(
            [
                8 * (inertia(q + step * k) - inertia(q - step * k))
                - (inertia(q + 2 * step * k) - inertia(q - 2 * step * k))
                for k in coefficients.T
            ]
        ) / (12 * step)
        rates = dq[independent]
        rows = np.stack(
            [
                inertia(q) @ ddq[independent],
                np.einsum("kij,j,k->i", slopes, rates, rates),
                -0.5 * np.einsum("ijk,j,k->i", slopes, rates, rates),
                coefficients.T @ module["potential_gradient"](q),
                -coefficients.T @ module["generalised_forces"](no_efforts),
            ]
        )
        error = np.abs(rows.sum(axis=0) - efforts) / np.abs(rows).max(axis=0)
        assert error.max() < 1e-8
