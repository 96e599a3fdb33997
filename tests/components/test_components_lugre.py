"""LuGre friction: stiffness before sliding, steady friction, stick and slip, energy, messages."""

import numpy as np
import pytest
from component_reading import complaints
from scipy.integrate import solve_ivp

import linkages

WHEEL = """
joints: {O: [0, 0]}
bars: {wheel: {points: {O: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}}
HOW: {wheel: {angle: 0, speed: SPEED}}
friction:
  - {joint: O, torque: 0.5, static: 0.8, stribeck_speed: 0.2,
     bristle_stiffness: 400, bristle_damping: 1.5}
"""
BLOCK = """
joints: {O: [0, 0], P: [-1, 0]}
bars: {belt: {joints: [P, Q], length: 0.1}}
sliders: {block: {joint: B, through: O, angle: 0, mass: 2}}
drives: {belt: {angle: 0, speed: 0}}
free: {block: {position: 0, speed: 0}}
springs: [{slider: block, stiffness: 100}]
loads: [{slider: block, force: "12*sin(5*t)"}]
friction:
  - {slider: block, force: 4, static: 6, stribeck_speed: 10 mm/s,
     bristle_stiffness: 5e4, bristle_damping: 100}
"""


def driven(speed):
    return WHEEL.replace("HOW", "drives").replace("SPEED", str(speed))


@pytest.mark.parametrize("speed", [0.05, 0.4, -3.0])
def test_sliding_at_a_constant_speed(speed):
    """z = g/σ0 (1 - exp(-σ0 |v| t/g)) sign(v), with g of Stribeck's curve."""
    end = 0.05 / abs(speed)
    mechanism, outputs = linkages.loads(driven(speed)), ["internal_state", "drive_effort"]
    data = linkages.simulate(mechanism, end=end, samples=21, outputs=outputs).data
    level = 0.5 + 0.3 * np.exp(-((speed / 0.2) ** 2))
    grown = 1 - np.exp(-400 * abs(speed) * data.time.to_numpy() / level)
    bent = np.sign(speed) * level / 400 * grown
    found = data.internal_state.sel(internal="friction[0].bristle").to_numpy()
    assert found == pytest.approx(bent, abs=1e-12)  # rtol 1e-10 of 2 mrad
    pulled = 400 * bent + 1.5 * speed * (1 - grown)
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(pulled, abs=1e-9)


def test_stiffness_before_sliding():
    """Small oscillations: J θ'' + (σ0 + σ1 d/dt) θ = 0, for bristles hardly slide at 1 mrad/s."""
    text = WHEEL.replace("HOW", "free").replace("SPEED", "1e-5")
    data = linkages.simulate(linkages.loads(text), end=0.2, samples=21).data
    damping, rate = 1.5 / 0.04, np.sqrt(400 / 0.02 - (1.5 / 0.04) ** 2)
    time = data.time.to_numpy()
    expected = 1e-5 / rate * np.exp(-damping * time) * np.sin(rate * time)
    # what slides: σ0 |v| z/g beside v, 400·1e-7/0.8 at most
    assert data.bar_angle.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-11)


@pytest.mark.slow
def test_stick_and_slip_on_a_spring():
    """Against SciPy; energy that bristles store comes back, all else is lost."""
    mechanism = linkages.loads(BLOCK)
    outputs = ["slider_position", "internal_state", "spring_force", "energy_residual"]
    data = linkages.simulate(mechanism, end=3.0, samples=31, outputs=outputs).data

    def motion(t, y):
        x, v, z = y
        level = 4 + 2 * np.exp(-((v / 0.01) ** 2))
        rate = v - 5e4 * abs(v) * z / level
        return [v, (12 * np.sin(5 * t) - 100 * x - 5e4 * z - 100 * rate) / 2, rate]

    own = solve_ivp(
        motion, (0, 3), [0, 0, 0], t_eval=data.time, rtol=1e-10, atol=1e-13, method="Radau"
    )
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(own.y[0], abs=3e-8)
    assert data.internal_state.to_numpy()[:, 0] == pytest.approx(own.y[2], abs=3e-8)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8  # of 0.5 J
    held = linkages.simulate(mechanism, times=np.linspace(0.001, 0.08, 20)).data
    # 12 sin(0.4) = 4.7 N is less than what breaks away: bristles creep, but hold the block
    # within twice what 4.7 N bend them by
    assert abs(held.slider_position.to_numpy()).max() < 2e-4


def test_limit_of_stiff_bristles():
    """Coulomb's friction: a wheel that coasts stops after J ω/M."""
    plain = """
joints: {O: [0, 0]}
bars: {wheel: {points: {O: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}}
free: {wheel: {angle: 0, speed: 10}}
friction: [{joint: O, torque: 0.5, bristle_stiffness: STIFF, bristle_damping: DAMP}]
"""
    errors = []
    for stiff in (1e3, 1e5):
        text = plain.replace("STIFF", str(stiff)).replace("DAMP", str(0.2 * (stiff / 1e3) ** 0.5))
        data = linkages.simulate(linkages.loads(text), end=0.4, samples=3, rtol=1e-8).data
        errors.append(abs(data.bar_angle.item(-1) - 0.5 * 0.02 * 100 / 0.5))
    # bristles bend by 0.5/σ0 first, 0.5 mrad of 2 rad, and damping is felt over that way
    assert errors[0] < 5e-3
    assert errors[1] < errors[0] / 5


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("torque: 1, bristle_stiffness: 0", "expected a torsional stiffness > 0"),
        ("torque: 0, bristle_stiffness: 5", "friction[0].torque: expected > 0"),
        ("torque: 1, bristle_damping: 5", "expected 'bristle_stiffness' with it"),
        ("torque: 1, bristle_stiffness: 5, slip_speed: 1", "expected no 'slip_speed' with them"),
        ("torque: 1, static: 0.5, stribeck_speed: 1, bristle_stiffness: 5", "expected at least 1"),
    ],
)
def test_wrong_entries(entry, found):
    text = WHEEL.split("friction:")[0].replace("HOW", "free").replace("SPEED", "1")
    assert found in complaints(f"{text}friction: [{{joint: O, {entry}}}]\n")[0]
