"""Derivatives of measures of series that jump where a mode changes, in motions that are free."""

from __future__ import annotations

import numpy as np
import pytest
from design_differences import richardson

import linkages
from linkages.design.differentiated import Differentiated
from linkages.errors import ComputationError

PENDULUM = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
parameters: {{limit: -1.05, push: 2, mu: 0.6}}
bars: {{rod: {{joints: [O, A], length: 0.5, mass: 1}}}}
free: {{rod: {{angle: 10 deg, speed: 0}}}}
loads: [{{bar: rod, torque: "{law}"}}]
"""
STOP = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
stops: [{slider: cart, lower: -0.3, upper: 0.6, stiffness: 2e4, damping: 50}]
free: {cart: {position: 0, speed: 3}}
"""
BALL = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {ball: {joint: P, through: O, angle: 90 deg, mass: 0.3}}
stops: [{slider: ball, lower: 0, restitution: 0.7}]
free: {ball: {position: 1, speed: 0}}
"""
CASES = {
    "dry friction that sticks": (
        PENDULUM.format(law="-mu*sign(rod.speed)"),
        ["parameters.mu", "bars.rod.length", "free.rod.angle"],
        (4.0, 401),
        ["rms(rod.acceleration)", "rms(loads[0].torque)", "max(rod.acceleration)",
         "time_of_max(rod.acceleration)", "at(1.231 s, rod.speed)"],
    ),
    "a law with where": (
        PENDULUM.format(law="where(rod.angle > limit, push, -0.5*push)"),
        ["parameters.limit", "parameters.push", "bars.rod.length"],
        (2.0, 201),
        ["mean(rod.acceleration)", "rms(rod.acceleration)", "min(rod.acceleration)",
         "time_of_min(rod.acceleration)", "max(rod.speed)", "mean(rod.speed*rod.speed)"],
    ),
    "an elastic stop": (
        STOP,
        ["stops[0].upper", "stops[0].stiffness", "stops[0].damping", "free.cart.speed"],
        (1.0, 201),
        ["mean(abs(cart.acceleration))", "rms(cart.acceleration)", "mean(cart.position)"],
    ),
    "a rigid stop": (
        BALL,
        ["stops[0].restitution", "free.ball.position"],
        (1.5, 151),
        ["mean(ball.velocity)", "rms(ball.velocity)", "max(ball.velocity)", "min(ball.velocity)",
         "time_of_max(ball.velocity)", "at(0.4512 s, ball.position)"],
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_measures_of_what_jumps_with_a_mode_have_the_derivatives_of_differences(name):
    """Motions are exact to 1e-12, differences of 1e-4 of a number to 1e-8 of what they are of."""
    text, paths, (end, samples), measures = CASES[name]
    run = {"end": end, "samples": samples, "rtol": 1e-12}
    found = Differentiated(linkages.loads(text), measures, paths, run=run)
    exact = found.at(found.values)
    assert exact.derivatives is not None
    for number, value in enumerate(found.values):
        size = abs(value) or 1.0
        difference, error = richardson(
            lambda x: found.at(x, derivatives=False).values, found.values, number, 1e-4 * size
        )
        own = exact.derivatives[:, number]
        scale = np.maximum(np.abs(own), np.abs(exact.values) / size)
        assert (np.abs(own - difference) <= 5e-8 * scale + 10 * error).all()


def test_means_of_accelerations_are_what_speeds_gain():
    """Another road to the same, whose derivatives need no jump: (v(T) − v(0))/T."""
    text, paths, (end, samples), _ = CASES["a rigid stop"]
    text = text.replace("restitution: 0.7", "stiffness: 1e5, damping: 30")
    paths = ["stops[0].stiffness", "free.ball.position"]
    run = {"end": end, "samples": samples, "rtol": 1e-12}
    measures = ["mean(ball.acceleration)*1.5 s", "final(ball.velocity)"]
    found = Differentiated(linkages.loads(text), measures, paths, run=run).at
    exact = found(Differentiated(linkages.loads(text), measures, paths, run=run).values)
    assert exact.derivatives is not None
    # quadrature with five places between samples, of which each touch has 40 at least
    np.testing.assert_allclose(*exact.values, rtol=1e-8)
    np.testing.assert_allclose(*exact.derivatives, rtol=1e-7)


@pytest.mark.slow
def test_means_through_many_touches_of_a_stiff_contact():
    """39 touches of a journal, of a force that goes with the power 1.5 of the depth."""
    run = {"end": 0.004, "samples": 401, "rtol": 1e-12}
    measures = ["mean(crank.effort)", "max(crank.effort)"]
    found = Differentiated(
        linkages.load("slider-crank-contact"), measures, ["clearances.gap.size"], run=run
    )
    exact = found.at(found.values).derivatives
    assert exact is not None
    difference, error = richardson(
        lambda x: found.at(x, derivatives=False).values, found.values, 0, 1e-5 * 5e-4
    )
    assert (abs(exact[:, 0] - difference) <= 1e-7 * abs(difference) + 10 * error).all()
    assert (error < 1e-4 * abs(difference)).all()


def test_a_value_just_where_a_mode_changes_has_no_derivative():
    """The ball, let go 1 m above its stop with weight 9.81, is there after sqrt(2/9.81) s."""
    touch = np.sqrt(2.0 / 9.81)
    found = Differentiated(
        linkages.loads(BALL), [f"at({touch:.17g} s, ball.velocity)"], ["free.ball.position"],
        run={"end": 1.5, "samples": 151, "rtol": 1e-12},
    )  # fmt: skip
    with pytest.raises(ComputationError, match=r"jumps at t = 0.451524 s, and numbers move"):
        found.at(found.values)
