"""Numbers of motors, cylinders, racks, cams, stops and frictions are bound as those of a file."""

import numpy as np
import pytest

import linkages
from linkages.kernel.system import System
from linkages.kernel.varying import Varying

ALL = """
gravity: [0, -9.81]
joints: {O: [0, 0], H: [0.7, 0.1]}
bars:
  upper: {joints: [O, A], length: 0.4, mass: 1}
  lower: {joints: [A, B], length: 0.3, mass: 0.7}
sliders:
  cart: {joint: C, through: H, angle: 30 deg, mass: 2}
  lift: {joint: L, through: [0.1, 0], angle: 90 deg, mass: 0.4}
  valve: {joint: V, through: O, angle: 90 deg, mass: 0.2}
free:
  upper: {angle: -1, speed: 1}
  lower: {angle: 0.2, speed: 0}
  cart: {position: 0.1, speed: 0.1}
springs:
  - {slider: cart, stiffness: 200, position: 5 cm, damping: 1}
  - {between: [H, B], force: 30, damping: 0.5}
loads:
  - {joint: B, on: lower, force: [3, 2]}
  - {between: [O, B], force: "20*sin(3*t)"}
cylinders:
  push: {between: [O, B], bore: 20 mm, rod: 10 mm, pressure: 1 bar, rod_pressure: 0.2 bar}
  gas: {between: [H, B], bore: 22 mm, gas_pressure: 8 bar, length: 0.8, volume: 300 cm^3}
motors:
  line:
    {bar: lower, against: upper, stall_torque: 0.5, no_load_speed: 1500 rpm, gear_ratio: 3,
     rotor_inertia: 3e-5, joint: A}
  electric: {bar: upper, voltage: 12, torque_constant: 0.05, resistance: 1.2, gear_ratio: 2}
racks: [{slider: lift, bar: upper, radius: 0.1, offset: 0.05}]
cams:
  - {slider: valve, bar: upper, angles: [0, 1, 2, 3.5, 5, 360 deg],
     lifts: [0, 0.01, 0.03, 0.04, 0.02, 0], offset: 0.03, base_radius: 0.04}
stops: [{slider: cart, lower: 0.2, upper: 0.9, stiffness: 500, damping: 3}]
friction: [{slider: cart, force: 3, static: 4, stribeck_speed: 0.1}, {joint: O, torque: 0.2}]
"""
CHANGES = {
    "springs[0].position": 0.2,
    "springs[1].force": 12.0,
    "cylinders.push.bore": 0.03,
    "cylinders.push.pressure": "3 bar",
    "cylinders.gas.volume": 4e-4,
    "cylinders.gas.exponent": 1.2,
    "motors.line.gear_ratio": -4.0,
    "motors.line.rotor_inertia": 6e-5,
    "motors.electric.resistance": 2.0,
    "racks[0].radius": -0.2,
    "racks[0].offset": 0.3,
    "cams[0].offset": 0.1,
    "cams[0].base_radius": 0.05,
    "stops[0].lower": 0.4,
    "stops[0].stiffness": 900.0,
    "friction[0].stribeck_speed": 0.3,
    "friction[1].torque": 0.7,
}


@pytest.fixture(scope="module")
def varying():
    found = Varying(linkages.loads(ALL))
    found.built({})  # all that follows is bound to its structure
    return found


def answers(system):
    model = system.model
    outputs = [*model.free_accelerations, model.power, model.potential_energy]
    return system.evaluate(outputs)[:, 0]


@pytest.mark.slow_except("springs*", "stops*", "motors*")
@pytest.mark.parametrize("path", CHANGES)
def test_a_number_is_that_of_a_file(varying, path):
    change = {path: CHANGES[path]}
    bound = varying.at(change)
    fresh = System(varying.mechanism.with_values(change))
    assert bound.structure is varying.base.system.structure
    np.testing.assert_array_equal(bound.parameters, fresh.parameters)
    np.testing.assert_array_equal(answers(bound), answers(fresh))
    if "base_radius" not in path:  # an output alone depends on that
        assert not np.array_equal(answers(bound), answers(varying.at({})))


def test_all_is_written_as_it_was_read():
    mechanism = linkages.loads(ALL)
    assert linkages.loads(mechanism.to_yaml()) == mechanism
    rebuilt = linkages.Mechanism(components=mechanism.components, name=mechanism.name)
    assert linkages.loads(rebuilt.to_yaml()) == mechanism


def test_all_of_it_keeps_the_balance_of_energy():
    data = linkages.simulate(
        linkages.loads(ALL), end=1.0, samples=11, outputs=["energy_residual", "kinetic_energy"]
    ).data
    # a lift's third derivative jumps at its angles, which steps of order 8 feel
    size = float(data.kinetic_energy.max())
    assert float(abs(data.energy_residual).max()) < 1e-5 * size
