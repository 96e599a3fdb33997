"""Analyses that end early keep what they have; motions that rest are no error."""

import contextlib
import dataclasses
import signal

import numpy as np
import pytest
from shared_definitions import DRIVEN_PENDULUM

import linkages
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.evidence import PER_PERIOD
from linkages.chaos.findings import tightened, verdict
from linkages.errors import Interrupted, UnfinishedError
from linkages.options.run import RunOptions
from linkages.solution.run_options import options_of
from linkages.sweeps.running import Threads, attempt

PENDULUM = DRIVEN_PENDULUM + "simulate: {end: 10, samples: 101, rtol: 1e-8}\n"

# Rocker 6 and link 8 fold onto each other at t = 1.546 s.
FOLDING = {"assembly.E": "left", "simulate.change_points": "stop"}


def pendulum(**changes: object) -> linkages.Mechanism:
    return linkages.loads(PENDULUM, set=changes)


class Interrupt:
    """Ctrl-C at a part of the way."""

    def __init__(self, part: float) -> None:
        self.part = part

    def __call__(self, fraction: float) -> None:
        if fraction >= self.part:
            raise KeyboardInterrupt


@pytest.mark.parametrize("section", [None, "arm.speed=0"], ids=["stroboscopic", "geometric"])
def test_section_points_so_far_are_kept(section):
    # longer than any machine computes before it looks for Ctrl-C, which it does after ten periods
    given = {"periods": 10**6, "section": section, "rtol": 1e-12}
    with pytest.raises(Interrupted, match="interrupted") as caught:
        linkages.poincare(pendulum(), **given, watch=Interrupt(1e-5))
    kept = caught.value.kept["poincare"]
    assert 0 < kept.sizes["crossing"] < 10**6
    few = min(5, kept.sizes["crossing"])
    whole = linkages.poincare(pendulum(), **{**given, "periods": few})
    # the same steps, but for the last one of a run
    assert kept.bar_speed[:few].to_numpy() == pytest.approx(whole.bar_speed.to_numpy(), abs=1e-9)


@pytest.mark.parametrize("section", [None, "r1.speed=0"])
def test_sections_of_a_motion_that_stops(section):
    mechanism = linkages.load("ninebar", set=FOLDING)
    with pytest.raises(UnfinishedError, match=r"at t = 1\.54.*joint F") as caught:
        linkages.poincare(mechanism, periods=5000, section=section)
    assert 1.54 < caught.value.time < 1.55
    assert (caught.value.kept["poincare"].time < 1.55).all()


