"""Springs along guides: oscillations in closed form."""

import numpy as np
import pytest
from component_reading import complaints, component

import linkages
from linkages.components.springs import GuideSpring

CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, angle: 30 deg, mass: 2}}
bars: {arm: {joints: [C, P], length: 0.1}}
free: {cart: {position: 0.3, speed: 0}, arm: {angle: 0, speed: 0}}
masses: {P: 1e-3}
springs:
"""
ALONE = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, angle: 30 deg, mass: 2}}
free: {cart: {position: 0.3, speed: 0}}
springs:
"""


def test_same_from_yaml_and_python():
    made = GuideSpring(index=0, slider="cart", stiffness=200, position=0.05, damping=3)
    entry = "- {slider: cart, stiffness: 0.2 N/mm, position: 5 cm, damping: 3}\n"
    assert component(CART + entry, "springs", 0) == made


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_damped_oscillation(damping):
    entry = f"- {{slider: cart, stiffness: 200, position: 5 cm, damping: {damping}}}\n"
    outputs = ["slider_position", "spring_force", "potential_energy", "energy_residual"]
    data = linkages.simulate(
        linkages.loads(ALONE + entry), end=2.0, samples=21, outputs=outputs
    ).data
    time = data.time.to_numpy()
    decay = damping / 4
    frequency = np.sqrt(100 - decay**2)
    wave = np.cos(frequency * time) + decay / frequency * np.sin(frequency * time)
    deflection = 0.25 * np.exp(-decay * time) * wave
    position = data.slider_position.sel(slider="cart").to_numpy()
    # rtol 1e-10 over 2 s, three oscillations
    assert position - 0.05 == pytest.approx(deflection, abs=1e-9)
    energy = data.potential_energy.to_numpy()
    assert energy == pytest.approx(100 * deflection**2, abs=1e-7)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8
    if damping == 0.0:
        force = data.spring_force.sel(spring="springs[0]").to_numpy()
        assert force == pytest.approx(-200 * deflection, abs=1e-6)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{slider: arm, stiffness: 1}", "unknown slider 'arm'; expected one of: cart"),
        ("{slider: cart, stiffness: -1}", "expected a stiffness >= 0"),
        ("{slider: cart, stiffness: 1, length: 1}", "unknown key 'length'"),
        ("{slider: cart}", "missing key 'stiffness'"),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(CART + f"- {entry}\n")
    assert found in problem
