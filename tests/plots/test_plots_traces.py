import io
import re
import xml.etree.ElementTree as Tree

import numpy as np
import pytest
from matplotlib.patches import Circle, Polygon
from plot_data import JOINTS, press, press_data

import linkages
from linkages.plots.films.stage import framed as film_frame
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
    names = {text.get_text() for text in ax.texts if text.get_gid() != "marks"}
    assert names == {"A", "B", "P", "F"}
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


def test_vector_graphics_have_every_sample_and_the_names_of_joints():
    """No vertex is left out, though a few would look the same; each path bears its joint's name."""
    data = press_data(3001)
    stream = io.StringIO()
    figure(data, press()).savefig(stream, format="svg")
    root = Tree.fromstring(stream.getvalue())
    groups = {element.get("id"): element for element in root.iter()}
    for joint in ("A", "B", "P", "F"):
        (path,) = groups[f"path-{joint}"]
        assert len(re.findall("[ML] ", path.get("d"))) == 3001


def test_a_dot_where_each_path_begins_and_an_arrow_along_it():
    data = press_data()
    (ax,) = figure(data, press()).axes
    starts = {tuple(np.round(p.center, 9)) for p in ax.patches if isinstance(p, Circle)}
    for joint in ("A", "B", "P", "F"):
        places = 1e3 * data["joint_position"].sel(joint=joint).values
        assert tuple(np.round(places[0], 9)) in starts
    arrows = [p.get_xy() for p in ax.patches if isinstance(p, Polygon)]
    assert arrows
    for tip, left, right, *_ in arrows:
        paths = (1e3 * data["joint_position"].sel(joint=joint).values for joint in "ABPF")
        middle = 0.5 * (left + right)
        # of the path whose sample is nearest to the foot of the arrow: the way that it goes there
        near = min(paths, key=lambda path: np.hypot(*(path - middle).T).min())
        at = int(np.argmin(np.hypot(*(near - middle).T)))
        assert (tip - middle) @ (near[at] - near[at - 1]) > 0


def test_the_picture_holds_the_mechanism_where_it_starts():
    data = press_data()
    (ax,) = figure(data, press()).axes
    for x, y in 1e3 * np.array(list(JOINTS.values())):
        assert ax.get_xlim()[0] < x < ax.get_xlim()[1]
        assert ax.get_ylim()[0] < y < ax.get_ylim()[1]


def test_films_and_traces_show_the_same_part_of_the_plane():
    """Within their margins, which differ: the middle is the same, and what is swept is inside."""
    solution = linkages.simulate(linkages.load("scotch-yoke"), samples=21)
    (ax,) = figure(solution.data, solution.mechanism).axes
    _, box = film_frame(solution.data, solution.mechanism)
    for limits, low, high in zip((ax.get_xlim(), ax.get_ylim()), box.low, box.high, strict=True):
        assert np.mean(limits) == pytest.approx(500 * (low + high), abs=1e-9)
        assert limits[0] < 1e3 * low < 1e3 * high < limits[1]
    # the rod of the yoke: a stroke beyond it, without its symbols
    assert box.bare.high[0] == pytest.approx(0.15, abs=1e-3)
