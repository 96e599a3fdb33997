"""Integrals, windows and harmonics in measures, against closed forms, SciPy and other samples.

Tolerances of 1e-9 are what the adaptive rule allows, as a part of the mean magnitude; those of
1e-12 are round-off of smooth integrands.
"""

import math

import numpy as np
import pytest
from scipy.integrate import quad

import linkages
from linkages.errors import ComputationError
from linkages.solution.measuring import FormulaSeries, doubts

PRESS = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 300 mm, mass: 5}
  rod: {joints: [A, B], length: 900 mm, mass: 3}
sliders: {piston: {joint: B, through: O, mass: 2}}
drives: {crank: {angle: %s, speed: 60 rpm}}
assembly: {B: [1.2, 0]}
loads: [{slider: piston, force: "where(piston.velocity < 0 m/s, 2 kN, 0 N)"}]
targets: {places: {points: [[300 mm, 0], [0, 310 mm], [-305 mm, 0]]}}
simulate: {end: 2.7, samples: 101}
"""
BALL = """
gravity: [0, -10]
joints: {O: [0, 0]}
sliders: {ball: {joint: P, through: O, angle: 90 deg, mass: 0.3}}
stops: [{slider: ball, lower: 0, restitution: 0.5}]
free: {ball: {position: 0.2, speed: 0}}
"""
MOTOR = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 120 mm, mass: 5}}
free: {crank: {angle: 0.3, speed: 0}}
motors:
  m: {bar: crank, stall_torque: 1 N m, no_load_speed: 30 rad/s, rotor_inertia: 0.004, joint: O}
simulate: {end: 3}
"""
FORCE, RADIUS, SPEED = 2000.0, 0.3, 2 * math.pi


@pytest.fixture(scope="module", params=[21, 101])
def press(request):
    return linkages.simulate(linkages.loads(PRESS % "0.3"), samples=request.param)


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        ("last_turn(crank.angle, mean(crank.effort))", FORCE * 2 * RADIUS / (2 * math.pi)),
        ("last_turn(crank.angle, integral(crank.effort*crank.speed))", FORCE * 2 * RADIUS),
        ("last_turn(crank.angle, first(t))", 1.7),
        ("last_turn(crank.angle, final(t))", 2.7),
        ("during(0.2 s, 1.4 s, integral(crank.speed))", 1.2 * SPEED),
        ("during(0.4 s, integral(1 + 0*t))", 2.3),
        ("during(0.2 s, 0.6 s, max(t) - min(t) - range(t) + first(t) + time_of_max(t))", 0.8),
        ("during(1 s, 2 s, at(1.5 s, crank.angle) - first(crank.angle))", 0.5 * SPEED),
        ("during(1 s, 2 s, last_turn(crank.angle, first(t)))", 1.0),
        ("during(0.5 s, 2 s, final(cumulative(t)))", 0.5 * (4 - 0.25)),
        ("at(1 s, cumulative(cumulative(t)))", 1 / 6),
        ("during(0.1 s, 0.2 s, rms(crank.angle - mean(crank.angle)))",
         0.1 * SPEED / math.sqrt(12)),
        # x = r cos θ of the joint of the crank: first order alone, a sine 90° ahead
        ("last_turn(crank.angle, harmonic(1, A.x position))", RADIUS),
        ("last_turn(crank.angle, harmonic(2, A.x position))", 0.0),
        ("last_turn(crank.angle, phase(1, A.y position))", 0.3 + 1.7 * SPEED - 4 * math.pi),
        ("max(A.velocity)", RADIUS * SPEED),
        ("drives.crank.speed*bars.crank.length", RADIUS * SPEED),
        ("max_distance(A, places)", 0.01),
        ("rms_distance(A, places)", math.sqrt((0.01**2 + 0.005**2) / 3)),
        ("sum_squared_distance(A, places)", 0.01**2 + 0.005**2),
    ],
)  # fmt: skip
def test_closed_forms_whatever_the_samples(press, text, exact):
    assert linkages.measure(press, text) == pytest.approx(exact, rel=1e-9, abs=1e-12)


