"""Springs given by tables, against linear springs and a quartic potential."""

import numpy as np
import pytest
from component_reading import complaints, component

import linkages
from linkages.components.springs import (
    TabulatedGuideSpring,
    TabulatedSpring,
)

PENDULUM = """
joints: {O: [0, 0], H: [0.7, 0.1]}
bars: {rod: {joints: [O, P], length: 0.5, mass: 1}}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {rod: {angle: 0.4, speed: 1}, cart: {position: 0.3, speed: 0}}
springs:
"""
OUTPUTS = ["bar_angle", "slider_position", "potential_energy", "energy_residual"]


def moved(springs, force, end=2.0):
    mechanism = linkages.loads(PENDULUM + springs)
    return linkages.simulate(mechanism, end=end, samples=21, outputs=[*OUTPUTS, force]).data


@pytest.mark.parametrize(
    ("table", "spring"),
    [
        (
            "- {between: [H, P], lengths: [0.1, 0.5], forces: [-8, 24], interpolation: linear}\n",
            "- {between: [H, P], stiffness: 80, length: 0.2}\n",
        ),
        (
            "- {slider: cart, positions: [-1, 1], forces: [-55, 45], interpolation: linear}\n",
            "- {slider: cart, stiffness: 50, position: 0.1}\n",
        ),
        (
            "- {between_bars: [ground, rod], angles: [0, 90 deg], torques: [-1, 2.5],"
            " interpolation: linear}\n",
            f"- {{bar: rod, stiffness: {7 / np.pi}, angle: {np.pi / 7}}}\n",
        ),
    ],
)
def test_a_straight_line_is_a_spring(table, spring):
    """Beyond its ends too."""
    force = "torsional_spring_torque" if "torques" in table else "spring_force"
    found, expected = moved(table, force), moved(spring, force)
    for name in ("bar_angle", "slider_position", force):
        # ends of the table are located, so steps are others; rtol 1e-10 over two swings
        assert found[name].to_numpy() == pytest.approx(
            expected[name].to_numpy(), rel=1e-8, abs=1e-8
        )
    assert abs(found.energy_residual.to_numpy()).max() < 1e-8


def test_a_hardening_spring_keeps_its_energy():
    """A cubic is what a spline is made of: F = 40·x + 900·x³ between its ends, but for its ends."""
    places = np.linspace(-0.5, 0.5, 101)
    forces = 40 * places + 900 * places**3
    table = "- {slider: cart, positions: [POSITIONS], forces: [FORCES], interpolation: spline}\n"
    table = table.replace("POSITIONS", ", ".join(map(repr, places.tolist())))
    data = moved(
        table.replace("FORCES", ", ".join(map(repr, forces.tolist()))), "spring_force", end=3.0
    )
    position = data.slider_position.to_numpy()[:, 0]
    expected = -(40 * position + 900 * position**3)
    # natural ends err by h²·F″/12 and fall off by 0.27 from knot to knot: 20 knots from there
    assert data.spring_force.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-9)
    assert position.min() == pytest.approx(-0.3, abs=5e-2)
    assert abs(position).max() <= 0.3 + 1e-8
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8


def test_same_from_yaml_and_python():
    made = TabulatedSpring(index=0, between=("H", "P"), lengths=(0.1, 0.2, 0.4), forces=(0, 1, 5))
    entry = "- {between: [H, P], lengths: [10 cm, 0.2, 0.4], forces: [0, 1, 5 N]}\n"
    assert component(PENDULUM + entry, "springs", 0) == made
    guide = TabulatedGuideSpring(index=0, slider="cart", positions=(0, 1, 2), forces=(0, 1, 5))
    entry = "- {slider: cart, positions: [0, 1, 2], forces: [0, 1, 5]}\n"
    assert component(PENDULUM + entry, "springs", 0) == guide


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{between: [H, P], lengths: [1, 2], forces: [1, 2]}", "at least 3 lengths, found 2"),
        ("{between: [H, P], lengths: [1, 2, 3], forces: [1, 2]}", "3 lengths and 2 forces"),
        ("{between: [H, P], lengths: [1, 3, 2], forces: [1, 2, 3]}", "found 2 after 3"),
        ("{between: [H, H], lengths: [1, 2, 3], forces: [1, 2, 3]}", "two different joints"),
        ("{slider: cart, positions: [1, 2, 3], forces: [1, 2, 3 m]}", "expected a force"),
        ("{slider: cart, positions: [1, 2, 3]}", "missing key 'forces'"),
        ("{between_bars: [rod, rod], angles: [0, 1, 2], torques: [1, 2, 3]}", "two different"),
    ],
)
def test_wrong_entries(entry, found):
    assert any(found in problem for problem in complaints(PENDULUM + f"- {entry}\n"))
