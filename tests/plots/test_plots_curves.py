import numpy as np

from linkages.plots.curves import MANY, peak_of, thinned


def test_thinning_keeps_every_peak():
    time = np.linspace(0.0, 1.0, 50 * MANY + 7)
    values = np.sin(300 * time)
    values[[12_345, -2]] = 5.0, -6.0
    x, y = thinned(time, values)
    assert len(x) == len(y) <= MANY
    assert (np.diff(x) >= 0).all()
    assert y.max() == 5.0
    assert y.min() == -6.0
    assert x[np.argmax(y)] == time[12_345]


def test_short_curves_are_left_as_they_are():
    time = np.arange(MANY, dtype=float)
    assert thinned(time, time)[1] is time


def test_thinning_survives_gaps():
    time = np.linspace(0.0, 1.0, 3 * MANY)
    values = np.where(time < 0.5, np.cos(9 * time), np.nan)
    _, y = thinned(time, values)
    assert np.nanmax(y) == 1.0
    assert np.nanmin(y) == np.nanmin(values)


def test_peak_is_the_sample_farthest_from_zero():
    assert peak_of(np.arange(4.0), np.array([1.0, np.nan, -3.0, 2.0])) == (2.0, -3.0)
    assert peak_of(np.arange(2.0), np.full(2, np.nan)) is None
    assert peak_of(np.array([]), np.array([])) is None
