"""Laws of state within the whole program: derivatives, sensitivities, sweeps, reports, stops."""

import numpy as np
import pytest
from scipy.optimize import brentq
from shared_definitions import ENGINE

import linkages
from linkages.chaos.volume_contraction import Volumes
from linkages.cli.verbs.contribution_rows import loads
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.plots.mechanism.roles import BOTH, load_sense

GAS = "{table: {over: crank.angle, at: [0, 180 deg, 360 deg], values: [0, -90, 0], periodic: true}}"


def engine(force, more=""):
    law = force if force.startswith("{") else repr(force)
    return linkages.loads(f"{ENGINE}loads: [{{slider: piston, force: {law}}}]\n{more}")


def shipped(name):
    """A shipped mechanism with a load that depends on other quantities than it acts along."""
    plain = linkages.load(name)
    turning = [body for body, entry in plain.bodies.items() if entry.kind == "bar"]
    sliders = [body for body, entry in plain.bodies.items() if entry.kind == "slider"]
    joint = next(j for b in turning for j in plain.bodies[b].points if j not in plain.ground)
    law = f"-0.3*{turning[-1]}.speed*(1 + {joint}.x**2) + 0.2*{joint}.vy*sin({turning[0]}.angle)"
    if sliders:
        law += f" - 0.1*{sliders[0]}.velocity"
    entry = {"bar": turning[0], "torque": law}
    count = len(plain.definition.content.get("loads") or [])
    return plain.with_values({f"loads[{count}]" if count else "loads": entry if count else [entry]})


@pytest.mark.parametrize("name", ["pendulum", "double-pendulum", "five-bar-free", "ninebar"])
def test_the_jacobian_is_that_of_differences(name):
    rhs = linkages.compile(shipped(name))
    time, state = 0.01, rhs.state + 0.02
    step = 1e-6  # central: truncation 1e-12 of third derivatives, round-off 1e-10 of the values
    ahead, behind = (
        rhs.batch(time, state[:, None] + sign * step * np.eye(len(state))) for sign in (1, -1)
    )
    found = rhs.jacobian(time, state)
    size = abs(rhs(time, state)).max() + abs(found).max()
    assert abs(found - (ahead - behind) / (2 * step)).max() < 1e-7 * size


@pytest.mark.slow
def test_tangents_go_along_a_table_over_an_angle():
    """Tangents of the variational equations are differences of motions, to second order."""
    mechanism = engine(GAS.replace("true", "true, interpolation: spline"))
    at = {name: (np.radians(10) + h, 30.0) for name, h in (("less", -1e-5), ("more", 1e-5))}
    options = {"end": 0.3, "samples": 2, "rtol": 1e-12, "atol": 1e-14}
    ends = [
        linkages.simulate(mechanism.with_state({"crank": start}), **options).data.isel(time=-1)
        for start in at.values()
    ]
    difference = [
        float((more - less) / 2e-5)
        for less, more in ((e[0][n][0], e[1][n][0]) for e in [ends] for n in PAIR)
    ]
    propagator = linkages.compile(mechanism)
    time = np.linspace(0.0, 0.3, 3001)
    motion = linkages.simulate(mechanism, end=0.3, samples=3001, rtol=1e-12, atol=1e-14).data
    states = np.stack([motion[n][:, 0].to_numpy() for n in PAIR])
    tangent = np.array([1.0, 0.0])
    for k in range(0, 3000, 2):  # Runge and Kutta's method, with the states in between
        h = time[k + 2] - time[k]
        a, b, c = (propagator.jacobian(time[i], states[:, i]) for i in (k, k + 1, k + 2))
        one = a @ tangent
        two = b @ (tangent + h / 2 * one)
        three = b @ (tangent + h / 2 * two)
        tangent = tangent + h / 6 * (one + 2 * two + 2 * three + c @ (tangent + h * three))
    assert tangent == pytest.approx(difference, rel=1e-5)


PAIR = ("bar_angle", "bar_speed")


