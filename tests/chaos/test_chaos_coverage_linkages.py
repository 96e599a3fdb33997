"""Errors of exponents of linkages cover the truth, as those of maps do."""

import numpy as np
import pytest
from chaos_systems import exponents_of

from linkages.chaos.growth.exponents import Exponents, lyapunov_spectrum
from linkages.chaos.growth.tangents import LinkageTangents
from linkages.components.mechanisms.definition import from_document
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.reading.document import parse

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
    return from_document(parse(text, "driven.yaml"))


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
    system = System(from_document(parse(PENDULUM, "pendulum.yaml")))
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
