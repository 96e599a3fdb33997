"""Racks, rolling wheels and ropes against closed forms.

References
----------
.. [1] Rolling without slipping: the wheel turns by −s/r, a point of it moves along a cycloid.
"""

import numpy as np
import pytest
from component_reading import complaints, component

import linkages
from linkages.components.transmissions import Rack

PAIR = """
joints: {O: [0, 0]}
bars: {pinion: {points: {O: [0, 0], P: [0.05, 0]}, mass: 2, center: [0, 0], inertia: 0.004}}
sliders: {rack: {joint: R, through: [0, 0.05], mass: 3}}
KNOWN
racks:
"""
FREE = PAIR.replace("KNOWN", "free: {pinion: {angle: 1, speed: 2}}")
OUTPUTS = ["bar_angle", "bar_speed", "slider_position", "slider_velocity", "slider_acceleration",
           "kinetic_energy", "energy_residual"]  # fmt: skip


def moved(text, end=1.0, outputs=(), **more):
    mechanism = linkages.loads(text)
    return linkages.simulate(
        mechanism, end=end, samples=21, outputs=[*OUTPUTS, *outputs], **more
    ).data


def test_same_from_yaml_and_python():
    made = Rack(index=0, slider="rack", bar="pinion", radius=-0.05, offset=0.1)
    entry = "- {slider: rack, bar: pinion, radius: -50 mm, offset: 10 cm}\n"
    assert component(FREE + entry, "racks", 0) == made


@pytest.mark.parametrize(
    "known",
    ["free: {pinion: {angle: 1, speed: 2}}", "free: {rack: {position: 0.05, speed: -0.1}}"],
)
def test_pulled_rack_turns_its_pinion(known):
    """A constant force, m + J/r² to move; the same whichever coordinate is the free one."""
    text = PAIR.replace("KNOWN", known)
    text += "- {slider: rack, bar: pinion, radius: -50 mm, offset: 10 cm}\n"
    data = moved(text + "loads: [{slider: rack, force: 4}]\n")
    acceleration = 4 / (3 + 0.004 / 0.05**2)
    time = data.time.to_numpy()
    expected = 0.05 - 0.1 * time + 0.5 * acceleration * time**2
    # polynomials in time: round-off of 1 m and of 20 rad
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-13)
    assert data.slider_acceleration.to_numpy()[:, 0] == pytest.approx(np.full(21, acceleration))
    assert data.bar_angle.to_numpy()[:, 0] == pytest.approx((expected - 0.1) / -0.05, abs=2e-12)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-12


def test_driven_pinion_needs_the_torque_of_its_rack():
    text = PAIR.replace("KNOWN", "drives: {pinion: {law: 3*t**2}}")
    text += "- {slider: rack, bar: pinion, radius: 0.05}\nloads: [{slider: rack, force: -7}]\n"
    data = moved(text, outputs=["drive_effort"])
    effort = (0.004 + 3 * 0.05**2) * 6 + 7 * 0.05
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(np.full(21, effort), rel=1e-12)


def test_a_wheel_rolls_down_a_slope():
    """g·sin(slope)/(1 + J/(m·r²)), and a point of its rim moves along a cycloid [1]_."""
    text = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {wheel: {points: {C: [0, 0], P: [0, -0.2]}, mass: 5, center: [0, 0], inertia: 0.1}}
sliders: {centre: {joint: C, through: O, angle: -30 deg}}
racks: [{slider: centre, bar: wheel, radius: -0.2, offset: 1}]
free: {centre: {position: 1, speed: 0}}
"""
    data = moved(text, end=2.0, outputs=["joint_position"])
    way = 0.5 * 9.81 * 0.5 / (1 + 0.1 / (5 * 0.04)) * data.time.to_numpy() ** 2
    # rtol 1e-10 of the 6 m and 30 rad that it goes
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(1 + way, abs=1e-9)
    slope, turned = np.deg2rad(-30), -way / 0.2 - np.pi / 2
    for axis, along, rim in zip("xy", (np.cos, np.sin), (np.cos, np.sin), strict=True):
        place = (1 + way) * along(slope) + 0.2 * rim(turned)
        found = data.joint_position.sel(joint="P", axis=axis).to_numpy()
        assert found == pytest.approx(place, abs=1e-8)


def test_a_wheel_within_a_loop():
    """A crank pushes a wheel that rolls: its turns are those of its way, over many revolutions."""
    text = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {joints: [A, P], length: 1}
  wheel: {points: {C: [0, 0], P: [0.02, 0]}, mass: 1, center: [0, 0], inertia: 1e-3}
sliders: {centre: {joint: C, through: O, mass: 1}}
racks: [{slider: centre, bar: wheel, radius: -0.05, offset: 1.0}]
drives: {crank: {angle: 0.5, speed: 20}}
assembly: {P: [1.25, 0.02]}
"""
    data = moved(text, outputs=["joint_position", "closure_residual"])
    way = data.slider_position.to_numpy()[:, 0]
    assert np.ptp(way) > 0.5  # more than a turn and a half of the wheel
    angle = data.bar_angle.sel(bar="wheel").to_numpy()
    assert way == pytest.approx(1.0 - 0.05 * angle, abs=1e-12)
    ends = (data.joint_position.sel(joint=name).to_numpy() for name in ("A", "P"))
    first, second = ends
    assert np.hypot(*(second - first).T) == pytest.approx(np.ones(21), abs=1e-12)
    assert data.closure_residual.to_numpy().max() < 1e-12


