"""Shaking forces against the momentum of all masses, and a textbook's partial balance."""

import numpy as np
import pytest

import linkages

ENGINE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.8}
  rod:   {joints: [A, B], length: 140 mm, mass: 0.5}
sliders: {piston: {joint: B, through: O, angle: 0, mass: 0.4}}
drives: {crank: {angle: 0, speed: 1500 rpm}}
assembly: {B: [0.18, 0]}
loads: [{slider: piston, force: -200 N}]
"""
MASSES = {"crank": ("O", "A", 0.8, 0.04), "rod": ("A", "B", 0.5, 0.14)}
STEP = 5e-5
BENDS = np.array([2, -27, 270, -490, 270, -27, 2]) / (180 * STEP**2)


@pytest.mark.parametrize("time", [0.003, 0.0117])
def test_shaking_is_the_rate_of_momentum(time):
    """Of uniform bars and a piston, by differences of sixth order of where they are."""
    data = linkages.simulate(
        linkages.loads(ENGINE), times=time + STEP * np.arange(-3, 4),
        outputs=["joint_position", "bar_angle", "shaking_force", "shaking_moment"],
    ).data  # fmt: skip
    joints = {name: data.joint_position.sel(joint=name).to_numpy() for name in "OAB"}
    parts = [(joints["B"], 0.4)]
    moment = 0.0
    for name, (start, end, mass, length) in MASSES.items():
        parts.append(((joints[start] + joints[end]) / 2, mass))
        moment += mass * length**2 / 12 * (BENDS @ data.bar_angle.sel(bar=name).to_numpy())
    rates = [mass * (BENDS @ centre) for centre, mass in parts]
    for (centre, _), rate in zip(parts, rates, strict=True):
        moment += centre[3, 0] * rate[1] - centre[3, 1] * rate[0]
    now = data.isel(time=3)
    # the step to the sixth and round-off over its square are both about 1e-8 of 1000 N
    assert now.shaking_force.to_numpy()[0] == pytest.approx(-np.sum(rates, axis=0), abs=1e-3)
    assert float(now.shaking_moment[0]) == pytest.approx(-moment, abs=1e-4)


@pytest.mark.slow
def test_half_of_what_goes_to_and_fro_is_the_best_that_a_counterweight_balances():
    """All that turns and half of the rest (J. P. Den Hartog, *Mechanical Vibrations*).

    The force is then m r ω²/2 in all directions of the crank.
    """
    yoke = linkages.load("scotch-yoke").with_values(
        {"counterweights.weight": {"bar": "crank", "joint": "O", "mass": 0.5, "distance": 0.05}}
    )
    found = linkages.optimise(
        yoke, {"counterweights.weight.mass": (0.1, 3)},
        minimise="max(sqrt(ground.x_shaking_force**2 + ground.y_shaking_force**2))",
        end=0.5, samples=101,
    )  # fmt: skip
    # of the crank, uniform, half turns at the pin; the pin block turns and goes with the yoke
    best, force = 0.3 / 2 + 0.05 + 1.5 / 2, 1.5 / 2 * 0.05 * (4 * np.pi) ** 2
    assert float(found.data.number[1, 0]) == pytest.approx(best, rel=1e-7)
    assert float(found.data.value[1]) == pytest.approx(force, rel=1e-7)