def test_a_sweep_binds_numbers_of_a_law_with_modes():
    mechanism = engine("where(piston.position > 0.15, -20, 5) - 3*abs(piston.velocity)")
    varying = Varying(mechanism)
    points = [{"bars.rod.length": length} for length in (0.15, 0.17)]
    along = varying.along(points)
    assert along.columns[1] is not None  # bound, not built anew
    for index, point in enumerate(points):
        bound, built = along.system(index), System(mechanism.with_values(point))
        assert np.array_equal(bound.numbers, built.numbers)
        nodes = [s.model.free_accelerations for s in (bound, built)]
        assert bound.evaluate(nodes[0]) == pytest.approx(built.evaluate(nodes[1]), rel=1e-14)


def test_a_sweep_checks_units_of_formulas():
    """Structure alone does not tell a force from a stiffness."""
    varying = Varying(engine("-20 N*s/m*piston.velocity"))
    known = varying.at({"loads[0].force": "-30 N*s/m*piston.velocity"})
    assert 30.0 in known.numbers  # and its sign is structure
    with pytest.raises(linkages.InputError, match="it is a power"):
        varying.at({"loads[0].force": "-30 N*piston.velocity"})


def test_formulas_with_other_numbers_share_their_kernel():
    one, other = (
        System(engine(f"{k}*(piston.position - {x})*cos(crank.angle)"))
        for k, x in (("-30 N/m", "10 cm"), ("-0.02 kN/m", "1 cm"))
    )
    assert one.structure is other.structure
    values = [s.evaluate(s.model.free_accelerations)[0, 0] for s in (one, other)]
    assert values[0] != pytest.approx(values[1], rel=1e-3)


@pytest.mark.parametrize(
    ("force", "dampers", "expected"),
    [
        (GAS, "", [("force", "piston, along its axis", "-90 to 0 N over crank.angle")]),
        (
            "-3*piston.velocity + t",
            "",
            [("force", "piston, along its axis", "a law of piston.velocity and t")],
        ),
        (
            "5",
            "dampers: [{joint: B, damping: '0.1*(1 + crank.angle**2)'}]",
            [
                ("force", "piston, along its axis", "5 N"),
                ("torsional damper", "rod", "a law of v and crank.angle"),
            ],
        ),
    ],
)
def test_reports_in_words(force, dampers, expected):
    found = loads(engine(force, dampers))
    assert [(row["kind"], row["on"], row["value"]) for row in found] == expected


def test_the_sense_of_an_arrow():
    assert load_sense(engine(GAS).loads[0], engine(GAS)) == -1
    assert load_sense(engine("-3*piston.velocity").loads[0], engine("1")) == BOTH


@pytest.mark.parametrize("moved", ["free", "drives"])
def test_a_law_without_a_value_is_named(moved):
    text = f"{ENGINE.replace('free', moved)}loads: [{{slider: piston, force: FORCE}}]"
    rated = text.replace("FORCE", "sqrt(piston.velocity)")
    with pytest.raises(linkages.InputError, match=r"loads\[0\]: cannot act at t = 0 s: it has no"):
        System(linkages.loads(rated))
    later = text.replace("FORCE", "0.01*sqrt(piston.position - 0.18)")
    with pytest.raises(linkages.IncompleteError, match=r"loads\[0\]"):
        linkages.simulate(linkages.loads(later))


def test_degrees_that_were_meant_are_asked_for():
    found = engine(GAS.replace(" deg", ""))
    notes = linkages.simulate(found, end=0.01, samples=2).notes
    assert any(
        "loads[0].force.table repeats every 360 rad, which is no whole number" in n for n in notes
    )
    notes = linkages.simulate(engine(GAS), end=0.01, samples=2).notes
    assert not any("repeats every" in n for n in notes)


TWO = """
joints: {O: [0, 0]}
bars: {upper: {joints: [O, A], length: 0.3, mass: 1}, lower: {joints: [A, B], length: 0.2, mass: 1}}
free: {upper: {angle: 1, speed: 0}, lower: {angle: 0, speed: 1}}
"""


@pytest.mark.parametrize(
    ("torque", "conservative", "potential"),
    [
        ("3*upper.angle", True, True),
        ("3*lower.angle", True, False),  # a spring on one side of a see-saw
        ("3*sin(t)", True, True),
        ("0.1*lower.speed", False, False),
        ("0.1*sign(upper.speed)", False, True),
        ("where(lower.angle > 0, 1, 2)", True, False),
    ],
)
def test_what_is_known_of_exponents_beforehand(torque, conservative, potential):
    """Forces that are no gradient part pairs of exponents; a jump at a speed changes volumes."""
    volumes = Volumes(System(linkages.loads(f"{TWO}loads: [{{bar: upper, torque: '{torque}'}}]")))
    assert (volumes.conservative, volumes.potential) == (conservative, potential)
    assert volumes.told == ("sign" not in torque)


