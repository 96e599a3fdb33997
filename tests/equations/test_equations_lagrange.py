"""Energies against textbook results; the reduced equations against T, V and the kernel."""

import numpy as np
import pytest
import sympy as sp
from lagrange_mechanisms import MORE_MECHANISMS
from printed_modules import GeneratedProgram, topology_of
from shared_definitions import loaded_engine

from linkages.equations import derive

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

# offsets of random states are large beside the size: most of them press, some of them pull
OPENS = loaded_engine("""\
clearances:
  gap: {joint: A, bar: rod, size: 5 mm, contact: hunt-crossley-constant, stiffness: 2e3 N/m^1.5,
        dissipation: 1.5 s/m, carries: pin, pin_radius: 8 mm, friction: 0.3, slip: 1 m/s}
  end: {joint: B, bar: rod, size: 1 mm, contact: kelvin-voigt, stiffness: 900 N/m,
        damping: 20 N*s/m, pin_radius: 6 mm, friction_law: bengisu-akay, friction: 0.2,
        static: 0.4, slip: 0.5 m/s, stribeck_speed: 2 m/s}
drives: {crank: {angle: 0.3, speed: 20}}
""")

# a guide on the ground, and one on a bar whose angle follows; blocks start pressed in
GUIDES = """
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.25, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 0.8, center: 0.01}
  lever: {joints: [D, E], length: 0.6, mass: 0.5}
  rod: {joints: [E, F], length: 0.5, mass: 0.3}
sliders:
  block: {joint: A, on: lever, angle: 0, mass: 0.4, inertia: 3e-4}
  ram: {joint: F, through: [0, 0.4], angle: 20 deg, mass: 0.7, inertia: 1e-3,
        points: {T: [0.1, 0.02]}}
clearances:
  inner: {slider: block, size: 1 mm, length: 60 mm, height: 40 mm, contact: kelvin-voigt,
          stiffness: 900 N/m, damping: 20 N*s/m, friction: 0.2, slip: 1 m/s,
          offset: 0.8 mm, angle: 1 deg, speed: 3}
  outer: {slider: ram, size: 2 mm, length: 80 mm, height: 50 mm, contact: hunt-crossley-constant,
          stiffness: 2e4 N/m^1.5, dissipation: 1.5 s/m, offset: -1 mm, angle: -2 deg, rate: 0.1}
masses: {T: 0.2}
drives: {crank: {angle: 2, speed: 20}}
loads: [{slider: ram, force: -200}]
assembly: {A: [-0.04, 0.09], F: [-0.6, 0.2], E: [-0.25, 0.2]}
"""

# as large as to hold the offsets of random states
FILMS = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}
  rod: {joints: [A, B], length: 0.14, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
clearances:
  gap: {joint: A, bar: rod, size: 4 m, contact: lubricated, viscosity: 1.3 Pa*s, width: 2 m,
        carries: pin, pin_radius: 3 m}
  end: {joint: B, bar: rod, size: 3 m, contact: lubricated-full, viscosity: 0.7, width: 1 m,
        pin_radius: 2 m}
free: {crank: {angle: 0.3, speed: 20}}
assembly: {B: [0.18, 0]}
"""

# a floor that a lever carries, and a drum on it; both are pressed in, and rub
WALLS = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  lever: {points: {O: [0, 0], W: [0.1, 0.02], C: [0.5, 0.3]}, mass: 1, center: [0.2, 0.1],
          inertia: 0.1}
  rod: {joints: [P, R], length: 0.2, mass: 0.4}
sliders:
  across: {joint: X, through: O, angle: 0}
  up: {joint: P, through: X, on: across, angle: 90 deg, mass: 0.3}
contacts:
  floor: {body: rod, points: [P], radius: 0.6, wall: lever, through: W, angle: 10 deg, size: 2,
          contact: kelvin-voigt, stiffness: 900 N/m, damping: 20, friction: 0.3, slip: 1 m/s}
  drum: {body: rod, points: [R], radius: 0.05, wall: lever, through: C, circle: 0.2, inside: true,
         size: 5, contact: hunt-crossley-constant, stiffness: 2e3, dissipation: 1.5, friction: 0.2,
         slip: 1 m/s}
  post: {body: rod, points: [R], radius: 0.5, through: O, circle: 0.2, size: 5, contact: hertz,
         stiffness: 2e3}
free: {lever: {angle: 0.1, speed: 1}, across: {position: 0.2}, up: {position: 0.2},
       rod: {angle: 0.3, speed: -2}}
"""

# a flat valve with friction, and a roller, pressed on two cams of which one is turned by a gear
CAMS = """
gravity: [0, -9.81]
joints: {O: [0, 0], Q: [0.3, 0]}
bars:
  cam: {points: {O: [0, 0], P: [0.02, 0]}, mass: 1, center: [0.01, 0], inertia: 0.01}
  wheel: {joints: [Q, R], length: 0.02, mass: 1}
gears: [{bars: [cam, wheel], ratio: -2}]
sliders:
  valve: {joint: V, through: O, angle: 60 deg, mass: 0.5}
  other: {joint: W, through: Q, angle: 30 deg, mass: 0.2}
cams:
  - {slider: valve, bar: cam, angles: [0, 2, 4, 360 deg], lifts: [0, 20 mm, 10 mm, 0],
     base_radius: 90 mm, offset: 400 mm, flat: true, contact: kelvin-voigt, stiffness: 900 N/m,
     damping: 20, friction: 0.3, slip: 1 m/s, size: 5}
  - {slider: other, bar: wheel, angles: [0, 1, 3], lifts: [0, 8 mm, 0], base_radius: 30 mm,
     offset: 900 mm, roller_radius: 10 mm, contact: hunt-crossley-constant, stiffness: 2e3,
     dissipation: 1.5, size: 5}
free: {cam: {angle: 0.3, speed: 3}, valve: {position: 0.2}, other: {position: 0.1, speed: 1}}
"""

KINDS = ("class-three", "parallelogram-free", "planetary", "floating-guides", "scotch-yoke")
MECHANISMS = {
    "nine-bar": NINE_BAR,
    "plates": PLATES,
    "opens": OPENS,
    "films": FILMS,
    "guides": GUIDES,
    "walls": WALLS,
    "cams": CAMS,
    **{kind: MORE_MECHANISMS[kind] for kind in KINDS},
}


@pytest.fixture(scope="module", params=MECHANISMS)
def printed(request):
    return GeneratedProgram(topology_of(MECHANISMS[request.param]), count=6)


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


@pytest.mark.slow_except("opens", "films", "walls", "cams", "scotch-yoke")
def test_mass_matrix_is_the_hessian_of_kinetic_energy(printed):
    equations = printed.equations
    rates = list(equations.symbols.rates.values())
    hessian = sp.hessian(equations.kinetic_energy, rates)
    values = equations.symbols.values
    evaluate = sp.lambdify((equations.coordinates, list(values)), hessian, cse=True)
    for state in printed.states:
        q = printed.of(state.position)
        expected = evaluate(q, list(values.values()))
        found = printed.module["mass_matrix"](q)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)


