"""Motions that start exactly on a rigid wall, or leave it slowly."""

import numpy as np
import pytest

import linkages

OSCILLATOR = """
gravity: [0, 0]
joints: {O: [0, 0]}
sliders: {mass: {joint: P, through: O, angle: 0, mass: 1}}
springs: [{slider: mass, stiffness: 1, damping: 0.1, position: 0}]
loads: [{slider: mass, force: cos(t)}]
stops: [{slider: mass, upper: 1, restitution: 0.8, least_rate: 1e-6}]
free: {mass: {position: 0, speed: 0}}
simulate: {end: 20, rtol: 1e-12}
"""


@pytest.mark.parametrize("rate", [-1e-6, -1e-5, -1e-3, -0.05])
def test_leaving_the_wall_from_zero_distance(rate):
    """x″ + 0.1 x′ + x = cos t: as from 1e-15 m beside the wall, and not at a constant rate.

    The contact pressed and did not touch, so that nothing acted on the mass.
    """
    equations = linkages.compile(linkages.loads(OSCILLATOR))
    there, beside = (
        equations.flow().advance([place, rate], 0.0, 6.0).y for place in (1.0, 1.0 - 1e-15)
    )
    np.testing.assert_allclose(there, beside, atol=1e-9)
    modes = equations.held(0.0, [1.0, rate])
    assert modes["mode stops[0].upper: touch"] == modes["mode stops[0].upper: press"] == -1.0
