"""Starts of searches: nearest points of paths, steps in the box, and path generators found."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import linkages
from linkages.design import atlas
from linkages.design.atlas import Atlas, across, nearest, passed_by
from linkages.design.goals import goal_of
from linkages.design.ranges import ranges_of
from linkages.options.run import SimulationOptions
from linkages.solution.run_options import options_of

# J. A. Cabrera, A. Simon, M. Prado, Mechanism and Machine Theory 37 (2002) 1165–1177, case 1
SIX = """
joints: {O2: [0, 0], O4: [40 mm, 0]}
bars:
  crank: {joints: [O2, A], length: 20 mm}
  coupler: {points: {A: [0, 0], B: [40 mm, 0], P: [20 mm, 20 mm]}}
  rocker: {joints: [O4, B], length: 40 mm}
drives: {crank: {angle: 0, speed: 60 rpm}}
assembly: {B: left}
targets:
  line:
    points:
      - [20 mm, 20 mm]
      - [20 mm, 25 mm]
      - [20 mm, 30 mm]
      - [20 mm, 35 mm]
      - [20 mm, 40 mm]
      - [20 mm, 45 mm]
simulate: {end: 1, samples: 181}
"""

BOUNDS = [
    *(f"joints.{joint}[{k}]=-60:60mm" for joint in ("O2", "O4") for k in (0, 1)),
    "bars.crank.length=5:60mm",
    "bars.coupler.points.B[0]=5:60mm",
    "bars.rocker.length=5:60mm",
    *(f"bars.coupler.points.P[{k}]=-60:60mm" for k in (0, 1)),
]

GOAL = "sum_squared_distance(P, line)"

POINTS = 0.02 + 1j * np.arange(0.02, 0.046, 0.005)

WITHIN = 1e-9
"""1e-3 mm²; the paper has 0.026 mm²."""


def six():
    """The atlas of Cabrera's points."""
    mechanism = linkages.loads(SIX)
    run = options_of(SimulationOptions, mechanism, {})
    aims = passed_by(mechanism, goal_of(GOAL, None))
    return Atlas(mechanism, ranges_of(mechanism, BOUNDS), run, aims)


def path_of_left_four_bars(numbers, count):
    """Coupler point over a turn, by intersecting circles; nan where they do not meet."""
    x2, y2, x4, y4, crank, coupler, rocker, px, py = numbers
    a = x2 + 1j * y2 + crank * np.exp(1j * np.linspace(0.0, 2 * np.pi, count))
    apart = x4 + 1j * y4 - a
    size = np.abs(apart)
    along = (coupler**2 - rocker**2 + size**2) / (2 * size)
    with np.errstate(invalid="ignore"):
        b = a + apart / size * (along + 1j * np.sqrt(coupler**2 - along**2))
    return a + (px + 1j * py) * (b - a) / coupler


def sum_of_squares(numbers, count=100_001):
    """Squared distances of the points from a path, added."""
    path = path_of_left_four_bars(numbers, count)
    return float(sum(np.abs(path - point).min() ** 2 for point in POINTS))


def test_the_nearest_point_of_a_circle_is_on_its_radius():
    angles = np.array([0.4, 1.3, 2.9])
    points = np.array([2.0, 0.3, 1.1]) * np.exp(1j * angles)
    grid = np.linspace(0.0, np.pi, 61)
    found = nearest(lambda t: np.exp(1j * t), points, grid, np.exp(1j * grid)[None])
    np.testing.assert_allclose(found.at[0], angles, atol=1e-9)
    np.testing.assert_allclose(found.tangent[0], 1j * np.exp(1j * angles), atol=1e-4)


def test_beyond_its_end_the_nearest_point_of_a_path_is_its_end():
    grid = np.linspace(0.0, 1.0, 11)
    found = nearest(lambda t: t + 0j, np.array([-0.2 + 1j, 1.5 - 1j]), grid, grid[None] + 0j)
    assert found.at.tolist() == [[0.0, 1.0]]
    assert found.tangent.tolist() == [[0.0, 0.0]]
    assert across(found.tangent[0], np.array([1.0, 1j])).tolist() == [1.0, 1j]


