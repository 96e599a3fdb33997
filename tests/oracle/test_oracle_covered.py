"""Every component is covered by the absolute formulation, or refused by its name."""

from dataclasses import fields

import numpy as np
import pytest
import yaml
from absolute_coordinates import AbsoluteModel
from absolute_covered import COVERED, NotCoveredError
from absolute_outputs import outputs
from kernel_values import at_start, disagreements, state_at

import linkages
from linkages.components.mechanisms.registry import components

BASE = """
gravity: [0, -9.81]
joints: {O: [0, 0], Q: [0, 0.6]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1, center: 0.03, inertia: 0.004}
  rod: {points: {A: [0, 0], B: [0.3, 0], E: [0.2, 0.1]}, mass: 0.5, center: [0.1, 0.02],
        inertia: 0.003}
  arm: {joints: [Q, W], length: 0.2, mass: 0.2}
sliders: {piston: {joint: B, through: O, angle: 0, mass: 0.4, inertia: 0.01}}
assembly: {B: [0.4, 0]}
free: {arm: {angle: 0.3, speed: -2}, crank: {angle: 0.5, speed: 20}}
"""
VALVE = "sliders: {valve: {joint: V, through: [0, 0.9], angle: 90 deg, mass: 0.1}}"
CASES = {
    "mass": ["masses: {E: 0.3}"],
    "weld": ["bars: {hand: {joints: [W, H], length: 0.1, mass: 0.1}}",
             "welds: {W: {bars: [arm, hand], angle: 40 deg}}"],
    "gear": ["free: {arm: }", "gears: [{bars: [crank, arm], ratio: -1.7}]"],
    "rack": [VALVE, "racks: [{bar: arm, slider: valve, radius: 20 mm}]"],
    "rope": [VALVE, "racks: [{sliders: [piston, valve], ratio: 0.5}]"],
    "cam": [VALVE, "cams: [{slider: valve, bar: arm, angles: [0, 2, 4, 360 deg],"
            " lifts: [0, 6 mm, 1 mm, 0], offset: 50 mm}]"],
    "clearance": ["clearances: {c: {joint: A, bar: rod, size: 1 mm, angle: 0.4, speed: 3}}",
                  "dampers: [{clearance: c, damping: 0.01}]"],
    "drive": ["free: {crank: }", "drives: {crank: {angle: 0.3, speed: 5}}"],
    "driven slider": ["free: {crank: }", "drives: {piston: {position: 0.32, speed: 1}}",
                      "assembly: {A: left}"],
    "free slider": ["free: {crank: , piston: {position: 0.32, speed: 1}}", "assembly: {A: left}"],
    "loads": ["loads: [{slider: piston, force: -30}, {joint: E, force: [3, 4]},"
              " {joint: E, 'on': rod, force: [3, 4]}, {between: [E, W], force: 5*cos(t)},"
              " {bar: arm, torque: -0.1*arm.speed}, {bars: [crank, arm], torque: 2}]"],
    "springs": ["springs: [{between: [E, W], stiffness: 50, length: 0.1},"
                " {between: [E, W], force: 3}, {slider: piston, stiffness: 9, position: 0.1},"
                " {between: [E, W], lengths: [0.1, 0.2, 0.5], forces: [0, 1, 4]},"
                " {slider: piston, positions: [0, 0.2, 0.5], forces: [0, 1, 4]},"
                " {between_bars: [crank, arm], angles: [-1, 0, 2], torques: [-1, 0, 3]},"
                " {bar: arm, stiffness: 3, angle: 2},"
                " {between_bars: [crank, arm], stiffness: 2, angle: 1, damping: 0.1}]"],
    "dampers": ["dampers: [{between: [E, W], damping: 3}, {slider: piston, damping: 2},"
                " {joint: A, damping: 0.1}, {bars: [crank, arm], damping: 0.2}]"],
    "controllers": ["controllers: {a: {bar: arm, of: arm.speed, setpoint: 3, proportional: 2},"
                    " b: {slider: piston, of: piston.position, setpoint: 0.3, proportional: 9},"
                    " c: {between: [E, W], of: arm.angle, setpoint: 1, derivative: 8}}"],
    "counterweight": ["counterweights: {w: {bar: arm, joint: Q, mass: 0.3, distance: 0.1}}"],
    "cylinders": ["cylinders: {a: {between: [E, W], bore: 20 mm, pressure: 3 bar},"
                  " b: {between: [E, W], gas_pressure: 2 bar, length: 0.8, bore: 15 mm,"
                  " volume: 1 L}}"],
    "motors": ["motors: {a: {bar: arm, stall_torque: 3, no_load_speed: 20},"
               " b: {bar: crank, voltage: 12, torque_constant: 0.1, resistance: 2}}"],
    "parameters": ["parameters: {k: 3}", "loads: [{bar: arm, torque: k*sin(arm.angle)}]"],
    "sliding": ["friction: [{joint: O, torque: 0.1},"
                " {slider: piston, force: 2, static: 3, stribeck_speed: 0.1},"
                " {between: [E, W], force: 1, slip_speed: 0.1},"
                " {between_bars: [crank, arm], torque: 0.2}]"],
    "pressed": ["friction: [{joint: O, coefficient: 0.2, radius: 30 mm, slip_speed: 0.1},"
                " {joint: A, coefficient: 0.2, radius: 20 mm, slip_speed: 0.1},"
                " {joint: B, coefficient: 0.25, radius: 20 mm, slip_speed: 0.1},"
                " {slider: piston, coefficient: 0.3, slip_speed: 0.01}]"],
    "stops": ["stops: [{slider: piston, lower: 0.5, stiffness: 1e3, damping: 3},"
              " {bars: [ground, arm], upper: 0.2, stiffness: 1e3},"
              " {between: [E, W], upper: 0.3, stiffness: 1e3}]"],
    "targets": ["targets: {wanted: {points: [[0.2, 0.1], [0.3, 0.1]]}}"],
    "options": ["simulate: {end: 1}"],
}  # fmt: skip
REFUSED = {
    "clearances.c: Contact": ["clearances: {c: {joint: A, bar: rod, size: 1 mm,"
                              " contact: kelvin-voigt, stiffness: 1e6, damping: 10}}"],
    "clearances.g: Play": ["clearances: {g: {slider: piston, size: 1 mm, length: 0.1, height: 0.05,"
                           " contact: kelvin-voigt, stiffness: 1e6, damping: 10}}"],
    "contacts.tip: Contact": ["contacts: {tip: {body: rod, points: [B], through: O, angle: -3,"
                              " contact: kelvin-voigt, stiffness: 1e6, damping: 10}}"],
    "cams[0]: Contact": [VALVE, "cams: [{slider: valve, bar: arm, angles: [0, 2, 4, 360 deg],"
                         " lifts: [0, 6 mm, 1 mm, 0], offset: 50 mm, contact: kelvin-voigt,"
                         " stiffness: 1e6, damping: 10}]", "free: {valve: {position: 55 mm}}"],
    "controllers.a: internal state": ["controllers: {a: {bar: arm, of: arm.speed, setpoint: 3,"
                                      " proportional: 2, integral: 1}}"],
    "motors.a: internal state": ["motors: {a: {bar: arm, voltage: 12, torque_constant: 0.1,"
                                 " resistance: 2, inductance: 0.1}}"],
    "friction[0]: internal state": ["friction: [{joint: O, torque: 0.1, bristle_stiffness: 9}]"],
    "maxwell[0]: internal state": ["maxwell: [{bar: arm, stiffness: 5, damping: 0.4},"
                                   " {between: [E, W], stiffness: 5, damping: 0.4},"
                                   " {slider: piston, stiffness: 5, damping: 0.4},"
                                   " {between_bars: [crank, arm], stiffness: 5, damping: 1}]"],
    "drives.E: guided": ["free: {crank: }", "drives: {E: {x: 0.27 + 0.1*t}}",
                         "assembly: {A: [0.07, 0.07]}"],
    "drives.A: guided": ["free: {crank: }", "drives: {A: {y: 0.05 + 0.2*t}}",
                         "assembly: {A: [0.07, 0.07]}"],
    "drives.H: guided": ["bars: {hand: {joints: [W, H], length: 0.15, mass: 0.1}}", "free: {arm: }",
                         "drives: {H: {waypoints: [[0.2, 0.7], [0.1, 0.8]], progress: 0.3 + t}}",
                         "assembly: {W: left}"],
    "actuators.a: Actuation": ["drives: {crank: {angle: 0.3, speed: 5}}", "free: {crank: }",
                               "actuators: {a: {slider: piston}}"],
    "actuators.b: Actuation": ["drives: {crank: {angle: 0.3, speed: 5}}", "free: {crank: }",
                               "actuators: {b: {between: [Q, B]}}"],
    "actuators.c: Actuation": ["drives: {crank: {angle: 0.3, speed: 5}}", "free: {crank: }",
                               "actuators: {c: {bar: rod}}"],
    "actuators.d: Actuation": ["drives: {crank: {angle: 0.3, speed: 5}}", "free: {crank: }",
                               "actuators: {d: {bars: [crank, rod]}}"],
    "states.lag: InternalState": ["states: {lag: {rate: arm.speed - lag.value}}"],
    "states.held: InternalState": ["states: {held: {next: arm.speed, period: 0.1}}"],
    "stops[0]: End": ["stops: [{slider: piston, lower: 0, restitution: 0.5}]"],
    "friction[0]: sign of zero": ["free: {arm: {angle: 0.3, speed: 0}}",
                                  "friction: [{joint: Q, torque: 0.1}]"],
}  # fmt: skip


