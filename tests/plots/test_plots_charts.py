"""Every figure by name: axes of its own, or those that are given."""

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from plot_data import SERIES, press, press_data
from shared_definitions import DRIVEN_ROD

import linkages
from linkages.kernel.outputs import VARIABLES
from linkages.plots import FIGURES, charts
from linkages.plots.chaos.diagrams import KINDS, SIGNS
from linkages.plots.motion.time_figures import drawable
from linkages.plots.style import PALETTE, style
from linkages.solution.series import available


class Solved:
    """A stand-in for a solution."""

    def __init__(self, data=None):
        self.data = press_data() if data is None else data
        self.mechanism = press()


OF_ANALYSES = {
    "bifurcation", "bode", "branches", "equilibria", "exponents", "indicator_map", "life",
    "multipliers", "orbit", "period_map", "rotation_map", "section", "wear", "wear_depth",
    "wear_profile",
}  # fmt: skip
OF_CONTACT = {"clearance_orbit", "clearance_state"}
PICTURES = ["mechanism", "traces", "phase_diagram"]
NAMED = {"pair", "plot", "vectors", "over_time", "polar", *OF_ANALYSES, *OF_CONTACT, *PICTURES}
ALL_OVER_TIME = [name for name in charts.__all__ if name not in NAMED]
OVER_TIME = [name for name in ALL_OVER_TIME if name in {*SERIES, "drive_force"}]
OF_SOLUTIONS = [*PICTURES, *OVER_TIME]


def solved(name):
    """A solution that has what a chart shows; `drive_force` needs a driven slider."""
    if name != "drive_force":
        return Solved()
    return Solved(press_data(drive=["ram"]))


@pytest.mark.slow_except("mechanism", "phase_diagram", "drive_effort")
@pytest.mark.parametrize("name", OF_SOLUTIONS)
def test_a_chart_has_axes_of_its_own_or_those_given(name):
    chart = getattr(linkages.charts, name)
    own = chart(solved(name))
    assert isinstance(own, Axes)
    assert own.figure.get_size_inches()[0] == pytest.approx(704 / 96)  # as wide as pages show it
    given = Figure().add_subplot()
    assert chart(solved(name), ax=given) is given
    assert given.get_xlabel() == own.get_xlabel() != ""
    assert given.get_ylabel() == own.get_ylabel() != ""
    assert "[" in own.get_xlabel()
    assert "[" in own.get_ylabel()
    assert len(given.lines) == len(own.lines)


@pytest.mark.parametrize("name", [n for n in OVER_TIME if not n.startswith("drive")])
def test_charts_over_time_take_data_alone(name):
    data = press_data()
    chart = getattr(charts, name)
    line, same = chart(data).lines[0], chart(Solved()).lines[0]
    np.testing.assert_array_equal(line.get_xydata(), same.get_xydata())


def test_there_is_a_chart_for_every_figure():
    """Those of outputs have `over_time` at least, and those of vectors `polar`."""
    own = {*PICTURES, *OF_CONTACT, "drive_force", "phase"}
    others = {name.removesuffix("_polar") for name in FIGURES if name not in own}
    assert others == {name for name in VARIABLES if drawable(name)}
    assert {*ALL_OVER_TIME} <= {*others, "drive_force"}


@pytest.mark.slow_except("four-bar")
@pytest.mark.parametrize("name", ["four-bar", "slider-crank-contact", "andrews"])
def test_every_output_has_a_chart(name):
    """Whatever a solution was asked for; of a four-bar, a gap and a motion that is integrated."""
    solution = linkages.simulate(linkages.load(name), end=0.01, samples=21, outputs=["bar_angle"])
    known = available(solution.system)
    for variable in known:
        if drawable(variable) and not VARIABLES[variable].whole:
            ax = charts.over_time(solution, variable)
            assert ax.lines or ax.collections, variable
            words = VARIABLES[variable].described(solution.system.model)[1]
            assert ax.get_ylabel().startswith(words.split(" or ")[0]), variable
            if variable in ALL_OVER_TIME and variable != "drive_effort":
                assert getattr(charts, variable)(solution).get_ylabel() == ax.get_ylabel()
    ax = charts.polar(solution, "shaking_force")
    force = solution.dense(["shaking_force"])["shaking_force"].to_numpy()[:, 0]
    x, y = ax.lines[0].get_xdata(), ax.lines[0].get_ydata()
    ratio = np.hypot(x, y).max() / np.hypot(*force.T).max()
    assert np.log10(ratio) == pytest.approx(round(np.log10(ratio)), abs=1e-9)
    assert ax.get_aspect() == 1.0
    with pytest.raises(ValueError, match="the data have no joint_reaction"):
        charts.over_time(solution, "joint_reaction")
    with pytest.raises(ValueError, match="bar_angle has no direction"):
        charts.polar(solution, "bar_angle")


