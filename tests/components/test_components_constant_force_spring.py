"""Constant-force springs: a uniform acceleration, and energy as of a weight."""

import numpy as np
import pytest
from component_reading import complaints, component

import linkages
from linkages.chaos.evidence import conservative
from linkages.components.springs import ConstantForceSpring

CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {cart: {position: 3, speed: 0}}
springs:
"""


def test_same_from_yaml_and_python():
    made = ConstantForceSpring(index=0, between=("O", "C"), force=40, damping=2)
    assert component(CART + "- {between: [O, C], force: 40 N, damping: 2}\n", "springs", 0) == made


def test_it_pulls_with_the_same_force_everywhere():
    mechanism = linkages.loads(CART + "- {between: [O, C], force: 4}\n")
    outputs = ["slider_position", "spring_force", "potential_energy", "load_power"]
    data = linkages.simulate(mechanism, end=1.0, samples=11, outputs=outputs).data
    expected = 3 - data.time.to_numpy() ** 2
    # a polynomial of the second degree, which the method follows to round-off
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-13)
    assert data.spring_force.to_numpy()[:, 0] == pytest.approx(np.full(11, 4.0))
    assert data.potential_energy.to_numpy() == pytest.approx(4 * expected, abs=1e-12)
    assert not data.load_power.to_numpy().any()  # all that it does is stored
    assert conservative(mechanism)


def test_terminal_speed_with_a_damper():
    text = CART.replace("position: 3", "position: 30")
    text += "- {between: [O, C], force: 4, damping: 8}\n"
    mechanism = linkages.loads(text)
    outputs = ["slider_velocity", "energy_residual"]
    data = linkages.simulate(mechanism, end=2.0, samples=11, outputs=outputs).data
    expected = -0.5 * (1 - np.exp(-4 * data.time.to_numpy()))
    assert data.slider_velocity.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-9)  # rtol 1e-10
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8
    assert not conservative(mechanism)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{between: [O, O], force: 1}", "expected two different joints, found 'O' twice"),
        ("{between: [O, E], force: 1}", "unknown joint 'E'"),
        ("{between: [O, C], force: 1 mm}", "expected a force"),
        ("{between: [O, C], force: 1, stiffness: 3}", "unknown key 'stiffness'"),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(CART + f"- {entry}\n")
    assert found in problem
