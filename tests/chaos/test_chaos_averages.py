"""Errors of means: against closed forms for independent and correlated series."""

import numpy as np
import pytest

from linkages.chaos.averages import drift, mean_error, slow_error


def autoregressive(factor, count, series, seed=3):
    noise = np.random.default_rng(seed).normal(size=(count, series))
    values = np.zeros_like(noise)
    for n in range(1, count):
        values[n] = factor * values[n - 1] + noise[n]
    return values


@pytest.mark.parametrize("factor", [0.0, 0.5, 0.9, -0.5])
def test_error_of_autoregressive_series(factor):
    """The mean of x' = f x + noise has variance 1 / (n (1 - f)²).

    An error from b blocks scatters by 1/√(2b), here 30 % at most; the mean of 40 by 5 %; finite
    blocks miss correlation of some percent.
    """
    errors, trusted = mean_error(autoregressive(factor, 4096, 40))
    assert trusted.all()
    assert errors.mean() == pytest.approx(1 / (64 * (1 - factor)), rel=0.2)


def test_bounded_sums_give_small_errors():
    """Increments of a bounded series: the mean is within its bound / n, 1/n for noise from 0 to 1.

    Blocks of n/8 have errors of about √(1/6)·8/(n √8); ordinary errors would be 20 times that.
    """
    noise = np.random.default_rng(0).uniform(size=4097)
    errors, trusted = mean_error(np.diff(noise))
    assert trusted.all()
    assert errors[0] < 4 / 4096


def test_correlation_as_long_as_the_series_is_not_trusted():
    walk = np.cumsum(np.random.default_rng(1).normal(size=1024))
    assert not mean_error(walk)[1][0]


def test_drift_of_stationary_series_and_of_others():
    """A range of four normal numbers passes 6 about once in 6000 cases; errors scatter too."""
    stationary = autoregressive(0.5, 2048, 40)
    assert (drift(stationary) > 6).mean() <= 0.05
    shifted = stationary.copy()
    shifted[:700] += 2.0  # 1.7 standard deviations
    assert (drift(shifted) > 6).all()
    assert drift(np.full(64, 2.0))[0] == 0


def test_too_short():
    with pytest.raises(ValueError, match="at least 16"):
        mean_error(np.zeros(15))


def test_long_cycles_are_wrong_by_their_range_alone():
    """Short blocks see bounded sums as diffusion, up to ten times too large; long ones tell.

    The range of the partial sums is that of one cycle, or a little more where the unfinished one
    at the end tilts them.
    """
    rng = np.random.default_rng(3)
    for _ in range(40):
        values = rng.normal(size=24)
        values -= values.mean()
        bound = np.sqrt(2 / np.pi) * np.ptp(np.append(np.cumsum(values), 0.0)) / 4701
        error = mean_error(np.resize(values, 4701))[0][0]
        assert bound < error < 2 * bound


@pytest.mark.parametrize(("apart", "alike"), [(5e-5, True), (1e-3, False)])
def test_parts_that_look_alike_in_print_do_not_drift(apart, alike):
    """Parts without any scatter of their own, as where tangents converge to those of a rest."""
    series = np.repeat([1.0 - apart, 1.0, 1.0, 1.0], 20)
    assert bool(drift(series)[0] == 0) is alike


@pytest.mark.parametrize("since", [0.1, 3.0, 100.0, 1e4])
@pytest.mark.parametrize("length", [0.25, 2.0])
def test_rates_that_fall_like_one_over_time(since, length):
    """Means of 1/(t + s), in closed form; batches see nothing of it where s is large."""
    times = since + length * np.arange(401)
    rates = np.diff(np.log(times))[:, None] * [1.0, -1.0] / length - 0.7
    exact = np.log(times[-1] / times[0]) / (400 * length)
    assert slow_error(rates, length) == pytest.approx([exact, exact], rel=1e-6)


def test_other_series_have_no_slow_error():
    """Chaos, cycles and transients; of independent numbers one in a hundred looks smooth."""
    noise = autoregressive(0.5, 1024, 200)
    assert (slow_error(noise, 1.0) > 0).mean() <= 0.02
    number = np.arange(1024.0)
    assert slow_error(np.sin(0.1 * number), 1.0) == 0
    small = np.exp(-0.01 * number)
    assert slow_error(1e-3 * small, 1.0) == 0
    assert slow_error(small, 1.0) == pytest.approx(small.mean(), rel=0.01)  # what it is wrong by
