"""Derivatives of integrals, windows, harmonics and distances; numbers of the file as goals.

Differences of motions that drives determine are good to some 1e-10 by Richardson's extrapolation,
those of integrated motions to what their tolerance of 1e-10 leaves after division by the step.
"""

import math

import numpy as np
import pytest
from design_differences import richardson

import linkages
from linkages.design.differentiated import Differentiated
from linkages.errors import ComputationError

PRESS = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 300 mm, mass: 5, center: 100 mm, inertia: 0.1}
  rod: {joints: [A, B], length: 900 mm, mass: 3}
sliders: {piston: {joint: B, through: O, mass: 2}}
drives: {crank: {angle: 0.3, speed: 60 rpm}}
assembly: {B: [1.2, 0]}
loads: [{slider: piston, force: "where(piston.velocity < 0 m/s, 2 kN, 0 N)"}]
targets: {places: {points: [[300 mm, 20 mm], [0, 310 mm], [-305 mm, 0]]}}
simulate: {end: 2.7, samples: 101}
"""
MOTOR = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 120 mm, mass: 5}
  rod: {joints: [A, B], length: 400 mm, mass: 3}
sliders: {piston: {joint: B, through: O, mass: 2}}
free: {crank: {angle: 0.3, speed: 60 rpm}}
motors:
  m: {bar: crank, stall_torque: 157 N m, no_load_speed: 1500 rpm, gear_ratio: 24,
      rotor_inertia: 0.004, joint: O}
assembly: {B: [0.52, 0]}
loads: [{slider: piston, force: "where(piston.velocity < 0 m/s, 500 N, 0 N)"}]
simulate: {end: 3, samples: 101}
"""
BALL = """
gravity: [0, -10]
joints: {O: [0, 0]}
sliders: {ball: {joint: P, through: O, angle: 90 deg, mass: 0.3}}
stops: [{slider: ball, lower: 0, restitution: 0.5}]
free: {ball: {position: 0.2, speed: 0}}
simulate: {end: 0.5, samples: 11}
"""
PATHS = ["bars.rod.length", "bars.crank.length", "drives.crank.speed", "bars.rod.mass"]


def slopes(text, paths, measures):
    """Values and derivatives of measures by numbers."""
    found = Differentiated(linkages.loads(text), measures, paths)
    return found, found.at(found.values)


DRIVEN = [
    "integral(crank.effort*crank.speed)",
    "during(0.4 s, 1.7 s, rms(piston.velocity))",
    "during(0.4 s, 1.7 s, integral(crank.effort))",
    "during(0.45 s, max(piston.velocity)) - during(0.45 s, 0.6 s, min(piston.velocity))",
    "last_turn(crank.angle, first(piston.position))",
    "last_turn(crank.angle, phase(1, piston.position) + harmonic(2, piston.position)/1 m)",
    "range(cumulative(crank.effort - mean(crank.effort)))",
    "last_turn(crank.angle, range(cumulative(crank.effort - mean(crank.effort))))",
    "at(1.3 s, cumulative(abs(piston.acceleration)))",
    "bars.rod.length*mean(abs(piston.velocity))",
    "rms_distance(A, places) + max_distance(A, places)",
    "max(A.velocity)",
    "during(0.2 s, 1.2 s, mean(where(piston.position > 0.8 m, 1, 0)))",
    "during(0.5 s, 2 s, during(0.6 s, mean(crank.effort)))",
    "during(time_of_max(piston.position) + 0.1 s, max(piston.position))",
]


@pytest.mark.slow_except("*phase*", "at*")
@pytest.mark.parametrize("measure", DRIVEN)
def test_derivatives_of_driven_motions(measure):
    found, exact = slopes(PRESS, PATHS, [measure])
    for number, value in enumerate(found.values):
        difference, error = richardson(
            lambda x: found.at(x, derivatives=False).values, found.values, number, 1e-2 * value
        )
        size = abs(difference) + abs(exact.values) / value
        assert exact.derivatives[:, number] == pytest.approx(
            difference, abs=max(1e-8 * size[0], 3 * error[0])
        )
        assert error <= 1e-5 * size