def mechanism(entries):
    """The base with more entries; an empty one of a mapping goes."""
    content = yaml.safe_load(BASE)
    for section, more in (item for text in entries for item in yaml.safe_load(text).items()):
        if isinstance(more, dict):
            merged = {**content.get(section, {}), **more}
            content[section] = {key: value for key, value in merged.items() if value is not None}
        else:
            content[section] = more
    return linkages.loads(yaml.safe_dump(content, sort_keys=False))


def compared(given):
    """What differs at t = 0; an effort of a drive depends on all loads."""
    found, model = at_start(given), AbsoluteModel(given)
    expected = outputs(model, model.solve(state_at(model, found, 0.0)))
    return disagreements(found, expected, 1e-11)


@pytest.mark.parametrize("case", CASES)
def test_what_is_covered_agrees(case):
    assert not compared(mechanism(CASES[case]))


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_not_covered_is_refused_by_its_name(message):
    with pytest.raises(NotCoveredError) as caught:
        compared(mechanism(REFUSED[message]))
    assert str(caught.value) == message


def test_every_component_is_covered_or_refused():
    entries = [*CASES.values(), *REFUSED.values()]
    tried = {type(one).__name__ for case in entries for one in mechanism(case).components}
    assert tried == set(components())


@pytest.mark.parametrize("term", COVERED, ids=lambda term: term.__name__)
def test_terms_have_no_field_that_the_formulation_does_not_know(term):
    assert {field.name for field in fields(term)} == COVERED[term]


def test_power_of_friction_that_follows_a_reaction():
    """What the drive of a walking leg needs for a joint is µ R |reaction| tanh(ω/v) ω."""
    coefficient, radius, slip = 0.1, 8e-3, 0.1
    friction = {"joint": "W", "coefficient": coefficient, "radius": radius, "slip_speed": slip}
    found = []
    for one in (linkages.load("jansen"), linkages.load("jansen", set={"friction": [friction]})):
        assert not compared(one)
        model = AbsoluteModel(one)
        state = state_at(model, at_start(one), 0.0)
        found.append(outputs(model, model.solve(state)))
    turning = [name for name, body in one.bodies.items() if "W" in body.points]
    first, second = (state.speed(name) for name in turning)
    relative, reaction = first - second, np.hypot(*found[1]["joint_reaction"]["W"])
    lost = coefficient * radius * reaction * np.tanh(relative / slip) * relative
    (crank,) = one.prescribed
    before, after = (float(values["drive_effort"][crank]) for values in found)
    # of an effort of about 1 N m with a dozen roundings
    assert (after - before) * state.speed(crank) == pytest.approx(lost, abs=1e-13)
    assert lost > 1e-4
