"""Sweeps, maps and diagrams on a stand-in for a graphics processor equal those on the CPU."""

import numpy as np
import pytest
from shared_definitions import worn_engine
from stand_in_driver import installed

import linkages
from linkages.chaos import bifurcation
from linkages.kernel.code.cuda import DeviceError
from linkages.options.option import OptionError
from linkages.solvers import device_motions as accelerated
from linkages.sweeps.engine import batches
from linkages.sweeps.running import Threads

PENDULUM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  arm: {joints: [O, P], length: 1 m, mass: 2 kg}
  more: {joints: [P, Q], length: 0.5 m, mass: 1 kg}
free: {arm: {angle: 2 rad, speed: 0 rad/s}, more: {angle: 0 rad, speed: 3 rad/s}}
simulate: {end: 0.5 s, samples: 11, rtol: 1e-8, method: vern9}
"""
CRANK = """
joints: {O: [0, 0]}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}
  rod: {joints: [A, B], length: 0.14, mass: 0.5, center: 0.07}
drives: {crank: {angle: 0, speed: 600 rpm}}
assembly: {B: [0.18, 0]}
"""
WORN = worn_engine("""\
clearances:
  gap: {joint: A, bar: rod, size: 0.1 mm, carries: hole, pin_radius: 8 mm,
        friction: 0.05, slip: 10 mm/s,
        contact: hunt-crossley-constant, stiffness: 2e8 N/m^1.5, dissipation: 1.5 s/m}
