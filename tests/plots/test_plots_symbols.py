"""What is drawn for each component: found again among the shapes, at its place."""

import numpy as np
import pytest
from drawn_shapes import SCALE, arrows, corners, discs, shapes, words
from matplotlib.figure import Figure

import linkages
from linkages.components.transmissions import Gear
from linkages.plots.mechanism.drawing import Wheels, draw, wheels
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.roles import parts_of
from linkages.plots.mechanism.shapes import Strokes
from linkages.plots.style import style

TEXT = """
joints: {O: [0, 0], D: [0.6, 0]}
bars:
  crank: {joints: [O, A], length: 0.2}
  coupler: {points: {A: [0, 0], B: [0.5, 0], C: [0.2, 0.2]}}
  rocker: {joints: [D, B], length: 0.3}
"""
PLACES = {"O": (0, 0), "D": (0.6, 0), "A": (0, 0.2), "B": (0.5, 0.3), "C": (0.16, 0.43)}
SLIDER = """
joints: {O: [0, 0], D: [0.6, 0]}
bars:
  arm: {joints: [O, B], length: 0.4}
sliders:
  rod: {joint: C, on: arm}
  ram: {joint: R, through: D, angle: 90 deg}
masses: {C: 1, R: 1}
"""
ARM = {"O": (0, 0), "D": (0.6, 0), "B": (0.4, 0), "C": (0.5, 0), "R": (0.6, 0.3)}


def drawn(text, places=PLACES):
    """The axes with a drawing."""
    with style():
        ax = draw(Figure(figsize=(6, 5)).add_subplot(), linkages.loads(text), places)
    ax.figure.draw_without_rendering()
    return ax


def posed(text, places=PLACES):
    return Pose(linkages.loads(text), places)


def springs_of(pose):
    return shapes(pose, Strokes, role="spring")


@pytest.mark.parametrize(
    ("more", "count"),
    [
        ("springs: [{between: [D, C], stiffness: 5, length: 0.1}]", 1),
        ("springs: [{between: [D, C], stiffness: 5, length: 0.1, damping: 2}]", 2),
        ("dampers: [{between: [D, C], damping: 5}]", 1),
        ("springs: [{between: [D, C], stiffness: 0, length: 0.1}]", 0),
    ],
)
def test_springs_and_dampers_reach_from_joint_to_joint(more, count):
    pose = posed(TEXT + more)
    found = springs_of(pose)
    assert len(found) == count
    for shape in found:
        path = corners(pose, shape)
        for joint in "DC":
            assert np.hypot(*(path - PLACES[joint]).T).min() < 1e-12  # metres


def test_a_damper_beside_a_spring_keeps_clear_of_it_and_of_the_joints():
    pose = posed(TEXT + "springs: [{between: [D, C], stiffness: 5, length: 0.1, damping: 2}]")
    spring, damper = (corners(pose, shape) for shape in springs_of(pose))
    way = np.subtract(PLACES["C"], PLACES["D"])
    across = np.array([-way[1], way[0]]) / np.hypot(*way)
    inner = [(path[6:] - PLACES["D"]) @ across for path in (spring, damper)]  # beyond the stubs
    assert inner[0].max() < 0 < inner[1].min() or inner[1].max() < 0 < inner[0].min()
    for path, joint in ((path, joint) for path in (spring, damper) for joint in "DC"):
        assert np.hypot(*(path[6:] - PLACES[joint]).T).min() * SCALE > 6.0  # beyond the pin


@pytest.mark.parametrize(
    ("more", "count", "joint"),
    [
        ("springs: [{bar: rocker, stiffness: 5}]", 1, "D"),
        ("springs: [{between_bars: [coupler, rocker], stiffness: 5, damping: 1}]", 2, "B"),
        ("dampers: [{joint: A, damping: 1}]", 1, "A"),
    ],
)
def test_torsional_springs_and_dampers_are_about_their_joint(more, count, joint):
    pose = posed(TEXT + more)
    found = springs_of(pose)
    assert len(found) == count
    for shape in found:
        assert np.hypot(*(corners(pose, shape) - PLACES[joint]).T).max() * SCALE < 20


