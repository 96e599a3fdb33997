"""What is drawn for each component: found again in the axes, at its place."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, PathPatch

from linkages.components.mechanisms.definition import from_document
from linkages.plots.mechanism.drawing import draw
from linkages.plots.mechanism.gears import Wheels, gears, wheels
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.springs import COLOUR
from linkages.plots.style import DRIVEN, LOAD, style
from linkages.reading.document import parse

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


def build(text):
    return from_document(parse(text, "m.yaml"))


def drawn(text, places=PLACES):
    """The axes with a drawing."""
    with style():
        ax = draw(Figure(figsize=(6, 5)).add_subplot(), build(text), places)
    ax.figure.draw_without_rendering()
    return ax


def added(more, text=TEXT, places=PLACES):
    """Patches that a component adds to a drawing."""
    before = len(drawn(text, places).patches)
    return drawn(text + more, places).patches[:], before


def springs_of(ax):
    return [p for p in ax.patches if isinstance(p, PathPatch) and edge(p) == COLOUR]


def edge(patch):
    from matplotlib.colors import to_hex

    return to_hex(patch.get_edgecolor()).upper()


def corners(patch):
    """Vertices of a symbol in pixels."""
    return patch.get_transform().transform(patch.get_path().vertices)


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
    ax = drawn(TEXT + more)
    found = springs_of(ax)
    assert len(found) == count
    for patch in found:
        path = corners(patch)
        for joint in "DC":
            pixel = ax.transData.transform(1e3 * np.array(PLACES[joint]))
            assert np.hypot(*(path - pixel).T).min() < 0.5  # pixels


def test_a_damper_beside_a_spring_keeps_clear_of_it():
    ax = drawn(TEXT + "springs: [{between: [D, C], stiffness: 5, length: 0.1, damping: 2}]")
    spring, damper = (corners(patch) for patch in springs_of(ax))
    way = np.subtract(PLACES["C"], PLACES["D"])
    across = np.array([-way[1], way[0]]) / np.hypot(*way)
    middle = ax.transData.transform(1e3 * np.array(PLACES["D"])) @ across
    inner = [path[3:-2] @ across - middle for path in (spring, damper)]
    assert inner[0].max() < 0 < inner[1].min() or inner[1].max() < 0 < inner[0].min()


@pytest.mark.parametrize(
    ("more", "count", "joint"),
    [
        ("springs: [{bar: rocker, stiffness: 5}]", 1, "D"),
        ("springs: [{between_bars: [coupler, rocker], stiffness: 5, damping: 1}]", 2, "B"),
        ("dampers: [{joint: A, damping: 1}]", 1, "A"),
    ],
)
def test_torsional_springs_and_dampers_are_about_their_joint(more, count, joint):
    ax = drawn(TEXT + more)
    found = springs_of(ax)
    assert len(found) == count
    pixel = ax.transData.transform(1e3 * np.array(PLACES[joint]))
    points = ax.figure.dpi / 72
    for patch in found:
        assert np.hypot(*(corners(patch) - pixel).T).max() < 20 * points


@pytest.mark.parametrize(
    ("more", "way"),
    [
        ("loads: [{joint: C, force: [3, 0]}]", (1, 0)),
        ("loads: [{joint: C, force: [0, -2*t]}]", (0, -1)),
    ],
)
def test_forces_point_where_they_push(more, way):
    ax = drawn(TEXT + more)
    (arrow,) = (p for p in ax.patches if isinstance(p, FancyArrowPatch))
    assert edge(arrow) == LOAD
    line = arrow.get_transform().transform(arrow._path_original.vertices)
    direction = (line[-1] - line[0]) / np.hypot(*(line[-1] - line[0]))
    assert direction == pytest.approx(way, abs=1e-9)


@pytest.mark.parametrize(("torque", "style_of"), [("4", "-|>"), ("sin(20*t)", "<|-|>")])
def test_torques_are_arcs_with_a_head_for_each_sense(torque, style_of):
    ax = drawn(TEXT + f"loads: [{{bar: coupler, torque: {torque}}}]")
    (arrow,) = (p for p in ax.patches if isinstance(p, FancyArrowPatch))
    heads = {"-|>": "CurveFilledB", "<|-|>": "CurveFilledAB"}
    assert type(arrow.get_arrowstyle()).__name__ == heads[style_of]
    texts = [text.get_text() for text in ax.texts]
    assert ("4 N·m" if torque == "4" else "M(t)") in texts


def test_masses_are_discs_larger_than_pins():
    patches, before = added("masses: {C: 3}")
    (extra,) = (p for p in patches if isinstance(p, Circle) and p.radius > 5)
    assert len(patches) == before + 1
    assert extra.get_facecolor() == extra.get_edgecolor()


def test_drive_of_a_slider_is_an_arrow_along_its_axis():
    drive = "drives: {ram: {position: 0.3, speed: -1}}"
    ax = drawn(SLIDER + drive, ARM)
    (arrow,) = (p for p in ax.patches if isinstance(p, FancyArrowPatch))
    assert edge(arrow) == DRIVEN
    line = arrow.get_transform().transform(arrow._path_original.vertices)
    assert line[0, 0] == pytest.approx(line[-1, 0])
    assert line[-1, 1] < line[0, 1]  # towards smaller displacements: downwards


def test_rod_leaves_its_cylinder_at_the_end():
    ax = drawn(SLIDER, ARM)
    rods = [line.get_xydata() for line in ax.lines if len(line.get_xdata()) == 2]
    assert any(np.allclose(rod, [(400, 0), (500, 0)]) for rod in rods)


def test_welded_joint_has_a_corner_instead_of_a_pin():
    lever = TEXT.replace("  rocker:", "  lever: {joints: [C, L], length: 0.1}\n  rocker:")
    places = {**PLACES, "L": (0.2, 0.55)}
    rings = [p for p in drawn(lever, places).patches if isinstance(p, Circle)]
    welded = drawn(lever + "welds: {C: {bars: [coupler, lever], angle: 0}}", places)
    assert len([p for p in welded.patches if isinstance(p, Circle)]) == len(rings) - 1


def gear_pose(entry):
    text = f"{TEXT}gears: [{entry}]"
    pose = Pose(build(text), PLACES)
    return pose, gears(pose)[0]


def test_pitch_circles_touch_on_the_line_of_the_axes():
    """Radii in the ratio 2 : 1, their sum the distance of the axes."""
    pose, gear = gear_pose("{bars: [crank, rocker], ratio: -2}")
    found = wheels(pose, gear)
    assert found.places == ((0, 0), (0.6, 0))
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
bars:
  arm: {joints: [O, P], length: 0.1}
  planet: {joints: [P, Q], length: 0.02}
gears: [{bars: [ground, planet], ratio: 3, carrier: arm}]
"""
    pose = Pose(build(text), {"O": (0, 0), "P": (0.1, 0), "Q": (0.1, 0.02)})
    found = wheels(pose, gears(pose)[0])
    assert found == Wheels(((0, 0), (0.1, 0)), pytest.approx((0.15, 0.05)), belt=False)


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
    ax = drawn(CRANK + f"loads: [{{slider: ram, force: {force}}}]", CRANK_PLACES)
    (arrow,) = (p for p in ax.patches if isinstance(p, FancyArrowPatch))
    line = arrow.get_transform().transform(arrow._path_original.vertices)
    pin = ax.transData.transform((400, 0))[0]
    assert (line[:, 0] > pin + 11 * ax.figure.dpi / 72).all()  # beyond the block
    assert np.sign(line[-1, 0] - line[0, 0]) == np.sign(force)


@pytest.mark.parametrize(("more", "side"), [("", 1), ("loads: [{slider: ram, force: -5}]", -1)])
def test_a_damper_in_a_guide_leaves_room_for_bars_and_forces(more, side):
    ax = drawn(CRANK + "dampers: [{slider: ram, damping: 5}]\n" + more, CRANK_PLACES)
    (damper,) = springs_of(ax)
    pin = ax.transData.transform((400, 0))[0]
    assert (np.sign(corners(damper)[:, 0] - pin) == side).all()


def test_plates_bear_their_names_inside():
    ax = drawn(TEXT)
    (name,) = (text for text in ax.texts if text.get_text() == "coupler")
    assert name.xy == pytest.approx(1e3 * np.mean([PLACES[j] for j in "ABC"], axis=0))
