"""Figures of equilibria, of their modes, and of frequency responses."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import linkages
from linkages.equilibria.equilibrium import swing
from linkages.plots.motion import equilibrium_figures as drawn


@pytest.fixture(scope="module")
def pendulum():
    return linkages.load("double-pendulum")


@pytest.fixture(scope="module")
def data(pendulum):
    return linkages.equilibrium(pendulum)


def test_figures_number_all_equilibria_and_modes(data, pendulum):
    figures = drawn.equilibrium_figures(data, pendulum)
    assert set(figures) == {"equilibria", "modes", *(f"bode_{k}" for k in range(1, 5))}
    (ax,) = figures["equilibria"].axes
    texts = {text.get_text() for text in ax.texts}
    assert {"1", "2", "3", "4", "4 equilibria, 1 stable"} <= texts
    titles = [own.get_title(loc="left") for own in figures["modes"].axes]
    # two modes of the hanging one, one pair and one divergent of each saddle, two of the upright
    assert len(titles) == 8
    assert titles[:2] == ["1.1  0.4266 Hz", "1.2  1.144 Hz"]


def test_a_mode_swings_in_its_shape_about_the_equilibrium(data, pendulum):
    phases = np.array([0.0, np.pi / 2, np.pi])
    scenes = swing(pendulum, data, 1, 2, phases)
    angles = scenes["bar_angle"].to_numpy() + np.pi / 2
    shape = data["mode_shape"].sel(equilibrium=1, mode=2).isel(part=0).to_numpy()
    assert angles[0] / angles[0, 0] == pytest.approx(shape / shape[0], rel=1e-9)
    assert angles[1] == pytest.approx([0, 0], abs=1e-15)
    assert angles[2] == pytest.approx(-angles[0], rel=1e-12)
    places = scenes["joint_position"].to_numpy()
    largest = np.hypot(*(places[0] - places[1]).T).max()
    assert largest == pytest.approx(0.08 * 2, rel=0.05)  # of two metres, along arcs


def test_a_frequency_response_is_drawn_as_magnitude_and_phase(data):
    figure = drawn.bode(data, 1).figure
    upper, lower = figure.axes[:2]
    assert (upper.get_xscale(), upper.get_yscale()) == ("log", "log")
    frequency, magnitude = upper.lines[0].get_data()
    response = data["response"].sel(equilibrium=1).isel(output=0, input=0).to_numpy()
    assert magnitude == pytest.approx(np.hypot(*response.T))
    assert frequency == pytest.approx(data["response_frequency"].to_numpy())
    assert len(lower.lines) == data.sizes["output"]
    assert linkages.charts.bode(data, 2).get_legend().get_title().get_text() == "to upper.torque"


def test_positions_are_drawn_into_given_axes(data, pendulum):
    given = Figure().add_subplot()
    assert linkages.charts.equilibria(data, pendulum, ax=given) is given
    assert "Double pendulum" in linkages.charts.equilibria(data, pendulum).get_title(loc="left")


def test_guides_reach_along_all_equilibria():
    """Of a von Mises truss, whose apex rests at both ends of its guide."""
    mechanism = linkages.loads("""
joints: {A: [-1, 0], B: [1, 0], G: [0, 0]}
sliders: {apex: {joint: P, through: G, angle: 90 deg, mass: 2}}
springs:
  - {between: [A, P], stiffness: 1000, length: 1.2}
  - {between: [B, P], stiffness: 1000, length: 1.2}
free: {apex: {position: 0.5, speed: 0}}
""")
    data = linkages.equilibrium(mechanism)
    half = np.sqrt(1.2**2 - 1.0)
    for pose in drawn.poses_of(data, mechanism, "equilibrium"):
        assert pose.travel["apex"] == pytest.approx((-half, half), rel=1e-9)
