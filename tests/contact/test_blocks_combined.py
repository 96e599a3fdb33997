"""Blocks on blocks, beside other clearances, and driven: balances of energy."""

import numpy as np
import pytest

import linkages

LAW = "contact: exact, restitution: 0.7, stiffness: 1e8, friction: 0.1, slip: 20 mm/s"
YOKE = f"""
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{crank: {{joints: [O, A], length: 50 mm, mass: 0.2}}}}
sliders:
  yoke: {{joint: Y, through: O, mass: 1, inertia: 2e-3}}
  pin:  {{joint: A, on: yoke, through: Y, angle: 90 deg, mass: 0.1, inertia: 1e-5}}
clearances:
  outer: {{slider: yoke, size: 0.5 mm, length: 60 mm, height: 40 mm, {LAW}}}
  inner: {{slider: pin, size: 0.2 mm, length: 20 mm, height: 16 mm, {LAW}}}
drives: {{crank: {{angle: 0.4, speed: 20}}}}
"""
ENGINE = f"""
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 0.05, mass: 0.4}}
  rod: {{joints: [A, B], length: 0.15, mass: 0.5}}
sliders: {{piston: {{joint: B, through: O, angle: 0.1, mass: 0.3, inertia: 2e-4}}}}
clearances:
  gap: {{joint: B, bar: rod, size: 0.2 mm, contact: exact, restitution: 0.6, stiffness: 1e9,
        carries: pin, pin_radius: 5 mm, friction: 0.1, slip: 20 mm/s}}
  link: {{joint: A, bar: rod, size: 0.1 mm}}
  play: {{slider: piston, size: 0.5 mm, length: 60 mm, height: 40 mm, {LAW}}}
drives: {{crank: {{angle: 1.0, speed: 30}}}}
loads: [{{slider: piston, force: -50}}]
assembly: {{B: [0.18, 0.02]}}
"""
DRIVEN = f"""
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 0.05, mass: 0.4}}
  rod: {{joints: [A, B], length: 0.15, mass: 0.5}}
sliders: {{piston: {{joint: B, through: O, mass: 0.3, inertia: 2e-4}}}}
clearances: {{play: {{slider: piston, size: 0.5 mm, length: 60 mm, height: 40 mm, {LAW}}}}}
drives: {{piston: {{position: 0.16, speed: 0.5}}}}
assembly: {{A: [0.03, 0.04]}}
"""
CASES = {
    "a block on a block": (YOKE, ("outer", "inner")),
    "a pin that opens, a massless link and a block": (ENGINE, ("gap", "play")),
    "a driven slider": (DRIVEN, ("play",)),
}


@pytest.mark.slow_except("a driven slider")
@pytest.mark.parametrize(("text", "touching"), CASES.values(), ids=CASES)
def test_balance_of_energy(text, touching):
    """1e-9 of the largest energy at rtol 1e-10; every clearance that may open touches."""
    data = linkages.simulate(
        linkages.loads(text), end=0.05, samples=101, rtol=1e-10, outputs="all"
    ).data
    largest = data.clearance_force.max("time")
    for name in touching:
        own = [str(c) for c in largest.clearance.values if str(c).partition(".")[0] == name]
        assert float(largest.sel(clearance=own).max()) > 1.0
    balance = np.abs(data.energy_residual).max() / np.abs(data.kinetic_energy).max()
    assert float(balance) < 1e-9
