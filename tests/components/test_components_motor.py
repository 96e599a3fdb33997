"""Direct-current motors: run-up in closed form, momentum with the rotor, energy."""

import numpy as np
import pytest
from component_reading import complaints, component
from scipy.linalg import expm

import linkages
from linkages.chaos.evidence import conservative
from linkages.components.actuators import ElectricMotor, Motor

WHEEL = """
joints: {O: [0, 0]}
bars: {wheel: {points: {O: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}}
free: {wheel: {angle: 0, speed: 0}}
motors:
"""
LINE = "  m: {bar: wheel, stall_torque: 0.6, no_load_speed: 2400 rpm, gear_ratio: RATIO, ROTOR}\n"
NO_LOAD, STALL = 80 * np.pi, 0.6


def test_same_from_yaml_and_python():
    made = Motor(name="m", bar="wheel", stall_torque=0.6, no_load_speed=NO_LOAD, gear_ratio=5)
    text = WHEEL + LINE.replace("RATIO, ROTOR", "5")
    assert component(text, "motors", "m") == made
    electric = ElectricMotor(name="m", bar="wheel", voltage=24, torque_constant=0.1, resistance=0.5)
    entry = "  m: {bar: wheel, voltage: 24 V, torque_constant: 0.1 V*s/rad, resistance: 500 mohm}\n"
    assert component(WHEEL + entry, "motors", "m") == electric


@pytest.mark.parametrize("ratio", [1.0, 5.0, -3.0])
@pytest.mark.parametrize("rotor", [0.0, 4e-4])
def test_run_up_of_a_wheel(ratio, rotor):
    more = f"rotor_inertia: {rotor}, joint: O"
    text = WHEEL + LINE.replace("RATIO", str(ratio)).replace("ROTOR", more)
    mechanism = linkages.loads(text)
    outputs = ["bar_speed", "load_torque", "load_power", "energy_residual"]
    data = linkages.simulate(mechanism, end=1.0, samples=21, outputs=outputs).data
    inertia = 0.02 + ratio**2 * rotor
    rise = inertia * NO_LOAD / (ratio**2 * STALL)
    share = np.exp(-data.time.to_numpy() / rise)
    speed = NO_LOAD / ratio * (1 - share)
    found = data.bar_speed.sel(bar="wheel").to_numpy()
    assert found == pytest.approx(speed, abs=1e-9 * NO_LOAD)  # rtol 1e-10
    torque = data.load_torque.sel(torque="motors.m").to_numpy()
    assert torque == pytest.approx(ratio * STALL * share, abs=1e-9 * STALL * abs(ratio) * 10)
    if rotor:
        turned = data.bar_speed.sel(bar="m").to_numpy()
        assert turned == pytest.approx(ratio * found, abs=1e-10 * NO_LOAD)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-7
    assert not conservative(mechanism)


def test_a_voltage_in_time():
    """J·dω/dt = k·(U(t) − k·ω)/R with U = a·t, from rest: a straight line and what lags behind."""
    entry = '  m: {bar: wheel, voltage: "6*t", torque_constant: 0.2, resistance: 0.5}\n'
    data = linkages.simulate(
        linkages.loads(WHEEL + entry), end=2.0, samples=21, outputs=["bar_speed"]
    ).data
    lag, time = 0.02 * 0.5 / 0.04, data.time.to_numpy()
    expected = 30 * (time - lag * (1 - np.exp(-time / lag)))
    assert data.bar_speed.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-8)