def test_atwoods_weights_on_a_rope():
    """Block and tackle: the weight at the loose end goes twice as fast, the other way."""
    text = """
gravity: [0, -9.81]
joints: {O: [0, 0], Q: [0.2, 0]}
sliders:
  hook: {joint: H, through: O, angle: 90 deg, mass: 3}
  end: {joint: E, through: Q, angle: 90 deg, mass: 2}
free: {end: {position: -1, speed: 0}}
racks: [{sliders: [hook, end], ratio: -2, offset: -3}]
"""
    outputs = ["slider_position", "energy_residual"]
    data = linkages.simulate(linkages.loads(text), end=1.0, samples=21, outputs=outputs).data
    acceleration = -9.81 * (2 - 3 / 2) / (2 + 3 / 4)
    end = -1 + 0.5 * acceleration * data.time.to_numpy() ** 2
    assert data.slider_position.sel(slider="end").to_numpy() == pytest.approx(end, abs=1e-12)
    hook = data.slider_position.sel(slider="hook").to_numpy()
    assert hook == pytest.approx((end + 3) / -2, abs=1e-12)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-11


def test_a_rack_on_an_arm_that_turns():
    """Its pinion stands still against the ground: the rack moves as the arm turns around it."""
    text = """
joints: {O: [0, 0]}
bars:
  arm: {joints: [O, E], length: 0.5, mass: 1}
  sun: {points: {O: [0, 0], S: [0.1, 0]}}
sliders: {rack: {joint: R, on: arm, through: [0.1, 0.1], mass: 2}}
racks: [{slider: rack, bar: sun, radius: -0.1, carrier: arm, offset: 0.2}]
drives: {arm: {angle: 0, speed: 3}, sun: {angle: 0, speed: 0}}
"""
    data = moved(text)
    expected = 0.2 + 0.1 * 3 * data.time.to_numpy()
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{slider: pinion, bar: pinion, radius: 1}", "unknown slider 'pinion'"),
        ("{slider: rack, bar: rack, radius: 1}", "unknown bar 'rack'"),
        ("{slider: rack, bar: pinion, radius: 0}", "expected a radius other than 0"),
        ("{slider: rack, bar: pinion, radius: 1, carrier: pinion}", "expected another body than"),
        ("{slider: rack, bar: pinion, radius: 1 rad}", "expected a length"),
        ("{sliders: [rack, rack], ratio: 1}", "expected two different sliders"),
        ("{sliders: [rack, rock], ratio: 1}", "did you mean 'rack'?"),
        ("{slider: rack, bar: pinion}", "missing key 'radius'"),
    ],
)
def test_wrong_entries(entry, found):
    assert any(found in problem for problem in complaints(FREE + f"- {entry}\n"))


def test_the_carrier_is_that_of_the_slider():
    text = FREE.replace("bars: {", "bars: {arm: {joints: [O, E], length: 1}, ")
    (problem,) = complaints(text + "- {slider: rack, bar: pinion, radius: 1, carrier: arm}\n")
    assert "expected what carries the axis of 'rack': ground, found arm" in problem


def test_both_cannot_be_given():
    known = "drives: {pinion: {angle: 0, speed: 1}, rack: {position: 0, speed: 1}}"
    (problem,) = complaints(
        PAIR.replace("KNOWN", known) + "- {slider: rack, bar: pinion, radius: 1}\n"
    )
    assert "'pinion' follows from this relation and is driven" in problem
