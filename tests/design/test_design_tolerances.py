"""What tolerances do to measures, against closed forms and the theory of normal numbers."""

from __future__ import annotations

import re
from math import atan2, cos, erf, hypot, radians, sin, sqrt

import numpy as np
import pytest

import linkages

STROKE, ERROR = "stroke(piston.position)", "max(abs(error(piston.position)))"
TOLERANCES = {"bars.crank.length": "40 ± 0.02 mm", "bars.rod.length": "140 ± 0.05 mm"}

FOUR_BAR = """\
name: Four-bar with tolerances
joints: {O: [0, 0], C: [100 ± 0.1 mm, 0]}
bars:
  crank: {joints: [O, A], length: 30 ± 0.02 mm}
  coupler: {joints: [A, B], length: 110 ± 0.05 mm}
  rocker: {joints: [B, C], length: 80 ± 0.04 mm (uniform)}
drives: {crank: {angle: 40 deg, speed: 0}}
assembly: {B: [0.11, 0.08]}
simulate: {end: 0.1, samples: 11}
"""


@pytest.fixture(scope="module")
def engine():
    return linkages.load("slider-crank").with_values(TOLERANCES)


@pytest.fixture(scope="module")
def found(engine):
    limits = [f"{STROKE} > 79.98 mm", f"79.98 mm < {STROKE} < 80.02 mm"]
    return linkages.tolerance(engine, [STROKE, ERROR], limits=limits, draws=4000, samples=101)


@pytest.mark.slow
def test_the_stroke_between_dead_centres_is_twice_the_crank(found):
    own = found.sel(measure=STROKE)
    # dead centres at r + l and l - r: exact derivatives 2 and 0, and no curvature at all
    assert own["sensitivity"].to_numpy() == pytest.approx([2.0, 0.0], abs=1e-12)
    assert own["contribution"].to_numpy() == pytest.approx([4e-5, 0.0], abs=1e-15)
    assert own["worst"].to_numpy() == pytest.approx([0.08 - 4e-5, 0.08 + 4e-5], rel=1e-12)
    assert own["corner"].to_numpy() == pytest.approx([0.08 - 4e-5, 0.08 + 4e-5], rel=1e-12)
    assert float(own["linear_deviation"]) == pytest.approx(2 * 0.02e-3 / 3, rel=1e-11)


@pytest.mark.slow
def test_samples_of_a_linear_measure_are_normal(found):
    own = found.sel(measure=STROKE)
    deviation, count = 2 * 0.02e-3 / 3, found.sizes["draw"]
    # within four standard errors of mean, deviation and skewness of normal numbers
    assert float(own["mean"]) == pytest.approx(0.08, abs=4 * deviation / sqrt(count))
    assert float(own["deviation"]) == pytest.approx(deviation, rel=4 / sqrt(2 * count))
    assert abs(float(own["skewness"])) < 4 * sqrt(6 / count)
    # what is linear is predicted draw by draw, up to how well an extreme is located
    assert own["sample"].to_numpy() == pytest.approx(own["linear_sample"].to_numpy(), abs=1e-11)


def test_the_linear_analysis_does_not_depend_on_random_copies(engine):
    """Mean and deviation are those of the zone: 2·(40.01 ± 0.03) mm, limits of 3 sigma."""
    shifted = engine.with_values({"bars.crank.length": "40 +0.04/-0.02 mm"})
    own = linkages.tolerance(shifted, STROKE, draws=100, seed=5, samples=101).sel(measure=STROKE)
    assert float(own["linear_mean"]) == pytest.approx(0.08002, rel=1e-12)
    assert float(own["linear_spread"]) == pytest.approx(2 * 0.03e-3 / 3, rel=1e-11)
    assert float(own["linear_spread"]) == float(own["linear_deviation"])
    # the copies have a mean and a deviation of their own, and are compared copy by copy
    assert abs(float(own["deviation"]) / float(own["linear_spread"]) - 1) > 1e-3
    assert "agree within their errors" in own.attrs["remarks"]


@pytest.mark.slow
def test_the_yield_is_that_of_normal_numbers(found):
    half = 0.02e-3 / (2 * 0.02e-3 / 3)  # limits in standard deviations
    one = 0.5 * (1 + erf(half / sqrt(2)))
    for row, wanted in zip(
        found["within"].to_numpy(), (one, 2 * one - 1, 2 * one - 1), strict=True
    ):
        share, low, high = row
        assert low < share < high
        assert low < wanted < high  # at this seed; of a hundred seeds five would fail
    assert [*found["limit"].to_numpy()][-1] == "all limits"


def test_errors_are_against_the_nominal_motion(found):
    own = found.sel(measure=ERROR)
    assert float(own["nominal"]) == 0.0
    # the piston follows r at dead centre, and l by 1/cos of the largest angle of the rod
    slope = 1 / sqrt(1 - (40 / 140) ** 2)
    # derivatives are interpolated by parabolas between samples an eighth of a radian apart
    assert own["sensitivity"].to_numpy() == pytest.approx([1.0, slope], rel=2e-4)
    # crank and rod together are worst at the dead centre that adds them: exactly 20 + 50 µm
    assert own["worst"].to_numpy() == pytest.approx([0.0, 70e-6], abs=1e-12)
    assert own["corner"].to_numpy() == pytest.approx([0.0, 70e-6], abs=1e-12)
    assert "agree within their errors" in found.attrs["remarks"]


