"""What contact must tend to: massless link, ideal joint; energy, and time that runs back."""

import numpy as np
import pytest
from contact_references import Reference
from random_contact import definition

import linkages

ENGINE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.8, center: 10 mm}
  rod:   {joints: [A, B], length: 140 mm, mass: 0.5}
sliders: {piston: {joint: B, through: O, angle: 0, mass: 0.4}}
clearances: {gap: {joint: A, bar: rod, size: 0.1 mm%s}}
drives: {crank: {angle: 0, speed: 60 rpm}}
loads: [{slider: piston, force: -200 N}]
assembly: {B: [0.18, 0]}
"""
LINK = ", angle: 180 deg"
CONTACT = (
    ", contact: hunt-crossley-constant, stiffness: %g N/m^1.5, dissipation: 20 s/m, offset: [%g, 0]"
)
FORCE = 200.0


def positions(text, times):
    data = linkages.simulate(
        linkages.loads(text), times=times, rtol=1e-10, outputs=["slider_position"]
    ).data
    return data.slider_position[:, 0].to_numpy()


@pytest.mark.parametrize("stiffness", [1e10, 1e11, 1e12, 1e13])
def test_loaded_and_damped_contact_tends_to_the_massless_link(stiffness):
    """It gives way by (F/K)^(2/3) of Hertz's law under the load; the file that starts there."""
    times = np.linspace(0.0, 0.25, 26)
    depth = (FORCE / stiffness) ** (2 / 3)
    start = -(1e-4 + depth)
    found = positions(ENGINE % (CONTACT % (stiffness, start)), times)
    off = (found - positions(ENGINE % LINK, times))[5:].mean()
    assert off == pytest.approx(-depth, rel=0.15)


@pytest.mark.parametrize("size", [1e-4, 1e-5, 1e-6])
def test_small_clearances_tend_to_the_ideal_joint(size):
    """The error of the position is at most the offset, which an indentation adds to."""
    reference = Reference("5-engine-crank-pin")
    mechanism = linkages.loads(reference.definition).with_values({"clearances.gap.size": size})
    data = linkages.simulate(
        mechanism, end=0.02, samples=401, rtol=1e-9,
        outputs=["slider_position_error", "clearance_indentation"],
    ).data  # fmt: skip
    depth = max(0.0, float(data.clearance_indentation.max()))
    assert float(np.abs(data.slider_position_error).max()) <= 1.1 * (size + depth)


CASES = {
    "slider-crank": (Reference("4-slider-crank-5000rpm").definition, 0.004),
    "friction": (Reference("5-engine-crank-pin").definition, 0.03),
    "elastic": (Reference("6-free-crank-energy").definition, 0.02),
    "two clearances": (definition(2), 0.03),
    "kelvin-voigt": (
        Reference("5-engine-crank-pin").definition
        .replace("hunt-crossley-constant, stiffness: 2e9 N/m^1.5, dissipation: 1.5 s/m",
                 "kelvin-voigt, stiffness: 1e7 N/m, damping: 300 N*s/m"), 0.02),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_energy_balance(case):
    """Energy less work and plus losses is constant, to 1e-9 of the energy at rtol 1e-10."""
    text, end = CASES[case]
    data = linkages.simulate(
        linkages.loads(text), end=end, samples=201, rtol=1e-10,
        outputs=["energy_residual", "kinetic_energy", "potential_energy", "clearance_force"],
    ).data  # fmt: skip
    size = np.abs(data.kinetic_energy).max() + np.abs(data.potential_energy).max()
    assert float(np.abs(data.energy_residual).max() / size) < 1e-9
    assert float(data.clearance_force.max()) > 0  # it did touch


def test_elastic_contact_without_friction_does_no_work():
    text, end = CASES["elastic"]
    data = linkages.simulate(
        linkages.loads(text), end=end, samples=201, rtol=1e-10,
        outputs=["kinetic_energy", "potential_energy"],
    ).data  # fmt: skip
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert float(np.ptp(energy)) < 1e-9 * float(np.abs(energy).max())


def test_time_runs_back_without_losses():
    """Forth, rates reversed, and forth again: the start, through ten touches."""
    text, end = CASES["elastic"]
    mechanism = linkages.loads(text)
    rhs = linkages.compile(mechanism)
    count = len(rhs.names) // 2
    flow = rhs.flow(rtol=1e-12)
    names = [name.rsplit(".", 1)[0] for name in rhs.names[:count]]
    start = np.zeros(2 * count)
    start[names.index("crank")], start[count + names.index("crank")] = 0.5, np.pi * 20
    there = flow.advance(start, 0.0, end).y
    back = flow.advance(np.concatenate([there[:count], -there[count:]]), 0.0, end).y
    off = np.abs(np.concatenate([back[:count], -back[count:]]) - start)
    offsets = [k for k, name in enumerate(names) if name.startswith("gap")]
    assert off[offsets].max() < 1e-6 * 1e-4
    assert off[[count + k for k in offsets]].max() < 1e-6 * 0.3
