"""Maxwell elements: relaxation in closed form, a linear oscillator, energy, messages."""

import numpy as np
import pytest
from component_reading import complaints, component
from scipy.linalg import expm

import linkages
from linkages.chaos.evidence import conservative
from linkages.components.springs import BarMaxwellElement, MaxwellElement

CRANK = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.2 m, mass: 1 kg}}
drives: {crank: {angle: 0, speed: SPEED}}
maxwell:
  - {bar: crank, stiffness: 30, damping: 6, deflection: START}
"""
BLOCK = """
joints: {O: [0, 0], P: [-1, 0]}
bars: {dummy: {joints: [P, Q], length: 0.1}}
sliders: {block: {joint: B, through: O, angle: 0, mass: 2}}
drives: {dummy: {angle: 0, speed: 0}}
free: {block: {position: 0.5, speed: 0.3}}
maxwell:
  - ELEMENT
"""


def test_same_from_yaml_and_python():
    made = BarMaxwellElement(index=0, bar="crank", stiffness=30, damping=6, deflection=0.1)
    text = CRANK.replace("SPEED", "0").replace("START", "0.1")
    assert component(text, "maxwell", 0) == made
    between = MaxwellElement(index=0, between=("P", "B"), stiffness=5, damping=20)
    text = BLOCK.replace("ELEMENT", "{between: [P, B], stiffness: 5 N/m, damping: 20 N s/m}")
    assert component(text, "maxwell", 0) == between


@pytest.mark.parametrize(("speed", "start"), [(0.0, 0.1), (2.0, 0.0), (-1.5, 0.2)])
def test_relaxation_under_a_drive(speed, start):
    """Nothing but the element is integrated: s = s0 e^(-t/τ) + ω τ (1 - e^(-t/τ)), τ = d/k."""
    text = CRANK.replace("SPEED", str(speed)).replace("START", str(start))
    outputs = ["internal_state", "drive_effort", "torsional_spring_torque"]
    data = linkages.simulate(linkages.loads(text), end=1.0, samples=21, outputs=outputs).data
    decay = np.exp(-data.time.to_numpy() * 30 / 6)
    expected = start * decay + speed * 6 / 30 * (1 - decay)
    found = data.internal_state.sel(internal="maxwell[0].deflection").to_numpy()
    assert found == pytest.approx(expected, abs=2e-10)  # rtol is 1e-10
    assert data.internal_state.attrs["units"] == "rad"
    torque = data.torsional_spring_torque.to_numpy()[:, 0]
    assert torque == pytest.approx(-30 * expected, abs=6e-9)
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(30 * expected, abs=6e-9)


@pytest.mark.slow_except("*dop853*", "*rk4*")
@pytest.mark.parametrize(
    "element",
    ["{slider: block, stiffness: 50, damping: 8}", "{between: [P, B], stiffness: 50, damping: 8}"],
)
@pytest.mark.parametrize(
    "method", [("dop853", None), ("radau", None), ("gauss8", 0.02), ("rk4", 1e-3)], ids=str
)
def test_a_mass_on_an_element(element, method):
    """Three linear equations, by the exponential of their matrix; energy beside it."""
    name, step = method
    mechanism = linkages.loads(BLOCK.replace("ELEMENT", element))
    outputs = ["slider_position", "slider_velocity", "internal_state", "energy_residual"]
    data = linkages.simulate(
        mechanism, end=2.0, samples=9, method=name, step=step, outputs=outputs
    ).data
    matrix = np.array([[0, 1, 0], [0, 0, -25], [0, 1, -50 / 8]])
    expected = np.array([expm(matrix * t) @ [0.5, 0.3, 0.0] for t in data.time.to_numpy()])
    names = ("slider_position", "slider_velocity", "internal_state")
    found = np.array([data[name].to_numpy()[:, 0] for name in names]).T
    assert found == pytest.approx(expected, abs=1e-8)  # rk4 with a millisecond: 1e-10
    # 0.09 J at the start, all of which the damper takes in the end
    assert abs(data.energy_residual.to_numpy()).max() < 1e-9
    assert not conservative(mechanism)


def test_stiff_and_soft_limits():
    """A rigid spring leaves the damper, a rigid damper leaves the spring."""
    one = "{slider: block, stiffness: 1e7, damping: 8}"
    other = "{slider: block, stiffness: 50, damping: 1e9}"
    plain = BLOCK.replace("maxwell:\n  - ELEMENT", "LISTED")
    pairs = [
        (one, "dampers:\n  - {slider: block, damping: 8}"),
        (other, "springs:\n  - {slider: block, stiffness: 50, position: 0.5}"),
    ]
    for element, alone in pairs:
        mechanisms = BLOCK.replace("ELEMENT", element), plain.replace("LISTED", alone)
        ends = [
            linkages.simulate(linkages.loads(text), end=1.0, samples=3, method="radau", rtol=1e-8)
            for text in mechanisms
        ]
        found, expected = (e.data.slider_position.to_numpy()[-1, 0] for e in ends)
        assert found == pytest.approx(expected, abs=1e-6)  # d²/(k m) and m/(d T): 3e-6 of 0.1 m


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{slider: block, stiffness: 0, damping: 1}", "expected a stiffness > 0"),
        ("{slider: block, stiffness: 1, damping: -1}", "expected a damping > 0"),
        ("{slider: blok, stiffness: 1, damping: 1}", "did you mean 'block'?"),
        ("{between: [P, P], stiffness: 1, damping: 1}", "expected two different joints"),
        ("{slider: block, stiffness: 1}", "missing key 'damping'"),
    ],
)
def test_wrong_entries(entry, found):
    assert found in complaints(BLOCK.replace("ELEMENT", entry))[0]
