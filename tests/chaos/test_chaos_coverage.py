"""Errors of exponents cover the truth: in 95 % of runs of every kind, whatever their length.

"Cover" means within two standard errors. Of 200 runs with an error that is right 191 ± 3 are
covered; fewer than 186 (93 %) are a fault. Errors along regular motions are bounds and cover more;
they must not be absurdly large either: on average within a few times the true deviation.

Runs are growth rates of maps with known exponents, many initial states side by side, each cut to
a length of its own; linkages are in `test_chaos_coverage_linkages.py`.
"""

import math

import numpy as np
import pytest

from linkages.chaos.averages import drift, mean_error
from linkages.chaos.exponents import DRIFTS, Exponents

RUNS = 200
LEAST = 0.93
ROUND_OFF = 1e-12


def logistic(rng, r, count, skip):
    x = rng.uniform(0.05, 0.95, RUNS)
    growth = np.empty((count, RUNS))
    for n in range(-skip, count):
        if n >= 0:
            growth[n] = np.log(np.abs(r * (1 - 2 * x)))
        x = r * x * (1 - x)
    return growth


def cycle(r, period):
    """Exponent of the stable cycle: its points by Newton's method from where the map goes."""
    x = 0.3
    for _ in range(100_000):
        x = r * x * (1 - x)
    for _ in range(3):
        y, slope = x, 1.0
        for _ in range(period):
            y, slope = r * y * (1 - y), slope * r * (1 - 2 * y)
        x -= (y - x) / (slope - 1)
    return math.log(abs(slope)) / period


def periodic(rng, period, count):
    """Growth of any cycle of a period, in every phase."""
    values = rng.normal(size=(period, RUNS))
    values -= values.mean(axis=0)
    places = np.arange(count)[:, None] + rng.integers(period, size=RUNS)
    return np.take_along_axis(values, places % period, axis=0)


def circle(rng, coupling, shift, count):
    """θ → θ + Ω − K/2π sin 2πθ for K < 1: quasi-periodic, conjugate to a rotation (Denjoy)."""
    x, growth = rng.uniform(size=RUNS), np.empty((count, RUNS))
    for n in range(count):
        growth[n] = np.log(1 - coupling * np.cos(2 * np.pi * x))
        x = (x + shift - coupling / (2 * np.pi) * np.sin(2 * np.pi * x)) % 1
    return growth


def standard(rng, coupling, momenta, count):
    """Chirikov's map far from its resonances: rotational tori, tangents grow like the time."""
    angle, momentum = rng.uniform(-np.pi, np.pi, RUNS), rng.uniform(*momenta, RUNS)
    direction = rng.uniform(0, 2 * np.pi, RUNS)
    u, v = np.cos(direction), np.sin(direction)
    growth = np.empty((count, RUNS))
    for n in range(count):
        v = v + coupling * np.cos(angle) * u
        u = u + v
        momentum = momentum + coupling * np.sin(angle)
        angle = angle + momentum
        length = np.hypot(u, v)
        u, v, growth[n] = u / length, v / length, np.log(length)
    return growth


def henon(rng, count):
    x, y = rng.uniform(-0.1, 0.1, (2, RUNS))
    u, v = np.ones(RUNS), np.zeros(RUNS)
    growth = np.empty((count, RUNS))
    for n in range(-100, count):
        u, v = -2.8 * x * u + v, 0.3 * u
        x, y = 1 - 1.4 * x * x + y, 0.3 * x
        length = np.hypot(u, v)
        u, v = u / length, v / length
        if n >= 0:
            growth[n] = np.log(length)
    return growth


def tent(rng, place, count):
    """Slopes 1/a and −1/(1 − a), met with probabilities a and 1 − a."""
    met = rng.uniform(size=(count, RUNS)) < place
    return np.where(met, -math.log(place), -math.log(1 - place))


def autoregressive(rng, factor, count, runs=RUNS):
    noise = rng.normal(size=(count + 300, runs))
    for n in range(1, len(noise)):
        noise[n] += factor * noise[n - 1]
    return noise[300:]


def settling(rng, count):
    """A transient, then a cycle of eight."""
    place = np.arange(count)[:, None]
    decay = rng.uniform(2, count / 30, RUNS)
    start = rng.uniform(1, 6, RUNS) * rng.choice([-1, 1], RUNS)
    return start * np.exp(-place / decay) + np.cos(2 * np.pi * place / 8 + start) - 0.06


def regular_runs(rng, count):
    """Name → growth and the exponent, of orbits whose sums are bounded."""
    for period, r in ((2, 3.3), (4, 3.5), (8, 3.55), (16, 3.566), (6, 3.8433)):
        yield f"cycle {period}", logistic(rng, r, count, 20_000), cycle(r, period)
    for period in (2, 3, 8, 12, 24, 32):
        yield f"period {period}", periodic(rng, period, count), 0.0
    yield "circle 0.8", circle(rng, 0.8, (math.sqrt(5) - 1) / 2, count), 0.0
    yield "circle 0.3", circle(rng, 0.3, math.sqrt(3) - 1, count), 0.0


def chaotic_runs(rng, count):
    yield "logistic map", logistic(rng, 4.0, count, 100), math.log(2)
    yield "Hénon's map", henon(rng, count), 0.419217
    yield "tent map", tent(rng, 0.3, count), -0.3 * math.log(0.3) - 0.7 * math.log(0.7)
    for factor in (0.5, -0.5, -0.9):
        yield f"AR {factor}", autoregressive(rng, factor, count), 0.0


