import numpy as np
import pytest
from plot_data import press, press_data

from linkages.plots.mechanism.traces import COUPLER, LED, figure, led_joints, moving_joints


def test_moving_joints_leave_out_ground_and_what_a_clearance_hides():
    assert list(moving_joints(press_data(), press())) == ["A", "B", "P", "F"]


def test_a_large_clearance_has_a_trace_of_its_own():
    data = press_data()
    data["joint_position"].loc[{"joint": "B.r1"}] += 0.1
    assert "B.r1" in moving_joints(data, press())


def test_each_trace_is_drawn_in_the_units_of_the_axes_and_labelled():
    data = press_data()
    (ax,) = figure(data, press()).axes
    assert ax.get_xlabel() == "x [mm]"
    assert {text.get_text() for text in ax.texts} == {"A", "B", "P", "F"}
    path = 1e3 * data["joint_position"].sel(joint="P").values
    assert any(
        line.get_xydata().shape == path.shape and np.allclose(line.get_xydata(), path)
        for line in ax.lines
    )


def test_coupler_curves_are_thicker_than_what_the_ground_leads():
    # crank and rocker turn on the ground, the ram slides on it: only P is free of it
    assert {"A", "F"} <= led_joints(press())
    assert "P" not in led_joints(press())
    data = press_data()
    (ax,) = figure(data, press()).axes
    samples = data.sizes["time"]
    widths = [line.get_linewidth() for line in ax.lines if len(line.get_xdata()) == samples]
    assert sorted(widths) == [LED, LED, COUPLER, COUPLER]  # B's bar ends beside the pin, at B.r1


@pytest.mark.parametrize("samples", [1, 2])
def test_short_data(samples):
    assert figure(press_data(samples), press()) is not None


def test_nothing_to_draw():
    assert figure(press_data().isel(time=slice(0)), press()) is None
