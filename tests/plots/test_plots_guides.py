"""Rails, rods in bushings, slots, cylinders and stops: where they are drawn, and where not."""

import numpy as np
import pytest
from drawn_shapes import SCALE, corners, shapes, strokes

import linkages
from linkages.plots.mechanism.guide_symbols import RAIL, rod_side, slider_of
from linkages.plots.mechanism.pose import Pose, Poses
from linkages.plots.mechanism.shapes import BLOCK, SMALL_BLOCK, Strokes, stands_still

CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: [0, HEIGHT], mass: 2}}
bars: {arm: {joints: [O, A], length: 0.2}, rod: {joints: [A, C], length: 0.4}}
drives: {arm: {angle: 90 deg, speed: 1}}
"""


def cart(height=0.0, travel=(0.3, 0.5)):
    mechanism = linkages.loads(CART.replace("HEIGHT", str(height)))
    places = {"O": (0.0, 0.0), "A": (0.0, 0.2), "C": (0.35, height)}
    return Pose(mechanism, places, travel={"cart": travel})


def rails(pose, name="cart"):
    """Heights of the two long lines of a guide over its axis, in points."""
    still = [s for s in shapes(pose, Strokes, role="ink") if s.name == name]
    (guide,) = (s for s in still if stands_still(s, pose.mechanism.ground) and not s.closed)
    long = [line for line in strokes(pose, guide) if np.ptp(line[:, 0]) * SCALE > 20]
    return sorted(float(line[0, 1]) for line in long), long


@pytest.mark.parametrize(("height", "sides"), [(0.0, (-1, 1)), (0.3, (1,)), (-0.3, (-1,))])
def test_rails_lie_on_the_far_side_of_the_mechanism(height, sides):
    """One of them where the linkage is on the other side of the axis, so that no bar crosses it."""
    heights, long = rails(cart(height))
    assert heights == pytest.approx([height + side * RAIL / SCALE for side in sides])
    for line in long:  # along all of the travel, and the block
        assert line[:, 0].min() <= 0.3 - BLOCK[0] / SCALE
        assert line[:, 0].max() >= 0.5 + BLOCK[0] / SCALE


@pytest.mark.parametrize(("travel", "side"), [((0.3, 0.5), 0), ((-0.2, 0.5), 1), ((-0.9, 0.1), -1)])
def test_a_guide_that_would_run_through_a_pivot_is_a_bushing_beyond_it(travel, side):
    pose = cart(travel=travel)
    assert rod_side(slider_of(pose, "cart"), SCALE) == side
    if side:
        low, high = travel[0], max(travel[1], 0.35)  # where it is now
        bushing = [s for s in shapes(pose, Strokes, role="ink", fill="") if s.name == "cart"]
        (rod,) = (s for s in shapes(pose, Strokes, width=3.4) if s.name == "cart")
        walls = side * np.vstack([corners(pose, s) for s in bushing])[:, 0]
        last, first = (high, low) if side > 0 else (-low, -high)
        assert walls.min() > last
        # where the slider is farthest away, the rod still reaches through the bushing
        assert first + np.ptp(corners(pose, rod)[:, 0]) > walls.max()


def test_the_yoke_of_a_scotch_yoke_has_a_slot_as_wide_as_its_block():
    solution = linkages.simulate(linkages.load("scotch-yoke"), samples=101)
    poses = Poses(solution.data, solution.mechanism)
    pose = poses.at(0)
    slot, block = (s for s in shapes(pose, Strokes) if s.name == "pin" and s.closed)
    assert np.ptp(corners(pose, slot)[:, 0]) * SCALE == pytest.approx(2 * SMALL_BLOCK[1])
    assert np.ptp(corners(pose, block)[:, 0]) * SCALE == pytest.approx(2 * SMALL_BLOCK[1])
    for index in range(0, 101, 10):  # inside it all the way
        there = poses.at(index)
        high, inner = (corners(there, shape)[:, 1] for shape in (slot, block))
        assert high.min() < inner.min()
        assert inner.max() < high.max()


def test_the_slot_of_a_quick_return_is_on_its_arm():
    solution = linkages.simulate(linkages.load("quick-return"), samples=101)
    pose = Poses(solution.data, solution.mechanism).at(0)
    slot, block = (s for s in shapes(pose, Strokes) if s.name == "block" and s.closed)
    length = np.hypot(*pose.positions["B"])
    along = corners(pose, slot) @ pose.positions["B"] / length
    # crank 50 mm, centre distance 100 mm: from 50 mm to 150 mm, and room for the block
    room = (SMALL_BLOCK[0] - 2 + SMALL_BLOCK[1]) / SCALE
    assert [along.min(), along.max()] == pytest.approx([0.05 - room, 0.15 + room], abs=1e-3)
    assert np.ptp(corners(pose, block) @ pose.positions["B"] / length) * SCALE < 20


def test_stops_are_walls_where_blocks_meet_them_and_edges_where_bars_do():
    text = """