@pytest.mark.slow_except("opens", "films", "walls", "cams", "scotch-yoke")
def test_rates_are_velocity_coefficients_times_those_that_are_known(printed):
    for state in printed.states:
        p = printed.parameters(state)
        coefficients = printed.module["velocity_coefficients"](printed.of(state.position), p)
        known = [state.rate[name] for name in printed.generalised]
        allowed = 1e-11 * (1 + np.abs(coefficients).max())
        np.testing.assert_allclose(coefficients @ known, printed.of(state.rate), atol=allowed)


@pytest.mark.slow_except("opens", "films", "walls", "cams", "scotch-yoke")
def test_printed_inertia_terms_are_those_of_the_module(printed):
    equations, reduced = printed.equations, printed.equations.lagrange
    for state in printed.states[:2]:
        q = printed.of(state.position)
        numbers = equations.symbols.values | dict(zip(equations.coordinates, q, strict=True))
        for block in reduced.blocks:
            if block.system is not None:
                numbers |= solved(block.system, numbers)
            numbers |= {d.symbol: float(d.value.subs(numbers)) for d in block.definitions}
        numbers |= {d.symbol: float(d.value.subs(numbers)) for d in reduced.masses.values()}
        inertia = printed.module["inertia"](q)
        for (i, j), definition in reduced.inertia.items():
            value = float(definition.value.subs(numbers))
            assert value == pytest.approx(inertia[i, j], rel=1e-10, abs=1e-12)


def solved(system, numbers):
    """Coefficients that the printed linear system defines."""
    matrix, right = (
        np.array(part.subs(numbers).evalf(), dtype=float) for part in (system.matrix, system.right)
    )
    values = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return dict(zip(system.coefficients, map(float, values.ravel()), strict=True))


@pytest.mark.slow_except("opens", "films", "walls", "cams", "scotch-yoke")
def test_papers_form_gives_the_kernels_efforts(printed):
    """Eq. 4: Σ J_ij q̈_j + Σ (∂J_ij/∂q_k − ½ ∂J_jk/∂q_i) q̇_j q̇_k + ∂V/∂q_i − Q_i."""
    module = printed.module
    step = 1e-4  # fourth-order differences: 1e-16 of truncation, 1e-12 of rounding
    no_efforts = np.zeros(len(printed.equations.efforts))
    for state in printed.states:
        q, dq, p = printed.of(state.position), printed.of(state.rate), printed.parameters(state)
        coefficients = module["velocity_coefficients"](q, p)

        def inertia(place, p=p):
            return module["inertia"](place, p)

        # Steps along a tangent open the loops by terms even in the step, which differences cancel.
        slopes = np.array(
            [
                8 * (inertia(q + step * k) - inertia(q - step * k))
                - (inertia(q + 2 * step * k) - inertia(q - 2 * step * k))
                for k in coefficients.T
            ]
        ) / (12 * step)
        rates = np.array([state.rate[name] for name in printed.generalised])
        accelerations = np.array([state.acceleration[name] for name in printed.generalised])
        acting = module["generalised_forces"](state.time, q, dq, no_efforts, p)
        rows = np.stack(
            [
                inertia(q) @ accelerations,
                np.einsum("kij,j,k->i", slopes, rates, rates),
                -0.5 * np.einsum("ijk,j,k->i", slopes, rates, rates),
                coefficients.T @ module["potential_gradient"](q, p),
                -coefficients.T @ acting,
            ]
        )
        error = np.abs(rows.sum(axis=0) - printed.row(state, "effort"))
        assert (error / np.abs(rows).max(axis=0)).max() < 1e-8
