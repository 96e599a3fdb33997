import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.text import Text
from plot_data import JOINTS, press, press_data

import linkages
from linkages.plots.mechanism.annotations import Labels
from linkages.plots.mechanism.drawing import draw, figure
from linkages.plots.mechanism.plane_view import gravity_arrow
from linkages.plots.mechanism.pose import pose_at
from linkages.plots.mechanism.roles import convex_hull
from linkages.plots.style import CLEARANCE, style


@pytest.fixture
def ax():
    with style():
        result = figure(press_data(), press())
    result.draw_without_rendering()
    return result.axes[0]


def test_every_joint_and_body_is_labelled_once(ax):
    texts = sorted(text.get_text() for text in ax.texts)
    bodies = ["crank", "coupler", "rocker", "rod", "ram", "r1"]
    assert texts == sorted([*"ODABPF", *bodies])  # the clearance's own end "B.r1" has no label


def test_labels_keep_clear_of_each_other_and_stay_inside(ax):
    boxes = [Text.get_window_extent(text) for text in ax.texts]  # without lines that lead to them
    window = ax.get_window_extent()
    for index, box in enumerate(boxes):
        assert window.x0 <= box.x0 < box.x1 <= window.x1
        assert window.y0 <= box.y0 < box.y1 <= window.y1
        for other in boxes[index + 1 :]:
            # A text's box includes room for descenders, which these names have not.
            assert not box.shrunk(1.0, 0.7).overlaps(other.shrunk(1.0, 0.7))


def test_scale_is_equal_and_in_millimetres_for_a_small_mechanism(ax):
    assert ax.get_xlabel() == "x [mm]"
    assert ax.get_aspect() == 1.0
    place = ax.transData.transform([(0, 0), (100, 0), (0, 100)])
    across, up = place[1, 0] - place[0, 0], place[2, 1] - place[0, 1]
    assert across == pytest.approx(up, rel=1e-6)


def test_symbols(ax):
    rings = [patch for patch in ax.patches if isinstance(patch, Circle)]
    assert len(rings) == len(JOINTS)  # none at B.r1, but two at B
    assert [ring.get_edgecolor() for ring in rings].count(to_rgba(CLEARANCE)) == 1


def test_the_legend_names_the_colours_that_occur(ax):
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["driven", "clearance"]


def test_own_axes_and_missing_joints():
    some = {name: JOINTS[name] for name in "OAB"}
    ax = draw(Figure().add_subplot(), press(), some)
    names = {text.get_text() for text in ax.texts}
    assert {"O", "A", "B", "crank", "coupler"} <= names
    assert not names & {"rod", "ram", "F"}


def test_positions():
    data = press_data()
    assert pose_at(data, press(), 0).positions["F"] == pytest.approx((0.25, 0.7))
    data["joint_position"].values[0, 0] = np.nan
    assert "O" not in pose_at(data, press(), 0).positions
    assert pose_at(data.isel(time=slice(0)), press(), 0).positions == {}
    assert figure(data.isel(time=slice(0)), press()) is None
    assert figure(data.drop_vars("joint_position"), press()) is None


def test_labels_go_where_there_is_room():
    figure = Figure()
    ax = figure.add_subplot()
    ax.set(xlim=(0, 1), ylim=(0, 1))
    labels = Labels(ax)
    ax.fill_between([0.2, 0.8], 0.5, 0.8, color="black")
    labels.beside_point("name", (0.5, 0.5))
    (text,) = ax.texts
    assert text.get_window_extent().y1 <= ax.transData.transform((0.5, 0.5))[1]


def test_hull_of_collinear_and_inner_points():
    line = np.array([[0.0, 0.0], [2.0, 2.0], [1.0, 1.0]])
    assert sorted(convex_hull(line).tolist()) == [[0.0, 0.0], [2.0, 2.0]]
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.4]], dtype=float)
    assert len(convex_hull(square)) == 4
    assert len(convex_hull(np.zeros((3, 2)))) == 1


def test_gravity_arrow():
    assert gravity_arrow(press()) == "↓"


def test_roles_of_one_colour_share_an_entry_of_the_legend():
    text = """
joints: {O: [0, 0], C: [0.4, -0.3]}
bars: {arm: {joints: [O, K], length: 1, mass: 2}}
cylinders: {c: {between: [C, K], bore: 0.05, pressure: 1e5}}
loads: [{joint: K, force: [0, -5]}]
free: {arm: {angle: 0, speed: 0}}
"""
    places = {"O": (0.0, 0.0), "C": (0.4, -0.3), "K": (1.0, 0.0)}
    ax = draw(Figure().add_subplot(), linkages.loads(text), places)
    names = [entry.get_text() for entry in ax.get_legend().get_texts()]
    assert names == ["free", "load, cylinder"]


@pytest.mark.slow
def test_a_casing_parts_bars_that_cross_and_leaves_fills_alone():
    """Pixels beside the upper of two crossing bars are those of paper, and the fill of a plate is
    as pale at its edge as in its middle."""
    text = """
joints: {O: [0, 0], D: [0, 1], G: [1.5, 0]}
bars:
  low: {joints: [O, A], length: 1.414}
  high: {joints: [D, B], length: 1.414}
  plate: {points: {G: [0, 0], H: [1, 0], I: [0.5, 1]}}
drives:
  low: {angle: 45 deg, speed: 0}
  high: {angle: -45 deg, speed: 1}
  plate: {angle: 0, speed: 0}
"""
    places = {"O": (0.0, 0.0), "D": (0.0, 1.0), "A": (1.0, 1.0), "B": (1.0, 0.0)}
    places |= {"G": (1.5, 0.0), "H": (2.5, 0.0), "I": (2.0, 1.0)}
    with style():
        figure = Figure(figsize=(6, 4), dpi=600)
        FigureCanvasAgg(figure)
        ax = draw(figure.add_subplot(), linkages.loads(text), places)
        ax.grid(visible=False)
        figure.canvas.draw()
    image = np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(int)

    def colour(point, points=0.0, way=(0.0, 0.0)):
        x, y = ax.transData.transform(point) + points * 600 / 72 * np.array(way)
        return image[image.shape[0] - 1 - round(y), round(x)]

    half = np.sqrt(0.5)
    along_low = (half, half)  # across the upper bar, along the lower one
    assert (colour((0.5, 0.5), 2.5, along_low) == 255).all()
    assert (colour((0.5, 0.5), 5.0, along_low) != 255).any()
    middle, edge = colour((2.0, 0.45)), colour((1.8, 0.0), 1.8, (0.0, 1.0))
    assert middle.tolist() == edge.tolist()
