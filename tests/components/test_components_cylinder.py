"""Cylinders and gas springs: forces by hand, energies by quadrature, oscillation of a piston."""

import numpy as np
import pytest
from component_reading import complaints, component
from scipy.integrate import quad

import linkages
from linkages.chaos.evidence import conservative
from linkages.components.actuators import Cylinder, GasCylinder

PISTON = """
joints: {O: [0, 0]}
sliders: {piston: {joint: C, through: O, mass: 5}}
KNOWN
cylinders:
"""
DRIVEN = PISTON.replace("KNOWN", "drives: {piston: {position: 0.2, speed: 0.1}}")
FREE = PISTON.replace("KNOWN", "free: {piston: {position: 0.25, speed: 0}}")
GAS = "bore: 20 mm, gas_pressure: 50 bar, length: 0.3, volume: 150 cm^3"
AREA = np.pi / 4 * 0.02**2


def test_same_from_yaml_and_python():
    made = Cylinder(name="c", between=("O", "C"), bore=0.05, pressure=16e6, rod=0.025)
    entry = "  c: {between: [O, C], bore: 5 cm, pressure: 160 bar, rod: 25 mm}\n"
    assert component(DRIVEN + entry, "cylinders", "c") == made
    gas = GasCylinder(
        name="c", between=("O", "C"), bore=0.02, gas_pressure=50e5, length=0.3, volume=150e-6
    )
    read = component(DRIVEN + f"  c: {{between: [O, C], {GAS}}}\n", "cylinders", "c")
    assert read.volume == pytest.approx(gas.volume)
    assert read.exponent == 1.4


def test_a_stroke_is_driven_by_a_slider():
    (problem,) = complaints(
        DRIVEN.replace("piston: {position", "c: {position")
        + """
  c: {between: [O, C], bore: 50 mm, pressure: 1e6}
"""
    )
    assert "drives.c: unknown slider 'c': a cylinder is a force and has no coordinate" in problem
    (problem,) = complaints(DRIVEN.replace("mass: 5", "length: 5"))
    assert "unknown key 'length': a slider has no length; for a cylinder write" in problem


def test_pressures_act_on_their_areas():
    entry = """
  c: {between: [O, C], bore: 50 mm, rod: 20 mm, pressure: "1e6*t", rod_pressure: 2 bar,
      damping: 300}
"""
    outputs = ["load_force", "drive_effort", "load_power"]
    data = linkages.simulate(
        linkages.loads(DRIVEN + entry), end=1.0, samples=5, outputs=outputs
    ).data
    full, ring = np.pi / 4 * 0.05**2, np.pi / 4 * (0.05**2 - 0.02**2)
    force = 1e6 * data.time.to_numpy() * full - 2e5 * ring - 300 * 0.1
    assert list(data.force.to_numpy()) == ["cylinders.c"]
    assert data.load_force.to_numpy()[:, 0] == pytest.approx(force, rel=1e-12)
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(-force, rel=1e-12)
    assert data.load_power.to_numpy() == pytest.approx(0.1 * force, rel=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 1.3, 2.0])
def test_a_gas_spring_stores_the_work_done_on_it(exponent):
    entry = f"  c: {{between: [O, C], {GAS}, exponent: {exponent}, ambient: 1 bar}}\n"
    mechanism = linkages.loads(DRIVEN + entry)
    outputs = ["spring_force", "potential_energy", "load_power", "slider_position"]
    data = linkages.simulate(mechanism, end=2.0, samples=5, outputs=outputs).data

    def push(x: float) -> float:
        volume = 150e-6 + AREA * (x - 0.3)
        return (50e5 * (150e-6 / volume) ** exponent - 1e5) * AREA

    places = data.slider_position.to_numpy()[:, 0]
    pull = data.spring_force.to_numpy()[:, 0]
    assert pull == pytest.approx([-push(x) for x in places], rel=1e-12)
    energy = [-quad(push, 0.3, x, epsabs=1e-12)[0] for x in places]
    assert data.potential_energy.to_numpy() == pytest.approx(energy, abs=1e-10)
    assert not data.load_power.to_numpy().any()
    assert conservative(mechanism)


def test_a_piston_on_gas_swings_as_its_stiffness_says():
    """Small oscillations about equilibrium: k = n·p·A²/V there."""
    entry = f"  c: {{between: [O, C], {GAS}, ambient: 50 bar}}\n"  # in balance at 0.3 m
    mechanism = linkages.loads(FREE.replace("0.25", "0.3001") + entry)
    stiffness = 1.4 * 50e5 * AREA**2 / 150e-6
    outputs = ["slider_position", "energy_residual"]
    data = linkages.simulate(mechanism, end=2.0, samples=41, outputs=outputs).data
    wave = 1e-4 * np.cos(np.sqrt(stiffness / 5) * data.time.to_numpy())
    # the force is not linear: relative deviation A·1e-4/V = 2e-4 of the amplitude
    found = data.slider_position.to_numpy()[:, 0] - 0.3
    assert found == pytest.approx(wave, abs=3e-4 * 1e-4)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-9


def test_gas_without_volume_ends_a_run():
    entry = "  c: {between: [O, C], bore: 0.1, gas_pressure: 1e5, length: 0.3, volume: 1e-4}\n"
    mechanism = linkages.loads(DRIVEN.replace("speed: 0.1", "speed: -0.1") + entry)
    with pytest.raises(linkages.InputError, match=r"cylinders\.c"):
        linkages.simulate(mechanism, end=1.0)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{between: [O, O], bore: 0.1, pressure: 1}", "expected two different joints"),
        ("{between: [O, C], bore: 0, pressure: 1}", "expected a length > 0"),
        (
            "{between: [O, C], bore: 20 mm, rod: 30 mm, pressure: 1}",
            "cylinders.c.rod: expected less than the bore, 0.02 m, found 0.03 m",
        ),
        ("{between: [O, C], bore: 20 mm, pressure: 1 N}", "expected a pressure"),
        ("{between: [O, C], bore: 20 mm}", "missing key 'pressure'"),
        ("{between: [O, C], bore: 20 mm, gas_pressure: 1 bar, length: 1}", "missing key 'volume'"),
        (
            f"{{between: [O, C], {GAS}, exponent: -1}}",
            "expected a number > 0",
        ),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(DRIVEN + f"  c: {entry}\n")
    assert found in problem
