"""One list of shapes is right for every position: it moves as the mechanism does."""

import json

import numpy as np
import pytest
from drawn_shapes import SCALE

import linkages
from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.inked_shapes import DARK, LIGHT, Inked
from linkages.plots.mechanism.placing import placed
from linkages.plots.mechanism.pose import Pose, Poses
from linkages.plots.mechanism.shapes import Disc, Strokes, anchors_of, as_json, stands_still
from linkages.reading.document import shipped


def poses(name, samples=7):
    solution = linkages.simulate(linkages.load(name), end=0.3, samples=samples)
    found = Poses(solution.data, solution.mechanism)
    return [found.at(index) for index in range(samples)]


@pytest.mark.slow_except("four-bar", "ninebar", "quick-return")
@pytest.mark.parametrize("name", sorted({*shipped()} - {"impact-oscillator"}))  # a slider alone
def test_bodies_move_with_their_joints(name):
    """Shapes of the first position, placed in a later one, are those of the later one.

    True of bars, plates, pins and blocks, which do not choose a side or a size for themselves.
    """
    first, *_, last = poses(name)
    names = {*first.mechanism.bodies, *first.positions}
    rough = [[s for s in shapes_of(pose, SCALE) if s.name in names] for pose in (first, last)]
    checked = 0
    for shape, other in zip(*rough, strict=True):
        if type(shape) is not type(other) or shape.look.width not in (3.4, 0.6 * 3.4):
            continue
        if {a.joints for a in anchors_of(shape)} != {a.joints for a in anchors_of(other)}:
            continue  # a rod, whose bushing stands elsewhere; a hull of other corners
        size = first.extent
        here = placed(last, anchors_of(shape), shape.direction, 1 / SCALE)
        there = placed(last, anchors_of(other), other.direction, 1 / SCALE)
        order = [np.lexsort(np.round(p / size, 9).T) for p in (here, there)]
        # positions of joints hold lengths to some 1e-12, and slots are anchored through them
        np.testing.assert_allclose(here[order[0]], there[order[1]], atol=1e-9 * size)
        checked += 1
    assert checked


@pytest.mark.parametrize("name", ["scotch-yoke", "slider-crank", "ninebar", "andrews"])
def test_what_stands_still_does_and_what_moves_moves(name):
    first, *_, last = poses(name)
    moved = 0
    for shape in shapes_of(first, SCALE):
        before, after = (
            placed(pose, anchors_of(shape), shape.direction, 1 / SCALE) for pose in (first, last)
        )
        if stands_still(shape, first.mechanism.ground):
            np.testing.assert_allclose(before, after, atol=1e-12 * first.extent)
        else:
            moved += bool((before != after).any())
    assert moved


@pytest.mark.slow_except("four-bar", "ninebar", "quick-return")
@pytest.mark.parametrize("name", sorted(shipped()))
def test_as_json_says_all_that_a_page_needs_to_place_them(name):
    """Placed again by a few lines that know the JSON alone."""
    _, pose = poses(name, samples=2)
    found = shapes_of(pose, SCALE)
    for plain, shape in zip(json.loads(json.dumps(as_json(found))), found, strict=True):
        direction = plain["direction"]
        angle = direction["angle"]
        if direction["ends"]:
            (ax, ay), (bx, by) = (mean(pose, place) for place in direction["ends"])
            angle += np.arctan2(by - ay, bx - ax)
        if direction["body"]:
            angle += pose.angle(direction["body"])
        anchors = {
            "line": lambda plain=plain: [a for stroke in plain["strokes"] for a in stroke],
            "disc": lambda plain=plain: [plain["centre"]],
            "word": lambda plain=plain: plain["beside"],
        }[plain["kind"]]()
        for anchor, place in zip(
            anchors, placed(pose, anchors_of(shape), shape.direction, 1 / SCALE), strict=True
        ):
            joints, along, across, more, aside = anchor
            x, y = mean(pose, joints)
            a, c = along + more / SCALE, across + aside / SCALE
            expected = (x + a * np.cos(angle) - c * np.sin(angle),
                        y + a * np.sin(angle) + c * np.cos(angle))  # fmt: skip
            assert place == pytest.approx(expected, abs=1e-12 * max(1.0, pose.extent))
        assert plain["role"] in LIGHT
        assert plain["fill"] in ("", *LIGHT)


def mean(pose, weights):
    return (
        np.sum([w * np.array(pose.positions[j]) for j, w in weights.items()], axis=0)
        if (weights)
        else np.zeros(2)
    )


def test_both_palettes_have_the_same_roles():
    assert LIGHT.keys() == DARK.keys()


def test_units_of_axes_are_those_of_the_pose():
    """The same drawing in millimetres is a thousand times as large, symbols included."""
    (pose, *_) = poses("slider-crank")
    shape = next(s for s in shapes_of(pose, SCALE) if isinstance(s, Strokes) and s.look.dashes)
    small = placed(pose, anchors_of(shape), shape.direction, 1 / SCALE)
    large = placed(pose.scaled(1e3), anchors_of(shape), shape.direction, 1e3 / SCALE)
    np.testing.assert_allclose(large, 1e3 * small, rtol=1e-12, atol=1e-9)


def test_artists_follow_the_pose():
    from matplotlib.figure import Figure

    first, *_, last = poses("slider-crank")
    ax = Figure().add_subplot()
    ax.set(xlim=(-0.1, 0.2), ylim=(-0.1, 0.2), aspect="equal")
    drawn = [s for s in shapes_of(first, SCALE) if isinstance(s, Disc)]
    inked = Inked(ax, drawn, first)
    inked.show(last)
    for shape, artist in zip(drawn, inked.artists, strict=True):
        (place,) = placed(last, [shape.centre], shape.direction, 0.0)
        assert artist.get_center() == pytest.approx(tuple(place), abs=1e-15)
        assert artist.get_gid().rpartition("-")[0] == shape.name
    assert len({artist.get_gid() for artist in inked.artists}) == len(drawn)


def test_what_is_not_known_at_a_time_is_hidden_and_comes_back():
    from matplotlib.figure import Figure

    first, *_ = poses("slider-crank")
    ax = Figure().add_subplot()
    ax.set(xlim=(-0.1, 0.2), ylim=(-0.1, 0.2), aspect="equal")
    inked = Inked(ax, shapes_of(first, SCALE), first)
    inked.show(Pose(first.mechanism, {"O": (0.0, 0.0), "A": first.positions["A"]}))
    shown = {artist.get_gid() for artist in inked.artists if artist.get_visible()}
    assert {"O-1", "A-1", "crank-1"} <= shown
    assert not {"B-1", "rod-1"} & shown
    inked.show(first)
    assert all(artist.get_visible() for artist in inked.artists)


def test_a_body_without_an_angle_says_so():
    wheel = linkages.loads("joints: {O: [0, 0]}\nbars: {wheel: {joints: [O, P], length: 1}}\n"
                           "drives: {wheel: {angle: 0, speed: 1}}\n")  # fmt: skip
    from linkages.plots.mechanism.placing import angle_of
    from linkages.plots.mechanism.shapes import Direction

    with pytest.raises(ValueError, match="wheel"):
        angle_of(Pose(wheel, {"O": (0.0, 0.0)}), Direction(body="wheel"))
