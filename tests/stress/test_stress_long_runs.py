"""Many steps: closure, energy and the way back."""

import numpy as np
import pytest
from stress_mechanisms import CLOSURE, HELD, double_pendulum, energy_of

import linkages
from linkages.kernel.system import System
from linkages.solution.plan import build_flow
from linkages.solvers import METHODS, Outcome, integrate

ENERGIES = ["kinetic_energy", "potential_energy"]
# Steps of the fixed-step methods at which the nine-bar's error after half a second is below 1e-9.
STEPS = {"rk4": 1e-5, "gauss8": 1e-4}


@pytest.mark.slow
def test_ten_million_steps_of_rk4():
    """Closure stays at round-off. The balance of energy errs by the truncation of RK4 alone, in
    proportion to time: round-off, the root of 1e7 times 1e-16 of some 100 J, is 1000 times less.
    """
    end, step = 100.0, 1e-5
    solution = linkages.simulate(
        linkages.load("ninebar"),
        end=end,
        samples=1001,
        method="rk4",
        step=step,
        outputs=["closure_residual", "energy_residual"],
    )
    assert solution.motion.cost["steps"] == 10_000_000
    assert float(solution.data.closure_residual.max()) <= CLOSURE
    residual = np.abs(solution.data.energy_residual.to_numpy())
    # measured 5.5e-9 J at this step; with half of it, 2^5 times less
    assert residual.max() < 1e-8
    assert residual[-1] == pytest.approx(10 * residual[100], rel=0.02)


@pytest.mark.slow_except("[!r]*", "rk4")
@pytest.mark.parametrize("method", METHODS)
def test_forward_and_back_again(method):
    """Half a second of the nine-bar and back: some 50 swings each way.

    The state at the end is off by the error of both ways; angular speeds are 650 times larger
    than angles, and so are their errors. A symmetric method undoes its steps up to round-off.
    """
    system = System(linkages.load("ninebar"))
    flow, step = build_flow(system), STEPS.get(method)
    there = integrate(flow, system.state, [0.0, 0.5], method=method, rtol=1e-10, step=step)
    back = integrate(flow, there.final_state, [0.5, 0.0], method=method, rtol=1e-10, step=step)
    assert there.outcome is back.outcome is Outcome.DONE
    off = np.abs(back.final_state - system.state) / [1.0, 650.0]
    assert off.max() < {"gauss8": 1e-13}.get(method, 1e-7)


def drift(mechanism, method, end, samples=2001, **settings):
    data = linkages.simulate(
        mechanism, method=method, end=end, samples=samples, outputs=ENERGIES, **settings
    ).data
    return data.time.to_numpy(), energy_of(data)


@pytest.mark.parametrize("method", ["dop853", "tsit5", "vern9"])
def test_adaptive_methods_drift_in_proportion_to_time(method):
    """Energy that a method loses or gains per swing is the same for every swing, so that the
    drift is a straight line; and it lessens with the tolerance.
    """
    time, loose = drift(double_pendulum(), method, 1000.0, rtol=1e-8)
    slope, start = np.polyfit(time, loose, 1)
    assert np.abs(loose - slope * time - start).max() < 0.2 * abs(loose[-1])
    # Error per step in proportion to the tolerance: 100 times less, in at most three times as
    # many steps; where errors of different signs cancel, it is less still.
    _, tight = drift(double_pendulum(), method, 1000.0, rtol=1e-10)
    assert np.abs(tight).max() < np.abs(loose).max() / 20


def test_rk4_loses_energy_with_every_swing():
    """A step multiplies the amplitude of an oscillation by 1 - (ωh)⁶/144: h⁵ per unit of time."""
    swings = linkages.load("ninebar", set=HELD)
    losses = []
    for step in (2e-4, 1e-4):
        _, energy = drift(swings, "rk4", 5.0, samples=101, step=step)
        # one sample in 50 ms, some six swings: what wavers within one is less than they lose
        assert (np.diff(energy) < 0).all()
        losses.append(-energy[-1])
    assert np.log2(losses[0] / losses[1]) == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize("speed", ["held", "pendulums"])
def test_gauss8_shows_no_secular_drift(speed):
    """Symmetric steps on a reversible motion: the error of the energy wavers about a constant.

    Its straight-line trend over the run stays below the wavering itself, where the same number
    of swings with RK4 loses a hundred times more.
    """
    if speed == "held":
        mechanism, end, step = linkages.load("ninebar", set=HELD), 20.0, 5e-4
    else:
        mechanism, end, step = double_pendulum(), 1000.0, 0.05
    time, energy = drift(mechanism, "gauss8", end, step=step)
    slope, _ = np.polyfit(time, energy, 1)
    wavering = np.ptp(energy[: len(energy) // 10])
    assert abs(slope) * end < wavering
    # nowhere does it leave the band of the first tenth by more than the band's own width
    assert np.abs(energy).max() < 3 * wavering


@pytest.mark.slow
def test_gauss8_at_round_off_over_a_million_steps():
    """Steps so short that only round-off is left, which compensated sums keep from growing."""
    swings = linkages.load("ninebar", set=HELD)
    _, energy = drift(swings, "gauss8", 100.0, samples=1001, step=1e-4)
    # 1e-16 of the 163 J of weight that the energy is the difference of
    assert np.abs(energy).max() < 1e-12