drives: {crank: {angle: 0, speed: 600 rpm}}
simulate: {end: 0.05, samples: 11, rtol: 1e-6}
""")
MEASURES = ["max(arm.speed)", "final(more.angle)"]


@pytest.fixture
def driver(monkeypatch):
    """A stand-in that two motions are worth while for, and that 24 fill."""
    monkeypatch.setattr(accelerated, "FEWEST", 2)
    monkeypatch.setattr(accelerated, "PER_MULTIPROCESSOR", 24)
    return installed(monkeypatch, multiprocessors=1)


def require_used(driver):
    assert driver.calls["cuLaunchKernel"]
    assert not driver.memory
    assert not driver.contexts


def test_a_sweep(driver):
    """More points than a chunk has; some cannot be assembled, some run out of steps."""
    mechanism = linkages.loads(PENDULUM)
    over = {"bars.arm.length": np.linspace(-0.01, 2, 40)}
    expected = linkages.sweep(mechanism, over, MEASURES, max_steps=40)
    assert {0, 1, 4} == set(np.unique(expected.outcome))
    found = linkages.sweep(mechanism, over, MEASURES, max_steps=40, device="cuda", cores=2)
    require_used(driver)
    assert found.identical(expected)


@pytest.mark.slow
@pytest.mark.parametrize("indicator", ["fli", "gali", "exponent"])
def test_a_map(indicator, driver):
    mechanism = linkages.loads(PENDULUM)
    axes = {"free.more.speed": [1.0, 3.0, 5.0]}, {"free.arm.angle": [0.1, 2.0, 3.0]}
    options = {"indicator": indicator, "periods": 4}
    expected = linkages.chaos_map(mechanism, *axes, **options)
    found = linkages.chaos_map(mechanism, *axes, **options, device="cuda")
    require_used(driver)
    assert found.identical(expected)


def test_a_diagram(driver):
    mechanism = linkages.load("ninebar")
    vary = {"clearances.r1.size": ["0.1 mm", "0.2 mm", "0.4 mm"]}
    options = {"periods": 2, "skip": 0, "rtol": 1e-6}
    expected = linkages.bifurcation(mechanism, vary, **options)
    found = linkages.bifurcation(mechanism, vary, **options, device="cuda")
    require_used(driver)
    assert found.identical(expected)


@pytest.mark.slow
def test_exponents_of_a_diagram(driver, monkeypatch):
    """Over fewer periods than users get."""
    monkeypatch.setattr(bifurcation, "EXPONENT_PERIODS", 4)
    monkeypatch.setattr(bifurcation, "ALIGNING", 1)
    mechanism = linkages.load("ninebar")
    vary = {"clearances.r1.size": ["0.1 mm", "0.2 mm", "0.4 mm"]}
    options = {"periods": 1, "skip": 0, "rtol": 1e-6, "exponent": True}
    expected = linkages.bifurcation(mechanism, vary, **options)
    assert np.isfinite(expected.exponent).all()
    found = linkages.bifurcation(mechanism, vary, **options, device="cuda")
    require_used(driver)
    assert found.identical(expected)


@pytest.mark.slow
def test_motions_with_modes(driver):
    """Contact opens and closes under friction: modes change in steps left to the CPU."""
    mechanism = linkages.loads(WORN)
    over = {"clearances.gap.size": ["0.1 mm", "0.2 mm", "0.3 mm"]}
    measures = ["max(gap.force)", "mean(gap.force)"]
    expected = linkages.sweep(mechanism, over, measures)
    assert not expected.outcome.any()
    found = linkages.sweep(mechanism, over, measures, device="cuda")
    require_used(driver)
    assert found.identical(expected)


@pytest.mark.slow
def test_a_map_of_motions_with_modes(driver):
    mechanism = linkages.loads(WORN)
    axes = {"clearances.gap.size": ["0.1 mm", "0.3 mm"]}, {"bars.rod.mass": [0.4, 0.5]}
    options = {"indicator": "fli", "periods": 4, "rtol": 1e-6}
    expected = linkages.chaos_map(mechanism, *axes, **options)
    found = linkages.chaos_map(mechanism, *axes, **options, device="cuda")
    require_used(driver)
    assert found.identical(expected)


@pytest.mark.slow
def test_a_store_goes_on_elsewhere(driver, tmp_path):
    """Chunks of one place beside chunks of another: the result has the same bytes."""
    mechanism = linkages.loads(PENDULUM)
    over = {"bars.arm.length": np.linspace(0.5, 2, 40)}
    for name, device in (("here", "cpu"), ("there", "cuda")):
        linkages.sweep(mechanism, over, MEASURES, store=tmp_path / name, device=device)
    require_used(driver)
    result = (tmp_path / "here" / "result.nc").read_bytes()
    assert (tmp_path / "there" / "result.nc").read_bytes() == result
    for name, device in (("here", "cuda"), ("there", "cpu")):
        store, before = tmp_path / name, driver.calls["cuLaunchKernel"]
        (store / "result.nc").unlink()
        chunks = sorted((store / "chunks").iterdir())
        assert len(chunks) == 5
        for chunk in chunks[1:4]:
            chunk.unlink()
        linkages.sweep(mechanism, over, MEASURES, store=store, device=device)
        assert (store / "result.nc").read_bytes() == result
        assert (driver.calls["cuLaunchKernel"] > before) == (device == "cuda")


def test_what_a_driver_refuses_is_no_answer(driver, tmp_path):
    """The sweep ends; nothing of it is taken for what became of the points."""
    mechanism = linkages.loads(PENDULUM)
    over = {"bars.arm.length": np.linspace(0.5, 2, 20)}
    driver.refuse["cuLaunchKernel"] = 2, 700
    with pytest.raises(DeviceError, match=r"refused cuLaunchKernel \(700\)"):
        linkages.sweep(mechanism, over, MEASURES, store=tmp_path, device="cuda", end=5.0)
    assert not list((tmp_path / "chunks").iterdir())
    assert not driver.memory
    assert not driver.contexts


def test_ctrl_c_ends_it(driver):
    mechanism = linkages.loads(PENDULUM)
    over = {"bars.arm.length": np.linspace(0.5, 2, 90)}

    def watch(_progress):
        raise KeyboardInterrupt

    with pytest.raises(linkages.Interrupted, match=r"after \d+ of 90 points") as ended:
        linkages.sweep(mechanism, over, MEASURES, device="cuda", watch=watch)
    outcomes = ended.value.kept["sweep"].outcome.to_numpy()
    assert set(np.unique(outcomes)) == {0, 7}
    require_used(driver)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ({"measure": "max(arm.speed)", "device": "gpu"}, "found 'gpu'; expected 'cpu' or 'cuda'"),
        ({"executor": object()}, "'cuda' is of this machine; expected no executor or scheduler"),
        ({"time_per_point": 9}, "a sweep with a time for each point is computed on the CPU only"),
        ({"measure": "max(energy_residual)"}, r"a measure of a whole motion \(energy_residual\)"),
        ({"method": "radau"}, "a motion by the method 'radau' is computed on the CPU only"),
        ({"method": "rk4", "step": 1e-3}, "a motion in steps of one length"),
        ({"over": {"simulate.rtol": [1e-8, 1e-9]}}, "a sweep over options of the simulation"),
    ],
)
def test_sweeps_that_are_computed_on_the_cpu_only(call, message):
    given = {"over": {"bars.arm.length": [1.0, 2.0]}, "measure": MEASURES, "device": "cuda"} | call
    with pytest.raises(OptionError, match=message) as refused:
        linkages.sweep(linkages.loads(PENDULUM), **given)
    assert refused.value.name == "device"


def test_motions_that_are_computed_on_the_cpu_only():
    over = {"bars.rod.mass": [0.4, 0.5]}
    with pytest.raises(OptionError, match="a motion that drives determine is computed on the CPU"):
        linkages.sweep(linkages.loads(CRANK), over, "max(abs(crank.effort))", device="cuda")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"start": "forward"}, "a diagram whose values go on from each other"),
        ({"section": "slider9.velocity=0"}, "a diagram of crossings of a section"),
    ],
)
def test_diagrams_that_are_computed_on_the_cpu_only(options, message):
    vary = {"clearances.r1.size": ["0.1 mm", "0.2 mm"]}
    with pytest.raises(OptionError, match=message):
        linkages.bifurcation(linkages.load("ninebar"), vary, **options, device="cuda")


def test_chunks_are_put_together_where_they_are_neighbours():
    spans = [(0, 8), (8, 16), (24, 32), (32, 40), (40, 44)]
    assert batches(spans, 0) == [[span] for span in spans]
    assert batches(spans, 16) == [[(0, 8), (8, 16)], [(24, 32), (32, 40)], [(40, 44)]]
    assert batches(spans, 100) == [[(0, 8), (8, 16)], [(24, 32), (32, 40), (40, 44)]]


def test_cores_are_those_that_finish_steps(driver):
    """They may be given as threads, too."""
    mechanism = linkages.loads(PENDULUM)
    over = {"bars.arm.length": np.linspace(0.5, 2, 4)}
    found = linkages.sweep(mechanism, over, MEASURES, executor=Threads(3), device="cuda")
    require_used(driver)
    assert found.identical(linkages.sweep(mechanism, over, MEASURES))
