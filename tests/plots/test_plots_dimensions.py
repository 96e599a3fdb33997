"""Lengths and centres of mass in drawings, against the numbers of the definition."""

import numpy as np
import pytest
from drawn_shapes import SCALE

import linkages
from linkages.kernel.system import System
from linkages.plots.mechanism.annotations import (
    CENTRE,
    centre_lines,
    draw_centres,
    frame_lines,
    frame_words,
    length_words,
)
from linkages.plots.mechanism.drawing import reach, start_figure, start_pose
from linkages.plots.mechanism.placing import placed
from linkages.plots.mechanism.shapes import Disc


@pytest.fixture(scope="module")
def system():
    return System(linkages.load("four-bar"))


def test_lengths_are_those_of_the_file(system):
    pose = start_pose(system)
    words = {}
    for word in length_words(pose, reach(pose).scale):
        words.setdefault(word.name, []).append(word.text)
    assert words["crank"] == ["40 mm"]
    assert words["rocker"] == ["80 mm"]
    assert sorted(words["coupler"])[0] == "120 mm"
    assert len(words["coupler"]) == 3


def test_centres_of_mass_are_where_the_bodies_have_them(system):
    pose = start_pose(system)
    found = {s.name: s for s in draw_centres(pose) if isinstance(s, Disc)}
    for name, body in system.mechanism.bodies.items():
        x, y = (number.value for number in body.centre)
        angle = pose.angle(name)
        joint, (u, v) = next(iter(body.points.items()))
        own = np.array([x - u.value, y - v.value])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        expected = np.array(pose.positions[joint]) + turn @ own
        disc = found[name]
        (place,) = placed(pose, [disc.centre], disc.direction, 1 / SCALE)
        assert place == pytest.approx(expected, abs=1e-15)
        assert disc.points == CENTRE


def test_a_centre_of_mass_far_from_the_joints_lies_within_the_frame():
    door = """
joints: {H: [0, 0]}
bars: {door: {joints: [H, A], length: 0.3, mass: 35, center: 0.9}}
free: {door: {angle: 90 deg, speed: 0}}
"""
    (ax,) = start_figure(System(linkages.loads(door)), dimensions=True).axes
    assert ax.get_ylim()[1] > 900 > start_figure(System(linkages.loads(door))).axes[0].get_ylim()[1]


def test_lines_join_centres_of_mass_and_nearest_joints(system):
    pose = start_pose(system)
    discs = {s.name: s for s in draw_centres(pose) if isinstance(s, Disc)}
    for line, (name, disc) in zip(centre_lines(pose), discs.items(), strict=True):
        (centre, joint) = placed(pose, line.strokes[0], line.direction, 1 / SCALE)
        (place,) = placed(pose, [disc.centre], disc.direction, 1 / SCALE)
        assert centre == pytest.approx(place, abs=1e-15)
        joints = [pose.positions[own] for own in system.mechanism.bodies[name].points]
        nearest = min(joints, key=lambda own: np.hypot(*(own - place)))
        assert joint == pytest.approx(nearest, abs=1e-15)


def test_they_are_drawn_if_they_are_asked_for(system):
    plain, full = (
        {text.get_text() for text in start_figure(system, dimensions=asked).axes[0].texts}
        for asked in (False, True)
    )
    assert {"40 mm", "80 mm", "120 mm"} <= full - plain


def test_the_frame_on_the_ground_has_its_lengths_and_angles(system):
    """Beside each other at one height: a length alone. Otherwise an angle at the left pivot."""
    pose = start_pose(system)
    assert [word.text for word in frame_words(pose, reach(pose).scale)] == ["100 mm"]
    assert len(frame_lines(pose)) == 1
    klann = start_pose(System(linkages.load("klann")))
    words = [word.text for word in frame_words(klann, reach(klann).scale)]
    b, d, a = (np.array(klann.positions[joint]) for joint in "BDA")  # from left to right
    for first, second, length, angle in ((b, d, *words[:2]), (d, a, *words[2:])):
        way = second - first
        assert float(length.split()[0]) == pytest.approx(1e3 * np.hypot(*way), rel=1e-3)
        degrees = float(angle.rstrip("°").replace("−", "-"))
        assert degrees == pytest.approx(np.degrees(np.arctan2(*way[::-1])), rel=1e-3)


def test_lengths_are_written_along_their_sides(system):
    """Turned as the side is, upside up, and clear of its line."""
    texts = {text.get_text(): text for text in start_figure(system, dimensions=True).axes[0].texts}
    places = start_pose(system).positions
    for word, (first, second) in {"80 mm": ("O4", "B"), "120 mm": ("A", "B")}.items():
        way = np.subtract(places[second], places[first])
        turned = np.degrees(np.arctan2(way[1], way[0]))
        assert texts[word].get_rotation() == pytest.approx(turned, abs=1e-6)
    assert texts["rocker"].get_rotation() == 0.0
