import numpy as np
import pytest
from matplotlib.figure import Figure
from plot_data import press, press_data

from linkages.plots.motion.phase_diagrams import (
    MANY_POINTS,
    Free,
    coordinates,
    draw,
    figure,
    refined,
    wrapped,
)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_wrapped_curve_breaks_at_each_passage_and_reaches_both_ends(sense):
    angle = sense * np.linspace(0.0, 4.8 * np.pi, 40)
    x, y = wrapped(angle, angle)
    gaps = np.flatnonzero(np.isnan(x))
    assert len(gaps) == 2  # at half a turn and at one and a half
    assert (np.isnan(y) == np.isnan(x)).all()
    np.testing.assert_array_equal(x[gaps - 1], 180.0 * sense)
    np.testing.assert_array_equal(x[gaps + 1], -180.0 * sense)
    # The speed is linear in the angle here, so interpolation is exact up to round-off.
    np.testing.assert_allclose(y[gaps - 1], sense * np.array([1, 3]) * np.pi, rtol=1e-12)
    joined = np.abs(np.diff(x))
    assert np.nanmax(joined) < 90.0


def test_wrapping_does_not_care_whether_turns_are_counted():
    angle = np.linspace(-1.0, 9.0, 200)
    within = np.angle(np.exp(1j * angle))
    for one, other in zip(wrapped(angle, angle), wrapped(within, angle), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)  # degrees; round-off of the turns


@pytest.mark.parametrize("turns", ["counted", "not counted"])
def test_refined_curve_follows_a_swing_between_samples(turns):
    # Seven samples a period, as of a clearance in the press. The error of cubic Hermite
    # interpolation is h⁴/384 · max |f⁗| = 0.0017 for sin t with this h; corners miss by 0.1.
    time = np.linspace(0.0, 20.0, 1 + round(20.0 / (2 * np.pi / 7)))
    angle, speed = 3.0 + np.sin(time), np.cos(time)
    if turns == "not counted":
        angle = np.angle(np.exp(1j * angle))
    x, y = refined(time, angle, speed, -np.sin(time))
    radius = np.hypot(x - 3.0, y)
    assert len(x) > 5 * len(time)
    np.testing.assert_allclose(radius, 1.0, atol=2 * 0.0017)


def test_angles_in_degrees_against_speed():
    data = press_data()
    ax = draw(Figure().add_subplot(), data, Free("clearance", "r1"), "Press")
    assert ax.get_xlabel() == "clearance angle [°]"
    assert ax.get_ylabel() == "clearance speed [rad/s]"
    curve = ax.lines[0].get_xydata()
    np.testing.assert_allclose(curve[:, 0], np.degrees(data["clearance_angle"].values[:, 0]))
    np.testing.assert_array_equal(curve[:, 1], data["clearance_speed"].values[:, 0])


def test_a_rotating_clearance_gets_the_whole_turn():
    data = press_data()
    data["clearance_angle"].values[:, 0] = np.linspace(0.0, 30.0, data.sizes["time"])
    ax = draw(Figure().add_subplot(), data, Free("clearance", "r1"))
    assert ax.get_xlim() == (-180.0, 180.0)
    assert np.isnan(ax.lines[0].get_xdata()).sum() == 5


def test_free_coordinates_are_found():
    data = press_data(bar=["crank", "left arm", "arm"])
    assert coordinates(data, press()) == [("clearance", "r1")]
    data.attrs["free"] = "r1 left arm ram"
    found = coordinates(data, press())
    assert found == [("clearance", "r1"), ("bar", "left arm"), ("bar", "arm"), ("slider", "ram")]


def test_one_panel_for_each_coordinate():
    data = press_data(clearance=["r1", "r2"])
    data.attrs["free"] = "r2"  # the press has no such clearance; without this it is no coordinate
    assert len(figure(data, press()).axes) == 2
    data.attrs["free"] = "r2 ram"
    result = figure(data, press())
    titles = [ax.get_title(loc="left") for ax in result.axes]
    assert titles == ["r1", "r2", "ram"]
    assert result.axes[2].get_xlabel() == "position [m]"


@pytest.mark.parametrize("samples", [1, 2])
def test_short_data(samples):
    assert figure(press_data(samples), press()) is not None


def test_nothing_to_draw():
    assert figure(press_data().isel(time=slice(0)), press()) is None
    assert figure(press_data().drop_vars("clearance_speed"), press()) is None


@pytest.mark.slow
def test_a_long_run_is_drawn_as_dots():
    ax = draw(Figure().add_subplot(), press_data(MANY_POINTS + 1), Free("clearance", "r1"))
    assert ax.lines[0].get_linestyle() == "None"
    assert ax.lines[0].get_rasterized()