def closed_form(t2: float, a=0.03, b=0.11, c=0.08, d=0.1):
    """Angles of coupler and rocker, and derivatives of the latter by d, a, b, c and a push."""
    x, y = d - a * cos(t2), -a * sin(t2)
    size = hypot(x, y)
    t3 = atan2(y, x) + np.arccos((b**2 + size**2 - c**2) / (2 * b * size))
    bx, by = a * cos(t2) + b * cos(t3), a * sin(t2) + b * sin(t3)
    t4 = atan2(by, bx - d)
    arm = c * sin(t4 - t3)
    slopes = [cos(t3), -cos(t2 - t3), -1.0, cos(t4 - t3)]
    return t3, t4, np.array(slopes) / arm, 1.0 / abs(arm)


def test_sensitivities_of_a_four_bar_are_those_of_its_closure():
    data = linkages.tolerance(linkages.loads(FOUR_BAR), "final(rocker.angle)", draws=200)
    *_, slopes, _ = closed_form(radians(40))
    # bars point the way their joints are listed: the rocker from B to C, which is a constant more
    assert data["sensitivity"].to_numpy()[0] == pytest.approx(slopes, rel=1e-10)
    halves = np.array([1e-4, 2e-5, 5e-5, 4e-5])
    deviations = halves / np.array([3, 3, 3, sqrt(3)])
    squares = (slopes * deviations) ** 2
    assert data["contribution"].to_numpy()[0] == pytest.approx(abs(slopes) * halves, rel=1e-10)
    assert float(data["linear_deviation"][0]) == pytest.approx(sqrt(squares.sum()), rel=1e-10)
    assert data["share"].to_numpy()[0] == pytest.approx(squares / squares.sum(), rel=1e-10)
    # the corner of the zones is a point of the closed form: second order is all that is left
    low, high = data["corner"].to_numpy()[0] - float(data["nominal"][0])
    assert [low, high] == pytest.approx([-abs(slopes) @ halves, abs(slopes) @ halves], rel=0.02)


def test_a_pin_in_its_hole_pushes_like_a_change_of_length_in_the_worst_direction():
    clearance = {"clearances": {"play": {"joint": "A", "bar": "coupler", "size": "0.1 mm"}}}
    mechanism = linkages.loads(FOUR_BAR).with_values(clearance)
    data = linkages.tolerance(mechanism, "final(B.y position)", draws=2000)
    _, t4, _, turned = closed_form(radians(40))
    push = turned * 0.08 * abs(cos(t4))
    own = data.sel(measure="final(B.y position)", contributor="clearances.play")
    assert float(own["sensitivity"]) == pytest.approx(push, rel=1e-4)  # a clearance of 1e-10 m
    assert float(own["contribution"]) == pytest.approx(push * 1e-4, rel=1e-4)
    # of a direction that is uniform over the circle, half the mean square goes each way
    squares = (data["sensitivity"][0] * data["standard_deviation"]) ** 2
    assert float(data["standard_deviation"][-1]) == pytest.approx(1e-4 / sqrt(2), rel=1e-12)
    assert float(own["share"]) == pytest.approx(float(squares[-1] / squares.sum()), rel=1e-12)
    assert float(data["deviation"][0]) == pytest.approx(sqrt(float(squares.sum())), rel=0.07)


def test_a_free_motion_has_tolerances_too():
    pendulum = linkages.load("pendulum").with_values(
        {"free.rod.angle": "30 ± 1 deg", "free.rod.speed": 0.0}
    )
    data = linkages.tolerance(pendulum, "max(rod.speed)", draws=100, end=1.5, samples=151)
    nominal, slope = float(data["nominal"][0]), float(data["sensitivity"][0, 0])
    turned = pendulum.with_values({"free.rod.angle": radians(30) + 1e-4})
    other = linkages.measure(linkages.simulate(turned, end=1.5, samples=151), "max(rod.speed)")
    assert slope == pytest.approx((other - nominal) / 1e-4, rel=1e-3)  # a forward difference


def test_curvature_is_said():
    still = {"bars.crank.length": "40 mm", "drives.crank.angle": "0 ± 6 deg"}
    engine = linkages.load("slider-crank").with_values(still)
    data = linkages.tolerance(engine, "at(0 s, piston.position)", draws=1000, samples=11)
    # at dead centre x = r + l - r(1 + r/l)θ²/2: no slope, and a mean that is lower
    shift = -0.5 * 0.04 * (1 + 40 / 140) * radians(2) ** 2
    assert float(data["sensitivity"][0, 0]) == pytest.approx(0.0, abs=1e-12)
    found = float(data["mean"][0] - data["nominal"][0])
    assert found == pytest.approx(shift, abs=4 * float(data["error_of_mean"][0]))
    assert "curvature shifts the mean" in data.attrs["remarks"]
    assert "the linear analysis sees no effect" in data.attrs["remarks"]


