"""Largest values among samples, and what samples may miss."""

import numpy as np
import pytest
import xarray as xr

import linkages
from linkages.solution.solution import _maxima


def missed(values):
    """The row's estimate for a series."""
    array = xr.DataArray(values, dims="time", coords={"time": np.arange(len(values))}, name="x")
    (row,) = _maxima(array.assign_attrs(units="", long_name="x"))
    assert row["value"] == values[np.argmax(np.abs(values))]
    return row["missed"]


@pytest.mark.parametrize("shift", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("per_period", [6, 20, 60])
def test_a_single_peak_is_missed_by_no_more_than_said(per_period, shift):
    """cos t, one period, with samples beside the peak: 1 − cos(h/2) at most."""
    step = 2 * np.pi / per_period
    samples = np.cos(step * (np.arange(-per_period // 2, per_period // 2) + shift))[1:-1]
    truth = 1 / samples.max() - 1
    # the parabola is the start of the cosine: its fourth order is missing
    assert missed(samples) >= 0.8 * truth
    assert missed(samples) <= 1.5 * step**2 / 8


def test_many_peaks_alike_are_resolved_by_few_samples_each():
    samples = np.cos(np.arange(2000.0))  # 6.3 samples in a period, 318 periods
    assert samples.max() > 0.9999
    assert missed(samples) < 1e-4


def test_a_spike_of_one_sample_is_not_resolved():
    samples = np.zeros(101)
    samples[50] = 3.0
    assert missed(samples) > 0.2


def test_joint_reactions_have_magnitudes():
    mechanism = linkages.load("four-bar", set={"simulate.samples": 101})
    solution = linkages.simulate(mechanism, outputs=["joint_reaction", "joint_position"])
    rows = solution.maxima
    assert {row["variable"] for row in rows} == {"joint_reaction"}
    sizes = np.hypot(*(solution.data.joint_reaction.sel(axis=axis) for axis in "xy"))
    for row in rows:
        assert row["value"] == pytest.approx(float(sizes.sel(joint=row["element"]).max()))