def test_exponents_so_far_are_kept():
    """Longer than any machine computes before it looks for Ctrl-C."""
    with pytest.raises(Interrupted, match="interrupted") as caught:
        linkages.lyapunov(pendulum(), periods=10**6, watch=Interrupt(1e-5))
    kept = caught.value.kept["lyapunov"]
    count = kept.sizes["time"]
    assert 64 <= count < 4 * 10**6
    few = min(100, count // 4)
    whole = linkages.lyapunov(pendulum(), periods=few)
    # the same steps, but for the last one of a run
    begun = kept.history[: 4 * few].to_numpy()
    assert (begun[:-1] == whole.history.to_numpy()[:-1]).all()
    assert begun[-1] == pytest.approx(whole.history.to_numpy()[-1], abs=1e-6)


def test_too_few_intervals_for_an_error_are_no_result():
    """An interval is so long that the first is not over when somebody presses Ctrl-C."""
    with pytest.raises(Interrupted, match="interrupted") as caught:
        linkages.lyapunov(pendulum(), periods=100, interval=1e6, watch=Interrupt(0.0))
    assert not caught.value.kept


@pytest.mark.parametrize("confirming", [False, True])
def test_evidence_so_far_is_kept(confirming, monkeypatch):
    """The run, or its repetition, takes longer than a machine computes until it looks for Ctrl-C.

    All that the verdict rests on is there before the repetition begins.
    """
    made = LinkageTangents.starting

    def for_long(self, run):
        found = made(self, run)
        grow = found.grow
        found.grow = lambda intervals, interval, **given: grow(10**4 * intervals, interval, **given)
        return found

    monkeypatch.setattr(LinkageTangents, "starting", for_long)
    interrupt = Interrupt(0.5 + 1e-9 if confirming else 1e-6)
    with pytest.raises(Interrupted) as caught:
        verdict(pendulum(), periods=200 if confirming else 10**6, watch=interrupt)
    motion = {"chaos_section", "chaos_motion"} if confirming else set()
    assert set(caught.value.kept) == {"chaos_exponents", *motion}
    if confirming:
        assert caught.value.kept["chaos_motion"].sizes["time"] == 200 * PER_PERIOD + 1


def test_continuation_keeps_the_values_that_are_done():
    def interrupt(progress):
        if progress.done == 2:
            raise KeyboardInterrupt

    vary = {"dampers[0].damping": np.linspace(0.5, 0.8, 4)}
    given = {"periods": 3, "skip": 0, "start": "forward", "executor": Threads(1)}
    with pytest.raises(Interrupted, match="interrupted after 2 of 4 values") as caught:
        linkages.bifurcation(pendulum(), vary, **given, watch=interrupt)
    part = caught.value.kept["bifurcation"]
    whole = linkages.bifurcation(pendulum(), vary, **given)
    assert part.attrs["interrupted"] == 1
    assert (part.bar_speed[0, :2] == whole.bar_speed[0, :2]).all()
    assert np.isnan(part.bar_speed[0, 2:]).all()
    assert [bool(reason) for reason in part.reason[0].to_numpy()] == [False, False, True, True]


def test_chains_of_continuation_do_not_depend_on_each_other():
    vary = {"dampers[0].damping": np.linspace(0.5, 0.7, 3)}
    starts = [{"free.arm.angle": 0.3}, {"free.arm.angle": 2.0}]
    given = {"periods": 3, "skip": 0, "start": "backward"}
    both = linkages.bifurcation(pendulum(), vary, **given, initial=starts)
    for row, start in enumerate(starts):
        alone = linkages.bifurcation(pendulum(), vary, **given, initial=[start])
        assert (both.bar_angle[row] == alone.bar_angle[0]).all()


@pytest.mark.parametrize(
    "computation",
    [
        lambda mechanism, **given: linkages.simulate(mechanism, end=1e6, **given),
        lambda mechanism, **given: linkages.simulate(mechanism, end=1e6, throw=False, **given),
        lambda mechanism, **given: linkages.poincare(mechanism, periods=10**6, **given),
        lambda mechanism, **given: linkages.lyapunov(mechanism, periods=10**4, **given),
        lambda mechanism, **given: verdict(mechanism, periods=10**5, **given),
    ],
    ids=["simulate", "simulate-throw", "poincare", "lyapunov", "chaos"],
)
def test_ctrl_c_ends_a_loop_that_goes_on_after_errors(computation):
    """It is no Exception: `except Exception` is what loops over many runs have."""
    rounds = []

    def loop() -> None:
        for number in range(2):
            rounds.append(number)
            with contextlib.suppress(Exception):
                computation(pendulum(), watch=Interrupt(1e-9))

    with pytest.raises(KeyboardInterrupt) as caught:
        loop()
    assert rounds == [0]
    assert isinstance(caught.value, Interrupted)


def test_ctrl_c_keeps_the_motion_so_far():
    with pytest.raises(Interrupted, match="interrupted") as caught:
        linkages.simulate(pendulum(), end=1e6, samples=10**6 + 1, watch=Interrupt(1e-5))
    data = caught.value.solution.data
    assert 0 < data.sizes["time"] < 10**6
    assert data.time[-1] <= caught.value.time
    whole = linkages.simulate(pendulum(), end=2.0, samples=3).data
    # the same steps but for the last
    assert data.bar_speed[:2].to_numpy() == pytest.approx(whole.bar_speed[:2].to_numpy(), abs=1e-7)


@pytest.mark.parametrize("step", ["evaluate_variables", "_add_derived"])
def test_ctrl_c_while_outputs_are_computed_keeps_the_motion(monkeypatch, step):
    from linkages.solution import simulate as module

    run = getattr(module, step)

    def pressed(*arguments):
        signal.raise_signal(signal.SIGINT)
        return run(*arguments)

    monkeypatch.setattr(module, step, pressed)
    with pytest.raises(Interrupted, match="after the motion was computed") as caught:
        linkages.simulate(pendulum(), outputs=["bar_angle", "kinetic_energy"])
    monkeypatch.undo()
    whole = linkages.simulate(pendulum(), outputs=["bar_angle", "kinetic_energy"])
    assert caught.value.solution.data.equals(whole.data)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_while_the_horizon_is_looked_for_is_heard(monkeypatch):
    """The comparison run was taken for one that went elsewhere."""
    from linkages.solution import solution as module

    solution = linkages.simulate(pendulum())
    run = module.compute_motion

    def interrupted(system, settings):
        return run(system, dataclasses.replace(settings, watch=Interrupt(0.5)))

    monkeypatch.setattr(module, "compute_motion", interrupted)
    with pytest.raises(KeyboardInterrupt):
        _ = solution.horizon


def test_interrupting_one_computation_interrupts_the_sweep():
    def task(_):
        raise Interrupted("interrupted")

    with pytest.raises(KeyboardInterrupt):
        attempt(task, 0, None)


def test_verdict_on_a_mechanism_at_rest():
    """Nothing drives it, and its section is never crossed."""
    rest = {"loads": [], "gravity": [1, 0], "free.arm.angle": 0}
    report = verdict(pendulum(**rest), periods=200)
    assert report.verdict == "at rest"
    assert report.section.sizes["crossing"] == 0
    assert report.rotation["arm"].kind == "resting"


def test_verdict_on_a_motion_that_dies_away():
    report = verdict(pendulum(loads=[]), periods=200, skip=0)
    assert report.verdict == "at rest"
    assert any("comes to rest" in reason for reason in report.reasons)
    # exponents of the equilibrium: eigenvalues -d/2 ± iω, with d = 0.5 N m s and J = 1 kg m²
    assert float(report.exponents.exponent[0]) == pytest.approx(-0.25, abs=1e-3)


def test_verdict_on_a_section_that_is_one_point():
    """Strong damping: after the transient all section points coincide to the last digit."""
    report = verdict(pendulum(**{"dampers[0].damping": 4.0}), periods=200, skip=100)
    assert report.verdict == "periodic"
    assert report.period == 1


def test_all_tolerances_are_tightened():
    given = options_of(RunOptions, pendulum(**{"simulate.atol": 1e-7}), {"rtol": 1e-6})
    assert (given.rtol, given.atol) == (1e-6, 1e-7)  # the file's atol stays, as in `simulate`
    tight = tightened(given)
    assert (tight.rtol, tight.atol) == pytest.approx((1e-7, 1e-8))


@pytest.mark.slow
def test_fixed_steps_are_shortened_instead_of_tolerances():
    mechanism = pendulum(**{"simulate.method": "rk4", "simulate.step": 0.02})
    given = {"periods": 20, "skip": 20}
    fixed = linkages.lyapunov(mechanism, **given)
    exact = linkages.lyapunov(pendulum(**{"dampers[0].damping": 0.5}), **given)
    # RK4 at this step errs by 1e-8 a period, chaos makes 20 periods from it: sums do not care
    assert fixed.attrs["sum"] == pytest.approx(exact.attrs["sum"], abs=1e-6)
    report = verdict(pendulum(**{"simulate.method": "rk4", "simulate.step": 0.05}), periods=200)
    assert report.tighter["how"] == f"step {0.05 / 10**0.25:.3g} s"
