"""Numbers that a drag changes, and the motion that is shown at once, against `simulate`."""

import json

import numpy as np
import pytest
from browser import needs_browser
from test_viewer_live import change, motion, number

import linkages

pytestmark = [needs_browser, pytest.mark.slow_except()]

SPOT = """
(() => {
  const { stage, player } = v, at = stage.scene(stage.motion.where(player.time)).joint(%r);
  const box = stage.canvas.getBoundingClientRect(), [x, y] = stage.camera.place(at);
  return [x + box.left, y + box.top];
})()
"""
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def place(page, joint):
    """Where a joint is at the time of the page, in metres."""
    return np.array(
        page.evaluate(f"v.stage.scene(v.stage.motion.where(v.player.time)).joint({joint!r})")
    )


def led(page, joint, way):
    """Drag a joint by pixels; where it should be then, in metres."""
    page.evaluate(DRAWN)
    x, y = page.evaluate(SPOT % joint)
    scale = page.evaluate("v.stage.camera.scale")
    start = place(page, joint)
    page.drag((x, y), (x + 0.5 * way[0], y + 0.5 * way[1]), (x + way[0], y + way[1]))
    page.evaluate("v.live.shown")
    page.evaluate(DRAWN)
    return start + np.array([way[0], -way[1]]) / scale, 1.0 / scale


# a moving joint with two lengths, a plate's point, a ground joint, a block of an iterated group,
# a joint beside a clearance, a free mechanism, one with contact
LED = [
    ("four-bar", "B", 0.1), ("four-bar", "P", 0.3), ("jansen", "V", 0.2), ("jansen", "Z", 0.2),
    ("class-three", "F", 0.05), ("ninebar", "B", 0.1), ("double-pendulum", "Q", 0.0),
    ("slider-crank-contact", "A", 0.0),
]  # fmt: skip


@pytest.mark.slow_except("four-bar-B*")
@pytest.mark.parametrize(("name", "joint", "time"), LED)
def test_a_dragged_joint_goes_along_and_the_file_says_the_same(opened, name, joint, time):
    """The definition that is copied has the joint where it was let go, by another program."""
    page = opened(name)
    page.evaluate(f"v.player.seek({time}); document.getElementById('edit').click()")
    way = (9.0, -6.0)
    goal, pixel = led(page, joint, way)
    found = place(page, joint)
    columns = page.evaluate(f"v.editor.choices[{joint!r}].length")
    assert columns > 0
    if name not in ("slider-crank-contact", "double-pendulum"):
        # numbers have four digits, and other joints stay as well as they can
        np.testing.assert_allclose(found, goal, rtol=0, atol=1.5 * pixel)
    else:  # along the crank or link alone: the nearest place on its line
        away, moved = goal - found, found - (goal - np.array([way[0], -way[1]]) * pixel)
        assert abs(away @ moved) < 2.0 * pixel * np.linalg.norm(moved) + (0.5 * pixel) ** 2
    text = page.evaluate("v.live.numbers.yaml")
    at = page.evaluate("v.player.time")
    times = [0.0, at] if at else [0.0]
    data = linkages.simulate(
        linkages.loads(text), times=times, outputs=["joint_position"], throw=False
    ).data
    own = data["joint_position"].sel(joint=joint).to_numpy()[-1]
    # the picture is between two frames of 600 or more
    np.testing.assert_allclose(found, own, rtol=0, atol=0.5 * pixel)
    assert page.complaints == []


SKETCHED = [
    ("four-bar", {"bars.rocker.length": 1.03}), ("jansen", {"bars.j.length": 1.02}),
    ("class-three", {"bars.leg2.length": 1.03}), ("quick-return", {"bars.crank.length": 1.05}),
    ("toggle-press", {"drives.crank.speed": 1.5}),
]  # fmt: skip


