"""Laws of loads that depend on quantities of the mechanism, by roads that share nothing with them.

Lagrange's equations derived with SymPy, the formulation in absolute coordinates (with the joint
reactions), potentials whose gradient a force is, and the entries for which formulas can stand in.
"""

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from kernel_values import assert_motion_agrees
from lagrange_equations import assert_satisfies_lagrange
from shared_definitions import ENGINE

import linkages
from linkages.kernel.system import System

RUN = {"rtol": 1e-12, "atol": 1e-14, "outputs": "all"}
CLOSE = 1e-10
"""Of integration at a tolerance of 1e-12 over some hundred steps."""


LINKAGE = """
name: linkage
gravity: [1, -9.81]
joints: {O: [0, 0], C: [1, 0.2]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  rod: {joints: [A, B], length: 0.9, mass: 1}
  rocker: {joints: [C, B], length: 0.7, mass: 1}
  tail: {joints: [B, T], length: 0.4, mass: 0.6}
sliders: {bead: {joint: W, on: rocker, angle: 0.2, mass: 0.5}}
free:
  crank: {angle: 0.8, speed: 1.5}
  tail: {angle: 0.3, speed: -2}
  bead: {position: 0.2, speed: 0.7}
assembly: {B: left}
simulate: {end: 0.3, samples: 4}
"""

TABLE = (
    "{table: {over: OVER, at: [0, 90 deg, 200 deg, 360 deg], values: [0, 3, -2, 0], periodic: true"
)
LAWS = {
    "another slider": "{slider: bead, force: '-3*tanh(rod.speed) + 2*crank.angle'}",
    "coordinates": "{joint: T, force: ['2*W.x - T.vy', '-0.3*W.vx*B.y']}",
    "angle between": "{bar: tail, torque: '-0.7*angle(crank, tail)'}",
    "its rate": "{bars: [rod, tail], torque: '-0.2*rate(angle(rocker, rod))'}",
    "distance": "{joint: B, force: ['-4*(distance(A, T) - 0.5)', 0]}",
    "rate of a distance": "{slider: bead, force: '-0.6*rate(distance(O, T))*t'}",
    "own spring": "{slider: bead, force: '-30*(bead.position - 0.1) - 2*bead.velocity'}",
    "gas": f"{{bar: tail, torque: {TABLE.replace('OVER', 'rocker.angle')}}}}}}}",
    "spline": f"{{slider: bead, force: {TABLE.replace('OVER', 'tail.angle')}, "
    "interpolation: spline}}}",
    "straight lines": f"{{joint: T, force: [{TABLE.replace('OVER', 'tail.angle - 10 deg')}, "
    "interpolation: linear}}, 0]}",
    "dry friction": "{bar: rocker, torque: '-0.4*sign(tail.speed)'}",
    "branches": "{slider: bead, force: 'where(T.x < 0.6, 3, max(T.y, 1 + t)) + abs(W.vy)'}",
    "functions": "{joint: W, force: [0, 'atan2(T.y, T.x) + asin(0.1*T.x) + acos(0.1*W.y)']}",
    "between joints": "{between: [O, T], force: '5*cos(crank.angle)*distance(T, O)'}",
}


def engine(text):
    return linkages.loads(ENGINE + text)


def linkage(*names):
    return linkages.loads(LINKAGE + f"loads: [{', '.join(LAWS[name] for name in names)}]")


def column(data, variable, **where):
    return data[variable].sel(where).to_numpy()


@pytest.mark.slow_except("coordinates", "spline")
@pytest.mark.parametrize("name", LAWS)
def test_lagrange_equations_agree(name):
    assert_satisfies_lagrange(linkage(name), count=8, least=4)


@pytest.mark.slow
def test_absolute_formulation_agrees():
    """Motion, efforts and joint reactions with all of them together, and the balance of energy."""
    mechanism = linkage(*LAWS)
    data = linkages.simulate(mechanism, rtol=1e-11, outputs="all").data
    assert_motion_agrees(AbsoluteModel(mechanism), data, 1e-11, 1e-9)  # as for random mechanisms


