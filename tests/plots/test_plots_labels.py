"""Labels of all shipped mechanisms, against the pixels that are drawn beneath them."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation

import linkages
from linkages.kernel.system import System
from linkages.plots.films.film import film_of
from linkages.plots.films.stage import Stage
from linkages.plots.mechanism import traces
from linkages.plots.mechanism.drawing import start_figure
from linkages.plots.style import style
from linkages.reading.document import shipped

DARK = 0.3  # of a pixel: more than the fill of a plate, less than any line
MOST = 0.02  # of a label: what may lie on lines; a line of a width of 1 pt through a name is 0.1


def labels_of(ax: Axes) -> list[Annotation]:
    return [text for text in ax.texts if isinstance(text, Annotation) and text.get_text()]


def corners(text: Annotation) -> np.ndarray:
    """Of the box around the letters of a text, in pixels, shape (4, 2), as Matplotlib draws it."""
    figure = text.get_figure()
    width, height, descent = RendererAgg(1, 1, figure.dpi).get_text_width_height_descent(
        text.get_text(), text.get_fontproperties(), False
    )
    x, y = text.axes.transData.transform(text.xy) + np.array(text.get_position()) * figure.dpi / 72
    turn = np.radians(text.get_rotation())
    along, up = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    low, high = (0.0, -descent), (width, height - descent)
    pairs = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    return np.array([(x, y) + u * along + v * up for u, v in pairs])


def apart(first: np.ndarray, second: np.ndarray) -> bool:
    """Whether a line separates two boxes: it is along a side of one of them."""
    for box in (first, second):
        for way in box[1:3] - box[:2]:
            one, other = first @ way, second @ way
            if one.max() <= other.min() or other.max() <= one.min():
                return True
    return False


def darkness(figure: Figure) -> np.ndarray:
    """How dark pixels are without labels, rows from the bottom, shape (height, width)."""
    shown = [text for ax in figure.axes for text in labels_of(ax)]
    for text in shown:
        text.set_visible(False)
    canvas = FigureCanvasAgg(figure)
    with style():
        canvas.draw()
    for text in shown:
        text.set_visible(True)
    return 1.0 - np.asarray(canvas.buffer_rgba())[::-1, :, :3].mean(axis=-1) / 255.0


def covered(box: np.ndarray, dark: np.ndarray) -> float:
    """The share of a box that lies on lines."""
    shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 60)] * 2), axis=-1).reshape(-1, 2)
    places = box[0] + shares @ (box[[1, 3]] - box[0])
    columns, rows = places.astype(int).T
    return float((dark[rows, columns] > DARK).mean())


def check(figure: Figure) -> None:
    dark = darkness(figure)
    for ax in figure.axes:
        boxes = [(text.get_text(), corners(text)) for text in labels_of(ax)]
        window = ax.get_window_extent()
        for name, box in boxes:
            assert (box >= window.min).all(), name
            assert (box <= window.max).all(), name
            assert covered(box, dark) <= MOST, name
        for (name, box), (other, own) in combinations(boxes, 2):
            assert apart(box, own), (name, other)


@pytest.mark.parametrize("name", ["four-bar", "jansen", "ninebar"])
def test_names_of_traces_lie_on_nothing(name):
    mechanism = linkages.load(name)
    data = linkages.simulate(mechanism, end=1.0, samples=101).data
    check(traces.figure(data, mechanism))


@pytest.mark.parametrize("name", ["four-bar", "jansen", "ninebar"])
def test_names_in_a_film_lie_on_less_than_in_a_corner(name):
    """Each keeps its place beside its joint; lines pass below it now and then, as it moves."""
    mechanism = linkages.load(name)
    data = linkages.simulate(mechanism, end=1.0, samples=49).data
    stage = Stage(data, mechanism, film_of(1.0), names=True)
    own, corner = [], []
    for index in range(0, 49, 4):
        stage.picture(index)
        shown = [each for each in stage._show(index, index) if not isinstance(each, Annotation)]
        with style():
            stage._canvas.restore_region(stage._background)
            for each in shown:
                each.draw(stage._canvas.get_renderer())
        dark = 1.0 - np.asarray(stage._canvas.buffer_rgba())[::-1, :, :3].mean(axis=-1) / 255.0
        for text in stage._names.values():
            own.append(covered(corners(text), dark))
            place = text.get_position()
            text.set_position((5.0, 5.0))
            corner.append(covered(corners(text), dark))
            text.set_position(place)
    assert np.mean(own) < 0.5 * np.mean(corner)
    assert np.mean(own) < 0.05


@pytest.mark.parametrize("dimensions", [False, True], ids=["plain", "dimensions"])
@pytest.mark.parametrize("name", shipped())
def test_labels_lie_on_nothing(name, dimensions):
    check(start_figure(System(linkages.load(name)), dimensions=dimensions))
