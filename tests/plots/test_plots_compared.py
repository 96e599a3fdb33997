"""Series of several motions over each other: their names, their differences, their axes."""

import numpy as np
import pytest

import linkages
from linkages.plots import charts
from linkages.plots.motion.compared import compared, told_apart, vectors
from linkages.plots.motion.overlay import VEILED, figure
from linkages.plots.style import path_words


@pytest.fixture(scope="module")
def cranks():
    return [
        linkages.simulate(linkages.load("four-bar", set={"drives.crank.speed": speed}))
        for speed in ("60 rpm", "120 rpm")
    ]


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("drives.crank.speed", "speed of crank"),
        ("clearances.r1.size", "radial clearance r1"),
        ("clearances.r1.angle", "angle of clearance r1"),
        ("bars.rod.center_of_mass", "center of mass of rod"),
        ("loads[0].force", "force of loads[0]"),
        ("loads[0].law.rate", "rate of loads[0].law"),
        ("bars.rod.points.P", "P of rod.points"),
        ("masses.W", "mass at W"),
        ("simulate.rtol", "rtol"),
        ("gravity", "gravity"),
        ("gravity[1]", "gravity along y"),
        ("joints.D[1]", "y of joint D"),
        ("bars.rod.points.P[0]", "x of P on rod"),
        ("sliders.ram.through[1]", "y of through of ram"),
        ("no path at all..", "no path at all.."),
    ],
)
def test_paths_in_words(path, words):
    assert path_words(path) == words


def test_motions_are_called_by_what_they_differ_in(cranks):
    one, two = (solution.mechanism for solution in cranks)
    speeds = ["speed of crank = 60 rpm", "speed of crank = 120 rpm"]
    assert told_apart([one, two]) == speeds
    assert told_apart([one, two], ["a", "b"]) == speeds
    assert told_apart([one, one], ["a", "b"]) == ["a", "b"]
    assert told_apart([one, one]) == [f"{one.name} (1)", f"{one.name} (2)"]
    lengths = [linkages.load("four-bar", set={"bars.crank.length": v}) for v in ("0.03", "35 mm")]
    assert told_apart(lengths) == ["length of crank = 0.03 m", "length of crank = 35 mm"]
    other = linkages.load("slider-crank")
    assert told_apart([one, two, other], ["f", "f", "s"]) == ["f (1)", "f (2)", "s (3)"]
    assert told_apart([None, None]) == ["run (1)", "run (2)"]


def test_a_legend_says_in_what_curves_differ(cranks):
    found = charts.plot(cranks, ["rocker.angle", "coupler.angle"])
    entries = [text.get_text() for text in found.get_legend().get_texts()]
    assert entries == [
        f"angle of {bar}, speed of crank = {speed} rpm"
        for speed in (60, 120) for bar in ("rocker", "coupler")
    ]  # fmt: skip
    assert found.get_ylabel() == "angle [°]"
    named = charts.plot({"slow": cranks[0], "fast": cranks[1]}, "rocker.angle")
    assert [text.get_text() for text in named.get_legend().get_texts()] == ["slow", "fast"]
    assert named.get_ylabel() == "angle of rocker [°]"
    alone = charts.plot(cranks[0], "rocker.angle")
    assert alone.get_legend() is None


def test_a_difference_over_time_is_exact_between_samples(cranks):
    """Against both motions sampled at the same times; one motion is looked at more closely."""
    name = "rocker.angle"
    (curve,) = compared(dict(zip("ab", cranks, strict=True)), [name], difference=True).curves
    fine = [
        linkages.simulate(s.mechanism, times=curve.time[1:], outputs=["bar_angle"]).data
        for s in cranks
    ]
    expected = fine[1].bar_angle.sel(bar="rocker") - fine[0].bar_angle.sel(bar="rocker")
    np.testing.assert_allclose(curve.y[1:], expected, atol=1e-12)  # driven: no interpolation


def test_lengths_over_lengths_have_equal_scales(cranks):
    assert charts.plot(cranks, "P.y position", "P.x position").get_aspect() == 1.0
    assert charts.plot(cranks, "P.y position").get_aspect() == "auto"
    assert charts.pair(cranks[0], "P.x position", "P.y position").get_aspect() == 1.0


def test_each_unit_has_a_panel_and_no_common_axis(cranks):
    found = compared({"": cranks[0]}, ["rocker.angle", "rocker.speed", "coupler.speed"])
    assert [ax.get_ylabel() for ax in figure(found).axes] == [
        "angle of rocker [°]", "angular speed [rad/s]",
    ]  # fmt: skip
    with pytest.raises(ValueError, match="have no common axis"):
        charts.plot(cranks[0], ["rocker.angle", "rocker.speed"], ax=figure(found).axes[0])


def test_sizes_are_those_of_components(cranks):
    """Of data as of a solution; a polar diagram has the same components."""
    solution = cranks[0]
    for source in (solution, solution.data):
        (size, x, y) = compared(
            {"": source}, ["P.velocity", "P.x velocity", "P.y velocity"]
        ).curves  # fmt: skip
        np.testing.assert_allclose(size.y, np.hypot(x.y, y.y), rtol=1e-14)
        (tips,) = vectors({"": source}, ["P.velocity"])
        np.testing.assert_array_equal([tips.curves[0].x, tips.curves[0].y], [x.y, y.y])


def test_dense_curves_over_time_are_veiled_envelopes_with_a_few_swings():
    solutions = {
        size: linkages.simulate(
            linkages.load("ninebar", set={"clearances.r1.size": size}), end=1.0, samples=11
        )
        for size in ("0.1 mm", "0.2 mm")
    }
    whole, swings = figure(compared(solutions, ["r1.force"])).axes
    assert [band.get_alpha() for band in whole.collections] == [VEILED, VEILED]
    assert np.ptp(swings.get_xlim()) < 0.1
    assert len([line for line in swings.lines if len(line.get_xdata()) > 100]) == 2


def test_what_cannot_be_compared_is_said(cranks):
    with pytest.raises(ValueError, match="expected at least one motion and one series"):
        charts.plot([], "rocker.angle")
    with pytest.raises(ValueError, match="the data have no joint_reaction; expected it in outputs"):
        charts.plot(cranks, "B.reaction")
    with pytest.raises(ValueError, match="rocker has no 'displacement'"):
        charts.plot(cranks, "rocker.displacement")
    crank = linkages.simulate(linkages.load("slider-crank"), end=0.01)
    with pytest.raises(
        ValueError, match=r"piston has no 'displacement'; did you mean 'piston\.position'"
    ):
        charts.plot(crank, "piston.displacement")


def test_least_and_greatest_are_those_of_the_table(cranks):
    """Located on the motion for a curve as for a row of `maxima`, to the same digits."""
    rows = {(row["variable"], row["element"]): row for row in cranks[0].maxima}
    keys = {"rocker.speed": ("bar_speed", "rocker"), "P.velocity": ("joint_velocity", "P")}
    for name, key in keys.items():
        (curve,) = compared({"": cranks[0]}, [name], "crank.angle").curves
        assert curve.least == pytest.approx(rows[key]["least"], rel=1e-12)
        assert curve.greatest == pytest.approx(rows[key]["greatest"], rel=1e-12)


def test_poles_do_not_hide_what_is_beside_them(cranks):
    """The mechanical advantage of a rocker is infinite where it turns back."""
    ax = charts.mechanical_advantage(cranks[0])
    values = np.concatenate([line.get_ydata() for line in ax.lines])
    assert np.isnan(values).any()
    assert np.nanmax(np.abs(values)) < 1e3
