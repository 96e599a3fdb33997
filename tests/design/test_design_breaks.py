"""Derivatives where laws of time jump at times that are numbers of the definition."""

from __future__ import annotations

import numpy as np
import pytest
from design_differences import compared, richardson

import linkages
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.sensitivity import differentiated
from linkages.design.sensitivity.differentiated import Differentiated
from linkages.errors import ComputationError, InputError

PATHS = ["drives.arm.law.begin", "drives.arm.law.duration", "bars.rod.length", "free.rod.angle"]


def _swung(rise: str = "harmonic", begin: float = 0.23) -> Mechanism:
    return linkages.loads(f"""
name: pendulum on an arm that starts and stops
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  arm: {{joints: [O, A], length: 0.2, mass: 1}}
  rod: {{joints: [A, B], length: 0.5, mass: 1.5}}
drives:
  arm: {{law: {{rise: {rise}, from: 0 deg, to: 70 deg, begin: {begin}, duration: 0.4}}}}
free:
  rod: {{angle: -80 deg, speed: 0}}
""")


def _driven(law: str, parameters: str = "{start: 0.23}") -> Mechanism:
    return linkages.loads(f"""
name: arm that is driven alone
gravity: [0, -9.81]
parameters: {parameters}
joints: {{O: [0, 0]}}
bars:
  arm: {{joints: [O, A], length: 0.2, mass: 1}}
drives:
  arm: {{law: {law}}}
""")


def test_derivatives_go_through_jumps_of_drives_whose_times_are_numbers(monkeypatch):
    """A harmonic rise jumps at begin and at begin + duration; a sample lies on neither, then one.

    Differences are of motions whose steps go across the jumps, at a relative error of 1e-12 each:
    that is 1e-8 of a derivative by differences of 1e-4 of a number.
    """
    times = np.array([0.1, 0.3, 0.5, 1.0, 1.2])
    series = ["rod.angle", "rod.speed", "arm.effort"]
    for samples in (241, 200):
        found = Differentiated(
            _swung(), [], PATHS, run={"end": 1.2, "samples": samples, "rtol": 1e-12}
        )
        missed, attainable = compared(found, series, times, [0, 1, 2, 3], 1e-3)
        assert (missed <= 3e-8 + 10 * attainable).all()
    monkeypatch.setattr(differentiated, "breaks", lambda *_: [])
    without = found.along(found.values, series, times).derivatives
    monkeypatch.undo()
    exact = found.along(found.values, series, times).derivatives
    assert exact is not None
    assert without is not None
    # what the jumps add is no small part of it
    assert abs(exact[1, 0, -1] - without[1, 0, -1]) > 0.1 * abs(exact[1, 0, -1])


def test_between_the_samples_around_a_jump_there_are_no_derivatives():
    run = {"end": 0.4, "samples": 81}
    found = Differentiated(_swung(), ["at(0.228 s, rod.speed)"], PATHS[:1], run=run)
    for ask in (
        lambda: found.at(found.values),
        lambda: found.along(found.values, ["rod.speed"], np.array([0.228])),
    ):
        with pytest.raises(ComputationError, match=r"jump between two samples at t = 0.23 s"):
            ask()


def test_a_jump_at_the_start_has_no_derivative_by_its_time():
    run = {"end": 0.6, "samples": 61}
    found = Differentiated(_swung(begin=0.0), ["final(rod.angle)"], PATHS[:1], run=run)
    with pytest.raises(ComputationError, match=r"jump at the start.*no derivative"):
        found.at(found.values)
    smooth = Differentiated(_swung("polynomial", 0.0), ["final(rod.angle)"], PATHS[:1], run=run)
    exact = smooth.at(smooth.values).derivatives
    assert exact is not None
    assert exact[0, 0] != 0.0


@pytest.mark.parametrize(
    ("law", "path"),
    [
        ("{rise: harmonic, to: 70 deg, begin: 0.23, duration: 0.4}", "drives.arm.law.begin"),
        ('"where(t < start, 0, (t - start)*(t - start)*10)"', "parameters.start"),
    ],
)
def test_means_of_what_jumps_at_a_time_that_moves_are_refused(law, path):
    mechanism = _driven(law)
    run = {"end": 0.8, "samples": 81}
    for measure in ("mean(arm.effort)", "rms(arm.effort)"):
        found = Differentiated(mechanism, [measure], [path], run=run)
        with pytest.raises(ComputationError, match=r"arm.effort jumps at t = 0.23 s"):
            found.at(found.values)
    found = Differentiated(mechanism, ["mean(arm.angle)"], [path], run=run)
    exact = found.at(found.values).derivatives
    assert exact is not None
    difference, error = richardson(
        lambda x: found.at(x, derivatives=False).values, found.values, 0, 1e-3
    )
    # Simpson's rule across a bend of the speed: h^2/12 of it, with h = 5 ms
    assert abs(exact[0, 0] - difference[0]) < 1e-4 * abs(exact[0, 0]) + 10 * error[0]


def test_extremes_next_to_a_jump_that_moves_are_refused_and_others_are_not():
    mechanism = _driven("{rise: harmonic, to: 70 deg, begin: 0.23, duration: 0.4}")
    path, run = "drives.arm.law.duration", {"end": 0.8, "samples": 81}
    found = Differentiated(mechanism, ["min(arm.acceleration)"], [path], run=run)
    with pytest.raises(ComputationError, match=r"arm.acceleration jumps"):
        found.at(found.values)
    found = Differentiated(mechanism, ["max(arm.speed)", "time_of_max(arm.speed)"], [path], run=run)
    exact = found.at(found.values).derivatives
    assert exact is not None
    # speed = A/2 π/d sin(π u), largest at begin + d/2
    largest = np.deg2rad(70) / 2 * np.pi / 0.4
    np.testing.assert_allclose(exact[:, 0], [-largest / 0.4, 0.5], rtol=1e-7)


@pytest.mark.parametrize(
    ("measure", "message"),
    [
        ("time_of_max(arm.angle)", "reached at t = .* and at t = "),
        ("at(0.23 s, arm.effort)", "arm.effort jumps at t = 0.23 s"),
    ],
)
def test_measures_without_a_derivative_say_so(measure, message):
    """On a plateau there is no one time; where a jump moves, no value."""
    mechanism = _driven("{rise: harmonic, to: 70 deg, begin: 0.23, duration: 0.4}")
    run = {"end": 0.8, "samples": 81}
    found = Differentiated(mechanism, [measure], ["drives.arm.law.begin"], run=run)
    with pytest.raises(ComputationError, match=message):
        found.at(found.values)


def test_the_time_of_an_extreme_at_an_end_stays():
    mechanism = _driven("{run-up: {speed: 2, duration: 0.3}}")
    found = Differentiated(
        mechanism, ["time_of_max(arm.angle)"], ["drives.arm.law.run-up.duration"],
        run={"end": 0.8, "samples": 81},
    )  # fmt: skip
    exact = found.at(found.values)
    assert exact.derivatives is not None
    assert (exact.values[0], exact.derivatives[0, 0]) == (0.8, 0.0)


def test_the_end_of_the_simulation_is_no_number_of_the_equations():
    mechanism = linkages.load("slider-crank")
    with pytest.raises(InputError, match=r"simulate.end: this number does not enter"):
        Differentiated(mechanism, ["final(piston.position)"], ["simulate.end"])
