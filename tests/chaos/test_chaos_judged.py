"""From evidence to a verdict: each kind of evidence counts, by as much as it should."""

import copy
from dataclasses import replace

import numpy as np
import pytest
from make.verdicts.own_systems import Map, Ode

from linkages.chaos.averages import steadiness
from linkages.chaos.exponents import Exponents
from linkages.chaos.judge import Course, judge, judged, transient
from linkages.chaos.stretch import Evidence, ends_alike, gathered
from linkages.chaos.tori import ClosedCurves

PERIODS = 300
GOLDEN = (5**0.5 - 1) / 2


def evidence(
    largest: float,
    *others: float,
    spread: float = 0.0,
    growth: float = 0.0,
    steady: tuple[float, float] = (0.0, 0.0),
    **given: object,
) -> Evidence:
    """Of a motion with certain exponents per period, whose growth fluctuates at random."""
    values = np.array([largest, *others])
    rates = values + spread * np.random.default_rng(5).normal(size=(PERIODS, 1))
    rates += values - rates.mean(axis=0)
    exponents = Exponents(
        growth=rates, states=np.zeros((PERIODS + 1, len(values))), times=np.arange(PERIODS + 1.0)
    )
    found = Evidence(
        points=np.zeros((PERIODS, len(values))),
        times=np.arange(float(PERIODS)),
        angles=np.zeros(len(values), dtype=bool),
        exponents=exponents,
        autonomous=False,
        rests=False,
        tests=((growth, 0.0),),
        period=None,
        curves=ClosedCurves(0, "Points branch."),
        settled=0.0,
        steady=steady,
    )
    return replace(found, **given)


def verdict(found: Evidence, *, dissipative: bool = True) -> str:
    return judged(found, dissipative=dissipative)[0]


CURVE = ClosedCurves(1)


@pytest.mark.parametrize(
    ("exponents", "growth", "expected"),
    [
        ((0.3,), 0.95, "chaotic"), ((0.3,), 0.65, "chaotic"), ((0.3,), 0.5, "undecided"),
        ((0.0, 0.0), 0.2, "quasi-periodic"), ((0.0, 0.0), 0.4, "undecided"),
    ],
)  # fmt: skip
def test_chaos_and_tori_that_are_no_curves_need_the_zero_one_test(exponents, growth, expected):
    assert verdict(evidence(*exponents, growth=growth)) == expected


@pytest.mark.parametrize(("second", "expected"), [(0.2, True), (-0.2, False)])
def test_several_positive_exponents_are_named(second, expected):
    found, reasons = judged(evidence(0.3, second, -0.9, growth=0.95), dissipative=True)
    assert found == "chaotic"
    assert ("2 exponents are positive (hyperchaos)." in reasons) is expected


@pytest.mark.parametrize(("errors", "expected"), [(2.0, "undecided"), (8.0, "chaotic")])
def test_chaos_needs_a_significant_exponent(errors, expected):
    """Tangents of a random walk are long in the end, and do not grow exponentially."""
    spread = 0.3 * PERIODS**0.5 / errors  # growth is white, so its mean errs by spread/√n
    found = evidence(0.3, spread=spread, growth=1.0)
    assert found.exponents.errors[0] == pytest.approx(0.3 / errors, rel=0.5)
    assert verdict(found) == expected


@pytest.mark.parametrize(
    ("exponents", "expected"),
    [
        ((0.0,), "quasi-periodic"),
        ((0.002,), "quasi-periodic"),
        ((-0.002,), "quasi-periodic"),
        ((0.02,), "undecided"),
        ((-0.02,), "undecided"),
        ((-0.4,), "undecided"),
    ],
)
def test_tori_need_an_exponent_that_cannot_be_told_from_zero(exponents, expected):
    """Less than 2.5 ln 2 in the last 150 periods, 0.0116 in each."""
    assert verdict(evidence(*exponents, curves=CURVE)) == expected


@pytest.mark.parametrize(
    ("largest", "autonomous", "expected"),
    [(-0.1, True, "at rest"), (0.0, True, "periodic"), (-0.1, False, "periodic")],
)
def test_a_free_motion_that_attracts_all_its_neighbours_comes_to_rest(
    largest, autonomous, expected
):
    """Along a periodic one its own direction is neutral; round-off may repeat at rest."""
    found = evidence(largest, -0.3, autonomous=autonomous, period=1)
    assert verdict(found) == expected
    assert verdict(replace(found, settled=0.9)) == "undecided"


def test_one_neutral_direction_makes_no_surface():
    """The end of a cascade of period doublings has an exponent of zero, and is no torus."""
    assert verdict(evidence(0.0, -0.5)) == "undecided"
    assert verdict(evidence(0.0, 0.0)) == "quasi-periodic"
    assert verdict(evidence(0.0, 0.0, -0.5, autonomous=True)) == "undecided"
    assert verdict(evidence(0.0, 0.0, 0.0, autonomous=True)) == "quasi-periodic"


