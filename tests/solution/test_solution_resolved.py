"""Motions looked at closely: every swing shows, and the motion stays the same."""

import numpy as np
import pytest

import linkages
from linkages.solution.run_options import PER_SWING, samples_per_swing, turning_points


@pytest.fixture(scope="module")
def ninebar():
    """The clearance swings about 90 times a second: 11 samples each."""
    return linkages.simulate(linkages.load("ninebar"), end=0.5, samples=501)


def test_turning_points_do_not_count_round_off():
    time = np.linspace(0.0, 1.0, 1001)
    wave = np.cos(2 * np.pi * 5 * time)
    noise = 1e-12 * np.resize([1.0, -1.0], 1001)
    assert turning_points(wave) == turning_points(wave + noise) == 9
    assert turning_points(1.0 + noise) == turning_points(np.zeros(5)) == 0
    assert turning_points(np.full(5, np.nan)) == turning_points(np.zeros(2)) == 0


def swings(data, names):
    return samples_per_swing([data[name].to_numpy() for name in names])


def test_curves_between_few_samples(ninebar):
    """A run with fifty times as many samples is what they must agree with."""
    names = ["clearance_force", "slider_acceleration_error"]
    data = ninebar.dense(names)
    assert set(data.data_vars) == set(names)
    assert swings(data, names) >= PER_SWING > swings(ninebar.data, names)
    fine = linkages.simulate(linkages.load("ninebar"), end=0.5, samples=25_001, outputs=names)
    rows = {row["variable"]: row for row in ninebar.maxima}
    for name in names:
        top, all_of = float(abs(data[name]).max()), float(abs(fine.data[name]).max())
        # cos(π/40) of the top is the least that samples at this distance may have
        assert np.cos(np.pi / PER_SWING) * all_of <= top <= all_of * (1 + 1e-4)
        found = data[name].interp(time=ninebar.data["time"])
        # the same motion: interpolation between samples is off by θ²/8 of the amplitude at most
        assert found.to_numpy() == pytest.approx(ninebar.data[name].to_numpy(), abs=0.01 * all_of)
        # 280 samples of a swing, whose peak is a tenth of it: (π/28)²/32 below its top at most
        assert all_of * (1 - 1e-9) <= abs(rows[name]["value"]) <= all_of * (1 + 4e-4)
        ((_, (value, time)),) = data[name].attrs["farthest"].items()
        assert (value, time) == (rows[name]["value"], rows[name]["time"])
    assert data.attrs == ninebar.data.attrs


@pytest.mark.parametrize(("few", "many"), [(46, 501), (2, 2001)])
def test_peaks_do_not_depend_on_samples(few, many):
    """With one sample per swing, or none at all: figures and tables show the motion."""
    mechanism = linkages.load("ninebar")
    names = ["clearance_speed", "drive_effort", "slider_acceleration_error"]
    found, other = (
        linkages.simulate(mechanism, end=0.1, samples=n, outputs=names) for n in (few, many)
    )
    for one, two in zip(found.maxima, other.maxima, strict=True):
        for key in ("least", "greatest", "value"):
            # quintic polynomials through four samples a step: 1e-9 of the amplitude
            assert one[key] == pytest.approx(two[key], rel=1e-8), (one["variable"], key)
        assert one["missed"] == two["missed"] == 0.0
    turns = [
        turning_points(solution.dense(names)["clearance_speed"].to_numpy()[:, 0])
        for solution in (found, other)
    ]
    assert turns[0] == turns[1] > 15


def test_a_drive_that_turns_fast_is_followed_whatever_the_samples():
    """Forty turns, samples at whole ones: all alike, though the piston strokes eighty times."""
    mechanism = linkages.load("slider-crank")
    turn = 0.04  # of 1500 rpm
    solution = linkages.simulate(mechanism, end=40 * turn, samples=41)
    assert np.ptp(solution.data.slider_position.to_numpy()) < 1e-12
    data = solution.dense(["slider_position"])
    assert turning_points(data["slider_position"].to_numpy()[:, 0]) == 79


def test_round_off_is_no_oscillation():
    """Accelerations of a parallelogram whose crank turns steadily are zero but for round-off."""
    text = """
name: Parallelogram
joints: {A: [0, 0], D: [0.3, 0]}
bars:
  crank: {joints: [A, B], length: 0.1}
  coupler: {joints: [B, C], length: 0.3}
  rocker: {joints: [D, C], length: 0.1}
drives: {crank: {angle: 0.7, speed: 1}}
assembly: {C: [0.37, 0.06]}
simulate: {end: 1, samples: 11}
"""
    solution = linkages.simulate(linkages.loads(text))
    assert solution.dense(["bar_acceleration"]).sizes["time"] < 50_000


def test_a_motion_that_took_long_keeps_its_samples_and_says_so(ninebar, monkeypatch):
    monkeypatch.setattr("linkages.solution.dense.MOST", 501)
    solution = linkages.simulate(linkages.load("ninebar"), end=0.5, samples=501)
    data = solution.dense(["clearance_force"])
    own = solution.data["clearance_force"].to_numpy()
    assert data["clearance_force"].to_numpy() == pytest.approx(own, rel=1e-12)
    (row,) = (row for row in solution.maxima if row["variable"] == "clearance_force")
    (true,) = (row for row in ninebar.maxima if row["variable"] == "clearance_force")
    assert row["missed"] > 0.0
    assert row["value"] < true["value"]


@pytest.mark.slow
def test_a_motion_that_stops_is_shown_up_to_there():
    mechanism = linkages.load("ninebar", set={"assembly.E": "left"})
    with pytest.raises(linkages.IncompleteError) as caught:
        linkages.simulate(mechanism, samples=401)
    data = caught.value.solution.dense(["clearance_force"])
    last = float(caught.value.solution.data.time[-1])
    assert float(data.time[-1]) == last < caught.value.time
    assert data.sizes["time"] > 4 * 300
