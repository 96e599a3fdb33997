"""Derivatives where laws of time jump at times that are numbers of the definition."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from design_differences import TWO_JUMPS, compared, richardson

import linkages
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design import differentiated
from linkages.design.differentiated import Differentiated
from linkages.design.law_breaks import APART, Break, _each_once, breaks
from linkages.errors import ComputationError, InputError
from linkages.kernel.number_effects import effects, numbers_of
from linkages.kernel.system import System

PATHS = ["drives.arm.law.begin", "drives.arm.law.duration", "bars.rod.length", "free.rod.angle"]


def _swung(rise: str = "harmonic", begin: float = 0.23) -> Mechanism:
    return linkages.loads(f"""
name: pendulum on an arm that starts and stops
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  arm: {{joints: [O, A], length: 0.2, mass: 1}}
  rod: {{joints: [A, B], length: 0.5, mass: 1.5}}
drives: {{arm: {{law: {{rise: {rise}, from: 0 deg, to: 70 deg, begin: {begin}, duration: 0.4}}}}}}
free: {{rod: {{angle: -80 deg, speed: 0}}}}
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


@pytest.mark.slow
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


def test_derivatives_are_known_between_the_samples_around_a_jump():
    """At 2 ms before the jump and 3 ms behind it, within the interval of samples of 5 ms."""
    run = {"end": 0.4, "samples": 80, "rtol": 1e-12}
    times, paths = np.array([0.228, 0.233]), PATHS
    found = Differentiated(_swung(), [], paths, run=run)
    missed, attainable = compared(found, ["rod.speed"], times, [0, 1, 2, 3], 1e-3)
    assert (missed <= 3e-8 + 10 * attainable).all()


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
def test_means_of_what_jumps_at_a_time_that_moves_change_by_the_jump(law, path):
    """The rms of the speed does not change: its differences are round-off, as is the derivative."""
    measures = ["mean(arm.effort)", "rms(arm.effort)", "mean(arm.angle)", "rms(arm.speed)"]
    found = Differentiated(_driven(law), measures, [path], run={"end": 0.8, "samples": 81})
    exact = found.at(found.values).derivatives
    assert exact is not None
    difference, error = richardson(
        lambda x: found.at(x, derivatives=False).values, found.values, 0, 1e-3
    )
    assert (abs(exact[:, 0] - difference) <= 1e-14 + 1e-9 * abs(exact[:, 0]) + 10 * error).all()
    assert abs(exact[0, 0]) > 0.1  # without the jump there is no more than a part of it


