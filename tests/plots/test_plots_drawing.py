import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from plot_data import JOINTS, press, press_data

from linkages.plots.mechanism.bodies import convex_hull
from linkages.plots.mechanism.drawing import draw, figure
from linkages.plots.mechanism.labels import Labels
from linkages.plots.mechanism.samples import pose_at
from linkages.plots.mechanism.view import gravity_arrow
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
    boxes = [text.get_window_extent() for text in ax.texts]
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
    x, y = np.meshgrid(np.linspace(0.2, 0.8, 400), np.linspace(0.5, 0.8, 400))
    labels.avoid(ax.transData.transform(np.column_stack((x.ravel(), y.ravel()))))
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