@pytest.mark.slow_except("four-bar-*")
@pytest.mark.parametrize(("name", "factors"), SKETCHED)
def test_what_is_shown_at_once_is_the_motion_where_drives_alone_determine_it(opened, name, factors):
    page = opened(name)
    set_ = {path: number(page, path) * factor for path, factor in factors.items()}
    time, x = page.evaluate(
        f"(() => {{ const set = {json.dumps(set_)}, all = v.live.model.numbers.map((one) =>"
        " set[one.path] ?? one.value);"
        " const { motion } = v.live.kinematics.motion(Float64Array.from(all), v.recorded, 0.1);"
        " return [Array.from(motion.time), motion.series.filter((one) => one.variable ==="
        " 'joint_position').map((one) => [one.place, Array.from(one.values)])]; })()"
    )
    # coordinates of iterated groups count from the file's motion, in 24 binary digits
    data = linkages.simulate(linkages.load(name, set=set_), times=np.array(time)).data
    assert 0.1 in np.array(time) or np.abs(np.array(time) - 0.1).min() < 1e-12
    size = float(np.abs(data["joint_position"]).max())
    for (joint, axis), values in x:
        own = data["joint_position"].sel(joint=joint, axis=axis).to_numpy()
        np.testing.assert_allclose(values, own, rtol=0, atol=1e-9 * size)


@pytest.mark.parametrize("name", ["ninebar", "slider-crank-contact"])
def test_free_coordinates_stay_as_they_were_until_the_motion_is_there(opened, name):
    """Loops are closed with the new lengths meanwhile, and nothing but positions is shown."""
    page = opened(name)
    path, (a, b) = {
        "ninebar": ("bars.link8.length", "EF"), "slider-crank-contact": ("bars.crank.length", "OA")
    }[name]  # fmt: skip
    length = 1.02 * number(page, path)
    page.evaluate(
        "v.player.seek(0.3 * v.recorded.end);"
        f" v.live.change(Float64Array.from(v.live.model.numbers, (one) => one.path === {path!r} ?"
        f" {length} : one.value), {{ hold: true }})"
    )
    assert page.evaluate("v.stage.motion === v.live.preview")
    ends = [np.array(page.evaluate(
        "['x', 'y'].map((axis) => Array.from(v.stage.motion.find('joint_position',"
        f" {joint!r}, axis).values))"
    )) for joint in (a, b)]  # fmt: skip
    np.testing.assert_allclose(np.hypot(*(ends[1] - ends[0])), length, rtol=1e-9)
    free = page.evaluate(
        "CONTENT.mechanism.free.map((name) => { const own = v.stage.motion.byName.get(name),"
        " was = v.recorded.byName.get(name); return Math.max(...Array.from(v.stage.motion.time,"
        " (t, i) => Math.abs(own.values[i] - v.recorded.at(was, v.recorded.where(t))))); })"
    )
    assert free == [0.0] * len(free)
    shown = page.evaluate("[...new Set(v.stage.motion.series.map((one) => one.variable))]")
    assert not {"joint_reaction", "clearance_force", "drive_effort", "bar_speed"} & set(shown)
    said = page.evaluate("document.getElementById('busy').textContent")
    assert said.startswith("Positions only")
    page.evaluate(DRAWN)
    caption = page.evaluate("v.stage.glasses[0].caption.textContent")
    assert "contact" not in caption  # nobody knows the force yet
    assert "\u202fN" not in caption


