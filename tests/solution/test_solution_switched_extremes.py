"""Extremes beside a change of mode, where rates of some order jump between two samples."""

import numpy as np
import pytest

import linkages
from linkages.components.mechanisms.definition import loads

BLOCK = """
gravity: [0, 0]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [B, C], length: 1, mass: 1}}}}
sliders: {{cart: {{joint: B, through: O, mass: 2}}}}
drives: {{arm: {{angle: 0, speed: 0}}}}
free: {{cart: {{position: {position}, speed: {speed}}}}}
{forces}
simulate: {{end: {end}, samples: {samples}}}
"""
MASS = 3.0
STOP = "stops: [{{slider: cart, lower: 0, {}}}]"
WORN = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.8, center: 10 mm}
  rod: {joints: [A, B], length: 140 mm, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
clearances:
  gap: {joint: A, bar: rod, size: 0.1 mm,
        contact: hunt-crossley-constant, stiffness: 2e9 N/m^1.5, dissipation: 1.5 s/m}
drives: {crank: {angle: 0, speed: 600 rpm}}
loads: [{slider: piston, force: -200 N}]
assembly: {B: [0.18, 0]}
simulate: {end: 0.03, samples: 601}
"""


def thrown(samples):
    """A block that a constant force pushes against a rigid stop."""
    forces = "loads: [{slider: cart, force: -30 N}]\n" + STOP.format("restitution: 0.5")
    return BLOCK.format(position=0.1, speed=0, forces=forces, end=0.25, samples=samples)


def extremes(text, variable, element="cart"):
    """Least and greatest value of an output."""
    solution = linkages.simulate(loads(text))
    (row,) = [r for r in solution.maxima if (r["variable"], r["element"]) == (variable, element)]
    assert row["missed"] == 0.0
    return row["least"], row["greatest"]


@pytest.mark.parametrize("samples", [101, 233, 1001])
def test_a_stop_with_a_damper_brakes_most_at_the_touch(samples):
    """Before it the block moves freely, behind it is damped far more than it is thrown back."""
    forces = STOP.format("stiffness: 50, damping: 90")
    text = BLOCK.format(position=0.1, speed=-1, forces=forces, end=0.25, samples=samples)
    least, greatest = extremes(text, "slider_acceleration")
    assert least == pytest.approx(0.0, abs=1e-9)
    assert greatest == pytest.approx(90 / MASS, rel=1e-6)


@pytest.mark.parametrize("samples", [101, 233, 1001])
def test_a_rigid_stop_reverses_the_speed_that_the_block_has_there(samples):
    """Nothing that the motion remembers differs behind the impact."""
    text = thrown(samples)
    speed = np.sqrt(2 * 30 / MASS * 0.1)
    least, greatest = extremes(text, "slider_velocity")
    assert least == pytest.approx(-speed, rel=1e-6)
    assert greatest == pytest.approx(0.5 * speed, rel=1e-6)
    least, greatest = extremes(text, "slider_position")
    assert least == pytest.approx(0.0, abs=1e-8)
    assert greatest == 0.1


@pytest.mark.parametrize("measure", ["min(cart.position)", "min(cart.velocity)"])
def test_one_of_many_has_the_extremes_of_one_alone(measure):
    mechanism, path = loads(thrown(101)), "stops[0].restitution"
    data = linkages.sweep(mechanism, {path: "uniform(0.2, 0.9)"}, measure, draws=4, seed=1)
    assert data[measure].to_numpy().tolist() == [
        linkages.measure(linkages.simulate(mechanism.with_values({path: value})), measure)
        for value in data[path].to_numpy().tolist()
    ]


@pytest.mark.parametrize("samples", [101, 233, 1001])
def test_friction_brakes_most_just_before_a_reversal(samples):
    forces = "springs: [{slider: cart, stiffness: 300}]\nfriction: [{slider: cart, force: 6 N}]"
    text = BLOCK.format(position=0.2, speed=0, forces=forces, end=0.5, samples=samples)
    least, greatest = extremes(text, "slider_acceleration")
    assert greatest == pytest.approx((300 * (0.2 - 2 * 6 / 300) + 6) / MASS, rel=1e-6)
    assert least == pytest.approx(-(300 * 0.2 - 6) / MASS, rel=1e-6)


RIGID = WORN.replace(
    "hunt-crossley-constant, stiffness: 2e9 N/m^1.5, dissipation: 1.5 s/m",
    "restitution, restitution: 0.5",
)


@pytest.mark.parametrize("text", [WORN, RIGID], ids=["compliant", "rigid"])
def test_between_samples_the_motion_is_that_of_closer_samples(text):
    """Closer samples come from the same steps: only what is interpolated differs."""
    solution = linkages.simulate(loads(text), outputs=["clearance_force"])
    followed = solution.closely
    parts = 8
    places = np.arange((len(followed.time) - 1) * parts + 1) / parts
    close = linkages.simulate(
        loads(text), samples=len(places), outputs=["clearance_force", "slider_acceleration"]
    )
    for name in ("clearance_force", "slider_acceleration"):
        exact = close.data[name].to_numpy()
        found = followed.between(name, places)
        assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()


def test_a_contact_that_never_pulls_has_no_negative_force():
    """Its journal takes off and touches again between samples."""
    assert extremes(WORN, "clearance_force", "gap")[0] == 0.0