@pytest.mark.parametrize(
    ("formula", "entry"),
    [
        (
            "loads: [{between: [O, T], force: '-400 N/m*(distance(O, T) - 30 cm)"
            " - 7 N*s/m*rate(distance(T, O))'}]",
            "springs: [{between: [O, T], stiffness: 400, length: 0.3, damping: 7}]",
        ),
        (
            "loads: [{slider: bead, force: '-7*bead.speed'}]",
            "dampers: [{slider: bead, damping: 7}]",
        ),
        (
            "loads: [{bar: tail, torque: '-5*(tail.angle - 0.4) - 0.3*tail.speed'}]",
            "springs: [{bar: tail, stiffness: 5, angle: 0.4, damping: 0.3}]",
        ),
        (
            "loads: [{bars: [rocker, tail], torque: '-5*angle(rocker, tail)'}]",
            "springs: [{between_bars: [rocker, tail], stiffness: 5}]",
        ),
        (
            "springs: [{between: [O, T], stiffness: '400 + 0*t', length: 0.3}]",
            "springs: [{between: [O, T], stiffness: 400, length: 0.3}]",
        ),
    ],
)
def test_a_formula_is_the_entry_that_it_writes_out(formula, entry):
    """Accelerations and, where the law is a polynomial of its own measure, the stored energy."""
    written, given = (System(linkages.loads(LINKAGE + text)) for text in (formula, entry))
    random = np.random.default_rng(5).standard_normal((len(given.state), 5))
    states = given.state[:, None] + 0.3 * random
    times = np.full(5, 0.3)
    for nodes in (
        lambda model: model.integrated_accelerations(model.changes),
        lambda model: [model.potential_energy] if "0*t" not in formula else [],
    ):
        found, expected = (s.evaluate(nodes(s.model), times, states) for s in (written, given))
        # operations are the same ones in another order
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_a_force_that_is_a_gradient_keeps_energy():
    """V = k x_T y_W: the forces −∂V/∂x at T and −∂V/∂y at W, each of the other's coordinate."""
    both = "loads: [{joint: T, force: ['-8*W.y', 0]}, {joint: W, force: [0, '-8*T.x']}]"
    data = linkages.simulate(linkages.loads(LINKAGE + both), end=2, samples=41, **RUN).data
    x, y = (column(data, "joint_position", joint=j, axis=a) for j, a in (("T", "x"), ("W", "y")))
    total = column(data, "kinetic_energy") + column(data, "potential_energy") + 8 * x * y
    scale = np.abs(column(data, "kinetic_energy")).max()
    assert np.abs(total - total[0]).max() < CLOSE * scale
    assert np.ptp(8 * x * y) > 0.1 * scale  # it does exchange energy
    one = "loads: [{joint: T, force: ['-8*W.y', 0]}]"
    data = linkages.simulate(linkages.loads(LINKAGE + one), end=2, samples=41, **RUN).data
    other = column(data, "kinetic_energy") + column(data, "potential_energy")
    assert np.ptp(other) > 0.01 * scale  # a half of it is no gradient


def test_a_gas_spring_follows_its_adiabat():
    """p V^κ = const: V(x) = p₀ V₀/(κ − 1) (V₀/V)^(κ − 1), with V = A (h − x)."""
    ambient = 1e5 * 1.2e-3
    force = f"exp(1.4*log(0.11/(0.26 - piston.position)))*(-3e5*1.2e-3) + {ambient}"
    data = linkages.simulate(engine(f"loads: [{{slider: piston, force: {force!r}}}]"), **RUN).data
    x = column(data, "slider_position", slider="piston")
    gap = 0.26 - x
    stored = 3e5 * 1.2e-3 * 0.11 / 0.4 * (0.11 / gap) ** 0.4 - ambient * x
    total = column(data, "kinetic_energy") + stored
    assert np.abs(total - total[0]).max() < CLOSE * np.ptp(stored)
    found = column(data, "load_force", force="loads[0]")
    assert found == pytest.approx(ambient - 3e5 * 1.2e-3 * (0.11 / gap) ** 1.4, rel=1e-12)


