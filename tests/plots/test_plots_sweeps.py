"""Figures of sweeps: a curve, a band, an image or a histogram, by what is varied."""

import numpy as np
import pytest

import linkages
from linkages.plots.study_figures import sweep_figure

ROD, CRANK = "bars.rod.length", "bars.crank.length"
GRID = {ROD: ["130 mm", "140 mm", "150 mm"], CRANK: ["38 mm", "40 mm"]}
FINE = {ROD: [f"{130 + k} mm" for k in range(8)], CRANK: [f"{38 + k / 4} mm" for k in range(7)]}


def swept(over, **how):
    mechanism = linkages.load("slider-crank")
    measure = {"stroke": "stroke(piston.position)"}
    return linkages.sweep(mechanism, over, measure, samples=51, **how)


def test_one_axis_is_a_curve():
    data = swept({CRANK: GRID[CRANK]})
    (ax,) = sweep_figure(data, "stroke").axes
    (line,) = ax.lines
    assert line.get_xdata().tolist() == [38, 40]
    # twice the crank, known to round-off
    assert line.get_ydata() == pytest.approx([76.0, 80.0], rel=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("length of crank [mm]", "stroke [mm]")
    # a list of a few values is no continuous axis
    assert [text.get_text() for text in ax.get_xticklabels()] == ["38", "40"]


@pytest.mark.parametrize("over", [GRID, {ROD: FINE[ROD], CRANK: GRID[CRANK]}], ids=["two", "one"])
def test_a_list_of_a_few_values_has_a_line_for_each(over):
    data = swept(over)
    for given in (over, dict(reversed(over.items()))):
        (ax,) = sweep_figure(swept(given), "stroke").axes
        for line, value in zip(ax.lines, (38.0, 40.0), strict=True):
            assert np.array_equal(line.get_ydata(), 1e3 * data.stroke.sel({CRANK: value}))
        legend = ax.get_legend()
        assert [text.get_text() for text in legend.get_texts()] == ["38", "40"]
        assert "length of crank [mm]" in legend.get_title().get_text()
        assert ax.get_xlabel() == "length of rod [mm]"


def test_two_axes_are_an_image():
    data = swept(FINE)
    ax, bar = sweep_figure(data, "stroke").axes
    (image,) = ax.collections
    assert image.get_array().shape == (8, 7)
    assert np.array_equal(image.get_array(), 1e3 * data.stroke)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("length of crank [mm]", "length of rod [mm]")
    assert bar.get_ylabel() == "stroke [mm]"


def test_draws_are_counted_and_along_an_axis_a_band():
    drawn = {CRANK: "normal(40 mm, 0.1 mm)"}
    data = swept(drawn, draws=64)
    (ax,) = sweep_figure(data, "stroke").axes
    assert sum(patch.get_height() for patch in ax.patches) == 64
    data = swept({ROD: FINE[ROD], **drawn}, draws=64)
    (ax,) = sweep_figure(data, "stroke").axes
    (line,) = ax.lines
    assert line.get_ydata() == pytest.approx(1e3 * data.stroke.median("draw").to_numpy(), rel=1e-12)
    assert len(ax.collections) == 1
    data = swept({ROD: GRID[ROD], **drawn}, draws=64)
    (ax,) = sweep_figure(data, "stroke").axes
    (bars,) = ax.containers
    middle, _, (between,) = bars.lines
    assert middle.get_ydata() == pytest.approx(
        1e3 * data.stroke.median("draw").to_numpy(), rel=1e-12
    )
    low, high = 1e3 * data.stroke.quantile([0.05, 0.95], "draw").to_numpy()
    ends = np.array([segment[:, 1] for segment in between.get_segments()])
    assert ends == pytest.approx(np.stack([low, high]).T, rel=1e-12)


def test_what_cannot_be_assembled_is_shaded():
    """A rod shorter than the crank: the first two of eight values, as far as half-way to others."""
    rods = {ROD: [f"{20 + 15 * k} mm" for k in range(8)]}
    data = swept(rods)
    (ax,) = sweep_figure(data, "stroke").axes
    assert np.isnan(data.stroke[:2]).all()
    assert np.isfinite(data.stroke[2:]).all()
    spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in ax.patches]
    assert spans == [pytest.approx((12.5, 42.5))]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["not computed (2)"]


def test_nothing_is_drawn_of_nothing_or_of_more_than_two_axes():
    assert sweep_figure(swept({ROD: [0.01, 0.02]}), "stroke") is None
    assert sweep_figure(swept({**GRID, "bars.rod.mass": [0.4, 0.5]}), "stroke") is None
