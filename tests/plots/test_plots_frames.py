"""Pictures hold everything that is drawn in them, whatever their shape."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import linkages
from linkages.plots.films.stage import MARGIN as FILM
from linkages.plots.mechanism import drawing
from linkages.plots.mechanism.inked_shapes import Inked, points_per_unit
from linkages.plots.mechanism.placing import Cover
from linkages.plots.mechanism.plane_view import MARGIN, ROOM, Box, frame, picture
from linkages.plots.mechanism.pose import Pose
from linkages.plots.style import style
from linkages.reading.document import shipped

SAMPLES = 5
EDGE = 0.5 * MARGIN
"""Inches: all of the margin is for labels, so that half of it is far more than round-off."""

NARROW = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, angle: 90 deg, mass: 2}}
springs: [{slider: cart, stiffness: 5, damping: 1}]
maxwell: [{slider: cart, stiffness: 5, damping: 1}]
friction: [{slider: cart, force: 1}]
free: {cart: {position: 0.001, speed: 0}}
"""


def edges(ax, artists):
    """How far inside the axes what is drawn reaches, in inches, as matplotlib draws it."""
    boxes = [artist.get_window_extent() for artist in artists if artist.get_visible()]
    window = ax.get_window_extent()
    low, high = (np.array([getattr(box, end) for box in boxes]) for end in ("min", "max"))
    return min((low - window.min).min(), (window.max - high).min()) / ax.figure.dpi


def shown(poses, box, margin=MARGIN):
    """How far inside its picture everything is in all positions."""
    with style():
        figure, ax = picture(box, margin)
        scale = frame(ax, box, poses[0].mechanism, margin).factor
        points = points_per_unit(ax) * scale
        shapes = [*drawing.under(poses[0], points), *drawing.over(poses[0], points)]
        inked, found = Inked(ax, shapes, poses[0].scaled(scale)), []
        for pose in poses:
            inked.show(pose.scaled(scale))
            found.append(edges(ax, inked.artists))
    assert figure is ax.figure
    return min(found)


@pytest.mark.slow_except("four-bar", "ninebar", "scotch-yoke")
@pytest.mark.parametrize("name", shipped())
def test_everything_is_inside_where_it_starts_and_along_the_motion(name):
    mechanism = linkages.load(name)
    data = linkages.simulate(mechanism, end=0.05, samples=SAMPLES).data
    poses, box = drawing.framed(data, mechanism)
    along = [poses.at(index) for index in range(SAMPLES)]
    assert shown(along[:1], drawing.reach(along[0])) > EDGE
    assert shown(along, box) > EDGE
    assert shown(along, box, FILM) > 0.5 * FILM


def test_symbols_beside_a_block_that_hardly_moves_are_inside_a_narrow_picture():
    pose = Pose(linkages.loads(NARROW), {"O": (0.0, 0.0), "C": (0.0, 0.001)})
    assert shown([pose], drawing.reach(pose)) > EDGE


def test_a_fitted_box_is_as_large_as_its_room_lets_it_be():
    """One point with a symbol beside it, and one without: both ends are known."""
    cover = Cover(np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[-50.0, 0.0], [0.0, 0.0]]))
    box = cover.fitted((150.0, 100.0))  # 100 points are left for a metre
    assert box.low == pytest.approx([-0.5, 0.0], rel=1e-12)
    assert box.high == pytest.approx([1.0, 0.0])
    assert cover.fitted(ROOM).bare.scale == Box.around([[0, 0], [1, 0]]).scale


@pytest.mark.parametrize("size", [(6.0, 5.0), (3.6, 3.2)])
def test_axes_of_any_size_hold_everything(size):
    pose = Pose(linkages.loads(NARROW), {"O": (0.0, 0.0), "C": (0.0, 0.001)})
    with style():
        ax = drawing.draw_pose(Figure(figsize=size).add_subplot(), pose)
        assert edges(ax, ax.patches) > 0.0