def test_a_curve_that_shrinks_is_no_torus_where_something_dissipates():
    found = evidence(0.0, curves=CURVE, steady=(0.05, 1.0))
    assert verdict(found) == "undecided"
    assert "averages over its halves differ" in transient(found)
    assert verdict(found, dissipative=False) == "quasi-periodic"
    assert verdict(replace(found, steady=(0.01, 1.0))) == "quasi-periodic"


@pytest.mark.parametrize(
    ("largest", "settled", "expected"),
    [
        (-0.5, 0.0, "periodic"),
        (0.0, 0.0, "periodic"),
        (-0.5, 0.4, "periodic"),
        (-0.5, 0.6, "undecided"),
        (0.3, 0.0, "undecided"),
        (0.3, 0.9, "undecided"),
    ],
)
def test_a_section_that_repeats(largest, settled, expected):
    """From its later half on at the latest, while tangents do not grow."""
    found = evidence(largest, growth=1.0, period=3, curves=None, settled=settled)
    assert verdict(found) == expected


@pytest.mark.parametrize(("largest", "expected"), [(-0.5, "at rest"), (0.0, "at rest"),
                                                   (0.3, "undecided")])  # fmt: skip
def test_rest(largest, expected):
    assert verdict(evidence(largest, rests=True, curves=None)) == expected


def test_transients_are_named():
    assert transient(evidence(-0.5)) == "tangents shrink, and the motion does not repeat yet"
    assert transient(evidence(-0.5, period=2)) == ""
    assert "repeats only after 40%" in transient(evidence(-0.5, period=2, settled=0.4))
    assert "comes to rest only" in transient(evidence(-0.5, rests=True, settled=0.4))
    assert transient(evidence(0.3, steady=(0.5, 3.0))) == ""
    assert "averages" in transient(evidence(0.3, steady=(0.5, 8.0)))


def test_shrinking_tangents_without_a_period_are_a_transient():
    _, reasons = judged(evidence(-0.5), dissipative=True)
    assert any("This is a transient" in reason for reason in reasons)
    _, reasons = judged(evidence(-0.5), dissipative=False)
    assert not any("transient" in reason for reason in reasons)


def test_too_few_points_are_no_section():
    found = evidence(0.3, growth=1.0)
    assert verdict(replace(found, points=found.points[:199])) == "undecided"
    assert verdict(replace(found, points=found.points[:200])) == "chaotic"


def turning(count: int, decay: float = 0.0) -> np.ndarray:
    """Points of a circle, or of a spiral towards its centre."""
    n = np.arange(count)
    radius = np.exp(-decay * n)
    return np.column_stack([radius * np.cos(2 * np.pi * GOLDEN * n),
                            radius * np.sin(2 * np.pi * GOLDEN * n)])  # fmt: skip


def shown(points: np.ndarray, **given: object) -> Evidence:
    """Evidence from points alone."""
    states = np.concatenate([points, points[-1:]])
    exponents = Exponents(
        growth=np.zeros((len(points), 2)), states=states, times=np.arange(len(states), dtype=float)
    )
    return gathered(
        points,
        np.arange(float(len(points))),
        np.zeros(points.shape[1], dtype=bool),
        exponents,
        np.full(points.shape[1], 1e-4),
        **given,
    )


def test_spirals_are_told_from_circles():
    """In 300 points the radius falls by 3 %."""
    assert verdict(shown(turning(300))) == "quasi-periodic"
    assert verdict(shown(turning(300, 1e-4))) == "undecided"


def test_round_off_of_the_section_is_no_dimension():
    """A rate that vanishes on the section does so to round-off, which is not to be scaled up."""
    noise = 1e-15 * np.random.default_rng(1).normal(size=(300, 1))
    found = shown(np.concatenate([turning(300), noise], axis=1))
    assert found.curves is not None
    assert found.curves.count == 1
    assert found.steady[0] < 1e-6


def test_averages_of_quasi_periodic_points_converge_fast():
    assert steadiness(turning(300))[0] < 1e-6
    # squares over the halves differ by about 4 δ/√2 in units of √(mean square) = 1/√2
    assert steadiness(turning(300, 1e-4))[0] == pytest.approx(0.03, rel=0.05)
    with pytest.raises(ValueError, match="at least 32"):
        steadiness(turning(31))


def test_a_period_is_found_in_the_later_part():
    n = np.arange(300)
    cycle = np.array([[0.1, 1.0], [0.7, 2.0], [0.4, 3.0]])[n % 3]
    for decay, share in ((1.0, 0.03), (0.1, 0.31), (0.06, 0.51)):
        found = shown(cycle + np.exp(-decay * n)[:, None])
        assert found.period == 3
        # e^(-decay n) = 1e-4
        assert found.settled == pytest.approx(share, abs=0.01)