@pytest.mark.parametrize(
    ("more", "way"),
    [
        ("loads: [{joint: C, force: [3, 0]}]", (1, 0)),
        ("loads: [{joint: C, force: [0, -2*t]}]", (0, -1)),
    ],
)
def test_forces_point_where_they_push(more, way):
    ((start, tip, _),) = arrows(posed(TEXT + more), "load")
    direction = (tip - start) / np.hypot(*(tip - start))
    assert direction == pytest.approx(way, abs=1e-9)


@pytest.mark.parametrize(("torque", "heads"), [("4", 1), ("sin(20*t)", 2)])
def test_torques_are_arcs_with_a_head_for_each_sense(torque, heads):
    pose = posed(TEXT + f"loads: [{{bar: coupler, torque: {torque}}}]")
    ((_, _, found),) = arrows(pose, "load")
    assert found == heads
    assert ("4 N·m" if torque == "4" else "M(t)") in words(pose)


def test_masses_are_discs_larger_than_pins():
    before = discs(posed(TEXT))
    after = discs(posed(TEXT + "masses: {C: 3}"))
    assert len(after) == len(before) + 1
    assert max(radius for _, radius in after) > max(radius for _, radius in before)


def test_drive_of_a_slider_is_an_arrow_along_its_axis():
    drive = "drives: {ram: {position: 0.3, speed: -1}}"
    ((start, tip, _),) = arrows(posed(SLIDER + drive, ARM), "driven")
    assert start[0] == pytest.approx(tip[0], abs=1e-12)
    assert tip[1] < start[1]  # towards smaller displacements: downwards


def test_a_slider_beyond_the_end_of_its_bar_is_the_rod_of_a_cylinder():
    """The rod ends at the pin C; its piston is inside the barrel, which ends with the bar at B."""
    pose = posed(SLIDER, ARM)
    rod = next(s for s in shapes(pose, Strokes, width=2.2) if s.name == "rod")
    ends = corners(pose, rod)
    assert ends[1] == pytest.approx(ARM["C"], abs=1e-15)
    assert 0.0 < ends[0, 0] < 0.4
    assert ends[0, 1] == 0.0
    barrel = next(s for s in shapes(pose, Strokes, fill="paper") if s.name == "rod")
    assert corners(pose, barrel)[:, 0].max() == pytest.approx(0.4, abs=1e-15)


def test_welded_joint_has_a_corner_instead_of_a_pin():
    lever = TEXT.replace("  rocker:", "  lever: {joints: [C, L], length: 0.1}\n  rocker:")
    places = {**PLACES, "L": (0.2, 0.55)}
    welded = lever + "welds: {C: {bars: [coupler, lever], angle: 0}}"
    assert len(discs(posed(welded, places))) == len(discs(posed(lever, places))) - 1


def gear_pose(entry):
    text = f"{TEXT}gears: [{entry}]"
    pose = Pose(linkages.loads(text), PLACES)
    return pose, parts_of(pose.mechanism, Gear)[0]


def test_pitch_circles_touch_on_the_line_of_the_axes():
    """Radii in the ratio 2 : 1, their sum the distance of the axes."""
    pose, gear = gear_pose("{bars: [crank, rocker], ratio: -2}")
    found = wheels(pose, gear)
    assert found.joints == ("O", "D")
    assert found.radii == pytest.approx((0.4, 0.2), rel=1e-15)
    assert not found.belt


def test_same_sense_on_the_ground_is_a_belt():
    pose, gear = gear_pose("{bars: [crank, rocker], ratio: 3}")
    found = wheels(pose, gear)
    assert found.belt
    assert found.radii[0] == pytest.approx(3 * found.radii[1])
    assert sum(found.radii) < 0.6


def test_inner_gear_on_a_carrier():
    """A ring that stands still: radii in the ratio 3 : 1, their difference the arm."""
    text = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 0.1}, planet: {joints: [P, Q], length: 0.02}}
