"""FLI and GALI tell regular from chaotic orbits of Hénon and Heiles."""

import math

import numpy as np
import pytest
from chaos_systems import henon, henon_heiles, lorenz
from make.verdicts.own_systems import Map, Ode

from linkages.chaos.exponents import lyapunov_spectrum
from linkages.chaos.indicators import ROUND_OFF, Verdict, classify, fast_indicators


def verdict_by_fli(found):
    return classify(found.times, found.fli)


def verdict_by_gali(found):
    """By what GALI tells before tangents are parallel to round-off."""
    told = int(np.argmax(found.gali <= ROUND_OFF)) + 1 if found.gali[-1] <= ROUND_OFF else None
    return classify(found.times[:told], -np.log(found.gali[:told]))


REGULAR = [(1 / 12, 0.3, 0.0), (1 / 12, -0.1, 0.1), (1 / 8, 0.55, 0.0)]
CHAOTIC = [(1 / 8, -0.25, 0.0), (1 / 6 - 1e-3, -0.1, 0.1)]


@pytest.mark.slow_except("orbit2")
@pytest.mark.parametrize("orbit", REGULAR)
def test_regular_orbits(orbit):
    """FLI grows like ln t, GALI_2 stays of order one on a torus of two dimensions."""
    found = fast_indicators(henon_heiles(*orbit), intervals=300, interval=5.0)
    assert verdict_by_fli(found) is Verdict.REGULAR
    assert verdict_by_gali(found) is Verdict.REGULAR
    assert found.gali[-1] > 1e-3
    assert found.fli[-1] < 2 * math.log(found.times[-1])


@pytest.mark.slow_except("orbit0")
@pytest.mark.parametrize("orbit", CHAOTIC)
def test_chaotic_orbits(orbit):
    found = fast_indicators(henon_heiles(*orbit), intervals=300, interval=5.0)
    assert verdict_by_fli(found) is Verdict.CHAOTIC
    assert verdict_by_gali(found) is Verdict.CHAOTIC
    assert found.gali[-1] <= 1e-12


@pytest.mark.slow
def test_fli_grows_after_tangents_have_become_parallel():
    """The fast indicator belongs to the whole run, not to what GALI can tell of."""
    found = fast_indicators(lorenz(), intervals=200, interval=1.0)
    parallel = int(np.argmax(found.gali <= ROUND_OFF))
    assert 0 < parallel < 60
    assert (found.gali[parallel:] == ROUND_OFF).all()
    assert found.times[-1] == pytest.approx(200.0)
    # λ = 0.9056 ± 0.0001 (Sprott 2003); its mean over 200 s fluctuates by some percent
    assert found.fli[-1] / 200.0 == pytest.approx(0.9056, rel=0.1)
    assert verdict_by_gali(found) is Verdict.CHAOTIC


@pytest.mark.slow
def test_power_law_of_gali_on_a_torus():
    """Skokos et al. 2007: GALI_3 ~ t^-2 and GALI_4 ~ t^-4 on a torus of two dimensions.

    Oscillation about the law at two times apart by 8 limits the exponent to ±0.7.
    """
    for count, power in ((3, 2), (4, 4)):
        found = fast_indicators(henon_heiles(*REGULAR[0]), intervals=400, interval=5.0, count=count)
        middles = [np.median(np.log(found.gali[part])) for part in (slice(40, 60), slice(360, 400))]
        slope = (middles[1] - middles[0]) / math.log(380 / 50)
        assert -slope == pytest.approx(power, abs=0.7)


@pytest.mark.slow
def test_fli_rises_with_the_exponent():
    """The mean slope of ln‖w‖ is the largest exponent, to 1/t."""
    found = fast_indicators(lorenz(), intervals=100, interval=0.5)
    exponents = lyapunov_spectrum(lorenz(), intervals=100, interval=0.5, count=1)
    end = len(found.times)
    assert found.fli[-1] / found.times[-1] == pytest.approx(exponents.history[end - 1, 0], rel=0.1)
    assert verdict_by_fli(found) is Verdict.CHAOTIC


def test_limit_cycle_is_regular_by_fli_only():
    """Friction aligns tangents along regular motions too: van der Pol."""
    system = Ode(
        lambda _, y: (y[1], (1 - y[0] ** 2) * y[1] - y[0]),
        lambda _, y: ((0.0, 1.0), (-2 * y[0] * y[1] - 1, 1 - y[0] ** 2)),
        [2.0, 0.0],
    )
    found = fast_indicators(system, intervals=40, interval=1.0)
    assert verdict_by_fli(found) is Verdict.REGULAR
    assert verdict_by_gali(found) is Verdict.CHAOTIC


def test_thresholds():
    times = np.arange(1.0, 1001.0)
    assert classify(times, 2 * np.log(times)) is Verdict.REGULAR
    assert classify(times, 5 * np.log(times)) is Verdict.UNDECIDED
    assert classify(times, 0.05 * times) is Verdict.CHAOTIC


@pytest.mark.parametrize("wrong", [{"intervals": 3}, {"count": 0}, {"count": 3}, {"interval": 0}])
def test_arguments(wrong):
    with pytest.raises(ValueError, match="must be"):
        fast_indicators(henon(), **({"intervals": 10, "interval": 1} | wrong))


def test_one_tangent_is_enough_for_fli():
    """It is the largest sum so far of what the exponent of that tangent averages, and GALI is 1."""
    found = fast_indicators(henon(), intervals=300, interval=1, count=1)
    growth = lyapunov_spectrum(henon(), intervals=300, interval=1, count=1).growth[:, 0]
    # two orders of summation of three hundred numbers
    assert found.fli == pytest.approx(np.maximum.accumulate(np.cumsum(growth).clip(0)), abs=1e-11)
    assert found.gali == pytest.approx(np.ones(300), abs=1e-15)


def test_fli_is_the_largest_stretching_so_far():
    """A tangent is doubled and halved in turn: FLI stays at ln 2."""
    breathing = Map(lambda x: x + 1, lambda x: [[2.0 if x[0] % 2 == 0 else 0.5]], [0.0])
    found = fast_indicators(breathing, intervals=8, interval=1, count=1)
    assert found.fli == pytest.approx(np.full(8, math.log(2)), abs=1e-15)
