"""What a page carries of a motion: numbers as text, frames, bands between them, descriptions."""

import base64
import json
import re
import zlib

import numpy as np
import pytest

import linkages
from linkages.kernel.system import System
from linkages.solution.series import data_series
from linkages.viewer.content import described, html
from linkages.viewer.recorded import (
    FEWEST,
    NUMBERS,
    PER_SWING,
    Packed,
    bounds,
    chosen,
    dense,
    detail,
    section,
    wanted,
)


def unpacked(text):
    """The way back, as `assets/unpack.js` goes it."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(4, -1)
    steps = planes.T.copy().view("<u4")[:, 0]
    return np.cumsum(steps, dtype=np.uint32).view(np.float32)


def test_packed_numbers_come_out_as_they_went_in():
    packed = Packed()
    values = [1.0, -0.0, np.nan, np.inf, 1e-40, -3.5e38, 1e300, np.pi]
    first, second = packed.add(values), packed.add([[7.0, 8.0]])
    found = unpacked(packed.text())
    with np.errstate(over="ignore"):
        expected = np.array([*values, 7.0, 8.0]).astype(np.float32)
    np.testing.assert_array_equal(found.view(np.uint32), expected.view(np.uint32))
    assert (first, second) == ((0, 8), (8, 2))


def test_times_are_exact_as_two_parts():
    packed = Packed()
    time = np.linspace(0.0, 61.7, 2001)
    (a, count), (b, _) = packed.add_exact(time)
    found = unpacked(packed.text()).astype(float)
    # two times 24 binary digits
    np.testing.assert_allclose(found[a : a + count] + found[b : b + count], time, rtol=2**-47)


def test_nothing_is_packed_as_nothing():
    assert unpacked(Packed().text()).size == 0


@pytest.mark.slow
def test_frames_show_every_swing_and_both_ends():
    data = dense(linkages.simulate(linkages.load("ninebar"), samples=101))
    frames = chosen(data)
    assert (frames[0], frames[-1]) == (0, data.sizes["time"] - 1)
    angle = data["clearance_angle"].to_numpy()[:, 0]
    swings = np.count_nonzero(np.diff(np.sign(np.diff(angle)))) / 2
    series = sum(int(np.prod(array.shape[1:])) for array in data.data_vars.values())
    # as many as swings need, or as there is room for
    assert len(frames) == pytest.approx(min(PER_SWING * swings, NUMBERS / series), rel=0.01)
    assert len(frames) > 7 * swings


def test_a_slow_motion_needs_few_frames():
    data = dense(linkages.simulate(linkages.load("four-bar"), samples=20001))
    assert len(chosen(data)) == FEWEST


def test_few_samples_are_all_frames():
    data = linkages.simulate(linkages.load("four-bar"), samples=5).data
    assert list(chosen(data)) == [0, 1, 2, 3, 4]


def test_bands_hold_all_that_is_between_frames():
    time = np.linspace(0.0, 1.0, 100_001)
    values = np.sin(2 * np.pi * 3000 * time) * (1 + time)
    frames = np.linspace(0, 100_000, 1001).round().astype(int)
    stretch, low, high = bounds(values, frames)
    assert stretch == 3
    for k in range(len(low)):
        first, last = frames[stretch * k], frames[min(stretch * (k + 1), 1000)]
        assert low[k] == values[first : last + 1].min()
        assert high[k] == values[first : last + 1].max()
    assert high.max() == values.max()
    assert len(low) == -(-1000 // stretch)


def test_what_frames_show_has_no_bands():
    time = np.linspace(0.0, 1.0, 100_001)
    frames = np.linspace(0, 100_000, 1001).round().astype(int)
    assert bounds(np.sin(2 * np.pi * 5 * time), frames) is None
    assert bounds(np.full_like(time, np.nan), frames) is None
    assert bounds(np.ones(5), np.arange(5)) is None


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["forwards", "back in time"])
def test_a_section_has_the_state_once_per_period(sign):
    """Of a sine, some 40 samples a swing, whose samples are nowhere at the ends of periods."""
    time, packed, period = sign * np.linspace(0.0, 10.0, 403), Packed(), 0.7
    found = section(time, {"swing": np.sin(6.1 * time)}, period, packed)
    numbers = unpacked(packed.text()).astype(float)
    (a, count), (b, _) = found["time"]
    place, _ = found["series"]["swing"]
    np.testing.assert_allclose(
        numbers[a : a + count] + numbers[b : b + count], sign * period * np.arange(15), rtol=1e-12
    )
    # the error of a cubic spline, (h ω)⁴ / 384, and near ends some times that
    np.testing.assert_allclose(
        numbers[place : place + count], np.sin(6.1 * period * sign * np.arange(15)), atol=2e-5
    )


def test_there_is_no_section_without_a_period_or_a_second_point():
    time, moved = np.linspace(0.0, 1.0, 50), {"swing": np.zeros(50)}
    assert section(time, moved, None, Packed()) is None
    assert section(time, moved, 1.01, Packed()) is None
    assert section(time, {}, 0.5, Packed()) is None
    assert section(time, {"swing": np.full(50, np.nan)}, 0.5, Packed()) is None
    assert section(time, moved, 1.0, Packed())["time"][0][1] == 2


def test_frames_that_show_swings_need_no_detail():
    time = np.linspace(0.0, 1.0, 20_001)
    moved = {"swing": np.sin(2 * np.pi * 500 * time)}
    assert detail(time, moved, 2600, Packed()) is None  # 5.2 frames a swing
    found = detail(time, moved, 2400, Packed())
    assert found["series"]["swing"][1] == found["time"][0][1] == 2000
    assert detail(time, {}, 100, Packed()) is None
    assert detail(time[::10], {"swing": moved["swing"][::10]}, 100, Packed()) is None
    assert section(time[::5], {"swing": moved["swing"][::5]}, 0.1, Packed()) is None
    assert section(time[::4], {"swing": moved["swing"][::4]}, 0.1, Packed()) is not None


def test_coordinates_of_a_state_are_series_of_the_page():
    for name in ("slider-crank-contact", "ninebar", "class-three", "impact-oscillator"):
        system = System(linkages.load(name))
        content = described(system)
        known = set(data_series(linkages.simulate(system.mechanism, end=1e-4, samples=2,
                                                  outputs=wanted(system)).data))  # fmt: skip
        assert len(content["state"]) == 2 * len(system.layout.coordinates)
        assert set(content["state"]) | set(content["free"]) <= known


def test_a_page_has_what_it_draws_whatever_was_asked_for():
    mechanism = linkages.load("ninebar")
    names = wanted(System(mechanism), ["drive_effort"])
    assert {"joint_position", "clearance_force", "joint_reaction"} <= set(names)
    solution = linkages.simulate(mechanism, outputs=["drive_effort"], end=0.01, samples=11)
    assert set(names) <= set(dense(solution).data_vars)


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("andrews", ["about", "between"]),
        ("slider-crank", ["along"]),
        ("beam-pump", ["about"]),
        ("four-bar", []),
    ],
)
def test_loads_are_described_by_what_they_act_along(name, kinds):
    found = described(System(linkages.load(name)))["loads"]
    assert [load["kind"] for load in found] == kinds


def test_content_cannot_end_its_element():
    mechanism = linkages.load("pendulum", set={"name": "</script><b>{{script}}"})
    text = html(linkages.simulate(mechanism, end=0.1, samples=3))
    assert "</script><b>" not in text
    found = re.search(r'<script type="application/json" id="content">(.*?)</script>', text, re.S)
    assert json.loads(found[1])["mechanism"]["name"] == "</script><b>{{script}}"
    assert text.count("<h1>&lt;/script&gt;&lt;b&gt;{{script}}</h1>") == 1


@pytest.mark.slow
def test_a_page_is_small_and_says_where_it_comes_from():
    text = html(linkages.simulate(linkages.load("ninebar"), samples=101))
    assert len(text) < 800_000  # of 124 series
    found = re.search(r'<script type="application/json" id="content">(.*?)</script>', text, re.S)
    origin = json.loads(found[1])["origin"]
    assert linkages.loads(origin["definition"]) == linkages.load("ninebar")
    assert origin["version"].startswith("linkages ")
    assert json.loads(origin["options"])["samples"] == 101


def test_results_from_a_disk_are_shown_as_they_were_computed(tmp_path):
    solution = linkages.simulate(linkages.load("four-bar"), samples=51)
    solution.save(tmp_path)
    path = linkages.view(linkages.open(tmp_path), tmp_path / "page.html")
    found = re.search(r'id="content">(.*?)</script>', path.read_text(encoding="utf-8"), re.S)
    assert json.loads(found[1])["motion"]["samples"] == 51


def test_a_page_needs_places_of_joints_and_something_to_show(tmp_path):
    solution = linkages.simulate(linkages.load("four-bar"), outputs=["bar_angle"], samples=3)
    solution.save(tmp_path)
    with pytest.raises(ValueError, match="no samples of joint_position"):
        linkages.view(linkages.open(tmp_path), tmp_path / "page.html")
    with pytest.raises(TypeError, match="expected a solution, a mechanism or opened results"):
        linkages.view(solution.data, tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()


def test_a_mechanism_is_simulated_and_named_after_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert linkages.view(linkages.load("four-bar")).name == "four-bar.html"
    assert [path.name for path in tmp_path.iterdir()] == ["four-bar.html"]


def test_coordinates_of_a_driven_point_are_series_of_the_page():
    made = linkages.loads("""
joints: {O: [0, 0]}
bars: {upper: {joints: [O, A], length: 0.4}, fore: {joints: [A, P], length: 0.3}}
drives: {P: {x: 0.5, y: 0.2*t}}
actuators: {shoulder: {bar: upper}, elbow: {bars: [upper, fore]}}
assembly: {A: left}
""")
    content = described(System(made))
    assert content["driven"] == ["P.x position", "P.y position"]
    guided = [body for body in content["bodies"] if body["name"].startswith("P.")]
    assert [body["joints"] for body in guided] == [[], []]  # nothing of them is drawn
    names = wanted(System(made))
    assert {"joint_position", "rotary_actuator_angle", "drive_effort"} <= {*names}