gears: [{bars: [ground, planet], ratio: 3, carrier: arm}]
"""
    pose = Pose(linkages.loads(text), {"O": (0, 0), "P": (0.1, 0), "Q": (0.1, 0.02)})
    found = wheels(pose, parts_of(pose.mechanism, Gear)[0])
    assert found == Wheels(("O", "P"), pytest.approx((0.15, 0.05)), belt=False)


def test_gears_without_axes_of_their_own_get_a_note():
    ax = drawn(f"{TEXT}gears: [{{bars: [crank, coupler], ratio: -2}}]")
    (note,) = (text.get_text() for text in ax.texts if text.get_gid() == "note")
    assert note == "gear: coupler turns -2 times as fast as crank"


CRANK = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.1}
  rod: {joints: [A, B], length: 0.3}
sliders:
  ram: {joint: B, through: O}
"""
CRANK_PLACES = {"O": (0, 0), "A": (0.1, 0), "B": (0.4, 0)}


@pytest.mark.parametrize("force", [5, -5])
def test_a_force_on_a_slider_stands_where_no_bar_is(force):
    pose = posed(CRANK + f"loads: [{{slider: ram, force: {force}}}]", CRANK_PLACES)
    ((start, tip, _),) = arrows(pose, "load")
    assert min(start[0], tip[0]) > 0.4 + 11 / SCALE  # beyond the block
    assert np.sign(tip[0] - start[0]) == np.sign(force)


@pytest.mark.parametrize(("more", "side"), [("", 1), ("loads: [{slider: ram, force: -5}]", -1)])
def test_a_damper_in_a_guide_leaves_room_for_bars_and_forces(more, side):
    pose = posed(CRANK + "dampers: [{slider: ram, damping: 5}]\n" + more, CRANK_PLACES)
    damper, wall = springs_of(pose)
    for shape in (damper, wall):
        assert (np.sign(corners(pose, shape)[:, 0] - 0.4) == side).all()


def test_plates_bear_their_names_inside():
    ax = drawn(TEXT)
    (name,) = (text for text in ax.texts if text.get_text() == "coupler")
    assert name.xy == pytest.approx(1e3 * np.mean([PLACES[j] for j in "ABC"], axis=0))


def test_three_joints_in_line_have_an_eye_in_the_middle():
    """One body goes on beyond the pin; two bars that end there have none."""
    three = CRANK.replace(
        "  rod: {joints: [A, B], length: 0.3}",
        """
  rod: {points: {A: [0, 0], M: [0.1, 0], B: [0.3, 0]}}
  lever: {joints: [M, N], length: 0.1}""",
    )
    places = {**CRANK_PLACES, "M": (0.2, 0.0), "N": (0.2, 0.1)}
    eyes = discs(posed(three, places), role="bar")
    assert [tuple(centre) for centre, _ in eyes] == [(0.2, 0.0)]
    assert not discs(posed(CRANK, CRANK_PLACES), role="bar")


@pytest.mark.parametrize("angle", ["0", "180 deg"])
def test_a_driven_crank_is_over_what_is_welded_to_it_in_line(angle):
    """The counterweight shows beside it, for it is wider; beyond the pin it hides nothing."""
    text = (
        CRANK.replace("  rod:", "  weight: {joints: [O, W], length: 0.1}\n  rod:")
        + f"""
welds: {{O: {{bars: [crank, weight], angle: {angle}}}}}
drives: {{crank: {{angle: 0, speed: 1}}}}
"""
    )
    side = 1.0 if angle == "0" else -1.0
    bars = shapes(posed(text, {**CRANK_PLACES, "W": (0.1 * side, 0.0)}), Strokes, casing=1.3)
    names = [bar.name for bar in bars]
    assert names.index("weight") < names.index("crank") == len(names) - 1
    width = {bar.name: bar.look.width for bar in bars}
    assert (width["weight"] > width["crank"]) == (side > 0)
