"""Counterweights: against the same mass as a plate that is welded on, and against balance."""

import math

import numpy as np
import pytest

import linkages

ENGINE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.8}
  rod: {joints: [A, B], length: 140 mm, mass: 0.5}
  WELDED
sliders: {piston: {joint: B, through: O, mass: 0.4}}
drives: {crank: {angle: 0.3, speed: 600 rpm}}
assembly: {B: [0.18, 0]}
"""
PLATE = "balance: {points: {O: [0, 0]}, mass: 1.2, center: [30 mm, 0], inertia: 4e-4}"
WELD = "welds: {O: {bars: [crank, balance], angle: 170 deg}}\n"
OWN = (
    "counterweights:\n"
    "  balance: {bar: crank, joint: O, mass: 1.2, distance: 30 mm, angle: 170 deg, inertia: 4e-4}\n"
)
OUTPUTS = ["bar_angle", "drive_effort", "joint_reaction", "kinetic_energy", "potential_energy"]


def test_it_is_a_plate_welded_to_its_bar():
    own = linkages.loads(ENGINE.replace("WELDED", "") + OWN)
    welded = linkages.loads(ENGINE.replace("WELDED", PLATE) + WELD)
    found, expected = (
        linkages.simulate(m, end=0.1, samples=21, outputs=OUTPUTS).data for m in (own, welded)
    )
    for name in OUTPUTS:
        elements = {d: expected[d].to_numpy() for d in expected[name].dims if d in ("bar", "joint")}
        size = 1e-12 * float(abs(expected[name]).max())  # round-off: the order of bodies differs
        assert float(abs(found[name].sel(elements) - expected[name]).max()) <= size, name


def test_a_balanced_crank_rests_and_turns_steadily():
    text = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 200 mm, mass: 1}}
counterweights: {balance: {bar: crank, joint: O, mass: 2 kg, distance: 5 cm}}
free: {crank: {angle: 0.5, speed: 3}}
"""
    outputs = [name for name in OUTPUTS if name != "drive_effort"]
    data = linkages.simulate(linkages.loads(text), end=5.0, samples=11, outputs=outputs).data
    expected = 0.5 + 3.0 * data.time.to_numpy()
    assert data.bar_angle.sel(bar="crank").to_numpy() == pytest.approx(expected, abs=1e-9)
    weight = data.joint_reaction.sel(joint="O").to_numpy()
    assert abs(weight) == pytest.approx(np.tile([0.0, 3 * 9.81], (11, 1)), abs=1e-9)
    inertia = 0.2**2 / 3 + 2 * 0.05**2
    assert data.kinetic_energy.to_numpy() == pytest.approx(0.5 * inertia * 9.0)


def test_it_stands_opposite_to_its_bar_unless_it_is_said():
    weight = linkages.Counterweight(name="w", bar="crank", joint="O", mass=1, distance=0.1)
    assert weight.angle == math.pi


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("bar: crank", "bar: crnk"), "did you mean 'crank'?"),
        (("joint: O", "joint: B"), "counterweights.balance.joint"),
        (("mass: 1.2", "mass: 0"), "expected a mass > 0, found 0"),
        (("  balance:", "  crank:"), "expected a name other than that of its bar"),
    ],
)
def test_what_is_wrong_is_named(change, message):
    with pytest.raises(linkages.InputError) as caught:
        linkages.loads(ENGINE.replace("WELDED", "") + OWN.replace(*change))
    assert message in str(caught.value)
