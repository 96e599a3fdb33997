import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import Circle
from plot_data import JOINTS, press

from linkages.plots.mechanism.branches import MOST, Mode, figure, shown_modes
from linkages.plots.style import DRIVEN


def modes(count, selected=1):
    places = {name: (x, y) for name, (x, y) in JOINTS.items()}
    return [Mode(n, places, "B left", n == selected) for n in range(1, count + 1)]


@pytest.mark.slow_except("1", "2", "4")
@pytest.mark.parametrize("count", [1, 2, 4, 8, 30])
def test_one_numbered_drawing_for_each_mode_inside_the_figure(count):
    result = figure(press(), modes(count))
    assert len(result.axes) == count
    assert [ax.get_title(loc="left").split()[0] for ax in result.axes] == [
        str(n) for n in range(1, count + 1)
    ]
    boxes = [ax.get_position() for ax in result.axes]
    for index, box in enumerate(boxes):
        assert box.x0 >= 0 <= box.y0
        assert box.x1 <= 1 >= box.y1
        assert not any(box.overlaps(other) for other in boxes[index + 1 :])


def test_drawings_of_one_size_have_no_scale_and_the_selected_one_is_framed():
    result = figure(press(), modes(5, selected=3))
    limits = [(*ax.get_xlim(), *ax.get_ylim()) for ax in result.axes]
    np.testing.assert_allclose(limits, limits[:1] * 5, rtol=1e-12)  # round-off of their places
    assert not any(ax.lines for ax in result.axes)
    frames = [to_hex(ax.spines["left"].get_edgecolor()).upper() for ax in result.axes]
    assert [colour == DRIVEN for colour in frames] == [False, False, True, False, False]


def test_joints_are_where_the_mode_puts_them():
    (ax,) = figure(press(), modes(1)).axes
    centres = {tuple(np.round(p.center, 9)) for p in ax.patches if isinstance(p, Circle)}
    assert JOINTS["O"] in centres


def test_every_drawing_fills_its_panel_and_has_a_scale_where_they_differ():
    """One twice as large: both reach equally far, and the bar has the length that it says."""
    one, two = modes(2)
    large = {name: (2 * x, 2 * y) for name, (x, y) in two.positions.items()}
    result = figure(press(), [one, Mode(2, large, "B right")])
    spans = [np.ptp(ax.get_ylim()) for ax in result.axes]
    assert spans[1] == pytest.approx(2 * spans[0], rel=0.05)  # the crank's pin is not twice as far
    for ax in result.axes:
        (bar,) = ax.lines
        (text,) = (text for text in ax.texts if text.get_text().endswith("m"))
        assert set(JOINTS) - {"B.r1"} <= {other.get_text() for other in ax.texts}
        number, unit = text.get_text().split()
        length = float(number) * {"m": 1.0, "mm": 1e-3}[unit]
        assert np.ptp(bar.get_xdata()) == pytest.approx(length, rel=1e-12)


@pytest.mark.slow
def test_too_many_say_so_and_keep_the_selected_one():
    many = modes(MOST + 20, selected=MOST + 10)
    assert [mode.number for mode in shown_modes(many)][-2:] == [MOST - 1, MOST + 10]
    texts = [text.get_text() for text in figure(press(), many).texts]
    assert any(f"{MOST} of {MOST + 20} modes" in text for text in texts)


@pytest.mark.slow_except("4")
@pytest.mark.parametrize("count", [4, 12, 30])
def test_long_titles_go_on_in_further_lines(count):
    """Whole, and each line no wider than its panel; sides stay with their joints."""
    text = ", ".join(f"{joint} {side}" for joint in "BDFHK" for side in ("left", "right"))
    places = {name: (x, y) for name, (x, y) in JOINTS.items()}
    result = figure(press(), [Mode(n, places, text) for n in range(1, count + 1)])
    for number, ax in enumerate(result.axes, 1):
        title = ax._left_title  # as matplotlib's own get_title finds it
        lines = title.get_text().split("\n")
        assert " ".join(" ".join(lines).replace("\u00a0", " ").split()) == f"{number} {text}"
        assert all(line.rstrip().endswith((",", "right")) for line in lines)
        assert title.get_window_extent().width <= ax.bbox.width


@pytest.mark.slow
def test_everything_is_inside_its_panel():
    result = figure(press(), modes(5))
    for ax in result.axes:
        window = ax.get_window_extent()
        for patch in ax.patches:
            box = patch.get_window_extent()
            assert (box.min >= window.min).all()
            assert (box.max <= window.max).all()