def test_a_long_motion_is_shown_from_its_beginning_while_it_is_computed(opened):
    page = opened("ninebar")
    path = "bars.link3.length"
    value = 1.01 * number(page, path)
    page.evaluate(
        "(() => { window.parts = []; const { show } = v.panels; v.panels.show = (motion) => {"
        " if (motion.last !== null) parts.push([motion.end, Array.from(motion.find("
        "'joint_position', 'E', 'x').values)]); show.call(v.panels, motion); }; })()"
    )
    change(page, **{path: value})
    parts = page.evaluate("parts")
    assert len(parts) > 1
    # swings may ask for more frames than the file's motion has: then it is computed again
    (again,) = np.nonzero(np.diff([end for end, _ in parts]) <= 0)
    assert len(again) <= 1
    assert page.evaluate("v.stage.motion.last === null && v.panels.motion === v.stage.motion")
    assert page.evaluate("document.getElementById('busy').hidden")
    time, found = motion(page)
    assert time[-1] == page.evaluate("v.recorded.end")
    # the last part was computed with as many frames, unless swings asked for more of them
    (end, values) = parts[-1]
    if len(values) <= len(time) and np.isclose(time[len(values) - 1], end):
        np.testing.assert_array_equal(values, found["E.x position"][: len(values)])
    else:
        assert end <= time[-1]


def test_after_a_motion_that_stopped_all_of_the_next_one_is_shown_at_once(opened):
    page = opened("four-bar")
    change(page, **{"bars.rocker.length": 0.058})
    assert page.evaluate("v.stage.motion.end < 0.9 * v.recorded.end")
    page.evaluate(
        "v.live.change(Float64Array.from(v.live.model.numbers, (one) => one.path ==="
        " 'bars.rocker.length' ? 0.078 : one.value), { hold: true })"
    )
    assert page.evaluate("v.stage.motion === v.live.preview")
    step = page.evaluate("v.stage.motion.time[1] - v.stage.motion.time[0]")
    assert page.evaluate("v.recorded.end - v.stage.motion.end") < step
    assert page.evaluate("document.getElementById('busy').hidden")


def test_a_single_position_is_edited_as_well(browser, tmp_path):
    mechanism = linkages.load("double-pendulum")
    page = browser.page()
    page.open(linkages.view(linkages.simulate(mechanism, times=[0.3]), tmp_path / "page.html"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    page.evaluate("document.getElementById('edit').click()")
    led(page, "Q", (10.0, 10.0))
    assert page.evaluate("document.getElementById('busy').hidden")
    assert page.evaluate("v.live.numbers.changedOnes.length") == 1
    assert page.complaints == []


def test_a_drag_can_be_undone_and_the_original_stays_behind_it(opened):
    page = opened("four-bar")
    page.evaluate("document.getElementById('edit').click()")
    led(page, "B", (12.0, 8.0))
    assert page.evaluate("v.live.numbers.changedOnes.length") == 2
    assert page.evaluate("v.stage.before.motion === v.recorded")
    assert page.evaluate("v.panels.beside.includes(v.recorded)")
    chips = page.evaluate("document.getElementById('shown').textContent")
    assert "Original motion" in chips
    page.evaluate("[...document.querySelectorAll('#editor button')][0].click()")
    page.evaluate("v.live.shown")
    assert page.evaluate("v.live.numbers.changedOnes.length") == 0
    assert page.evaluate("v.stage.motion === v.recorded && v.stage.before === null")
    assert "Original" not in page.evaluate("document.getElementById('shown').textContent")


def test_joints_that_no_number_moves_say_so_and_stay(opened):
    """A coordinate of exactly zero is a part of the structure."""
    page = opened("four-bar")
    page.evaluate("document.getElementById('edit').click()")
    led(page, "O2", (12.0, 8.0))
    assert page.evaluate("v.stage.motion === v.recorded")
    said = page.evaluate("v.editor.says.textContent")
    assert said.startswith("O2 cannot be dragged")


def test_a_drag_stops_where_the_mechanism_cannot_be_assembled(opened):
    page = opened("four-bar")
    page.evaluate("document.getElementById('edit').click()")
    x, y = page.evaluate(SPOT % "O4")
    page.drag((x, y), (x + 80, y), (x + 1500, y))
    page.evaluate("v.live.shown")
    numbers = page.evaluate("v.live.numbers.values")
    assert np.isfinite(numbers).all()
    assert np.isfinite(place(page, "B")).all()
    assert page.complaints == []
