"""Errors of exponents of linkages cover the truth, as those of maps do."""

import numpy as np
import pytest
from chaos_systems import exponents_of

import linkages
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.exponents import Exponents, lyapunov_spectrum
from linkages.kernel.system import System
from linkages.options.run import RunOptions

PARTS = 4
RUNS = 200

PENDULUM = """\
name: Pendulum
gravity: [0, -1]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
free: {arm: {angle: -1.2, speed: 0}}
simulate: {end: 10, rtol: 1e-9}
"""

DRIVEN = """\
dampers: [{joint: O, damping: DAMPING}]
loads: [{bar: arm, torque: "1.15*cos(2*t/3)"}]
"""


def driven(damping):
    text = PENDULUM + DRIVEN.replace("DAMPING", repr(damping))
    return linkages.loads(text)


def part(whole, begin, count):
    """Some intervals of a run, as if it had begun and ended there."""
    chosen = slice(begin, begin + count)
    states, times = (x[begin : begin + count + 1] for x in (whole.states, whole.times))
    return Exponents(whole.growth[chosen], states, times)


@pytest.mark.slow
@pytest.mark.parametrize(("damping", "period"), [(0.54, 2), (0.5388, 4), (0.5378, 8)])
def test_periods_of_a_cascade(damping, period):
    """A driven pendulum that doubles its period: parts of one long run, in any phase.

    The truth is the mean over whole cycles: their growth repeats to 1e-6 of an interval's.
    """
    rng = np.random.default_rng(7)
    whole = exponents_of(driven(damping), periods=256, skip=1200)
    cycle = whole.growth.reshape(-1, period * PARTS, 2)
    assert np.ptp(cycle.mean(axis=1), axis=0).max() < 1e-6
    shorter = whole.growth.reshape(-1, period * PARTS // 2, 2).mean(axis=1)
    assert np.ptp(shorter, axis=0).max() > 1e-4  # and not after half of it
    truth = whole.values
    ratios = []
    for _ in range(RUNS):
        count = int(rng.integers(16 * PARTS, 128 * PARTS))
        run = part(whole, int(rng.integers(len(whole.growth) - count)), count)
        apart = np.abs(run.values - truth)
        assert (apart <= 2 * run.errors + 1e-7).all()
        assert run.settled, run.unsettled
        ratios.append((run.errors**2, apart**2))
        # the error is of order 1/T: whatever the length, a few times what one cycle does
        assert (run.errors * count < 20 * np.abs(whole.growth).max()).all()
    errors, apart = np.sqrt(np.mean(ratios, axis=0))
    assert (errors < 6 * apart).all()


@pytest.mark.slow
def test_tori_of_a_pendulum():
    """Without friction both exponents are zero, whatever the amplitude: tangents grow like t."""
    rng = np.random.default_rng(8)
    system = System(linkages.loads(PENDULUM))
    covered = []
    for amplitude in rng.uniform(0.3, 2.6, RUNS // 10):
        start = system.at(0.0, np.array([-np.pi / 2 + amplitude, 0.0]))
        tangents = LinkageTangents(start, 2, RunOptions(rtol=1e-9))
        whole = lyapunov_spectrum(tangents, intervals=400, interval=1.7)
        for count in rng.integers(100, 401, 10):
            run = part(whole, 0, int(count))
            covered.append((np.abs(run.values) <= 2 * run.errors).all())
    assert np.mean(covered) >= 0.93


@pytest.mark.long
def test_chaos_of_a_driven_pendulum():
    """Two hundred runs of fifty periods against the mean of all, which is 14 times as sure."""
    whole = exponents_of(driven(0.5), periods=RUNS * 50, skip=200)
    runs = [part(whole, k * 50 * PARTS, 50 * PARTS) for k in range(RUNS)]
    covered = [np.abs(run.values - whole.values) <= 2 * run.errors for run in runs]
    assert (np.mean(covered, axis=0) >= 0.93).all()
    ratio = np.mean([run.errors for run in runs], axis=0) / np.std([r.values for r in runs], axis=0)
    assert (ratio < 1.5).all()


DAMPED = """\
name: Damped
sliders: {block: {joint: P, through: [0, 0], mass: 2}}
loads: [{slider: block, force: "cos(1.3*t) - 2*block.position - 4*DAMPING*block.velocity"}]
free: {block: {position: 0.3, speed: 0}}
simulate: {end: 10}
"""


@pytest.mark.parametrize(("skip", "periods"), [(0, 20), (0, 200), (20, 20), (100, 20), (100, 200)])
@pytest.mark.parametrize("beyond", [0.0, 1e-8, -1e-8, 1e-6, -1e-6, 1e-5])
def test_nearly_double_exponents(beyond, skip, periods):
    """An oscillator at its critical damping: its exponents are -1 in rad/s, both of them.

    Tangents grow like (1 + t) exp(-t), so that averages are wrong by ln(1 + t)/t, which skipping
    does not end: behind 100 periods of 4.8 s rates hardly change within 20, and are wrong by 1/t.
    """
    damping = 1.0 + beyond
    found = exponents_of(
        linkages.loads(DAMPED.replace("DAMPING", repr(damping))),
        skip=skip, periods=periods,
    )  # fmt: skip
    apart = np.sqrt(complex(damping**2 - 1))
    exact = np.array([(-damping + apart).real, (-damping - apart).real])
    wrong = np.abs(found.values - exact)
    assert (wrong < 1.1 * found.errors).all()  # an error is the size of what it is of
    assert (found.errors < 0.1).all()
    if beyond == 0.0 and skip:  # not far too large either
        assert (wrong > 0.9 * found.errors).all()
