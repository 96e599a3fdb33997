"""The way of a pin in its hole, and strips of free flight, impacts and following contact."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.patches import Circle
from plot_data import hopping_data, press, press_data

from linkages.plots import FIGURES, charts
from linkages.plots.motion.clearance_orbit import COLOURS, opening, shares


def segments(ax):
    (found,) = (c for c in ax.collections if isinstance(c, LineCollection))
    return found


def test_an_orbit_has_the_circle_of_the_clearance_and_a_segment_between_samples():
    data = hopping_data()
    ax = charts.clearance_orbit(data)
    (circle,) = (p for p in ax.patches if isinstance(p, Circle))
    assert circle.radius == pytest.approx(200.0)  # µm
    assert ax.get_xlabel() == "offset x [µm]"
    lines = segments(ax)
    assert len(lines.get_segments()) == data.sizes["time"] - 1
    ends = np.array(lines.get_segments())[:, 0]
    offset = 1e6 * data["clearance_offset"].values[:-1, 0]
    np.testing.assert_allclose(np.sort(ends, 0), np.sort(offset, 0), rtol=1e-12)


def test_segments_are_coloured_by_the_state_that_they_lead_from():
    data = hopping_data()
    found = segments(charts.clearance_orbit(data)).get_colors()
    state = data["clearance_state"].values[:-1, 0]
    for value, colour in enumerate(COLOURS):
        same = (np.abs(found - np.array(to_rgba(colour))) < 1e-12).all(axis=1)
        assert same.sum() == (state == value).sum()


def test_shares_are_those_of_time_whatever_the_samples():
    data = hopping_data(samples=4001)
    expected = [0.67, 0.08, 0.25]
    assert shares(data, ["gap"]) == pytest.approx(expected, abs=1e-3)
    uneven = np.flatnonzero((data["time"].values > 0.6) | (np.arange(4001) % 4 == 0))
    assert shares(data.isel(time=uneven), ["gap"]) == pytest.approx(expected, abs=2e-3)


def test_strips_fill_the_time_once():
    ax = charts.clearance_state(hopping_data(("gap", "worn")))
    assert [label.get_text() for label in ax.get_yticklabels()] == ["worn", "gap"]
    boxes = [path.get_extents() for bars in ax.collections for path in bars.get_paths()]
    assert sum(box.width for box in boxes) == pytest.approx(2 * 1.0 * 1.0, rel=1e-12)
    assert "free flight: 67" in ax.get_legend().get_texts()[0].get_text()


@pytest.mark.parametrize("name", ["clearance_orbit", "clearance_state"])
def test_figures_are_for_clearances_that_open_alone(name):
    assert FIGURES[name](press_data(), press()) is None
    mixed = hopping_data(("gap", "link"))
    mixed["clearance_offset"][:, 1] = np.nan  # as a massless link beside it has it
    assert opening(mixed) == ["gap"]
    assert FIGURES[name](mixed, press()) is not None
    with pytest.raises(ValueError, match="the data have no"):
        getattr(charts, name)(press_data())


def test_an_unknown_clearance_is_named_with_those_that_are_known():
    with pytest.raises(ValueError, match=r"unknown clearance .* 'r2'; .*: gap"):
        charts.clearance_orbit(hopping_data(), "r2")
