"""Steps for graphics processors: their rounding, and motions on a stand-in, to the last bit."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from stand_in_driver import installed

import linkages
from linkages.kernel.code.cuda import DeviceError, MissingFunctionError
from linkages.kernel.system import System
from linkages.solution.plan import Plan
from linkages.solvers import device_motions as accelerated_motions
from linkages.solvers import device_motions as launches
from linkages.solvers.device_motions import Accelerator, accelerated
from linkages.solvers.device_steps import write_device_steps
from linkages.solvers.flow import Flow, Renormalisation
from linkages.solvers.integration import METHODS, integrate, request
from linkages.solvers.lanes import integrate_many
from linkages.solvers.loops.row_layout import RowLayout
from linkages.solvers.trajectory import Outcome

ADAPTIVE = ["tsit5", "dop853", "vern9"]
ROUNDED = re.compile(r"^\s*(?:@\S+\s+)?((?:add|sub|mul|div|fma|mad|rcp|sqrt)\.\S*f64)\s", re.M)
PARTS = (
    "time", "state", "turns", "acceleration", "angles", "final_state", "final_turns",
    "final_angles", "lengths", "grown", "outcome", "stop_time", "block", "steps", "rejected",
    "evaluations",
)  # fmt: skip

# No crank: where coupler and rocker are stretched the mechanism goes no further.
ROCKERS = """
joints: {O: [0, 0], C: [1 m, 0]}
bars:
  crank: {joints: [O, A], length: 0.6 m, mass: 1 kg}
  coupler: {joints: [A, B], length: 0.5 m, mass: 1 kg}
  rocker: {joints: [B, C], length: 0.5 m, mass: 1 kg}
free: {crank: {angle: 0.4 rad, speed: 0.1 rad/s}}
assembly: {B: [1, 0.5]}
"""
TURNING = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.3 m, 0]}
bars:
  crank: {joints: [O, A], length: 1 m, mass: 1 kg}
  coupler: {joints: [A, B], length: 0.8 m, mass: 1 kg}
  rocker: {joints: [B, C], length: 1 m, mass: 1 kg}
  second: {joints: [A, D], length: 0.2 m, mass: 1 kg}
free: {crank: {angle: 0.4 rad, speed: 9 rad/s}, second: {angle: 0 rad, speed: -3 rad/s}}
assembly: {B: [0.6, 1]}
"""


def ptx_of(name, method, tangents=0):
    flow = Plan.of(of := System(linkages.load(name)), tangents=tangents).bind(of)
    chosen = METHODS[method]
    return write_device_steps(chosen.tableau, RowLayout.of(flow), flow.routines(), chosen.memory)


@pytest.mark.slow_except("ninebar-1-tsit5")
@pytest.mark.parametrize(
    ("name", "tangents", "method"),
    [
        ("ninebar", 0, "vern9"), ("ninebar", 1, "tsit5"), ("andrews", 0, "dop853"),
        ("class-three", 0, "tsit5"), ("slider-crank-contact", 1, "vern9"),
    ],
)  # fmt: skip
def test_every_operation_says_how_it_rounds(name, tangents, method):
    text = ptx_of(name, method, tangents)
    operations = ROUNDED.findall(text)
    assert len(operations) > 700
    assert all(".rn" in operation for operation in operations)
    assert not re.findall(r"\.extern|\.approx|\.ftz|prototype_", text)  # nor calls by address
    assert len(re.findall(r"\.visible \.entry advance_lanes\(", text)) == 1


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("ptxas"), reason="needs NVIDIA's assembler")
@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_assembler_takes_it(method, tmp_path):
    """Without tangents nothing is spilled, and 384 threads have room on a multiprocessor."""
    path = tmp_path / "steps.ptx"
    path.write_text(ptx_of("ninebar", method))
    command = ["ptxas", "-v", "-arch=sm_90", str(path), "-o", str(tmp_path / "code")]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    (used,) = map(int, re.findall(r"Used (\d+) registers", said))
    assert used <= 65536 // 384, said
    assert not any(map(int, re.findall(r"(\d+) bytes spill", said))), said


