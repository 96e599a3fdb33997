"""Figures of isoperiodic planes show what the data say."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from linkages.plots import charts
from linkages.plots.chaos.diagrams import LOOKS, classes, period_figure, period_map
from linkages.plots.style import style

PERIODS = [LOOKS[number][0] for number in range(1, 10)]
CHAOTIC, UNDECIDED, FAILED = (LOOKS[number][0] for number in (-1, -2, -3))
FOUND = [[1, 2, 8], [9, 40, "chaotic"], ["undecided", "failed", 3]]
COLOURS = [
    [PERIODS[0], PERIODS[1], PERIODS[7]],
    [PERIODS[8], PERIODS[8], CHAOTIC],
    [UNDECIDED, FAILED, PERIODS[2]],
]


def plane_data(found=FOUND, units="m"):
    codes = {"failed": 0, "chaotic": 2, "undecided": 3}
    regime = [[codes.get(each, 1) for each in row] for row in found]
    period = [[np.nan if each in codes else float(each) for each in row] for row in found]
    rows, columns = np.shape(found)
    return xr.Dataset(
        {"regime": (("y", "x"), regime), "indicator": (("y", "x"), period)},
        {
            "bars.a.length": ("x", np.arange(columns) * 0.5, {"units": units}),
            "bars.b.mass": ("y", np.arange(rows) * 2.0, {"units": "kg"}),
        },
        {"name": "Press", "x": "bars.a.length", "y": "bars.b.mass"},
    )


def test_every_class_has_its_colour():
    figure = period_map(plane_data()).figure
    mesh = figure.axes[0].collections[0]
    shown = mesh.cmap(mesh.norm(np.asarray(mesh.get_array())))
    assert [[to_hex(cell).upper() for cell in row] for row in shown] == [
        [colour.upper() for colour in row] for row in COLOURS
    ]
    assert len({*PERIODS, CHAOTIC, UNDECIDED, FAILED}) == len(PERIODS) + 3


def test_the_legend_has_what_is_there():
    texts = [text.get_text() for text in period_map(plane_data()).get_legend().texts]
    periods = ["period 1", "period 2", "period 3", "period 8", "period 9 or more"]
    assert texts == [*periods, "chaotic", "undecided", "not computed"]
    data = plane_data([[1, 1, "chaotic"]] * 2)
    texts = [text.get_text() for text in period_map(data).get_legend().texts]
    assert texts == ["period 1", "chaotic"]
    assert period_figure(data) is not None
    assert period_figure(plane_data([[1, 1, 1]] * 2)) is None
    assert (classes(data)[:, 2] == -1).all()


@pytest.mark.parametrize(("units", "factor"), [("m", 1.0), ("rad", 180 / np.pi)])
def test_curves_lie_on_top(units, factor):
    """In the units of the data, which are drawn in degrees where they are angles."""
    data, x = plane_data(units=units), np.array([-5.0, 0.5, np.nan, 1.0])
    ax = charts.period_map(data, curves={"PD1": (x, x), "G1": ([0.0, 1.0], [4.0, 0.0])})
    named = {line.get_label(): line for line in ax.lines if not line.get_label().startswith("_")}
    assert list(named) == ["PD1", "G1"]
    np.testing.assert_allclose(named["PD1"].get_xdata(), factor * x)
    np.testing.assert_allclose(named["PD1"].get_ydata(), x)
    assert named["PD1"].get_linestyle() != named["G1"].get_linestyle()
    assert ax.get_xlim() == pytest.approx((-0.25 * factor, 1.25 * factor))  # as without curves
    assert [text.get_text() for text in ax.get_legend().texts][-2:] == ["PD1", "G1"]


def test_axes_may_be_given():
    given = Figure().add_subplot()
    with style():
        assert charts.period_map(plane_data(), given) is given
    assert given.get_legend() is not None
