"""Six-bars with blocks that slide on moving bars, drawn at random; closed, balanced or reported."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from stress_mechanisms import CLOSURE, defined
from test_stress_random import METHODS, angles, decades, drawn, run

import linkages
from linkages.errors import InputError


def shaper(crank, offset, arm, rod, start, motion, speed, masses, points=""):
    """A crank moves a block along a swinging arm, which moves a ram by a rod."""
    reach = math.hypot(offset, crank)
    text = (
        "gravity: [0, -9.81]\n"
        f"joints: {{O: [0, 0], C: [0, {-offset!r}], R: [0, {arm * 0.9 - offset!r}]}}\n"
        f"bars:\n  crank: {{joints: [O, A], length: {crank!r}, mass: {masses[0]!r}}}\n"
        f"  arm: {{joints: [C, P], length: {arm!r}, mass: {masses[1]!r}}}\n"
        f"  rod: {{joints: [P, Q], length: {rod!r}, mass: {masses[2]!r}}}\n"
        f"sliders:\n  block: {{joint: A, on: arm, through: C, mass: {masses[0]!r}, "
        f"inertia: {masses[0] * crank**2!r}{points}}}\n"
        f"  ram: {{joint: Q, through: R, mass: {masses[3]!r}}}\n"
        f"{motion}: {{crank: {{angle: {start!r}, speed: {speed!r}}}}}\n"
        f"assembly: {{P: [0, {arm - offset!r}], Q: [{rod + reach!r}, {arm * 0.9 - offset!r}]}}\n"
    )
    return defined(text)


@drawn
@given(
    crank=decades(-2, 0),
    shares=st.tuples(st.floats(0.2, 5), st.floats(0.5, 10), st.floats(0.2, 5)),
    start=angles,
    motion=st.sampled_from(["drives", "free"]),
    speed=st.floats(-100, 100),
    masses=st.tuples(decades(-3, 3), decades(-3, 3), decades(-3, 3), decades(-3, 3)),
    how=METHODS,
)
def test_block_on_a_swinging_arm(crank, shares, start, motion, speed, masses, how):
    """Offsets below the crank make the arm turn fully, rams reach or fail to: all is told."""
    offset, arm, rod = (crank * share for share in shares)
    run(lambda: shaper(crank, offset, arm, rod, start, motion, speed, masses), how, 0.1)


@pytest.mark.slow
@drawn
@given(
    lengths=st.tuples(decades(-2, 0), decades(-2, 0), decades(-2, 0)),
    place=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
    tilt=angles,
    start=angles,
    motion=st.sampled_from(["drives", "free"]),
    masses=st.tuples(decades(-3, 3), decades(-3, 3), decades(-3, 3)),
    how=METHODS,
)
def test_inverted_slider_crank_with_a_bar_on_its_block(
    lengths, place, tilt, start, motion, masses, how
):
    """A block on the coupler with a point of its own that drags a further bar along."""
    crank, coupler, follower = lengths
    text = (
        f"gravity: [0, -9.81]\njoints: {{O: [0, 0], C: {[0.3 * p for p in place]}}}\n"
        f"bars:\n  crank: {{joints: [O, A], length: {crank!r}, mass: {masses[0]!r}}}\n"
        f"  guide: {{points: {{A: [0, 0], T: [{coupler!r}, 0]}}, mass: {masses[1]!r}, "
        f"center: [{coupler / 2!r}, 0], inertia: {masses[1] * coupler**2 / 12!r}}}\n"
        f"  tail: {{joints: [U, V], length: {follower!r}, mass: {masses[2]!r}}}\n"
        "sliders:\n"
        f"  block: {{joint: C, on: guide, through: A, angle: {tilt!r}, mass: 0.1, inertia: 1e-3, "
        f"points: {{U: [{0.1 * coupler!r}, {0.2 * coupler!r}]}}}}\n"
        f"{motion}: {{crank: {{angle: {start!r}, speed: 20}}}}\n"
        "free: {tail: {angle: 0.3, speed: 1}}\n"
    )
    if motion == "free":
        text = text.replace("free: {tail: {angle: 0.3, speed: 1}}\n", "").replace(
            "speed: 20}}", "speed: 20}, tail: {angle: 0.3, speed: 1}}"
        )
    run(lambda: defined(text), how, 0.1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_shapers_that_turn_fully(seed):
    """Dimensions with which all goes round: then every run must get to its end, and balance."""
    generator = np.random.default_rng(seed)
    done = 0
    for _ in range(30):
        crank = 10 ** generator.uniform(-2, -0.5)
        offset = crank * generator.uniform(1.5, 4)
        arm = offset * generator.uniform(2, 4)
        # The ram's axis is at 0.9 arm; the arm's end stays between there and 1 arm, above or not.
        lowest = arm * math.cos(math.asin(crank / offset))
        rod = 3 * max(arm - 0.9 * arm, abs(0.9 * arm - lowest)) + arm
        masses = 10 ** generator.uniform(-1, 1, 4)
        motion = "drives" if generator.uniform() < 0.5 else "free"
        speed = float(generator.uniform(5, 60))
        try:
            mechanism = shaper(
                *(float(x) for x in (crank, offset, arm, rod)), 0.3, motion, speed,
                [float(m) for m in masses],
            )  # fmt: skip
            solution = linkages.simulate(
                mechanism, end=0.2, samples=101, rtol=1e-11, outputs="all", throw=False
            )
        except InputError:
            continue
        assert solution.completed, (seed, solution.motion.failure)
        done += 1
        data = solution.data
        assert float(data.closure_residual.max()) <= CLOSURE
        scale = float(np.abs(data.kinetic_energy).max()) + float(
            np.ptp(data.potential_energy.to_numpy())
        )
        assert float(np.abs(data.energy_residual).max()) < 1e-8 * scale
    assert done > 20