def test_any_output_against_any_other():
    given = Figure().add_subplot()
    assert charts.pair(Solved(), "ram.velocity", "r1.angle", given) is given
    own = charts.pair(press_data(), "ram.velocity", "r1.angle")
    assert own.get_xlabel() == given.get_xlabel() == "velocity of ram [m/s]"
    np.testing.assert_array_equal(own.lines[0].get_xydata(), given.lines[0].get_xydata())
    with pytest.raises(ValueError, match=r"unknown element 'rum'; did you mean 'ram\.velocity'"):
        charts.pair(Solved(), "rum.velocity", "r1.angle")


def test_what_is_missing_is_named():
    empty = Solved(press_data()[["slider_velocity"]])
    for name in set(OF_SOLUTIONS) - {"slider_velocity", "phase_diagram"}:
        with pytest.raises(ValueError, match="the data have no "):
            getattr(charts, name)(empty)
    with pytest.raises(ValueError, match="no free coordinate"):
        charts.phase_diagram(empty)
    with pytest.raises(ValueError, match="unknown free coordinate 'r2'; expected one of: r1"):
        charts.phase_diagram(Solved(), "r2")


def test_the_mechanism_at_a_time():
    at_end = charts.mechanism(Solved(), time=2.0)
    pins = [text.xy for text in at_end.texts if text.get_text() == "A"]
    place = 1e3 * press_data()["joint_position"].isel(time=-1).sel(joint="A")
    assert pins == [pytest.approx(place.to_numpy())]


def test_charts_leave_a_users_settings_alone():
    with matplotlib.rc_context({"lines.linewidth": 7.0}):
        chart = charts.slider_velocity(Solved())
        assert matplotlib.rcParams["lines.linewidth"] == 7.0
    assert chart.lines[0].get_linewidth() < 2


def lightness(colour):
    """CIE lightness, 0 (black) to 100."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return 116 * np.cbrt(np.dot(linear, (0.2126, 0.7152, 0.0722))) - 16


def test_maps_can_be_read_in_black_and_white():
    shades = [lightness(colour) for colour in SIGNS]
    middle = len(SIGNS) // 2
    assert shades[middle] == pytest.approx(max(shades))
    assert (np.diff(shades[: middle + 1]) > 15).all()
    assert (np.diff(shades[middle:]) < -10).all()
    classes = sorted(lightness(colour) for colour in KINDS.values())
    assert (np.diff(classes) > 15).all()


def test_lines_differ_in_black_and_white():
    # neighbouring lines have other dashes, whatever their colours look like
    from linkages.plots.style import line_style

    looks = [str(line_style(index)["linestyle"]) for index in range(5)]
    assert len(set(looks)) == 5
    assert len({line_style(i)["color"] for i in range(9)}) == len(PALETTE)


@pytest.fixture(scope="module")
def pendulum():
    """A driven pendulum: small, and with a period to take sections by."""
    return linkages.loads(DRIVEN_ROD)


def test_charts_of_analyses(pendulum):
    points = linkages.poincare(pendulum, periods=20)
    assert len(charts.section(points, "rod").lines[0].get_xdata()) == 20
    history = linkages.lyapunov(pendulum, periods=5)
    label = "running estimate of the Lyapunov exponent [1/s]"
    assert charts.exponents(history).get_ylabel() == label
    given = Figure().add_subplot()
    assert charts.exponents(history, ax=given) is given
    with pytest.raises(ValueError, match="unknown free coordinate 'crank'; expected one of: rod"):
        charts.section(points, "crank")


def test_charts_of_maps():
    from test_plots_chaos import map_data

    data = map_data(np.linspace(-1.0, 1.0, 6).reshape(2, 3))
    assert charts.indicator_map(data).collections
    given = Figure().add_subplot()
    with style():
        assert charts.indicator_map(data, given) is given
    assert [ax.get_ylabel() for ax in given.figure.axes[1:]] != [""]
    assert charts.rotation_map(data).collections