def jumping(order):
    """Amplitude of an order of 2 kN over half of the period."""
    return 2 * FORCE / (math.pi * order) if order % 2 else 0.0


@pytest.mark.parametrize("order", [1, 2, 7, 50])
def test_harmonics_of_a_force_that_jumps(press, order):
    found = linkages.measure(press, f"last_turn(crank.angle, harmonic({order}, loads[0].force))")
    assert found == pytest.approx(jumping(order), abs=1e-9 * FORCE)


def test_harmonics_of_a_smooth_motion_are_those_of_a_discrete_transform():
    """Which is exact to round-off for an analytic periodic function and 256 samples."""
    times = np.linspace(1.0, 2.0, 257)
    solution = linkages.simulate(linkages.loads(PRESS % "0.3"), times=[0.0, *times])
    values = solution.data.slider_position.sel(slider="piston").to_numpy()[1:-1]
    found = np.fft.rfft(values) / 128
    # one more for the sine than for the cosine of the transform
    for order in (1, 2, 3, 4):
        own = [
            linkages.measure(solution, f"during(1 s, 2 s, {name}({order}, piston.position))")
            for name in ("harmonic", "phase")
        ]
        whole = own[0] * np.exp(1j * (own[1] - math.pi / 2))
        assert whole == pytest.approx(found[order], abs=1e-12)


@pytest.mark.parametrize("text", ["piston.velocity**2", "abs(piston.acceleration)"])
@pytest.mark.parametrize("edges", [(0.13, 1.91), (0.5, 0.500001)])
def test_integrals_over_windows_are_those_of_another_quadrature(press, text, edges):
    series = FormulaSeries(press, text)
    zeros = [k / 4 - 0.3 / SPEED for k in range(12)]  # near those of the acceleration
    exact, error = quad(
        lambda t: float(series.at(np.array([t]))[0]), *edges, epsabs=1e-12, limit=400,
        points=[z for z in zeros if edges[0] < z < edges[1]],
    )  # fmt: skip
    text = f"during({edges[0]!r} s, {edges[1]!r} s, integral({text}))"
    assert linkages.measure(press, text) == pytest.approx(exact, rel=1e-9, abs=1e-11 + error)


def test_the_running_integral_of_a_power_is_the_kinetic_energy():
    """Of a motion without friction that starts at rest, work is energy at all times."""
    solution = linkages.simulate(linkages.loads(MOTOR), samples=7)
    work = FormulaSeries(solution, "cumulative(load_power)")
    assert work.unit == "N m"
    energy = FormulaSeries(solution, "kinetic_energy")
    times = np.linspace(0.0, 3.0, 41)
    assert work.at(times) == pytest.approx(energy.at(times), abs=1e-9 * energy.at(times).max())