def test_over_a_driven_angle_it_is_a_law_of_time():
    driven = ENGINE.replace("free:", "drives:")
    sensed = "loads: [{slider: piston, force: '40*cos(3*crank.angle) + crank.speed'}]"
    timed = "loads: [{slider: piston, force: '40*cos(3*(10*pi/180 + 30*t)) + 30'}]"
    one, other = (
        linkages.simulate(linkages.loads(driven + t), **RUN).data for t in (sensed, timed)
    )
    for name in ("drive_effort", "joint_reaction", "load_force"):
        scale = float(np.abs(other[name]).max())
        assert float(np.abs(one[name] - other[name]).max()) < 1e-13 * scale
    assert float(np.abs(one.energy_residual).max()) < 1e-12


def test_a_table_over_an_angle_is_the_formula_that_it_tabulates():
    """A spline through 361 values of a sine is off by h⁴/384 and less at its fourth derivative."""
    angles = np.linspace(0, 360, 361)
    values = 50 * np.sin(np.radians(angles))
    values[-1] = values[0]
    at, listed = ([f"{angle:g} deg" for angle in angles], values.tolist())
    text = (
        f"{{over: crank.angle, at: {at}, values: {listed}, periodic: true, interpolation: spline}}"
    )
    table = engine(f"loads: [{{slider: piston, force: {{table: {text}}}}}]".replace("'", ""))
    formula = engine("loads: [{slider: piston, force: '50*sin(crank.angle)'}]")
    one, other = (linkages.simulate(m, **RUN).data for m in (table, formula))
    speed = column(other, "bar_speed", bar="crank")
    assert np.ptp(column(other, "bar_angle", bar="crank")) > 2 * np.pi  # more than a turn
    bound = 50 * np.radians(1) ** 4 / 384
    force = column(one, "load_force", force="loads[0]")
    angle = column(one, "bar_angle", bar="crank")
    assert np.abs(force - 50 * np.sin(angle)).max() < 1.01 * bound
    # accelerations are off by less than 10 × this force's part of 50 N, over 0.4 s
    assert np.abs(column(one, "bar_speed", bar="crank") - speed).max() < 1e3 * bound


def test_a_jump_is_located_to_round_off():
    """A block under where(x < 1, 3, −5): v² = 6 x, then 6 − 10 (x − 1), in closed form."""
    text = """
name: block
joints: {O: [0, 0]}
bars: {rod: {joints: [B, C], length: 1, inertia: 1}}
sliders: {block: {joint: B, through: O, mass: 2}}
free: {block: {position: 0, speed: 0}, rod: {angle: 0, speed: 0}}
loads: [{slider: block, force: "where(block.position < 1 m, 6 N, -10 N)"}]
simulate: {end: 1.3, samples: 14}
"""
    for method in ("dop853", "tsit5", "vern9"):
        solution = linkages.simulate(linkages.loads(text), method=method, rtol=1e-6, outputs="all")
        time, crossed = solution.data.time.to_numpy(), np.sqrt(2 / 3)
        late = time - crossed
        exact = np.where(late < 0, 1.5 * time**2, 1 + 3 * crossed * late - 2.5 * late**2)
        # these methods have no error for polynomials of degree two; what is left is that of the
        # located time, and of the many terms of an interpolant
        assert column(solution.data, "slider_position", slider="block") == pytest.approx(
            exact, abs=1e-11
        )
        assert float(np.abs(solution.data.energy_residual).max()) < 1e-10  # of samples, 10 N