def test_a_motor_between_two_bodies_keeps_their_momentum():
    """Its rotor turns with what carries it, and n times as fast against that."""
    text = """
joints: {O: [0, 0]}
bars:
  frame: {points: {O: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.03}
  wheel: {points: {O: [0, 0], Q: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}
free: {frame: {angle: 0, speed: 3}, wheel: {angle: 0, speed: -1}}
motors:
  m:
    {bar: wheel, against: frame, stall_torque: 0.6, no_load_speed: 250, gear_ratio: 4,
     rotor_inertia: 5e-4, joint: O}
"""
    outputs = ["bar_speed", "kinetic_energy", "energy_residual"]
    data = linkages.simulate(linkages.loads(text), end=1.0, samples=11, outputs=outputs).data
    frame, wheel, rotor = (data.bar_speed.sel(bar=n).to_numpy() for n in ("frame", "wheel", "m"))
    assert rotor == pytest.approx(frame + 4 * (wheel - frame), abs=1e-9)
    momentum = 0.03 * frame + 0.02 * wheel + 5e-4 * rotor
    assert momentum == pytest.approx(np.full(11, momentum[0]), abs=1e-9)
    energy = 0.5 * (0.03 * frame**2 + 0.02 * wheel**2 + 5e-4 * rotor**2)
    assert data.kinetic_energy.to_numpy() == pytest.approx(energy)
    assert wheel[-1] - frame[-1] > 40  # 250 rad/s over four, nearly reached
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{bar: weel, stall_torque: 1, no_load_speed: 9}", "did you mean 'wheel'?"),
        ("{bar: wheel, stall_torque: 1, no_load_speed: -9}", "of the same sign, not 0"),
        ("{bar: wheel, stall_torque: 0, no_load_speed: 9}", "of the same sign, not 0"),
        ("{bar: wheel, stall_torque: 1}", "missing key 'no_load_speed'"),
        (
            "{bar: wheel, stall_torque: 1, no_load_speed: 9, gear_ratio: 0}",
            "motors.m.gear_ratio: expected a ratio other than 0",
        ),
        (
            "{bar: wheel, against: wheel, stall_torque: 1, no_load_speed: 9}",
            "expected another body than 'wheel'",
        ),
        (
            "{bar: wheel, stall_torque: 1, no_load_speed: 9, rotor_inertia: 1e-4}",
            "missing key 'joint': the rotor needs a place, a joint of 'wheel'",
        ),
        (
            "{bar: wheel, stall_torque: 1, no_load_speed: 9, rotor_inertia: 1e-4, joint: C}",
            "bar 'wheel' has no joint 'C'; it has O, P",
        ),
        ("{bar: wheel, voltage: 9 A, torque_constant: 1, resistance: 1}", "expected a voltage"),
        (
            "{bar: wheel, voltage: 9, torque_constant: 1, resistance: 0}",
            "expected a resistance > 0",
        ),
    ],
)
def test_wrong_entries(entry, found):
    problems = complaints(WHEEL + f"  m: {entry}\n")
    assert found in problems[0]


def test_a_current_rises_in_a_locked_motor():
    """U/R (1 - exp(-R t/L)), with nothing else integrated."""
    held = WHEEL.replace(
        "free: {wheel: {angle: 0, speed: 0}}", "drives: {wheel: {angle: 0, speed: 0}}"
    )
    entry = """
  m: {bar: wheel, voltage: 24 V, torque_constant: 0.1, resistance: 0.5 ohm, inductance: 20 mH,
      gear_ratio: 3, current: 5 A}
"""
    outputs = ["internal_state", "drive_effort"]
    data = linkages.simulate(
        linkages.loads(held + entry), end=0.2, samples=21, outputs=outputs
    ).data
    rest = 24 / 0.5
    expected = rest + (5 - rest) * np.exp(-data.time.to_numpy() * 0.5 / 0.02)
    found = data.internal_state.sel(internal="motors.m.current").to_numpy()
    assert found == pytest.approx(expected, abs=5e-9)  # rtol 1e-10 of 48 A
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(-3 * 0.1 * expected, abs=2e-9)


@pytest.mark.slow
@pytest.mark.parametrize("rotor", [0.0, 4e-4])
def test_run_up_with_inductance(rotor):
    """Speed and current are linear; without inductance the current follows at once."""
    entry = f"""
  m: {{bar: wheel, voltage: 24, torque_constant: 0.1, resistance: 0.5, inductance: INDUCTANCE,
      gear_ratio: 3, rotor_inertia: {rotor}, joint: O}}
"""
    outputs = ["bar_speed", "internal_state", "load_torque", "energy_residual", "load_power"]
    options = {"end": 1.0, "samples": 11, "outputs": outputs}
    mechanism = linkages.loads(WHEEL + entry.replace("INDUCTANCE", "0.02"))
    data = linkages.simulate(mechanism, **options).data
    inertia = 0.02 + 9 * rotor
    matrix = np.array([[0, 0.3 / inertia], [-0.3 / 0.02, -0.5 / 0.02]])
    rest = np.array([24 / 0.3, 0.0])
    expected = np.array([expm(matrix * t) @ -rest + rest for t in data.time.to_numpy()])
    wheel = data.bar_speed.sel(bar="wheel").to_numpy()
    found = np.array([wheel, data.internal_state.to_numpy()[:, 0]]).T
    assert found == pytest.approx(expected, abs=2e-8)
    assert data.load_torque.sel(torque="motors.m").to_numpy() == pytest.approx(0.3 * found[:, 1])
    assert abs(data.energy_residual.to_numpy()).max() < 1e-7
    quick = linkages.loads(WHEEL + entry.replace("INDUCTANCE", "1e-6"))
    plain = linkages.loads(WHEEL + entry.replace("inductance: INDUCTANCE,", ""))
    options["outputs"] = ["bar_speed"]
    ends = [
        linkages.simulate(m, **options, method="radau").data.bar_speed.to_numpy()[:, 0]
        for m in (quick, plain)
    ]
    assert ends[0] == pytest.approx(ends[1], abs=1e-2)  # L/R is 2 µs, times 360 rad/s²
    assert not conservative(mechanism)


def test_a_current_at_the_start_needs_an_inductance():
    entry = "  m: {bar: wheel, voltage: 9, torque_constant: 1, resistance: 1, current: 2}\n"
    assert "without 'inductance' the current follows" in complaints(WHEEL + entry)[0]
