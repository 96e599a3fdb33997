"""Extremes beside a change of mode, where rates of some order jump between two samples."""

from itertools import pairwise

import numpy as np
import pytest

import linkages

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
GAP = {"joint": "B", "bar": "rod", "size": "0.5 mm"}
LAWS = {
    "compliant": {
        "contact": "hunt-crossley-constant", "stiffness": "2e9 N/m^1.5", "dissipation": "1.5 s/m"
    },
    "rigid": {"contact": "restitution", "restitution": 0.5},
}  # fmt: skip


def block(**given):
    """A cart, with what is to be put into its definition."""
    return linkages.loads(BLOCK.format(**given))


def engine(law):
    """A slider-crank whose journal takes off and touches again between samples."""
    given = {"clearances.gap": GAP | LAWS[law], "simulate.end": 0.006, "simulate.samples": 301}
    return linkages.load("slider-crank-contact", set=given)


def thrown(samples):
    """A block that a constant force pushes against a rigid stop."""
    forces = "loads: [{slider: cart, force: -30 N}]\n" + STOP.format("restitution: 0.5")
    return block(position=0.1, speed=0, forces=forces, end=0.25, samples=samples)


def extremes(mechanism, variable, element="cart"):
    """Least and greatest value of an output."""
    solution = linkages.simulate(mechanism)
    (row,) = [r for r in solution.maxima if (r["variable"], r["element"]) == (variable, element)]
    assert row["missed"] == 0.0
    return row["least"], row["greatest"]


@pytest.mark.slow_except("101")
@pytest.mark.parametrize("samples", [101, 233, 1001])
def test_a_stop_with_a_damper_brakes_most_at_the_touch(samples):
    """Before it the block moves freely, behind it is damped far more than it is thrown back."""
    forces = STOP.format("stiffness: 50, damping: 90")
    mechanism = block(position=0.1, speed=-1, forces=forces, end=0.25, samples=samples)
    least, greatest = extremes(mechanism, "slider_acceleration")
    assert least == pytest.approx(0.0, abs=1e-9)
    assert greatest == pytest.approx(90 / MASS, rel=1e-6)


@pytest.mark.slow_except("101", "233")
@pytest.mark.parametrize("samples", [101, 233, 1001])
def test_a_rigid_stop_reverses_the_speed_that_the_block_has_there(samples):
    """Nothing that the motion remembers differs behind the impact."""
    mechanism = thrown(samples)
    speed = np.sqrt(2 * 30 / MASS * 0.1)
    least, greatest = extremes(mechanism, "slider_velocity")
    assert least == pytest.approx(-speed, rel=1e-6)
    assert greatest == pytest.approx(0.5 * speed, rel=1e-6)
    least, greatest = extremes(mechanism, "slider_position")
    assert least == pytest.approx(0.0, abs=1e-8)
    assert greatest == 0.1


@pytest.mark.parametrize("measure", ["min(cart.position)", "min(cart.velocity)"])
def test_one_of_many_has_the_extremes_of_one_alone(measure):
    mechanism, path = thrown(101), "stops[0].restitution"
    data = linkages.sweep(mechanism, {path: "uniform(0.2, 0.9)"}, measure, draws=4, seed=1)
    assert data[measure].to_numpy().tolist() == [
        linkages.measure(linkages.simulate(mechanism.with_values({path: value})), measure)
        for value in data[path].to_numpy().tolist()
    ]


@pytest.mark.parametrize("samples", [101, 233, 1001])
def test_friction_brakes_most_just_before_a_reversal(samples):
    forces = "springs: [{slider: cart, stiffness: 300}]\nfriction: [{slider: cart, force: 6 N}]"
    mechanism = block(position=0.2, speed=0, forces=forces, end=0.5, samples=samples)
    least, greatest = extremes(mechanism, "slider_acceleration")
    assert greatest == pytest.approx((300 * (0.2 - 2 * 6 / 300) + 6) / MASS, rel=1e-6)
    assert least == pytest.approx(-(300 * 0.2 - 6) / MASS, rel=1e-6)


def between_changes(motion, times):
    """Times between the first and the last of several changes within one interval of samples."""
    changes = np.sort(np.concatenate([found.time for found in motion.changes.values()]))
    edges = np.searchsorted(changes, motion.time)
    found = np.zeros(len(times), dtype=bool)
    for first, behind in pairwise(edges):
        if behind - first > 1:
            found |= (changes[first] < times) & (times < changes[behind - 1])
    return found


@pytest.mark.parametrize("law", LAWS)
def test_between_samples_the_motion_is_that_of_closer_samples(law):
    """Closer samples come from the same steps: only what is interpolated differs."""
    mechanism = engine(law)
    followed = linkages.simulate(mechanism, outputs=["clearance_force"]).closely
    parts = 8
    places = np.arange((len(followed.time) - 1) * parts + 1) / parts
    close = linkages.simulate(
        mechanism, samples=len(places), outputs=["clearance_force", "slider_acceleration"]
    )
    known = ~between_changes(followed.motion, close.data.time.to_numpy())
    assert known.mean() > 0.99
    for name in ("clearance_force", "slider_acceleration"):
        exact = close.data[name].to_numpy()
        error = np.abs(followed.between(name, places) - exact)[known].max()
        assert error < 1e-6 * np.abs(exact).max()


def test_a_contact_that_never_pulls_has_no_negative_force():
    assert extremes(engine("compliant"), "clearance_force", "gap")[0] == 0.0
