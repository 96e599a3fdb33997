"""Stops: times of contact and restitution in closed form, ropes that get taut."""

import numpy as np
import pytest
from component_reading import complaints, component

import linkages
from linkages.chaos.evidence import conservative
from linkages.components.stops import AngleStop, GuideStop

CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {cart: {position: 0, speed: 3}}
stops:
"""
ARM = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 0.5, mass: 1.2}}
free: {arm: {angle: 0, speed: 3}}
stops:
"""
OUTPUTS = ["slider_position", "slider_velocity", "spring_force", "potential_energy",
           "energy_residual"]  # fmt: skip


def moved(text, end, samples=201, outputs=OUTPUTS):
    return linkages.simulate(linkages.loads(text), end=end, samples=samples, outputs=outputs).data


def test_same_from_yaml_and_python():
    made = GuideStop(index=0, slider="cart", upper=0.3, stiffness=1e6)
    entry = "- {slider: cart, upper: 30 cm, stiffness: 1 kN/mm}\n"
    assert component(CART + entry, "stops", 0) == made
    angle = AngleStop(index=0, bars=("ground", "arm"), lower=0, upper=np.pi, stiffness=50)
    entry = "- {bars: [ground, arm], lower: 0, upper: 180 deg, stiffness: 50 N*m/rad}\n"
    assert component(ARM + entry, "stops", 0) == angle


def test_back_and_forth_between_two_elastic_stops():
    """Free flight at constant speed, and half a sine of the spring at each end."""
    mechanism = linkages.loads(CART + "- {slider: cart, lower: -0.3, upper: 0.6, stiffness: 2e4}\n")
    rate = 100.0
    period = 2 * (0.9 / 3 + np.pi / rate)
    data = linkages.simulate(
        mechanism, end=3 * period, samples=1001, outputs=OUTPUTS, rtol=1e-11
    ).data
    phase = np.mod(data.time.to_numpy(), period)
    first, touch = 0.6 / 3, np.pi / rate
    second = first + touch + 0.9 / 3
    deep = 3 / rate
    expected = np.select(
        [phase < first, phase < first + touch, phase < second, phase < second + touch],
        [
            3 * phase,
            0.6 + deep * np.sin(rate * (phase - first)),
            0.6 - 3 * (phase - first - touch),
            -0.3 - deep * np.sin(rate * (phase - second)),
        ],
        -0.3 + 3 * (phase - second - touch),
    )
    position = data.slider_position.to_numpy()[:, 0]
    assert position == pytest.approx(expected, abs=1e-8)  # rtol 1e-11, six contacts
    depth = np.maximum(position - 0.6, 0) - np.maximum(-0.3 - position, 0)
    assert data.spring_force.to_numpy()[:, 0] == pytest.approx(-2e4 * depth, abs=1e-6)
    assert data.potential_energy.to_numpy() == pytest.approx(1e4 * depth**2, abs=1e-8)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8
    assert conservative(mechanism)


@pytest.mark.parametrize("share", [0.05, 0.3, 0.9])
def test_restitution_of_a_damped_stop(share):
    """Contact ends where spring and damper push no more: at ẍ = 0, not at zero depth."""
    rate, root = 100.0, np.sqrt(1 - share**2)
    damping = 2 * share * rate * 2.0
    text = CART + f"- {{slider: cart, upper: 0.3, stiffness: 2e4, damping: {damping}}}\n"
    data = moved(text, 0.3)
    turned = np.arctan2(2 * share * root, 2 * share**2 - 1)
    left = np.exp(-share / root * turned) * (np.cos(turned) - share / root * np.sin(turned))
    # steps meet both ends of the contact; rtol 1e-10
    assert data.slider_velocity.to_numpy()[-1, 0] == pytest.approx(3 * left, abs=1e-8)
    assert data.spring_force.to_numpy().max() <= 0  # it never pulls
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8
    assert not conservative(linkages.loads(text))


def test_an_arm_falls_on_its_stop_from_whole_turns_away():
    data = moved(
        ARM.replace("angle: 0", "angle: 360 deg")
        + "- {bars: [ground, arm], upper: 400 deg, stiffness: 1000}\n",
        1.0, outputs=["bar_angle", "bar_speed", "torsional_spring_torque"],
    )  # fmt: skip
    assert data.bar_speed.to_numpy()[-1, 0] == pytest.approx(-3, abs=1e-9)
    rate = np.sqrt(1000 / (1.2 * 0.25 / 3))
    last = 2 * np.deg2rad(400) - np.deg2rad(360) - 3 * (1 - np.pi / rate)
    assert data.bar_angle.to_numpy()[-1, 0] == pytest.approx(last, abs=1e-9)


def test_a_rope_gets_taut_and_goes_slack():
    text = """
joints: {O: [0, 0]}
sliders: {load: {joint: L, through: O, angle: -90 deg, mass: 2}}
gravity: [0, -9.81]
free: {load: {position: 0.2, speed: 0}}
stops: [{between: [O, L], upper: 0.7, stiffness: 5e3}]
"""
    data = moved(text, 2.0, samples=401)
    position = data.slider_position.to_numpy()[:, 0]
    pull = data.spring_force.to_numpy()[:, 0]
    assert pull == pytest.approx(5e3 * np.maximum(position - 0.7, 0), abs=1e-6)
    assert (pull > 0).any()
    assert position.min() == pytest.approx(0.2, abs=1e-4)  # it comes back, between samples
    # the deepest point from the energy: m·g·(0.5 + d) = k·d²/2
    d = (19.62 + np.sqrt(19.62**2 + 2 * 5e3 * 19.62 * 0.5)) / 5e3
    assert position.max() <= 0.7 + d + 1e-9
    assert abs(data.energy_residual.to_numpy()).max() < 1e-7


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{slider: cart, stiffness: 1}", "missing key 'lower' or 'upper'"),
        ("{slider: cart, lower: 1, upper: 0.5, stiffness: 1}", "more than 'lower', 1, found 0.5"),
        ("{slider: cart, upper: 1, stiffness: 0}", "expected a stiffness > 0"),
        ("{slider: cart, upper: 1, stiffness: 1, damping: -1}", "expected a damping >= 0"),
        ("{bars: [ground, arm], upper: 1, stiffness: 1}", "unknown bar 'arm'"),
        ("{between: [O, O], upper: 1, stiffness: 1}", "expected two different joints"),
        ("{slider: cart, upper: 1 rad, stiffness: 1}", "expected a length"),
        ("{slider: cart, upper: 1}", "missing key 'stiffness' or 'restitution'"),
        ("{slider: cart, upper: 1, restitution: 1.1}", "expected at most 1, found 1.1"),
        ("{slider: cart, upper: 1, restitution: -1}", ">= 0"),
        ("{slider: cart, upper: 1, restitution: 1, stiffness: 1}", "expected one of the two"),
        ("{slider: cart, upper: 1, restitution: 1, damping: 1}", "it is for 'stiffness'"),
        ("{slider: cart, upper: 1, stiffness: 1, least_rate: 1}", "it is for 'restitution'"),
        (
            "{slider: cart, upper: 1, stiffness: 1, friction: 0.2}",
            "a wall: expected one under 'con",
        ),
        ("{slider: cart, upper: 1, restitution: 0, friction: 0.2}", "nothing slides along a stop"),
    ],
)
def test_wrong_entries(entry, found):
    assert any(found in problem for problem in complaints(CART + f"- {entry}\n"))
