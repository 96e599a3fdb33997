"""Laws whose jumps and corners are zeros of the same quantity, along which a motion stays."""

import numpy as np
import pytest

import linkages

BLOCK = """
sliders: {{block: {{joint: P, through: [0, 0], mass: 2}}}}
parameters: {{size: 3, against: -3}}
loads: [{{slider: block, force: '{}'}}]
free: {{block: {{position: {}, speed: {}}}}}
"""
SLIP = "(block.velocity - 0.3*cos(3*t))"
TIMES = np.linspace(0.0, 6.0, 121)


def moved(force, position=0.0, speed=3.0, times=TIMES):
    """Positions and velocities of the block."""
    mechanism = linkages.loads(BLOCK.format(force, position, speed))
    data = linkages.simulate(mechanism, times=times, rtol=1e-11, atol=1e-13).data
    return data.slider_position[:, 0].to_numpy(), data.slider_velocity[:, 0].to_numpy()


@pytest.mark.parametrize(
    "law",
    [
        "-2*sign(U) - 3*abs(U)*U",
        "-3*abs(U)*U - 2*sign(U)",
        "-2*sign(U) - 3*abs(-U)*U",
        "-2*sign(U) - abs(3*U)*U",
        "-2*sign(U) - abs(size*U)*U",
        "-2*sign(U) + abs(U*against)*-U",
        "-2*sign(U) - 0.03*abs(U/0.01)*U",
        "where(U > 0, -2 - 3*U*U, 2 + 3*U*U)*0 - 2*sign(U) - where(U < 0, -3, 3)*U*U",
    ],
)
def test_a_block_that_is_carried_along(law):
    """All these are one law; friction holds the block on a belt, which needs 1.8 N of its 2 N."""
    position, velocity = moved(law.replace("U", SLIP))
    carried = TIMES > 2.0
    assert velocity[carried] == pytest.approx(0.3 * np.cos(3 * TIMES[carried]), abs=1e-12)
    written_once = "-2*sign(U) - 3*sign(U)*U*U".replace("U", "(block.velocity - 0.3*cos(3*t))")
    assert position == pytest.approx(moved(written_once)[0], abs=1e-9)


def test_a_factor_of_zero_is_no_change_of_sign():
    """The sign of 0 is 1, whatever it is multiplied by."""
    mechanism = linkages.loads(BLOCK.format("-2*sign(size*block.velocity)", 0, -3))
    data = linkages.simulate(mechanism.with_values({"parameters.size": 0}), times=TIMES).data
    assert data.slider_velocity[:, 0].to_numpy() == pytest.approx(-3 - TIMES, rel=1e-9)


def test_a_crank_that_friction_holds():
    """The factor is within the argument of one corner alone."""
    mechanism = linkages.loads("""
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 50 mm, mass: 1}
  rod: {joints: [A, B], length: 150 mm, mass: 1}
sliders: {piston: {joint: B, through: O, mass: 1}}
loads: [{slider: piston, force: '-2*sign(piston.velocity)*(1 + abs(3*piston.velocity))'}]
free: {crank: {angle: 30 deg, speed: 3}}
assembly: {B: [0.18, 0]}
simulate: {end: 8, samples: 81}
""")
    names = ("kinetic_energy", "potential_energy", "energy_residual")
    data = linkages.simulate(mechanism, outputs=names).data
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert (np.diff(energy) < 1e-9).all()  # J; friction only takes
    assert energy[-1] < energy[0] - 0.01
    assert np.abs(data.energy_residual.to_numpy()).max() < 1e-7


@pytest.mark.parametrize("law", ["-4*sqrt(abs(U))*sign(U)", "-4*sqrt(max(U, -U))*sign(U)"])
def test_a_root_of_a_speed_brings_a_block_to_rest(law):
    """2 dv/dt = -4 sqrt(v): sqrt(v) falls by 1 m/s per second, to rest in finite time."""
    _, velocity = moved(law.replace("U", "block.velocity"), speed=4.0)
    expected = np.maximum(2.0 - TIMES, 0.0) ** 2
    assert velocity == pytest.approx(expected, abs=1e-8)


def test_a_root_of_a_position_swings():
    """Energy: the force -30 sqrt(abs(x)) stores 20 abs(x)^1.5."""
    position, velocity = moved("-30*sqrt(abs(X))*sign(X)".replace("X", "block.position"), 0.1, 0.0)
    assert position.min() < -0.099
    energy = velocity**2 + 20 * np.abs(position) ** 1.5
    assert energy == pytest.approx(energy[0], rel=1e-7)
