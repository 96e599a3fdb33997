"""Springs in guides, cylinders, motors and forces that turn with a body are in drawings."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import ArrowStyle, Circle, FancyArrowPatch, PathPatch

import linkages
from linkages.plots.mechanism import drawing, sliders
from linkages.plots.mechanism.springs import COLOUR

CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
bars: {arm: {joints: [C, P], length: 0.4, mass: 1}}
free: {cart: {position: 0.3, speed: 0}, arm: {angle: 0.5, speed: 0}}
"""


def drawn(text):
    mechanism = linkages.loads(CART + text)
    ax = Figure().add_subplot()
    tip = (0.3 + 0.4 * np.cos(0.5), 0.4 * np.sin(0.5))
    drawing.draw(ax, mechanism, {"O": (0, 0), "C": (0.3, 0), "P": tip})
    return ax


def springs_of(ax):
    found = (p for p in ax.get_children() if isinstance(p, PathPatch))
    return [p for p in found if to_hex(p.get_edgecolor()).upper() == COLOUR.upper()]


def arrows_of(ax):
    return [p for p in ax.get_children() if isinstance(p, FancyArrowPatch)]


@pytest.mark.parametrize(
    ("text", "symbols"),
    [
        ("springs: [{slider: cart, stiffness: 3}]", 1),
        ("springs: [{slider: cart, stiffness: 3, damping: 1}]", 2),
        ("springs: [{slider: cart, stiffness: 0}]", 0),
        ("springs: [{between: [O, P], force: 3}]", 1),
        ("springs: [{between: [O, P], force: 3, damping: 1}]", 2),
        ("springs: [{between: [O, P], force: 0}]", 0),
        ("loads: [{between: [O, P], force: 3}]", 1),
        ("cylinders: {c: {between: [O, P], bore: 0.1, pressure: 1e5}}", 1),
        ("cylinders: {c: {between: [O, P], bore: 0.1, pressure: 1e5, damping: 3}}", 1),
        ("cylinders: {c: {between: [O, P], bore: 0.1, pressure: 0}}", 0),
    ],
)
def test_each_has_its_symbol(text, symbols):
    assert len(springs_of(drawn(text))) == symbols


def test_spring_and_damper_of_a_block_stand_beside_each_other():
    ax = drawn("springs: [{slider: cart, stiffness: 3, damping: 1}]")
    heights = [p.get_path().vertices[0][1] for p in springs_of(ax)]
    assert sorted(heights) == [-0.5 * sliders.ABREAST, 0.5 * sliders.ABREAST]


RACK = """
joints: {O: [0, 0]}
bars: {wheel: {joints: [O, P], length: 0.05}}
sliders: {rack: {joint: R, through: [0, 0.1], angle: 90 deg}}
drives: {wheel: {angle: 0.3, speed: 1}}
"""


def outlines(text, angle=0.3):
    """Lines of a drawing, in metres, and its pitch circles."""
    ax = Figure().add_subplot()
    tip = (0.05 * np.cos(angle), 0.05 * np.sin(angle))
    drawing.draw(ax, linkages.loads(text), {"O": (0, 0), "P": tip, "R": (0.0, 0.2)})
    scale = 1e-3 if "mm" in ax.get_xlabel() else 1.0
    lines = [scale * np.asarray(line.get_xydata(), dtype=float) for line in ax.lines]
    circles = [p for p in ax.patches if isinstance(p, Circle)]
    return lines, [scale * circle.radius for circle in circles]


@pytest.mark.parametrize(("radius", "side"), [(0.05, 1.0), (-0.05, -1.0)])
def test_a_rack_touches_the_pitch_circle_of_its_pinion(radius, side):
    lines, circles = outlines(RACK + f"racks: [{{slider: rack, bar: wheel, radius: {radius}}}]\n")
    assert 0.05 in np.round(circles, 12)
    # it goes up where a wheel that turns counter-clockwise has its right side
    assert any(np.allclose(line[:, 0], side * 0.05) for line in lines if len(line) == 2)


def test_a_cam_is_drawn_through_its_roller():
    more = """
cams:
  - {slider: rack, bar: wheel, angles: [0, 120 deg, 240 deg, 360 deg], lifts: [0, 0.02, 0.05, 0],
     base_radius: 0.04, roller_radius: 0.01, eccentricity: 0.01}
"""
    lines, _ = outlines(RACK + more, angle=np.deg2rad(120))
    (outline,) = (line for line in lines if len(line) == 361)
    place = np.array([0.01, np.sqrt(0.05**2 - 0.01**2) + 0.02])
    assert np.hypot(*(outline - place).T).min() < 1e-3  # a point every degree


def test_a_motor_is_an_arrow_both_ways():
    ax = drawn("motors: {m: {bar: arm, stall_torque: 1, no_load_speed: 9}}")
    (arrow,) = arrows_of(ax)
    assert isinstance(arrow.get_arrowstyle(), ArrowStyle.CurveFilledAB)
    assert any(text.get_text() == "M(v)" for text in ax.texts)


@pytest.mark.parametrize("angle", [0.5, 2.0])
def test_a_force_that_turns_is_drawn_in_the_frame_of_its_body(angle):
    mechanism = linkages.loads(CART + "loads: [{joint: C, on: arm, force: [0, 3]}]")
    ax = Figure().add_subplot()
    tip = (0.3 + 0.4 * np.cos(angle), 0.4 * np.sin(angle))
    drawing.draw(ax, mechanism, {"O": (0, 0), "C": (0.3, 0), "P": tip})
    (arrow,) = arrows_of(ax)
    start, *_, end = arrow.get_transform().transform(arrow._path_original.vertices)
    way = end - start
    # pixels of the renderer are floats
    assert way / np.hypot(*way) == pytest.approx((-np.sin(angle), np.cos(angle)), abs=1e-6)
