import numpy as np
import pytest
from plot_data import press, press_data

from linkages.plots.traces import figure, moving_joints


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


@pytest.mark.parametrize("samples", [1, 2])
def test_short_data(samples):
    assert figure(press_data(samples), press()) is not None


def test_nothing_to_draw():
    assert figure(press_data().isel(time=slice(0)), press()) is None
