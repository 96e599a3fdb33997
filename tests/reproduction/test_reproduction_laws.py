"""How the spread of α̇ goes with the size of the clearance and with the speed."""

import numpy as np
import pytest
from make.reproduction import judgements, spreads
from make.reproduction.reported import SIZE, press

import linkages

STARTS = spreads.start_angles(120)
"""Three of the page's six."""

PERIODS = 20


@pytest.fixture(scope="module")
def sizes():
    data = spreads.over_sizes(np.geomspace(2.5e-5, 5e-4, 4), STARTS, PERIODS)
    return data[SIZE].to_numpy(), spreads.spread(data)


@pytest.fixture(scope="module")
def speeds():
    factors = np.array([0.25, 0.5, 1.0, 1.5, 4.0, 5.0, 10.0, 20.0, 40.0])
    data = spreads.over_speeds(np.pi * factors, [*STARTS, *spreads.own_starts()[:1]], PERIODS)
    return factors, spreads.spread(data)


def test_power_law_of_exact_points():
    x = np.array([1.0, 2.0, 5.0, 7.0])
    law = spreads.power_law(x, 3 * x**-0.5)
    assert law.exponent == pytest.approx(-0.5, abs=1e-12)
    assert law.at(x) == pytest.approx(3 * x**-0.5)


def test_error_of_a_power_law_covers_its_scatter():
    """Over many samples the fitted exponents scatter by the error that is given."""
    random = np.random.default_rng(1)
    x = np.geomspace(1, 100, 10)
    laws = [spreads.power_law(x, x**-0.5 * np.exp(random.normal(0, 0.2, 10))) for _ in range(400)]
    scatter = np.std([law.exponent for law in laws])
    given = np.sqrt(np.mean([law.error**2 for law in laws]))
    assert given == pytest.approx(scatter, rel=0.15)  # 400 samples: 4 %, and few points each
    assert np.mean([law.agrees(-0.5) for law in laws]) == pytest.approx(0.99, abs=0.015)


def test_libration_follows_the_law_of_a_pendulum():
    """α̇ ~ (F / M r)^½: let go at the same angle, only r sets the rate of a regular libration."""
    sizes = np.geomspace(2.5e-5, 5e-4, 4)
    peaks = []
    for size in sizes:
        run = linkages.simulate(press(changes={SIZE: size}), outputs=["clearance_speed"])
        peaks.append(float(np.abs(run.data.clearance_speed).max()))
    law = spreads.power_law(sizes, np.array(peaks))
    assert law.exponent == pytest.approx(-0.5, abs=0.02)  # samples beside the very peak


@pytest.mark.slow
def test_claim_on_size(sizes, grades):
    r, found = sizes
    law, losses = spreads.size_laws(r, found)
    (judged,) = judgements.of_sizes(losses, law)
    assert judged.grade == grades["f"]
    assert law.exponent == pytest.approx(-0.5, abs=0.2)  # few points of chaotic motions


@pytest.mark.slow
def test_claim_on_speed(speeds, grades):
    factors, found = speeds
    slow, fast, gains = spreads.speed_laws(np.pi * factors, found)
    (judged,) = judgements.of_speeds(gains, slow, fast)
    assert judged.grade == grades["g"]
    assert slow.agrees(0.0)
    assert fast.exponent == pytest.approx(1.0, abs=0.35)


def test_exponents_of_the_page(page):
    """Expected: −1/2 over r; 0 while weight carries the force, towards +1 once inertia does."""
    size, error = page["sizes"]["law"]
    assert abs(size + 0.5) < 4 * error
    slow, error = page["speeds"]["slow"]
    assert abs(slow) < 4 * error
    fast, error = page["speeds"]["fast"]
    assert 0.7 < fast < 1.2
    assert fast > 4 * error