@pytest.mark.parametrize("samples", [2, 41])
def test_windows_of_a_motion_with_impacts(samples):
    """Flights of a ball that falls 0.2 m at 10 m/s²: it meets the stop at 0.2 s with 2 m/s."""
    solution = linkages.simulate(linkages.loads(BALL), end=0.9, samples=samples)
    found = [
        linkages.measure(solution, text)
        for text in (
            "during(0.1 s, 0.3 s, integral(ball.velocity))",
            "during(0.25 s, 0.5 s, max(ball.position))",
            "during(0.25 s, time_of_max(ball.velocity) + 0.05 s, min(ball.velocity))",
            "during(0.15 s, 0.35 s, integral(abs(ball.velocity)))",
            "during(0.15 s, 0.35 s, range(cumulative(ball.velocity)))",
        )
    ]
    # at 0.1 s it is at 0.15 m, at 0.3 s at 0.05 m; after the stop it goes 1 m/s upward
    fall, rise = 0.2 - 0.5 * 10 * 0.15**2, 0.15 - 5 * 0.15**2
    exact = [0.05 - 0.15, 0.05, 0.5, fall + 0.05 + (0.05 - 5 * 0.05**2) * 0, fall]
    assert rise == pytest.approx(0.0375)
    assert found[:2] == pytest.approx(exact[:2], rel=1e-9)
    assert found[3] == pytest.approx(fall + 0.05 + (0.05 - rise), rel=1e-9)
    assert found[4] == pytest.approx(exact[4], rel=1e-9)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("during(1 s, 3 s, mean(t))", "the window from 1 s to 3 s is outside of the motion, from "
         "0 s to 2.7 s"),
        ("during(2 s, 1 s, mean(t))", "the window from 2 s to 1 s is empty"),
        ("during(2.7 s, mean(t))", "the window from 2.7 s to 2.7 s is empty"),
        ("during(1 s, 2 s, during(0.5 s, 1.5 s, mean(t)))", "the window from 0.5 s to 1.5 s is "
         "outside of the motion, from 1 s to 2 s"),
        ("during(1 s, 2 s, at(2.5 s, t))", "t = 2.5 s is outside of the window, from 1 s to 2 s"),
        ("last_turn(rod.angle, mean(t))", "the angle turns by"),
        ("during(1 s, 2 s, 1/min(0*t))", "divides by zero"),
    ],
)  # fmt: skip
def test_a_window_that_there_is_not(press, text, reason):
    with pytest.raises(ComputationError) as caught:
        linkages.measure(press, text)
    assert reason in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "during(1 s, crank.speed)",
            "'during' expects a number last, such as during(1 s, 2 s, mea",
        ),
        ("during(1 m, mean(t))", "a time (s) and a length (m) do not go together"),
        ("last_turn(piston.position, mean(t))", "an angle or a pure number and a length (m) do"),
        ("last_turn(1, mean(t))", "'last_turn' expects an angle first"),
        ("harmonic(1.5, crank.effort)", "'harmonic' expects an order first, a whole number from 1"),
        ("harmonic(0, crank.effort)", "'harmonic' expects an order first"),
        ("max_distance(A, place)", "unknown target 'place'; did you mean 'places'?"),
        ("max_distance(Q, places)", "unknown joint 'Q'; expected one of: O, A or B"),
        ("max_distance(A + 1, places)", "'max_distance' expects a joint and a target"),
        ("integral(crank.speed) + 1 rad/s", "do not go together"),
    ],
)
def test_what_is_refused(press, text, message):
    with pytest.raises(ValueError, match="measure") as caught:
        linkages.measure(press, text)
    assert message in str(caught.value)


def test_units_of_integrals():
    solution = linkages.simulate(linkages.loads(PRESS % "0"), samples=2)
    from linkages.solution.measuring import unit_of

    for text, unit in (
        ("integral(piston.velocity)", "m"),
        ("integral(t)", "s^2"),
        ("max(cumulative(crank.effort*crank.speed))", "N m"),
        ("during(1 s, max(crank.effort))", "N m"),
        ("harmonic(2, piston.position)", "m"),
        ("phase(2, piston.position)", ""),
        ("bars.rod.length", "m"),
        ("bars.rod.mass*bars.rod.length**2", "kg m^2"),
        ("loads[0].force/A.reaction", ""),
        ("sum_squared_distance(A, places)", "m^2"),
    ):
        text = text.replace("loads[0].force/A.reaction", "max(loads[0].force)/max(A.reaction)")
        assert unit_of(solution, text) == unit, text


MANY = {
    "turn": "last_turn(crank.angle, mean(crank.effort))",
    "edges": "during(time_of_max(piston.position), rms(crank.effort - mean(crank.effort)))",
    "energy": "range(cumulative(crank.effort - mean(crank.effort)))",
    "order": "last_turn(crank.angle, harmonic(3, loads[0].force))",
    "away": "rms_distance(A, places)",
}


