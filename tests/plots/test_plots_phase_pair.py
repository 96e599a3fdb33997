"""Phase diagrams of any two outputs."""

import numpy as np
import pytest

import linkages
from linkages.plots.motion.overlay import pair_figure


@pytest.fixture(scope="module")
def data():
    mechanism = linkages.load("ninebar", set={"clearances.r1.angle": "90 deg"})
    outputs = ["clearance_angle", "slider_velocity", "bar_angle", "slider_position"]
    return linkages.simulate(mechanism, end=2.0, samples=4001, outputs=outputs).data


def test_curve_is_that_of_the_outputs(data):
    (ax,) = pair_figure(data, "slider9.position", "slider9.velocity").axes
    x, y = ax.lines[0].get_data()
    np.testing.assert_allclose(x, data.slider_position[:, 0], rtol=1e-15)
    np.testing.assert_allclose(y, data.slider_velocity[:, 0], rtol=1e-15)
    assert ax.get_xlabel() == "position of slider9 [m]"
    assert ax.get_ylabel() == "velocity of slider9 [m/s]"


@pytest.mark.parametrize("wrap", [True, False])
def test_angles_are_wrapped_unless_told_otherwise(data, wrap):
    (ax,) = pair_figure(data, "r1.angle", "crank1.angle", wrap=wrap).axes
    x, y = ax.lines[0].get_data()
    angle = np.degrees(data.clearance_angle[:, 0].to_numpy())
    assert np.ptp(angle) > 3600  # it rotates
    if wrap:
        assert np.nanmax(np.abs(x)) == np.nanmax(np.abs(y)) == 180
        gaps = np.isnan(x) | np.isnan(y)
        steps = np.abs(np.diff(x))[~(gaps[1:] | gaps[:-1])]
        assert steps.max() < 180  # the curve never crosses the picture
    else:
        np.testing.assert_allclose(x, angle, rtol=1e-15)
        np.testing.assert_allclose(y, np.degrees(data.bar_angle.sel(bar="crank1")), rtol=1e-15)


def test_over_time_angles_keep_their_turns(data):
    (ax,) = pair_figure(data, "time", "r1.angle").axes
    x, y = ax.lines[0].get_data()
    np.testing.assert_array_equal(x, data.time)
    np.testing.assert_allclose(y, np.degrees(data.clearance_angle[:, 0]), rtol=1e-15)
    assert len(ax.lines) == 1  # no mark at the start
    assert ax.get_xlabel() == "time [s]"


def test_without_samples_there_is_no_figure(data):
    assert pair_figure(data.isel(time=slice(0, 0)), "r1.angle", "slider9.velocity") is None


def test_unknown_names_are_refused(data):
    with pytest.raises(ValueError, match=r"did you mean 'r1\.angle'"):
        pair_figure(data, "r1.angl", "slider9.velocity")