def covered(rng, growth, truth, shortest):
    """Part of runs of random lengths that cover the truth, and mean error by true deviation."""
    lengths = rng.integers(shortest, len(growth) + 1, RUNS)
    means = np.array([growth[:n, k].mean() for k, n in enumerate(lengths)])
    errors = np.array([mean_error(growth[:n, k])[0][0] for k, n in enumerate(lengths)])
    apart = np.abs(means - truth)
    ratio = math.sqrt(np.mean(errors**2) / np.mean(apart**2))
    return float(np.mean(apart <= 2 * errors + ROUND_OFF)), ratio


def settled(rng, growth, shortest):
    """Part of runs of random lengths that do not drift, and whose error can be trusted."""
    lengths = rng.integers(shortest, len(growth) + 1, RUNS)
    runs = [growth[:n, k] for k, n in enumerate(lengths[: RUNS // 4])]
    return float(np.mean([drift(run)[0] <= DRIFTS and mean_error(run)[1][0] for run in runs]))


@pytest.mark.slow
def test_cycles_and_tori_are_covered_and_settled():
    """Two errors are more than the range of sums, so that all are covered; none drifts by chance.

    Where phases are spread evenly the deviation is about 0.4 of the range, the error 0.8 of it:
    the ratio is about two, less where a cycle has few phases, more where few ends are far out.
    """
    rng = np.random.default_rng(1)
    for name, growth, truth in regular_runs(rng, 700):
        part, ratio = covered(rng, growth, truth, 100)
        assert part == 1.0, name
        assert 1.2 < ratio < 8.0, (name, ratio)
        # a quarter of the run, 32 of it and more, sees every one of these cycles
        assert settled(rng, growth, 128) == 1.0, name


@pytest.mark.slow_except("200")
@pytest.mark.parametrize("count", [200, 1000])
def test_chaos_is_covered(count):
    """Errors of the logistic map are too large: its growth is nearly the increment of a series."""
    rng = np.random.default_rng(2)
    for name, growth, truth in chaotic_runs(rng, count):
        part, ratio = covered(rng, growth, truth, count - 70)
        assert part >= LEAST, (name, part)
        assert 0.9 < ratio < (8 if name == "logistic map" else 1.5), (name, ratio)
        assert (drift(growth) <= DRIFTS).mean() >= 0.98, name


@pytest.mark.parametrize("coupling", [0.05, 0.2, 0.3])
def test_tangents_that_grow_like_the_time_are_covered(coupling):
    """ln n / n after n steps, where zero is true; the error is near the deviation itself."""
    rng = np.random.default_rng(3)
    growth = standard(rng, coupling, (0.8, 1.9), 1200)
    part, ratio = covered(rng, growth, 0.0, 250)
    assert part >= LEAST
    assert 0.9 < ratio < 1.4


def test_transients_are_covered_and_said_to_drift():
    """The sum of a transient is bounded like that of a cycle."""
    rng = np.random.default_rng(4)
    growth = settling(rng, 1000)
    part, ratio = covered(rng, growth, -0.06, 600)
    assert part == 1.0
    assert 0.5 < ratio < 2.0
    # sums of transients shorter than some cycles do not stand out of those of the cycle
    strong = np.abs(growth.sum(axis=0) + 60) > 30
    assert strong.sum() > 20
    assert (drift(growth[:, strong]) > DRIFTS).all()


def test_long_correlation_is_covered_or_distrusted():
    """Of AR 0.9, correlated over 20 steps, runs of 64 know no better."""
    rng = np.random.default_rng(5)
    assert mean_error(autoregressive(rng, 0.9, 64))[1].mean() < 0.05
    part, _ = covered(rng, autoregressive(rng, 0.9, 2000), 0.0, 1000)
    assert part >= LEAST


@pytest.mark.slow
def test_sums_of_exponents_are_covered():
    """A sum of several rates is a series of its own: errors of parts do not add up."""
    rng = np.random.default_rng(6)
    parts = []
    for _ in range(RUNS):
        first = autoregressive(rng, 0.5, 500, 2)
        growth = np.stack([first[:, 0], -first[:, 0] + 0.1 * first[:, 1]], axis=1)
        found = Exponents(growth, np.zeros((501, 2)), np.arange(501.0))
        value, error = found.sum
        assert error < 0.3 * found.errors.max()
        parts.append(abs(value) <= 2 * error)
    assert np.mean(parts) >= LEAST


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("count", [128, 300, 1200, 4800])
def test_coverage_whatever_the_length(count, seed):
    """All kinds, at fixed lengths from half of `count` to all of it."""
    rng = np.random.default_rng(100 + seed)
    for name, growth, truth in regular_runs(rng, count):
        part, ratio = covered(rng, growth, truth, count // 2)
        assert part == 1.0, (name, part)
        assert 1.0 < ratio < 10.0, (name, ratio)
    for name, growth, truth in chaotic_runs(rng, count):
        part, _ = covered(rng, growth, truth, count // 2)
        # four standard deviations of the part below 95 %, where the error claims to be right
        assert part >= 0.89 or not mean_error(growth)[1].all(), (name, part)
