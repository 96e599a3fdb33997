"""Points and exponent at a value belong to one motion, also where two are a hair apart.

A pendulum with a constant torque either swings about its equilibrium or turns for ever. Started on
the border between the two, errors of the integration decide: a second run from the same start, with
tangents that have a say in its steps, may go the other way.
"""

import numpy as np
import pytest

import linkages
from linkages.chaos.lyapunov import run_exponents
from linkages.kernel.system import System
from linkages.options.analysis_options import ExponentOptions

BISTABLE = """\
name: Pendulum with a torque
gravity: [0, -1]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
dampers: [{joint: O, damping: 0.1}]
loads: [{bar: arm, torque: {harmonic: {mean: 0.3, amplitude: 0.01, angular_frequency: 1}}}]
free: {arm: {angle: -90 deg, speed: 0}}
simulate: {end: 10, samples: 101, rtol: 1e-5}
"""
SKIP = 30
"""Periods: a swing dies out by exp(−0.05·2π·30) = 8e-5."""

SWINGING = -0.05
"""The exponent of a damped swing is minus half the damping over the inertia (1 kg m²)."""

TURNING = 0.0
"""Of two incommensurable frequencies, turning and torque: a torus."""


def pendulum(speed=0.0):
    return linkages.loads(BISTABLE).with_state({"arm": (-np.pi / 2, speed)})


def turns(speed):
    data = linkages.poincare(pendulum(speed), periods=1, skip=SKIP)
    return abs(float(data.bar_speed[0, 0])) > 1.0  # 3 rad/s, or hardly any


@pytest.fixture(scope="module")
def border():
    """Speeds on both sides of the border, closer than the errors of an integration."""
    low, high = 0.0, 4.0
    assert (turns(low), turns(high)) == (False, True)
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if turns(middle) else (middle, high)
    return low, high


@pytest.mark.slow
def test_a_second_run_from_the_start_goes_the_other_way(border):
    """Why exponents must not start again: this is what the other tests are about."""
    found = []
    for speed in border:
        mechanism = pendulum(speed)
        options = ExponentOptions(periods=100, skip=SKIP, count=1)
        found.append(run_exponents(System(mechanism), options).values[0] > 0.5 * SWINGING)
    assert found != [False, True]


SECTIONS = {
    "stroboscopic": [{}, {}],
    "phase": [{"phase": 0.3}, {"phase": 0.3}],
    "geometric": [{"section": "arm.speed=0"}, {"section": "arm.angle=0"}],
}


@pytest.mark.slow_except("phase-same", "geometric-same")
@pytest.mark.parametrize("start", ["same", "backward"])
@pytest.mark.parametrize("kind", SECTIONS)
def test_exponents_belong_to_the_points(border, kind, start):
    """Both values are the border itself: forward and backward start there, too."""
    for side, (speed, section) in enumerate(zip(border, SECTIONS[kind], strict=True)):
        vary = {"gravity[0]": [0.0, 0.0]}
        data = linkages.bifurcation(
            pendulum(speed), vary, periods=5, skip=SKIP, start=start, exponent=True, **section
        )
        moving = np.abs(data.bar_speed[0, :, :, 0]).max("crossing").to_numpy() > 1.0
        assert moving.tolist() == [bool(side)] * 2
        expected = TURNING if side else SWINGING
        # over 100 periods of 6.28 s a torus has an exponent of the order ln(T)/T
        assert data.exponent[0].to_numpy() == pytest.approx([expected] * 2, abs=0.012)