joints: {O: [0, 0], D: [0.5, 0.3]}
sliders: {cart: {joint: C, through: O, mass: 2}}
bars: {arm: {joints: [D, E], length: 0.2, mass: 1}}
stops:
  - {slider: cart, lower: -0.3, upper: 0.6, stiffness: 2e4}
  - {bars: [ground, arm], upper: 60 deg, restitution: 0.5}
  - {between: [C, E], upper: 0.8, stiffness: 2e4}
free: {cart: {position: 0, speed: 3}, arm: {angle: 0, speed: 1}}
"""
    places = {"O": (0, 0), "D": (0.5, 0.3), "C": (0.1, 0.0), "E": (0.7, 0.3)}
    pose = Pose(linkages.loads(text), places)
    assert not shapes(pose, role="spring")
    left, right, edge = shapes(pose, Strokes, role="ink", width=1.0)
    faces = [strokes(pose, wall)[0][0, 0] for wall in (left, right)]
    assert faces == pytest.approx([-0.3 - BLOCK[0] / SCALE, 0.6 + BLOCK[0] / SCALE])
    line = strokes(pose, edge)[0] - places["D"]
    assert np.degrees(np.arctan2(line[:, 1], line[:, 0])) == pytest.approx(60.0)
    hatched = np.vstack(strokes(pose, edge)[1:]) - places["D"]
    assert np.arctan2(hatched[:, 1], hatched[:, 0]).max() > np.radians(60.0) + 0.1
    (rope,) = shapes(pose, Strokes, dashes=(4.0, 3.0))
    assert corners(pose, rope) == pytest.approx(np.array([places["C"], places["E"]]))


def test_ground_that_only_an_axis_goes_through_has_no_bearing():
    text = """
joints: {O: [0, 0], S: [0, 0.5]}
sliders: {cart: {joint: C, through: O, mass: 2}}
springs: [{between: [S, C], stiffness: 5, length: 0.1}]
free: {cart: {position: 0.1, speed: 3}}
"""
    pose = Pose(linkages.loads(text), {"O": (0, 0), "S": (0, 0.5), "C": (0.1, 0)})
    bearings = {s.name for s in shapes(pose, Strokes, fill="pale") if len(s.strokes[0]) == 3}
    assert bearings == {"S"}


@pytest.mark.parametrize("angle", [90, 80, 40])
def test_rails_that_would_cross_leave_the_way_free(angle):
    """Elliptic trammel: no line of one guide meets one of the other, and both have two parts."""
    text = f"""
joints: {{O: [0, 0]}}
bars: {{link: {{points: {{X: [0, 0], Y: [0.3, 0]}}}}}}
sliders: {{across: {{joint: X, through: O}}, upright: {{joint: Y, through: O, angle: {angle} deg}}}}
drives: {{link: {{angle: 120 deg, speed: 1}}}}
"""
    travel = {"across": (-0.3, 0.3), "upright": (-0.3, 0.3)}
    turned = 0.2 * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    pose = Pose(linkages.loads(text), {"O": (0, 0), "X": (0.2, 0), "Y": tuple(turned)},
                travel=travel)  # fmt: skip
    guides = [
        [line for shape in shapes(pose, Strokes, role="ink", fill="") if shape.name == name
         for line in strokes(pose, shape)]
        for name in travel
    ]  # fmt: skip
    for lines in guides:
        assert len([line for line in lines if np.hypot(*(line[1] - line[0])) * SCALE > 20]) == 4
    for first in guides[0]:
        assert not any(meet(first, second) for second in guides[1])


def meet(first, second):
    """Whether two segments meet: the ends of each lie on both sides of the other."""

    def side(line, point):
        (ax, ay), (bx, by) = line[1] - line[0], point - line[0]
        return np.sign(ax * by - ay * bx)

    return all(
        side(one, other[0]) != side(one, other[1])
        for one, other in ((first, second), (second, first))
    )