@pytest.fixture
def driver(monkeypatch):
    """A stand-in with room for 64 motions at a time, on which two are as good as many."""
    monkeypatch.setattr(accelerated_motions, "FEWEST", 2)
    return installed(monkeypatch, multiprocessors=1)


def there(requests, driver, helpers=1, **options):
    """Integrate on the stand-in."""
    with Accelerator(helpers=helpers) as card, accelerated(card):
        found = integrate_many(requests, **options)
    assert driver.calls["cuLaunchKernel"]
    assert not driver.memory
    assert not driver.contexts
    return found


def require_equal(found, expected):
    for k, (one, other) in enumerate(zip(found, expected, strict=True)):
        for name in PARTS:
            a, b = getattr(one, name), getattr(other, name)
            assert np.array_equal(a, b), (k, name)


def motions(text, count, times, **options):
    """States apart by a thousandth, and speeds; each motion has more time than the one before."""
    of = System(linkages.loads(text) if "\n" in text else linkages.load(text))
    layout = {key: options.pop(key) for key in ("tangents_", "counting") if key in options}
    plan = Plan.of(of, tangents=layout.get("tangents_", 0), counting=layout.get("counting", False))
    found = []
    for k in range(count):
        flow = plan.bind(of)
        start = np.ones(2 * flow.coordinates)
        start[: len(of.state) // 2] = of.state[: len(of.state) // 2]
        start[flow.coordinates :][: len(of.state) // 2] = of.state[len(of.state) // 2 :]
        start *= 1 + 1e-3 * k
        given = {"rtol": 1e-8} | {n: v[k] if isinstance(v, list) else v for n, v in options.items()}
        found.append((flow, start, np.asarray(times) * (1 + 0.01 * k), given))
    return found


def asked(given):
    return [request(flow, state, times, **options) for flow, state, times, options in given]


def alone(given):
    return [integrate(flow, state, times, **options) for flow, state, times, options in given]


@pytest.mark.slow_except("tsit5")
@pytest.mark.parametrize("method", ADAPTIVE)
def test_motions_have_the_bits_of_single_ones(method, driver):
    """With samples, more motions than slots, and several threads that could finish steps."""
    given = motions("ninebar", 70, [0.0, 0.004, 0.0041, 0.0042, 0.02], method=method)
    found = there(asked(given), driver, helpers=3)
    assert {one.outcome for one in found} == {Outcome.DONE}
    require_equal(found, alone(given))


def test_dependent_angles_are_counted(driver):
    given = motions(TURNING, 5, np.linspace(0, 3, 40), counting=True)
    found = there(asked(given), driver)
    assert any(np.abs(one.angles[-1]).max() > 2 * np.pi for one in found)
    assert any(one.final_turns.any() for one in found)
    require_equal(found, alone(given))


@pytest.mark.parametrize("orthogonal", [True, False])
def test_tangents_are_renormalised_on_the_cpu(orthogonal, driver):
    """Each of their samples is in a step that is left to it."""
    given = motions(
        "ninebar", 4, np.linspace(0, 0.05, 11)[1:], start=0.0, tangents_=1,
        tangents=Renormalisation(size=1, placed=1, columns=1, grown=np.zeros(1),
                                 orthogonal=orthogonal),
    )  # fmt: skip
    found = there(asked(given), driver)
    assert all(len(one.lengths) for one in found)
    require_equal(found, alone(given))


def test_motions_backward_in_time(driver):
    given = motions("ninebar", 3, [0.0, -0.01, -0.02])
    require_equal(there(asked(given), driver), alone(given))


def test_what_ends_a_motion_leaves_the_others_alone(driver):
    steps = [10**6, 7, 10**6, 10**6, 10**6]
    given = motions(ROCKERS, 5, np.linspace(0, 20, 41), max_steps=steps)
    flow, state, times, options = given[2]
    given[2] = (flow, 10 * state, times, options)  # cannot even begin
    given[3] = (flow, state, [0.0], options)  # ends where it begins
    expected = alone(given)
    ends = [one.outcome for one in expected]
    assert ends[0] in (Outcome.SINGULAR, Outcome.UNREACHABLE)
    assert ends[1:4] == [Outcome.STEP_BUDGET, Outcome.UNREACHABLE, Outcome.DONE]
    require_equal(there(asked(given), driver), expected)


def test_order_and_length_of_launches_do_not_matter(driver, monkeypatch):
    given = motions("ninebar", 9, [0.0, 0.02, 0.05])
    expected = alone(given)
    for most in (1, 3, 50):
        monkeypatch.setattr(launches, "MOST_TICKS", most)
        require_equal(there(asked(given[::-1]), driver), expected[::-1])


def test_some_are_integrated_here(driver):
    """Watched ones, fixed steps and those whose functions are known by their addresses alone."""
    given = motions("ninebar", 3, [0.0, 0.01]) + motions("ninebar", 3, [0.0, 0.01], step=1e-3)
    bare = [
        (Flow(**{**vars(flow), "routines": None}), *rest)
        for flow, *rest in motions("andrews", 3, [0.0, 0.001])
    ]
    require_equal(there(asked(given + bare), driver), alone(given + bare))
    assert len(driver.codes) == 1


def test_ctrl_c_keeps_what_is_there(driver):
    """The motions would take hours; each ends behind a launch."""
    given = motions("ninebar", 70, [0.0, 0.01, 1e6])

    def watch(fraction):
        assert 0.0 <= fraction < 1.0
        if driver.calls["cuLaunchKernel"] >= 2:
            raise KeyboardInterrupt

    found = there(asked(given), driver, watch=watch)
    assert {one.outcome for one in found} == {Outcome.INTERRUPTED}
    moved = [one for one in found if one.steps]
    assert len(moved) == 64  # the others had no slot yet
    assert all(one.stop_time > 0.0 for one in moved)
    early = found[0]
    flow, state, _, options = given[0]
    whole = integrate(flow, state, [0.0, 0.01, 0.2], **options)
    assert np.array_equal(early.state[1], whole.state[1])


@pytest.mark.parametrize(
    ("name", "number", "status", "message"),
    [
        ("cuMemAlloc_v2", 5, 2, r"refused cuMemAlloc_v2 \(2\): out of memory"),
        ("cuLaunchKernel", 2, 700, r"refused cuLaunchKernel \(700\): an illegal memory access"),
    ],
)
def test_a_driver_that_fails(name, number, status, message, driver):
    driver.refuse[name] = number, status
    with Accelerator() as card, accelerated(card), pytest.raises(DeviceError, match=message):
        integrate_many(asked(motions("ninebar", 4, [0.0, 1e6])))
    assert not driver.memory
    assert not driver.contexts


def test_little_memory_has_fewer_slots(driver, caplog):
    """Where there is room for a warp alone, others wait until it has done; nothing goes in less."""
    caplog.set_level("INFO")
    given = motions("ninebar", 70, [0.0, 0.01])
    threads = 128 * 2048  # what those of the stand-in take: bytes of each, threads at a time
    driver.free = threads + 20_000
    message = r"has \d+ bytes of memory left; 32 motions need (\d+), and its threads 262144"
    with (
        Accelerator() as card,
        accelerated(card),
        pytest.raises(DeviceError, match=message) as refused,
    ):
        integrate_many(asked(given))
    needed = int(re.search(message, str(refused.value))[1])
    driver.free = threads + 2 * needed
    require_equal(there(asked(given), driver), alone(given))
    assert "70 motions in 32 slots of Stand-in" in caplog.text


@pytest.mark.usefixtures("driver")
def test_functions_of_the_c_library_are_refused(monkeypatch):
    def refuse(*_):
        raise MissingFunctionError(["erf"])

    monkeypatch.setattr("linkages.solvers.device_motions.write_device_steps", refuse)
    with Accelerator() as card, accelerated(card), pytest.raises(DeviceError, match="call erf"):
        integrate_many(asked(motions("ninebar", 4, [0.0, 0.01])))
