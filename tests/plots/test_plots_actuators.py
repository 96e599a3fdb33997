"""Springs in guides, cylinders, motors and forces that turn with a body are in drawings."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import ArrowStyle, FancyArrowPatch, PathPatch

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
