"""What is varied: grids, lists, draws; and what is refused."""

import numpy as np
import pytest
import scipy.stats

import linkages
from linkages.sweeps.axes import MOST_POINTS
from linkages.sweeps.points import distribution_of, points_of, probabilities


def test_draws_depend_on_seed_path_and_number_alone():
    few, many = (probabilities(["a", "b"], draws, 3) for draws in (10, 1000))
    assert np.array_equal(few, many[:, :10])
    assert np.array_equal(probabilities(["b"], 10, 3)[0], few[1])
    assert not np.array_equal(probabilities(["a"], 10, 4)[0], few[0])
    assert not np.array_equal(few[0], few[1])


@pytest.mark.parametrize("sequence", ["random", "sobol", "latin-hypercube"])
@pytest.mark.parametrize(
    ("text", "cdf"),
    [
        ("normal(2, 0.5)", scipy.stats.norm(2, 0.5).cdf),
        ("uniform(1, 4)", scipy.stats.uniform(1, 3).cdf),
        ("triangular(0, 1, 3)", scipy.stats.triang(1 / 3, 0, 3).cdf),
    ],
)
def test_draws_are_distributed_as_asked(text, cdf, sequence):
    """Kolmogorov and Smirnov's test at 0.1 %, of fixed draws; sequences are more even still."""
    found = points_of({"a": text}, 4096, 1, sequence).draw_values[0]
    assert scipy.stats.kstest(found, cdf).pvalue > 1e-3


def test_distributions_of_scipy_are_taken():
    points = points_of({"a": scipy.stats.expon(scale=2.0)}, 4096, 1, "random")
    assert scipy.stats.kstest(points.draw_values[0], "expon", (0, 2.0)).pvalue > 1e-3
    assert "expon" in points.described["drawn"]["a"]


def test_a_latin_hypercube_has_a_draw_in_every_layer():
    found = probabilities(["a", "b"], 50, 1, "latin-hypercube")
    assert np.array_equal(np.sort(found * 50 // 1, axis=1), np.tile(np.arange(50.0), (2, 1)))


def test_a_grid_of_axes_and_draws():
    over = {"a": [1.0, 2.0], ("b", "c"): [(1, 10), (2, 20), (3, 30)], "d": "uniform(1 mm, 2 mm)"}
    points = points_of(over, 4, 0, "random")
    assert points.shape == (2, 3, 4)
    assert points.dims == ("a", "b", "draw")
    whole = points.overrides(0, 24)
    assert whole[:12] == points.overrides(0, 12)
    assert whole[0]["a"] == whole[11]["a"] == 1.0
    assert (whole[4]["b"], whole[4]["c"]) == (2.0, 20.0)
    assert whole[0]["d"] == whole[4]["d"] == whole[12]["d"]
    assert whole[0]["d"] != whole[1]["d"]
    assert whole[0]["d"].endswith(" mm")
    assert points.overrides(5, 6, si=True)[0]["d"] == points.draw_values[0, 1] / 1000


@pytest.mark.parametrize(
    ("over", "draws", "message"),
    [
        ({}, None, "nothing is varied"),
        ({"a": "normal(1, 2)"}, None, "need a number of draws"),
        ({"a": [1.0, 2.0]}, 5, "nothing is drawn"),
        ({"a": "norml(1, 2)"}, 5, "did you mean 'normal'"),
        ({"a": "normal(1)"}, 5, "expected normal(mean, deviation)"),
        ({"a": "normal(1 mm, 2)"}, 5, "need the same unit"),
        ({"a": "normal(1, 0)"}, 5, "expected a deviation > 0"),
        ({"a": "uniform(2, 1)"}, 5, "low, high in rising order"),
        ({"a": [1.0, 2.0], ("a", "b"): [(1, 2), (2, 3)]}, None, "varied by two ranges"),
        ({("a", "b"): [(1, 2, 3)]}, None, "rows with 2 values each"),
        ({name: np.arange(1000.0) for name in "abc"}, None, "would take at least"),
    ],
)
def test_refusals(over, draws, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        points_of(over, draws, 0, "random")
    assert message in str(caught.value)


def test_a_range_of_a_thousand_million_values_is_refused_before_it_is_made():
    from linkages.sweeps.axes import parse_range

    with pytest.raises(ValueError, match=r"1e\+09 points would take at least 27.8 hours"):
        parse_range("a=0:1:1000000000")
    assert len(parse_range("a=0:1:1000")) == 1000
    assert MOST_POINTS >= 10**6


def test_an_unknown_path_is_refused_with_the_nearest():
    mechanism = linkages.load("slider-crank")
    with pytest.raises(linkages.InputError, match="did you mean 'rod'"):
        linkages.sweep(mechanism, {"bars.rodd.length": [0.1, 0.2]}, "max(crank.effort)")
    with pytest.raises(linkages.InputError, match="length"):
        linkages.sweep(
            mechanism, {"bars.rod.length": "normal(1 kg, 0.1 kg)"}, "max(crank.effort)", draws=3
        )
    assert distribution_of("a", "uniform(1, 2)").text == "uniform(1, 2)"
