"""Every shipped mechanism is drawn, with all of its joints and bodies named."""

import pytest
from matplotlib.figure import Figure

import linkages
from linkages.kernel.system import System
from linkages.plots.mechanism.drawing import draw
from linkages.plots.mechanism.roles import clearance_ends
from linkages.plots.mechanism.traces import led_joints
from linkages.plots.style import style
from linkages.reading.document import shipped


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped())
def test_every_shipped_mechanism(name):
    system = System(linkages.load(name))
    mechanism = system.mechanism
    places = {joint: tuple(system.places()[joint]) for joint in system.topology.joints}
    with style():
        ax = draw(Figure(figsize=(6, 5)).add_subplot(), mechanism, places)
    ax.figure.draw_without_rendering()
    written = [text.get_text() for text in ax.texts]
    beside = clearance_ends(mechanism)
    for joint in system.topology.joints:
        assert (joint in beside or "." in joint) != (joint in written)
    # both axes of a clearance that opens are drawn as one
    named = {name.removesuffix(".x").removesuffix(".y") for name in mechanism.bodies}
    assert named <= set(written)


@pytest.mark.parametrize(
    ("name", "curves"),
    [("jansen", "FT"), ("klann", "FG"), ("hoeken", "P"), ("chebyshev", "P"), ("peaucellier", "Q")],
)
def test_coupler_points_of_the_classics(name, curves):
    mechanism = linkages.load(name)
    joints = {joint for body in mechanism.bodies.values() for joint in body.points}
    assert joints - led_joints(mechanism) == set(curves)