def test_slow_doubling_does_not_double_the_period():
    """With a multiplier near -1 twice the period repeats long before the period does."""
    n = np.arange(300)
    found = shown(np.column_stack([1 + (-0.99) ** (n + 540.0), n * 0.0]))
    # 2 · 0.99⁸³⁹ > 1e-4, and 0.99ⁿ is within 1e-4 of 0.99⁸³⁹ from n = 802 on
    assert found.period == 2
    assert found.settled == pytest.approx((802 - 540) / 300, abs=0.01)
    found = shown(np.column_stack([1 + (-0.97) ** (n + 100.0), n * 0.0]))
    # 0.97ⁿ = 1e-4 at n = 302
    assert found.period == 1
    assert found.settled == pytest.approx(0.675, abs=0.01)


def test_laminar_phases_are_no_periods():
    """Near a tangent bifurcation points move by less than the tolerance each time."""
    n = np.arange(300)
    points = np.column_stack([np.array([0.1, 0.5, 0.9])[n % 3] + 2e-5 * n, n * 0.0])
    assert shown(points).period is None


def test_few_points_that_coincide_are_no_period():
    points = np.random.default_rng(2).normal(size=(80, 2))
    points[-9:] = points[-9]
    assert shown(points).period is None


@pytest.mark.parametrize(("noise", "chaotic"), [(1e-9, False), (1e-2, True)])
def test_round_off_of_a_cycle_is_not_tested(noise, chaotic):
    """What remains of a cycle of two but for round-off is regular; what is more is asked."""
    cycle = np.array([0.2, 0.8])[np.arange(300) % 2]
    found = shown((cycle + noise * np.random.default_rng(3).normal(size=300))[:, None])
    assert (found.tests[0][0] > 0.9) is chaotic


def test_a_motion_at_rest_rests_for_a_tenth_of_the_stretch():
    states = np.linspace(1, 0, 200)[:, None]
    exponents = Exponents(growth=np.zeros((199, 1)), states=states, times=np.arange(200.0))
    angles, tolerance = np.zeros(1, dtype=bool), np.array([1e-4])
    for count, expected in ((10, False), (30, True)):
        states[-count:] = states[-1]
        assert ends_alike(exponents, angles, tolerance) is expected


def contracting(factor: float) -> Map:
    return Map(lambda x: factor * x, lambda _: [[factor]], [1.0])


@pytest.mark.slow_except("0.5-None-*", "0.98-500-*")
@pytest.mark.parametrize(
    ("factor", "skip", "skipped", "expected"),
    [
        (0.5, None, 100, "periodic"),
        # 0.98ⁿ = 1e-4 at n = 456, within the stretch from 400 to 700
        (0.98, None, 800, "periodic"),
        # 0.9995ⁿ = 1e-4 at n = 18 417
        (0.9995, None, 1600, "undecided"),
        (0.5, 0, 0, "periodic"),
        (0.98, 0, 0, "undecided"),
        (0.98, 500, 500, "periodic"),
    ],
)
def test_the_transient_is_skipped(factor, skip, skipped, expected):
    course = Course(period=1, parts=1, periods=PERIODS, skip=skip)
    found = judge(contracting(factor), course, copy.copy)
    assert (found.verdict, found.skipped) == (expected, skipped)
    assert found.start.time == found.evidence.times[0] == skipped
    assert ("the most that is tried" in found.how_skipped) is (skipped == 1600)


def test_nothing_is_skipped_of_a_conservative_motion():
    course = Course(period=1, parts=1, periods=PERIODS, dissipative=False)
    found = judge(contracting(0.5), course, copy.copy)
    assert (found.skipped, found.how_skipped) == (0, "nothing dissipates")


@pytest.mark.slow
def test_an_interval_that_is_a_period_is_no_rest():
    """States at all ends of intervals are the same, and the motion between is looked at."""
    oscillator = Ode(
        lambda _, y: (y[1], -y[0]), lambda _t, _y: ((0.0, 1.0), (-1.0, 0.0)), [1.0, 0.0]
    )
    course = Course(period=8 * np.pi, periods=200, dissipative=False)
    found = judge(oscillator, course, copy.copy)
    assert (found.verdict, found.evidence.period) == ("periodic", 1)


def test_bands_are_no_regular_part():
    """Chaos in two bands: the logistic map at 3.6."""
    found = judge(
        Map(lambda x: 3.6 * x * (1 - x), lambda x: [[3.6 * (1 - 2 * x[0])]], [0.3]),
        Course(period=1, parts=1, periods=PERIODS),
        copy.copy,
    )
    assert found.verdict == found.verdict_again == "chaotic"
    assert found.evidence.tests[0][0] > 0.9
