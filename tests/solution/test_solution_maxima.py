"""Largest values among samples, and what samples may miss."""

from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.solution.extremes import largest, local_maxima


def row_of(values, scale=0.0):
    """The peak of a series with samples 0.1 s apart."""
    peak = largest(np.asarray(values, dtype=float), scale)
    return {"value": peak.value, "time": 0.1 * peak.time, "missed": peak.missed}


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("per_period", [6, 12, 20, 60, 200])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_single_peak_is_located_between_samples(per_period, shift, sign):
    """−cos t between 0 and 2π, its peak beside a sample; the estimate covers what is missing."""
    step = 2 * np.pi / per_period
    steps = np.arange(1, per_period)
    samples = -sign * np.cos(step * (steps + shift))
    row = row_of(samples)
    # degree 4: the fifth power is the first one missing, at most step⁵/120·√(32/…) < step⁵/30
    if row["missed"] < 0.01:  # beyond that the largest sample is given
        assert row["value"] == pytest.approx(sign, rel=max(step**5 / 30, 1e-14))
    assert abs(sign) <= abs(row["value"]) * (1 + 1.2 * row["missed"]) + 1e-14
    if per_period > 6:
        assert row["missed"] <= max(0.04 * step**4, 1e-12)  # degree 3: h⁴ (x+2)(x+1)x(x−1)/24
        half = 0.1 * (per_period / 2 - 1 - shift)
        assert row["time"] == pytest.approx(half, abs=0.1 * max(step**4 / 10, 1e-6))


def test_many_peaks_alike_are_resolved_by_few_samples_each():
    samples = np.cos(np.arange(2000.0))  # 6.3 samples in a period, 318 periods
    assert samples.max() > 0.9999
    assert row_of(samples)["missed"] < 1e-4


def test_a_spike_of_one_sample_is_not_resolved():
    samples = np.zeros(101)
    samples[50] = 3.0
    assert row_of(samples)["missed"] > 0.05
    assert row_of(samples[48:52])["missed"] > 0.2  # too few for a polynomial


@pytest.mark.parametrize(
    "samples", [np.ones(50), np.linspace(0, 1, 50), np.linspace(1, 0, 50), np.array([0.0, 1.0])]
)
def test_a_largest_value_at_an_end_is_that_sample(samples):
    row = row_of(samples)
    assert (row["value"], row["missed"]) == (1.0, 0.0)
    assert row["time"] == 0.1 * int(np.argmax(samples))


def test_round_off_has_no_peaks():
    """A bar that translates turns by round-off, beside one that turns."""
    noise = np.random.default_rng(0).normal(scale=1e-13, size=200)
    assert row_of(noise, 2.0)["missed"] == 0.0
    assert row_of(noise, 2.0)["value"] in noise
    assert row_of(noise, np.inf)["missed"] == 0.0


def test_of_peaks_alike_the_first_is_given():
    """It begins at its largest value, and comes back to it between samples and at one."""
    times = np.linspace(0, 6, 181)
    row = row_of(np.cos(np.pi * times))
    assert (row["value"], row["time"], row["missed"] < 1e-4) == (1.0, 0.0, True)
    row = row_of(np.sin(np.pi * times + 0.01))
    assert row["value"] == pytest.approx(1.0, abs=1e-6)
    assert row["time"] == pytest.approx(0.1 * (0.5 - 0.01 / np.pi) * 30, abs=0.01)


@pytest.mark.slow
def test_a_steady_motion_has_no_peaks_to_miss():
    """Three parallel cranks: speeds are constant, the plate translates, the rest is round-off."""
    path = Path(__file__).parents[1] / "data" / "redundant" / "three-cranks.yaml"
    for row in linkages.simulate(linkages.load(path)).maxima:
        if row["variable"] in ("bar_speed", "bar_acceleration"):
            assert row["missed"] < 1e-9, row


def test_maxima_do_not_depend_on_samples():
    """A slider-crank's speeds and forces with a hundredth of the samples: the same digits."""
    few, many = (
        linkages.simulate(linkages.load("slider-crank"), samples=n).maxima for n in (201, 20001)
    )
    for one, other in zip(few, many, strict=True):
        if not one["variable"].endswith("residual"):
            # a stroke has two ends: which of two equal peaks is found is round-off
            # the size of a vector that passes through zero has a kink there, found to 1e-7
            size = max(abs(other["least"]), abs(other["greatest"]))
            for key in ("least", "greatest"):
                assert one[key] == pytest.approx(other[key], rel=1e-9, abs=1e-7 * size), one
            assert one["missed"] == 0.0


def test_joint_reactions_have_magnitudes():
    mechanism = linkages.load("four-bar", set={"simulate.samples": 101})
    solution = linkages.simulate(mechanism, outputs=["joint_reaction", "joint_position"])
    rows = solution.maxima
    assert {row["variable"] for row in rows} == {"joint_reaction"}
    sizes = np.hypot(*(solution.data.joint_reaction.sel(axis=axis) for axis in "xy"))
    for row in rows:
        largest = float(sizes.sel(joint=row["element"]).max())  # of the samples
        assert largest <= row["value"] == pytest.approx(largest, rel=2e-3)


def test_a_plateau_has_local_maxima_from_end_to_end():
    """A small change of the mechanism may raise either end of it."""

    def clipped(places):
        return np.minimum(np.cos(0.2 * (places - 10.3)), 0.9)

    found = local_maxima(clipped(np.arange(21.0)), clipped)
    assert (found.value == 0.9).all()
    # arccos(0.9)/0.2 = 2.26 samples on each side of 10.3: samples 9 to 12
    assert found.place[0] <= 9.0
    assert found.place[-1] >= 11.0


def test_local_maxima_beside_higher_ones_and_poles():
    """Each is located between its neighbours; samples without a value are none."""
    values = np.array([0.0, 1.0, 0.5, 2.0, 0.0, 1.5, np.inf, 1.0, 1.2, 0.3, np.nan, 0.1])

    def between(places):
        with np.errstate(invalid="ignore"):
            return np.interp(places, np.arange(len(values)), values)

    found = local_maxima(values, between)
    assert found.place.tolist() == [1.0, 3.0, 8.0]
    assert found.value.tolist() == [1.0, 2.0, 1.2]
