"""Errors in measures: differences from the nominal motion at the same time."""

from __future__ import annotations

import numpy as np
import pytest

import linkages

LENGTHS = ["139.9 mm", "140 mm", "140.2 mm"]


def motion(mechanism, output, **options):
    return linkages.simulate(mechanism, outputs=[output], **options).data[output]


def test_errors_of_driven_motions_are_differences_of_runs():
    engine = linkages.load("slider-crank")
    data = linkages.sweep(
        engine,
        {"bars.rod.length": LENGTHS},
        {"at": "at(13 ms, error(piston.position))", "mean": "mean(error(piston.position))"},
    )
    options = {"end": 0.08, "samples": 80 * 8 + 1}  # 13 ms is a sample
    nominal = motion(engine, "slider_position", **options)
    for k, length in enumerate(LENGTHS):
        other = motion(
            engine.with_values({"bars.rod.length": length}), "slider_position", **options
        )
        error = (other - nominal).to_numpy()[:, 0]
        assert float(data["at"][k]) == pytest.approx(error[13 * 8], abs=1e-16)
        # Simpson's rule over a smooth periodic motion, at other samples
        assert float(data["mean"][k]) == pytest.approx(np.trapezoid(error, dx=1 / 640), abs=1e-12)


def test_errors_of_free_motions_are_taken_at_the_same_time_whatever_the_samples():
    pendulum = linkages.load("pendulum")
    measure = {"e": "at(0.7 s, error(rod.angle))", "most": "max(abs(error(rod.angle)))"}
    over = {"free.rod.angle": [0.5, 0.51]}
    coarse, fine = (
        linkages.sweep(pendulum, over, measure, end=1.0, samples=samples) for samples in (11, 101)
    )
    for name in measure:
        assert coarse[name].to_numpy() == pytest.approx(fine[name].to_numpy(), abs=1e-9)
    one, other = (
        motion(pendulum.with_values(values), "bar_angle", end=1.0, samples=11)[7, 0]
        for values in ({}, {"free.rod.angle": 0.51})
    )
    assert float(coarse["e"][1]) == pytest.approx(float(other - one), abs=1e-9)


def test_errors_may_be_against_another_mechanism():
    engine = linkages.load("slider-crank")
    other = engine.with_values({"bars.rod.length": "141 mm"})
    over = {"bars.rod.length": ["141 mm", "142 mm"]}
    data = linkages.sweep(engine, over, "max(abs(error(piston.position)))", nominal=other)
    first, second = data["max(abs(error(piston.position)))"].to_numpy()
    assert first == 0.0
    assert second == pytest.approx(1e-3 / np.sqrt(1 - (40 / 141.5) ** 2), rel=1e-3)


def test_points_that_do_not_differ_are_all_answered():
    rows = [[0.0401, 0.14]] * 20
    data = linkages.sweep(
        linkages.load("slider-crank"),
        {("bars.crank.length", "bars.rod.length"): rows},
        "stroke(piston.position)",
    )
    assert data["stroke(piston.position)"].to_numpy() == pytest.approx(np.full(20, 0.0802))


def test_a_single_motion_has_no_errors():
    solution = linkages.simulate(linkages.load("slider-crank"))
    with pytest.raises(ValueError, match="there is no other motion to compare with"):
        linkages.measure(solution, "max(error(piston.position))")


def test_a_nominal_motion_that_stops_is_said():
    engine = linkages.load("slider-crank").with_values({"bars.rod.length": "39 mm"})
    over = {"bars.rod.length": ["140 mm", "141 mm"]}
    with pytest.raises(linkages.LinkagesError, match="nominal motion"):
        linkages.sweep(engine, over, "max(error(piston.position))")
