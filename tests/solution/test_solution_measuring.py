"""Measures of motions against closed forms, and where their texts are wrong."""

import math

import numpy as np
import pytest

import linkages
from linkages.solution.extremes import largest_between
from linkages.solution.interpolation import between

SLIDER_CRANK = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8}
  rod: {joints: [A, B], length: 0.14, mass: 0.5}
sliders: {piston: {joint: B, through: O, angle: 0, mass: 0.4}}
drives: {crank: {angle: 0.3, speed: 100}}
assembly: {B: [0.18, 0]}
simulate: {end: 0.1, samples: %d}
"""

OSCILLATOR = """
joints: {O: [0, 0]}
bars: {bar: {joints: [O, A], length: 1, mass: 1, center: 0, inertia: 0.5}}
free: {bar: {angle: 0.2, speed: 0}}
springs: [{bar: bar, stiffness: 8, angle: 0}]
simulate: {end: 3, samples: %d}
"""


@pytest.fixture(scope="module", params=[41, 401])
def crank(request):
    return linkages.simulate(linkages.loads(SLIDER_CRANK % request.param), outputs="all")


def position(angle):
    return 0.04 * np.cos(angle) + np.sqrt(0.14**2 - (0.04 * np.sin(angle)) ** 2)


def test_extremes_of_a_driven_motion_lie_between_samples(crank):
    # round-off: the motion is evaluated wherever it is looked at
    assert linkages.measure(crank, "max(piston.position)") == pytest.approx(0.18, rel=1e-12)
    assert linkages.measure(crank, "min(piston.position)") == pytest.approx(0.10, rel=1e-12)
    assert linkages.measure(crank, "stroke(piston.position)") == pytest.approx(0.08, rel=1e-11)
    # a place is known to a part of a sample in 16^-4
    first = (math.pi - 0.3) / 100
    step = float(crank.data["time"][1])
    found = linkages.measure(crank, "time_of_min(piston.position)")
    assert found == pytest.approx(first, abs=step * 1e-4)


def test_kinks_are_found(crank):
    # the magnitude of a velocity that changes sign: each look is sixteen times as close
    least = linkages.measure(crank, "min(abs(piston.velocity))")
    assert 0.0 <= least < 1e-9


def test_values_at_times(crank):
    found = linkages.measure(crank, "at(12.3 ms, piston.position)")
    assert found == pytest.approx(position(0.3 + 1.23), rel=1e-13)
    assert linkages.measure(crank, "final(crank.angle)") == pytest.approx(10.3, rel=1e-14)


def test_means_over_time():
    # two turns: sampled evenly, Simpson's rule is as exact as trapezes on what repeats
    text = SLIDER_CRANK.replace("end: 0.1", f"end: {4 * math.pi / 100!r}")
    solution = linkages.simulate(linkages.loads(text % 201))
    angles = np.linspace(0, 2 * np.pi, 4001)[:-1]
    mean = np.mean(position(angles))
    assert linkages.measure(solution, "mean(piston.position)") == pytest.approx(mean, rel=1e-12)
    square = math.sqrt(np.mean(position(angles) ** 2))
    assert linkages.measure(solution, "rms(piston.position)") == pytest.approx(square, rel=1e-12)


def test_power_balance_of_a_turn():
    # what a drive gives in a whole turn is what it takes: no friction, no load
    text = SLIDER_CRANK.replace("end: 0.1", f"end: {2 * math.pi / 100!r}")
    solution = linkages.simulate(linkages.loads(text % 201))
    scale = linkages.measure(solution, "max(abs(crank.effort*crank.speed))")
    assert abs(linkages.measure(solution, "mean(crank.effort*crank.speed)")) < 1e-9 * scale


@pytest.mark.parametrize("samples", [8, 60])
def test_free_motions_are_followed_between_samples(samples):
    # θ = 0.2 cos 4t, from I θ'' = -8 θ with I = 1/2; with few samples the motion is computed again
    solution = linkages.simulate(linkages.loads(OSCILLATOR % samples), rtol=1e-12)
    assert linkages.measure(solution, "min(bar.angle)") == pytest.approx(-0.2, rel=1e-9)
    assert linkages.measure(solution, "max(abs(bar.speed))") == pytest.approx(0.8, rel=1e-9)
    assert linkages.measure(solution, "time_of_min(bar.angle)") == pytest.approx(
        math.pi / 4, rel=1e-4
    )
    mean = 0.2 * math.sin(12.0) / 12.0
    assert linkages.measure(solution, "mean(bar.angle)") == pytest.approx(mean, rel=1e-6)


def test_a_motion_between_samples_is_that_motion():
    coarse = linkages.simulate(linkages.loads(OSCILLATOR % 61), rtol=1e-12).motion.pieces[0]
    found = between(coarse, np.array([3, 17]), np.array([0.25, 0.6]))
    # degree 5 over an interval of 0.05 s: (4·0.05)^6/720/64 of the amplitude
    expected = 0.2 * np.cos(4 * found.time)
    assert np.abs(found.state[0] - expected).max() < 1e-9
    assert np.abs(found.acceleration[0] + 16 * expected).max() < 2e-8


def test_reactions_and_errors_are_measured_too(crank):
    largest = float(np.abs(crank.data["joint_reaction"].sel(joint="B", axis="y")).max())
    found = linkages.measure(crank, "max(abs(B.y reaction))")
    assert largest <= found * (1 + 1e-12)
    # at most 41 samples in 1.6 turns: a peak exceeds its sample by (π/25)²/8·4
    assert found < 1.02 * largest


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("max(crank.efort)", "did you mean 'crank.effort'"),
        ("max(crnk.effort)", "did you mean 'crank.effort'"),
        ("max(knetic_energy)", "did you mean 'kinetic_energy'"),
        ("max(crank.effort) + 1 mm", "do not go together"),
    ],
)
def test_messages(crank, text, message):
    with pytest.raises(ValueError, match="measure") as caught:
        linkages.measure(crank, text)
    assert message in str(caught.value)


def test_names_of_an_output_are_listed_once():
    press = linkages.simulate(linkages.load("toggle-press"), end=0.01, samples=3)
    with pytest.raises(ValueError, match="one of its series") as found:
        linkages.measure(press, "min(transmission_angle)")
    assert str(found.value).count("ram.transmission") == 1


@pytest.mark.parametrize("text", ["1/(max(t) - final(t))", "max(1/(crank.angle - 0.3))"])
def test_division_by_zero(crank, text):
    with pytest.raises(linkages.ComputationError, match="divides by zero"):
        linkages.measure(crank, text)


def test_times_that_follow_from_the_motion(crank):
    found = linkages.measure(crank, "at(time_of_max(piston.velocity), crank.angle)")
    time = linkages.measure(crank, "time_of_max(piston.velocity)")
    assert found == pytest.approx(0.3 + 100 * time, rel=1e-12)
    found = linkages.measure(crank, "at(final(t)/2, piston.position)")
    assert found == pytest.approx(position(0.3 + 5), rel=1e-12)


@pytest.mark.parametrize("text", ["at(1 s, crank.effort)", "at(10*final(t), crank.effort)"])
def test_a_time_outside_of_the_motion_costs_that_measure_alone(crank, text):
    reason = f"measure {text!r}: t = 1 s is outside of the motion, from 0 s to 0.1 s"
    with pytest.raises(linkages.ComputationError) as caught:
        linkages.measure(crank, text)
    assert str(caught.value) == reason
    vary, other = {"bars.rod.length": [0.14, 0.15]}, "final(piston.position)"
    data = linkages.sweep(crank.mechanism, vary, [text, other])
    assert np.isnan(data[text]).all()
    assert np.isfinite(data[other]).all()
    assert data["reason"].to_numpy().tolist() == [reason] * 2


def test_each_motion_of_a_sweep_has_its_own_times(crank):
    """Driven motions are evaluated at once, free ones are integrated side by side."""
    free = linkages.loads(OSCILLATOR % 21)
    for mechanism, path, values, text in (
        (crank.mechanism, "bars.rod.length", [0.14, 0.15, 0.2], "piston.velocity"),
        (free, "springs[0].stiffness", [8.0, 20.0, 50.0], "bar.speed"),
    ):
        place = "piston.position" if text[0] == "p" else "bar.angle"
        measure = f"at(time_of_max({text}), {place})"
        data = linkages.sweep(mechanism, {path: values}, measure)
        assert data[measure].to_numpy().tolist() == [
            linkages.measure(linkages.simulate(mechanism.with_values({path: value})), measure)
            for value in values
        ]


def test_what_was_not_computed_must_be_asked_for():
    solution = linkages.simulate(linkages.loads(SLIDER_CRANK % 41))
    with pytest.raises(ValueError, match="expected outputs that have 'joint_reaction'"):
        linkages.measure(solution, "max(B.x reaction)")
    assert linkages.measure(solution, "max(kinetic_energy)") > 0  # of the motion at one time


def test_rows_side_by_side_do_not_depend_on_each_other():
    generator = np.random.default_rng(1)
    phases = generator.uniform(0, 6, 7)

    def value(which, places):
        return np.sin(0.2 * places + phases[which])

    def found(rows):
        places = np.arange(60.0)
        samples = np.sin(0.2 * places + phases[rows][:, None])
        return largest_between(samples, lambda which, at: value(rows[which], at))

    together = found(np.arange(7))
    alone = [found(np.array([row])) for row in range(7)]
    assert np.array_equal(together.value, [one.value[0] for one in alone])
    assert np.array_equal(together.place, [one.place[0] for one in alone])
    assert together.value == pytest.approx(1.0, abs=1e-14)


def test_a_series_that_rests_is_looked_at_beside_its_peaks_only():
    """Bumps on a floor, each between two samples; one sample of the floor stands for all."""

    def value(places):
        return np.maximum(0.0, 1.0 - (places % 100 - 50.5) ** 2)

    looked = []

    def found(sign):
        def between(_which, places):
            looked.append(len(places))
            return sign * value(places)

        return largest_between(sign * value(np.arange(10_000.0))[None], between)

    # a parabola between two of 16 parts of a sample, which then shrink: its top is one of them
    assert (found(1.0).value[0], found(1.0).place[0]) == (1.0, 50.5)
    looked.clear()
    floor = found(-1.0)
    assert (floor.value[0], floor.place[0]) == (0.0, 0.0)
    bends = 2 * 100 + 1  # where the floor ends on either side of a bump, and its first sample
    assert looked[0] <= 33 * bends  # places beside each


def test_internal_states_are_followed_between_samples():
    """A current that decays by itself: i = i0 exp(−R t/L), for the rotor is held by a heavy bar."""
    mechanism = linkages.loads(
        """
        joints: {O: [0, 0]}
        bars: {rod: {joints: [O, A], length: 1, mass: 1 t}}
        free: {rod: {angle: 0, speed: 0}}
        motors:
          hoist: {bar: rod, voltage: 1 nV, torque_constant: 1e-6, resistance: 1, inductance: 0.2,
                  current: 3}
        """
    )
    times = 0.1234, 0.6789
    solution = linkages.simulate(mechanism, end=1.0, samples=11, outputs="all")
    found = [linkages.measure(solution, f"at({t} s, motors.hoist.current.state)") for t in times]
    # cubic polynomials between samples that are four times as close as the steps
    assert found == pytest.approx([3 * np.exp(-5 * t) for t in times], rel=1e-6)


LOADED = """
joints: {O: [0, 0], W: [0.3, 0]}
bars:
  crank: {joints: [O, A], length: 0.1}
  "rod 1": {joints: [A, B], length: 0.3, mass: 1}
  rocker: {joints: [W, B], length: 0.25}
