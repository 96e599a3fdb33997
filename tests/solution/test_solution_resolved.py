"""Samples for figures: every swing shows, and the motion stays the same."""

import numpy as np
import pytest

import linkages
from linkages.solution.resolved import PER_SWING, per_swing, resolved, turning_points


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


def test_curves_between_few_samples(ninebar):
    """A run with fifty times as many samples is what they must agree with."""
    names = ["clearance_force", "slider_acceleration_error"]
    data = resolved(ninebar, names)
    assert set(data.data_vars) == set(names)
    assert per_swing(data, names) >= PER_SWING > per_swing(ninebar.data, names)
    fine = linkages.simulate(linkages.load("ninebar"), end=0.5, samples=25_001, outputs=names)
    for name in names:
        top, all_of = float(abs(data[name]).max()), float(abs(fine.data[name]).max())
        # cos(π/40) of the top is the least that samples at this distance may have
        assert np.cos(np.pi / PER_SWING) * all_of <= top <= all_of * (1 + 1e-6)
        found = data[name].interp(time=ninebar.data["time"])
        # the same motion: interpolation between samples is off by θ²/8 of the amplitude at most
        assert found.to_numpy() == pytest.approx(ninebar.data[name].to_numpy(), abs=0.01 * all_of)
    assert data.attrs == ninebar.data.attrs


def test_swings_that_samples_pass_over_are_found():
    """One sample per swing looks like a slow curve, but the steps tell."""
    mechanism = linkages.load("ninebar")
    solution = linkages.simulate(mechanism, end=0.5, samples=46, outputs=["clearance_speed"])
    fine = linkages.simulate(mechanism, end=0.5, samples=25_001, outputs=["clearance_speed"])
    few, found, all_of = (
        turning_points(data["clearance_speed"].to_numpy()[:, 0])
        for data in (solution.data, resolved(solution, ["clearance_speed"]), fine.data)
    )
    assert few < 0.2 * all_of
    assert found == all_of


def test_samples_that_show_every_swing_are_kept():
    solution = linkages.simulate(linkages.load("slider-crank"))
    assert resolved(solution, ["slider_velocity"]).equals(solution.data)


def test_a_motion_that_took_long_is_not_computed_again(ninebar, monkeypatch):
    monkeypatch.setattr("linkages.solution.resolved.MOST_EVALUATIONS", 1000)
    assert resolved(ninebar, ["clearance_force"]) is ninebar.data


def test_a_motion_that_stops_is_shown_up_to_there():
    mechanism = linkages.load("ninebar", set={"assembly.E": "left"})
    with pytest.raises(linkages.IncompleteError) as caught:
        linkages.simulate(mechanism, samples=401)
    data = resolved(caught.value.solution, ["clearance_force"])
    last = float(caught.value.solution.data.time[-1])
    assert last <= float(data.time[-1]) < caught.value.time
    assert data.sizes["time"] > 4 * 300