def test_steps_without_damping_are_those_of_linear_least_squares_in_the_box():
    rng = np.random.default_rng(3)
    slopes, residuals = rng.normal(size=(20, 6, 3)), rng.normal(size=(20, 6))
    places = np.full((20, 3), 0.5)
    reached = atlas._stepped(places, residuals, slopes, np.full(20, 1e-12))
    inside = 0
    for own, rates, place in zip(residuals, slopes, reached, strict=True):
        best = lsq_linear(rates, -own).x + 0.5
        if (best > 0.0).all() and (best < 1.0).all():
            np.testing.assert_allclose(place, best, atol=1e-9)
            inside += 1
        assert (np.clip(place, 0.0, 1.0) == place).all()
    assert 0 < inside < 20


def test_slopes_at_nearest_points_are_those_of_the_sum_of_squares():
    """Times of nearest points move with the numbers, and count for nothing (envelope)."""
    own = six()
    mechanism = linkages.loads(SIX)
    ranges = ranges_of(mechanism, BOUNDS)
    numbers = np.array([0.0, 0.0, 0.04, 0.0, 0.02, 0.045, 0.041, 0.02, 0.02])
    places = ranges.places(numbers)[None]
    ((residuals, slopes),) = own._linear(places, np.array([np.inf]))
    assert residuals @ residuals == pytest.approx(sum_of_squares(numbers), rel=1e-6)
    step = 1e-4
    for k, rate in enumerate(2.0 * residuals @ slopes):
        both = np.array([numbers, numbers])
        both[:, k] += np.array([-step, step]) * ranges.width[k]
        before, after = map(sum_of_squares, both)
        assert rate == pytest.approx((after - before) / (2 * step), rel=1e-4, abs=1e-9)


def test_starts_do_not_depend_on_how_many_are_computed_together(monkeypatch):
    start = np.array([0.0, 0.0, 0.04, 0.0, 0.02, 0.04, 0.04, 0.02, 0.02])
    monkeypatch.setattr(atlas, "LOOKS", 32)
    together = six().starts(start, 2, 4)
    monkeypatch.setattr(atlas, "TOGETHER", 11)
    np.testing.assert_array_equal(six().starts(start, 2, 4), together)


@pytest.mark.slow
def test_an_atlas_finds_a_crank_through_six_points_on_a_line():
    mechanism = linkages.loads(SIX)
    found = six().starts(np.zeros(9), 6, 1)
    numbers = ranges_of(mechanism, BOUNDS).numbers(found[1])
    assert sum_of_squares(numbers) < WITHIN
    x2, y2, x4, y4, crank, coupler, rocker = numbers[:7]
    lengths = np.sort([crank, coupler, rocker, np.hypot(x4 - x2, y4 - y2)])
    # the crank or the frame is the shortest of a chain that satisfies Grashof's condition
    assert lengths[0] in (crank, np.hypot(x4 - x2, y4 - y2))
    assert lengths[0] + lengths[3] < lengths[1] + lengths[2]


@pytest.mark.slow
def test_a_foot_is_found_in_all_branches_and_senses():
    """2.205e-4 m², by SciPy's least squares on closed-form kinematics."""
    lift = np.radians(np.arange(30.0, 151.0, 30.0))
    points = [*(60.0 - 20.0 * k - 200j for k in range(7))]
    points += [*(-60.0 * np.cos(lift) + 1j * (35.0 * np.sin(lift) - 200.0))]
    measured = {
        "time (s)": np.arange(12) / 12,
        "P.x position (mm)": np.real(points),
        "P.y position (mm)": np.imag(points),
    }
    mechanism = linkages.loads(
        SIX, set={"joints.O4": "[80 mm, 0]", "bars.crank.length": "30 mm", "simulate.samples": 361}
    )
    vary = [f"joints.{joint}[{k}]=-300:300mm" for joint in ("O2", "O4") for k in (0, 1)]
    vary += ["bars.crank.length=5:300mm", "bars.coupler.points.B[0]=10:300mm"]
    vary += ["bars.rocker.length=10:300mm", "drives.crank.angle=0:360deg"]
    vary += [f"bars.coupler.points.P[{k}]=-300:300mm" for k in (0, 1)]
    found = linkages.fit(mechanism, measured, vary, branches="all", starts=6, seed=1)
    assert found.data.attrs["chi_square"] < 2.2053e-4
    assert "reversed" in found.data.attrs["variant"]