loads: [{joint: A, force: [0, 3 N]}]
drives: {crank: {angle: 0, speed: 1}}
assembly: {B: [0.3, 0.25]}
simulate: {end: 0.1, samples: 3}
"""


@pytest.fixture(scope="module")
def loaded():
    return linkages.simulate(linkages.loads(LOADED), outputs="all")


@pytest.mark.parametrize(
    ("name", "same"),
    [
        ("ground.x_shaking_force", "ground.x shaking force"),
        ("crank.rocker.mechanical_advantage", "crank.rocker.mechanical advantage"),
        ("transmission angle", "B.transmission_angle"),
        ("transmission_angle", "B.transmission angle"),
        ("'rod 1'.speed", '"rod 1".speed'),
        ("loads[0].y", "loads[0].y.force"),
        ("rocker.mechanical_advantage", "crank.rocker.mechanical advantage"),
        (
            "ground.shaking_force",
            "sqrt(ground.x shaking force**2 + ground.y shaking force**2)",
        ),
        ("B.velocity", "sqrt(B.x velocity**2 + B.y velocity**2)"),
    ],
)
def test_one_meaning_of_a_name_is_enough(loaded, name, same):
    assert linkages.measure(loaded, f"max({name})") == linkages.measure(loaded, f"max({same})")


@pytest.mark.parametrize(
    ("name", "suggested"),
    [
        ("loads[0].y force", ["loads[0].y.force"]),
        ("rocker.reaction", ["O.x reaction"]),
        ("crank.torque", ["crank.effort"]),
        ("crank", ["crank.angle", "crank.speed", "crank.acceleration", "crank.effort"]),
        ("'rod 2'.angle", ["'rod 1'.angle"]),
        ("bar_speed", ["crank.speed", "'rod 1'.speed", "rocker.speed"]),
        ("knetic energy", ["kinetic_energy"]),
        ("crank.effrt", ["crank.effort"]),
    ],
)
def test_suggested_names_are_measures(loaded, name, suggested):
    with pytest.raises(ValueError, match="measure") as caught:
        linkages.measure(loaded, f"max({name})")
    for each in suggested:
        assert each in str(caught.value).partition(": ")[2]
        assert np.isfinite(linkages.measure(loaded, f"max({each})"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("max(bars.rocker.length)", "bars.rocker.length is a number of the definition, and a meas"),
        ("bars.rocker.lenght", "'bars.rocker.lenght' is no number of the definition; did you mean "
         "'bars.rocker.length'?"),
        ("bars.rocker + 1", "'bars.rocker' is no number of the definition; did you mean"),
        ("crank.speed + bars.rocker.length", "it changes with time; expected outputs within a re"),
        ("at(crank.speed, crank.angle)", "'at' expects a time first, such as at(0.2 s, crank.eff"),
        ("bars.rocker.length + 1 s", "a length (m) and a time (s) do not go together"),
    ],
)  # fmt: skip
def test_a_number_of_the_definition_does_not_change_with_time(loaded, text, message):
    with pytest.raises(ValueError, match="measure") as caught:
        linkages.measure(loaded, text)
    assert message in str(caught.value)


def test_words_of_conditions_end_names(loaded):
    text = "max(where(crank.speed < rocker.speed and crank.angle < 9, 1, 2))"
    assert linkages.measure(loaded, text) in (1, 2)


def test_magnitudes_whose_squares_overflow():
    text = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1e200, mass: 1}}
drives: {rod: {angle: 0, speed: 1}}
simulate: {end: 1, samples: 5}
"""
    rows = linkages.simulate(linkages.loads(text), outputs=["joint_velocity"]).maxima
    assert {row["element"]: row["value"] for row in rows}["P"] == pytest.approx(1e200, rel=1e-12)