@pytest.mark.slow
@pytest.mark.parametrize(
    "measure",
    [
        "during(1 s, (max(crank.speed) - min(crank.speed))/mean(crank.speed))",
        "last_turn(crank.angle, (max(crank.speed) - min(crank.speed))/mean(crank.speed))",
        "last_turn(crank.angle, harmonic(2, crank.speed))",
        "last_turn(crank.angle, phase(2, crank.speed))",
        "range(cumulative(load_power))",
        "motors.m.rotor_inertia*max(crank.speed)**2/2",
        "during(0.3 s, 2.1 s, rms(crank.acceleration))",
    ],
)
def test_derivatives_of_integrated_motions(measure):
    found, exact = slopes(MOTOR, ["motors.m.rotor_inertia", "bars.crank.length"], [measure])
    for number, value in enumerate(found.values):
        difference, error = richardson(
            lambda x: found.at(x, derivatives=False).values, found.values, number, 2e-2 * value
        )
        noise = 1e-9 * max(1.0, abs(exact.values[0])) / (2e-2 * value)
        assert exact.derivatives[:, number] == pytest.approx(
            difference, abs=max(noise, 3 * error[0])
        )
        assert error[0] <= 1e-3 * (abs(difference[0]) + abs(exact.values[0]) / value)


def test_energy_of_a_turn_is_twice_the_force_times_the_crank():
    """∂/∂r of 2 F r; the rod, the masses and the speed do no work in a whole turn."""
    turn = "last_turn(crank.angle, %s)"
    _, found = slopes(
        PRESS, PATHS, [turn % "integral(crank.effort*crank.speed)", turn % "mean(crank.effort)"]
    )
    assert found.values == pytest.approx([1200.0, 600 / math.pi], rel=1e-12)
    exact = np.array([[0, 4000, 0, 0], [0, 2000 / math.pi, 0, 0]])
    assert found.derivatives == pytest.approx(exact, abs=1e-7)


def test_numbers_of_the_file_have_derivatives():
    """Their own is 1; that of an inertia that is not given follows from m l²/12."""
    _, found = slopes(PRESS, PATHS, ["bars.rod.length", "bars.rod.inertia", "sqrt(bars.rod.mass)"])
    exact = [[1, 0, 0, 0], [3 * 0.9 / 6, 0, 0, 0.9**2 / 12], [0, 0, 0, 0.5 / math.sqrt(3)]]
    assert found.derivatives == pytest.approx(np.array(exact), abs=1e-14)


def test_windows_beside_impacts():
    """A ball that falls from h at g meets the stop at T = √(2h/g) with √(2gh), and rises with half.

    Its path in a window around that time has the derivative of the closed form.
    """
    measure = "during(0.1 s, 0.3 s, integral(abs(ball.velocity)))"
    _, found = slopes(BALL, ["free.ball.position"], [measure])

    def path(h):
        time = math.sqrt(0.2 * h)
        down = h - 5 * 0.1**2
        up = 5 * time * (0.3 - time) - 5 * (0.3 - time) ** 2
        return down + up

    # it goes up until the end of the window: T/2 after the impact at 0.2 s
    assert found.values == pytest.approx([path(0.2)], rel=1e-9)
    step = 1e-5
    slope = (path(0.2 + step) - path(0.2 - step)) / (2 * step)
    assert found.derivatives == pytest.approx(np.array([[slope]]), rel=1e-7)


def test_sensitivities_and_tolerances_take_them():
    mechanism = linkages.loads(
        PRESS.replace("900 mm", "900 ± 1 mm").replace("mass: 3", "mass: 3 ± 0.1")
    )
    energy = "last_turn(crank.angle, integral(abs(crank.effort*crank.speed)))"
    texts = [energy, "bars.rod.length*2", "bars.rod.mass", "loads[0].force"]
    found = linkages.sensitivities(mechanism, texts, ["bars.rod.*"])
    assert [float(found[text].sel(parameter=path)) for text, path in (
        ("bars.rod.length*2", "bars.rod.length"), ("bars.rod.mass", "bars.rod.mass"),
        ("bars.rod.mass", "bars.rod.length"),
    )] == pytest.approx([2.0, 1.0, 0.0])  # fmt: skip
    assert found["loads[0].force"].dims == ("time", "parameter")  # a series, too
    data = linkages.tolerance(mechanism, [energy, "bars.rod.length*1"], draws=100, seed=1)
    linear, drawn = data["linear_deviation"].to_numpy(), data["deviation"].to_numpy()
    assert linear[1] == pytest.approx(1e-3 / 3)  # the limits are three standard deviations away
    assert drawn == pytest.approx(linear, rel=0.3)  # of 100 draws: 7 % is their standard deviation