@pytest.mark.parametrize("name", [*MANY])
@pytest.mark.parametrize("cores", [1, 2])
def test_points_of_sweeps_have_the_bits_of_single_runs(name, cores):
    lengths, text = [0.8, 0.9, 1.1], MANY[name]
    data = linkages.sweep(
        linkages.loads(PRESS % "0.3"), {"bars.rod.length": lengths}, {name: text}, cores=cores
    )
    alone = [
        linkages.measure(
            linkages.simulate(linkages.loads(PRESS % "0.3", set={"bars.rod.length": length})), text
        )
        for length in lengths
    ]
    assert data[name].to_numpy().tolist() == alone


@pytest.mark.parametrize("text", ["bars.rod.length*2", "max(piston.position) - bars.rod.length"])
def test_numbers_of_points_of_sweeps(text):
    lengths = np.array([0.8, 0.9, 1.1])
    data = linkages.sweep(linkages.loads(PRESS % "0.3"), {"bars.rod.length": lengths}, {"m": text})
    exact = 2 * lengths if "*2" in text else np.full(3, RADIUS)
    assert data.m.to_numpy() == pytest.approx(exact, rel=1e-12)


def test_numbers_that_follow_from_others():
    """The inertia of a rod is m l²/12 where the file does not give it."""
    data = linkages.sweep(
        linkages.loads(PRESS % "0.3"), {"bars.rod.length": [0.8, 1.1]}, {"m": "bars.rod.inertia"}
    )
    assert data.m.to_numpy() == pytest.approx([3 * 0.8**2 / 12, 3 * 1.1**2 / 12], rel=1e-14)


def test_windows_of_motions_side_by_side():
    """Those of motions with independent coordinates, each with a window of its own."""
    text = "last_turn(crank.angle, (max(crank.speed) - min(crank.speed))/mean(crank.speed))"
    heavy = MOTOR + "loads: [{joint: A, force: [0, -5 N]}]\n"
    inertias = [0.004, 0.006, 50.0]
    data = linkages.sweep(
        linkages.loads(heavy), {"motors.m.rotor_inertia": inertias},
        {"even": text, "inertia": "motors.m.rotor_inertia"}, end=4.0,
    )  # fmt: skip
    alone = [
        linkages.measure(
            linkages.simulate(linkages.loads(heavy, set={"motors.m.rotor_inertia": j}), end=4.0),
            text,
        )
        for j in inertias[:2]
    ]
    assert data.even.to_numpy()[:2].tolist() == alone
    assert data.inertia.to_numpy()[:2].tolist() == inertias[:2]
    assert "the angle turns by" in str(data.reason.to_numpy()[2])


def test_doubts_name_what_is_not_steady():
    rising = linkages.simulate(linkages.loads(MOTOR), end=2.0)
    (found,) = doubts(rising, "last_turn(crank.angle, mean(crank.speed))")
    assert "in the turn before: the motion is not steady; simulate it for longer" in found
    settled = linkages.simulate(linkages.loads(PRESS % "0.3"))
    assert not doubts(settled, "last_turn(crank.angle, harmonic(2, piston.position))")
    (found,) = doubts(settled, "harmonic(2, piston.position)")
    assert "the window is no whole period of it" in found


def test_a_number_that_is_varied_is_no_measure_of_a_sweep():
    with pytest.raises(ValueError, match=r"bars\.rod\.length is varied itself"):
        linkages.sweep(
            linkages.loads(PRESS % "0"), {"bars.rod.length": [0.8, 0.9]}, ["bars.rod.length"]
        )


def test_a_branch_that_is_not_taken_may_ask_for_what_there_is_not(press):
    text = "where(drives.crank.speed > 1 rad/s, 3, during(1 s, 9 s, max(t))/1 s)"
    assert linkages.measure(press, text) == 3.0