def test_of_one_coordinate_any_force_is_a_gradient():
    assert Volumes(System(engine("3*crank.angle"))).potential


ARM = """
joints: {O: [0, 0]}
gravity: [0, -9.81]
bars: {arm: {joints: [O, A], length: 0.5, mass: 2}}
free: {arm: {angle: -90 deg, speed: 0}}
motors:
  servo:
    bar: arm
    voltage: "max(-24 V, min(24 V, 600 V*(0.5 - arm.angle) - 20 V*s*arm.speed))"
    torque_constant: 50 N mm/A
    resistance: 0.8 ohm
    gear_ratio: 60
"""


def test_a_motor_with_a_controller_holds_a_load():
    """At rest n k U/R balances the weight: m g L/2 cos θ = n k·600 V·(0.5 − θ)/R."""
    mechanism = linkages.loads(ARM)
    solution = linkages.simulate(mechanism, end=3, samples=31, outputs="all")

    def left_over(angle):
        return 60 * 0.05 / 0.8 * 600 * (0.5 - angle) - 2 * 9.81 * 0.25 * np.cos(angle)

    found = float(solution.data.bar_angle[-1, 0])
    assert found == pytest.approx(brentq(left_over, 0, 0.5), abs=1e-8)  # settles within 0.1 s
    assert len(solution.system.model.switches.switches) == 2
    (row,) = loads(mechanism)
    assert "voltage a law of arm.angle and arm.speed, torque constant" in row["value"]


LINES = "at: [0, 90 deg, 180 deg, 360 deg], values: [-9, -5, 0, -9], periodic: true"


@pytest.mark.parametrize("angle", ["30 deg", "0", "180 deg"])
def test_a_linear_table_of_an_odd_number_of_lines_repeats_with_the_turn(angle):
    """Energy: what the torque has done follows from the angle, as the area under the lines."""
    mechanism = linkages.loads(f"""
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, A], length: 300 mm, mass: 1}}}}
loads: [{{bar: arm, torque: {{table: {{over: arm.angle, {LINES}, interpolation: linear}}}}}}]
free: {{arm: {{angle: {angle}, speed: 60}}}}
simulate: {{end: 2, samples: 201, rtol: 1e-11}}
""")
    data = linkages.simulate(mechanism).data
    turned, speed = (data[name][:, 0].to_numpy() for name in ("bar_angle", "bar_speed"))
    assert np.ptp(turned) > 6 * np.pi
    grid = np.radians([0, 90, 180, 360])
    areas = np.array([0.0, -7.0, -9.5, -18.5]) * np.pi / 2  # up to each of these places
    torques = np.array([-9.0, -5.0, 0.0, -9.0])

    def done(angle):
        turns, within = np.divmod(angle, 2 * np.pi)
        place = np.clip(np.searchsorted(grid, within, side="right") - 1, 0, 2)
        mean = (torques[place] + np.interp(within, grid, torques)) / 2
        return turns * areas[-1] + areas[place] + (within - grid[place]) * mean

    kinetic = 0.03 * speed**2 / 2
    # a hundred times the tolerance of the speed
    assert kinetic - kinetic[0] == pytest.approx(done(turned) - done(turned[0]), abs=1e-7)


def test_a_point_on_a_line_of_a_table_changes_nothing():
    table = "{{table: {{over: crank.angle, {}, periodic: true, interpolation: linear}}}}"
    three, four = (
        linkages.simulate(engine(table.format(points)), end=2.0, rtol=1e-11).data.slider_position
        for points in (
            "at: [0, 90 deg, 180 deg, 360 deg], values: [-9, -5, 0, -9]",
            "at: [0, 90 deg, 180 deg, 240 deg, 360 deg], values: [-9, -5, 0, -3, -9]",
        )
    )
    assert three.to_numpy() == pytest.approx(four.to_numpy(), abs=1e-9)