@pytest.mark.slow
def test_a_global_search_for_a_number_of_the_file():
    """The shortest crank with a stroke of 0.5 m has half of that."""
    found = linkages.optimise(
        linkages.loads(PRESS), {"bars.crank.length": (0.1, 0.4)}, minimise="bars.crank.length",
        subject_to="during(0.2 s, stroke(piston.position)) > 0.5 m", search="global", runs=100,
    )  # fmt: skip
    assert float(found.data.value.sel(state="optimum")) == pytest.approx(0.25, rel=0.05)


@pytest.mark.slow
def test_the_least_flywheel():
    """The least inertia that keeps the fluctuation at 10 % is that at which it is 10 %."""
    even = "last_turn(crank.angle, (max(crank.speed) - min(crank.speed))/mean(crank.speed))"
    heavy = MOTOR.replace("500 N, 0 N", "3 kN, 0 N").replace("end: 3", "end: 6")
    found = linkages.optimise(
        linkages.loads(heavy), {"motors.m.rotor_inertia": (0.001, 0.2)},
        minimise="motors.m.rotor_inertia", subject_to=f"{even} < 0.1",
    )  # fmt: skip
    assert float(found.data.value.sel(state="optimum")) == float(
        found.data.number.sel(state="optimum")[0]
    )
    again = linkages.measure(linkages.simulate(found.mechanism), even)
    assert again == pytest.approx(0.1, rel=1e-6)
    assert float(found.data.value.sel(state="start")) == 0.004


def test_the_least_peak_in_a_window_is_held_down():
    """Of x = a sin 2πt, which is largest at 0.25 s, and falls from 0.3 s on."""
    text = """
    joints: {O: [0, 0]}
    sliders: {block: {joint: P, through: O, mass: 1}}
    parameters: {a: 0.3}
    drives: {block: {law: "a*sin(2*pi*t)"}}
    simulate: {end: 1, samples: 21}
    """
    found = linkages.optimise(
        linkages.loads(text), {"parameters.a": (0.05, 1)},
        minimise="during(0.3 s, 0.4 s, max(block.position))",
        subject_to="during(0.2 s, 0.3 s, max(block.position)) > 0.1 m",
    )  # fmt: skip
    assert float(found.data.number.sel(state="optimum")[0]) == pytest.approx(0.1, rel=1e-7)
    value = float(found.data.value.sel(state="optimum"))
    assert value == pytest.approx(0.1 * math.sin(0.6 * math.pi), rel=1e-7)


def test_a_path_is_brought_to_points_without_timing():
    """Points on a circle about a pivot that is found: the crank is as long as they are away."""
    text = """
    joints: {O: [0, 0]}
    bars: {crank: {joints: [O, A], length: 300 mm}}
    drives: {crank: {angle: 0, speed: 60 rpm}}
    targets: {round: {points: [[0.5, 0.1], [0.1, 0.5], [-0.3, 0.1]]}}
    simulate: {end: 1, samples: 61}
    """
    found = linkages.optimise(
        linkages.loads(text),
        {"bars.crank.length": (0.1, 1), "joints.O[0]": (-0.5, 0.5), "joints.O[1]": (-0.5, 0.5)},
        minimise="sum_squared_distance(A, round)",
    )
    number = found.data.number.sel(state="optimum").to_numpy()
    assert number == pytest.approx([0.4, 0.1, 0.1], abs=1e-5)


@pytest.mark.parametrize(
    ("measure", "reason"),
    [
        ("during(1 s, 3 s, mean(t))", "the window from 1 s to 3 s is outside of the motion"),
        ("during(2 s, 1 s, mean(t))", "the window from 2 s to 1 s is empty"),
        ("last_turn(rod.angle, mean(t))", "the angle turns by"),
        ("during(1 s, 2 s, at(2.5 s, t))", "t = 2.5 s is outside of the window"),
    ],
)
def test_a_window_that_there_is_not(measure, reason):
    with pytest.raises(ComputationError) as caught:
        slopes(PRESS, ["bars.rod.length"], [measure])
    assert reason in str(caught.value)