def test_copies_that_cannot_be_made_are_counted():
    risky = {"bars.rod.length": "40.5 ± 1.5 mm"}  # some rods are shorter than the crank
    engine = linkages.load("slider-crank").with_values(risky)
    limits = f"{STROKE} < 1 m"  # all that move are within
    data = linkages.tolerance(engine, STROKE, limits=limits, draws=300, samples=41)
    failed = int((data["outcome"] != 0).sum())
    assert 0 < failed < 300
    # rods shorter than the crank: normal, one standard deviation below the mean
    short = int((data["bars.rod.length"] <= 0.04).sum())
    assert failed == short
    assert f"{failed} of 300 samples have no result" in data.attrs["remarks"]
    assert float(data["within"][0, 0]) == pytest.approx(1 - failed / 300)


@pytest.mark.slow
def test_draws_do_not_depend_on_cores_or_stores(engine, tmp_path):
    options = {"draws": 600, "samples": 41, "seed": 3}
    one = linkages.tolerance(engine, ERROR, cores=1, **options)
    two = linkages.tolerance(engine, ERROR, cores=2, store=tmp_path / "kept", **options)
    again = linkages.tolerance(engine, ERROR, store=tmp_path / "kept", **options)
    assert one.equals(two)
    assert one.equals(again)
    other = linkages.tolerance(engine, ERROR, draws=700, samples=41, seed=3)
    assert other["sample"][:, :600].equals(one["sample"])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"of": "stroke(pistol.position)"}, "did you mean 'piston.position'?"),
        ({"of": []}, "nothing is asked for"),
        ({"limits": "stroke(piston.position)"}, "expected limits such as"),
        ({"limits": "stroke(piston.position) < 3 kg"}, "the measure is in m"),
        ({"limits": "2 mm < stroke(piston.position) < 1 mm"}, "nothing lies between them"),
        ({"draws": 10}, "expected at least 100 draws, found 10"),
        ({"of": "max(error(3))"}, "'error' expects what changes with time"),
        ({"of": "max(error(error(piston.position)))"}, "the error itself"),
    ],
)
def test_what_makes_no_sense_is_refused(engine, changes, message):
    of = changes.pop("of", STROKE)
    with pytest.raises(ValueError, match=re.escape(message)):
        linkages.tolerance(engine, of, **changes)


def test_a_measure_that_divides_by_zero_is_refused(engine):
    zero = f"{STROKE} - {STROKE}"
    with pytest.raises(linkages.ComputationError, match="divides by zero"):
        linkages.tolerance(engine, f"1 m / ({zero})", draws=100, samples=41)


def test_a_mechanism_in_which_nothing_varies_is_refused():
    with pytest.raises(ValueError, match="nothing varies"):
        linkages.tolerance(linkages.load("slider-crank"), STROKE)


GUIDED = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 40 mm}, rod: {joints: [A, B], length: 140 mm}}
sliders: {piston: {joint: B, through: [0, 5 mm], angle: ANGLE, mass: 1, inertia: 1e-4}}
drives: {crank: {angle: 50 deg, speed: 10}}
assembly: {B: [0.17, 0]}
clearances:
  room: {slider: piston, size: 0.2 mm, length: 30 mm, height: 20 mm, contact: hertz, stiffness: 1e9}
simulate: {end: 0.1, samples: 11}
"""


@pytest.mark.parametrize("angle", ["0", "12 deg"])
def test_a_block_rests_against_one_wall_of_its_guide_or_the_other(angle):
    """The piston's displacement s with its joint e off the axis: |A − B(s, e)| = l by hand."""
    mechanism = linkages.loads(GUIDED.replace("ANGLE", angle))
    data = linkages.tolerance(mechanism, "at(0, piston.position)", draws=128, seed=3)
    axis = np.deg2rad(float(angle.split()[0]))
    along, across = (np.array([np.cos(a), np.sin(a)]) for a in (axis, axis + np.pi / 2))
    crank = 0.04 * np.array([np.cos(np.deg2rad(50)), np.sin(np.deg2rad(50))])

    def position(e):
        away = crank - np.array([0.0, 0.005]) - e * across
        height = away @ across
        return away @ along + np.sqrt(0.14**2 - height**2)

    assert float(data["nominal"][0]) == pytest.approx(position(0.0), rel=1e-12)
    # both walls, and nothing in between, each about as often
    found = np.unique(data["sample"][0].to_numpy().round(13))
    expected = sorted([position(0.0002), position(-0.0002)])
    np.testing.assert_allclose(found, expected, rtol=1e-11)
    assert 32 < (data["sample"][0] > position(0.0)).sum() < 96
    slope = (position(1e-6) - position(-1e-6)) / 2e-6
    own = data.sel(contributor="clearances.room")
    assert float(own["sensitivity"][0]) == pytest.approx(abs(slope), rel=1e-6)
    assert float(data["linear_deviation"][0]) == pytest.approx(abs(slope) * 0.0002, rel=1e-6)