def test_extremes_at_a_jump_that_moves_follow_it():
    """Acceleration A/2 (π/d)² cos(π u): largest behind begin, least before begin + d."""
    mechanism = _driven("{rise: harmonic, to: 70 deg, begin: 0.23, duration: 0.4}")
    paths, run = ["drives.arm.law.begin", "drives.arm.law.duration"], {"end": 0.8, "samples": 81}
    measures = [f"{each}(arm.acceleration)" for each in ("min", "time_of_min", "max")]
    measures += ["max(arm.speed)", "time_of_max(arm.speed)"]
    found = Differentiated(mechanism, measures, paths, run=run)
    evaluated = found.at(found.values)
    bend, speed = np.deg2rad(70) / 2 * (np.pi / 0.4) ** 2, np.deg2rad(70) / 2 * np.pi / 0.4
    np.testing.assert_allclose(evaluated.values, [-bend, 0.63, bend, speed, 0.43], rtol=1e-12)
    closed = [[0, 2 * bend / 0.4], [1, 1], [0, -2 * bend / 0.4], [0, -speed / 0.4], [1, 0.5]]
    # the rate beside the jump is that of a polynomial of degree 24
    np.testing.assert_allclose(evaluated.derivatives, closed, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize(
    ("measure", "message"),
    [
        ("time_of_max(arm.angle)", "reached at t = .* and at t = "),
        ("at(0.23 s, arm.effort)", "jumps at t = 0.23 s, and numbers move that time"),
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


def test_two_jumps_between_two_looks_are_found():
    """A push of 0.1 ms, half of what lies between two looks: the mean is 5 N m · 2 w/T."""
    mechanism = linkages.loads("""
joints: {O: [0, 0]}
parameters: {width: 5e-5}
bars: {arm: {joints: [O, A], length: 0.2, mass: 1}}
drives: {arm: {angle: 0, speed: 1}}
loads: [{bar: arm, torque: "where(abs(t - 0.40009) < width, -5, 0)"}]
""")
    run = {"end": 0.8, "samples": 81}
    found = Differentiated(mechanism, ["mean(arm.effort)"], ["parameters.width"], run=run)
    evaluated = found.at(found.values)
    assert evaluated.derivatives is not None
    # times near 0.4 s are known to 5e-17 s, and sides are 1e-15 s apart
    np.testing.assert_allclose(evaluated.values, [5 * 2 * 5e-5 / 0.8], rtol=1e-9)
    np.testing.assert_allclose(evaluated.derivatives, [[5 * 2 / 0.8]], rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "bar", "limit"), [("four-bar", "coupler", 0.73),
                                                    ("class-three", "leg1", 1.03)])  # fmt: skip
def test_laws_of_state_jump_in_driven_motions_at_times_that_move(name, bar, limit):
    """Nothing is integrated, so jumps are no modes; loops close by formulas or by iteration."""
    definition = yaml.safe_load(linkages.load(name).to_yaml())
    definition["parameters"] = {"limit": limit, "push": 20}
    definition["loads"] = [
        {"bar": bar, "torque": f"where({bar}.angle > limit, push, -push)"},
        *(definition.get("loads") or []),
    ]
    paths = ["parameters.limit", "parameters.push"]
    measures = ["mean(abs(crank.effort))", "rms(crank.effort)", "max(crank.effort)"]
    found = Differentiated(
        linkages.loads(yaml.safe_dump(definition)), measures, paths,
        run={"end": 1.0, "samples": 201},
    )  # fmt: skip
    exact = found.at(found.values).derivatives
    assert exact is not None
    assert abs(exact[1, 0]) > 0.1
    for number, value in enumerate(found.values):
        difference, error = richardson(
            lambda x: found.at(x, derivatives=False).values, found.values, number, 1e-3 * value
        )
        scale = np.abs(exact[:, number]) + 1e-3  # of efforts of about 10 N m
        # round-off, and iterations that end at 1e-12
        assert (np.abs(exact[:, number] - difference) <= 1e-8 * scale + 10 * error).all()


def test_a_break_is_the_first_time_on_its_other_side():
    mechanism = _driven('"where(t < start, 0, (t - start)*(t - start)*10)"')
    system = System(mechanism)
    numbers = effects(system, numbers_of(mechanism, ["parameters.start"]))
    law = system.model.positions.laws["arm"]
    (found,) = breaks(system, [law.acceleration], numbers, 0.8)
    assert found.time == 0.23
    assert found.before < found.time < found.behind
    np.testing.assert_allclose(found.moved, [1.0], rtol=1e-12)


def _apart(roundings: int, *moved: list[float]) -> list[Break]:
    """Breaks a number of roundings of their time apart, with what they move by."""
    step = float(np.spacing(0.8))
    times = [0.3 + k * roundings * step for k in range(len(moved))]
    return [
        Break(time, time - APART * step, time + APART * step, np.array(rates))
        for time, rates in zip(times, moved, strict=True)
    ]


def test_breaks_that_overlap_and_move_alike_are_one():
    """Motions are led from one side of a break to the other, and must not be led back."""
    assert len(_each_once(_apart(2 * APART - 2, [1.0, 0.0], [1.0, 0.0]))) == 1
    assert len(_each_once(_apart(2 * APART - 2, [1.0, 0.0], [1.0, 0.5]))) == 2
    assert len(_each_once(_apart(2 * APART + 2, [1.0, 0.0], [1.0, 0.0]))) == 2


def test_jumps_at_one_time_that_numbers_part_have_no_derivative():
    mechanism = linkages.loads(TWO_JUMPS)
    paths, run = ["parameters.one", "parameters.other"], {"end": 0.8, "samples": 81}
    found = Differentiated(mechanism, ["mean(arm.effort)"], paths, run=run)
    with pytest.raises(ComputationError, match="no finite derivative"):
        found.at(found.values)
    evaluated = found.at(np.array([0.3, 0.4]))
    np.testing.assert_allclose(evaluated.derivatives, [[1 / 0.8, 4 / 0.8]], rtol=1e-9)
