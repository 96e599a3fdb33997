"""Times of the parts of a simulation, one test each.

    python -m pytest tests/benchmarks/test_benchmarks_parts.py --benchmark-only

Without that option each part runs once, so that an ordinary test run sees that it works and takes
no time. Machines are noisy: compare medians of runs on the same machine.
"""

import io

import numpy as np
import pytest

import linkages
from linkages.benchmark.problem import derivative
from linkages.kernel.system import System
from linkages.plots.figures import FIGURES, OF_ALL
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.march import compute_motion
from linkages.solution.plan import build_flow, kernel_source
from linkages.solution.simulate import simulate
from linkages.solvers.integration import integrate
from linkages.topology.topology import build_topology


@pytest.fixture
def timed(benchmark, request):
    """Run a part once; with ``--benchmark-only``, as often as pytest-benchmark sees fit."""
    benchmark.disabled = not request.config.getoption("benchmark_only")
    return benchmark


@pytest.fixture(scope="module")
def press():
    return linkages.load("ninebar")


@pytest.fixture(scope="module")
def system(press):
    return System(press)


@pytest.fixture(scope="module")
def flow(system):
    """Compiled, or loaded from the cache, before anything is timed."""
    flow = build_flow(system)
    integrate(flow, system.state, [0.0, 1e-3], method="rk4", step=1e-4)
    integrate(flow, system.state, [0.0, 1e-3])
    return flow


@pytest.fixture(scope="module")
def solution(press):
    return simulate(press, end=2.0)


def test_loading_a_file(timed):
    found = timed(linkages.load, "ninebar")
    assert len(found.bodies) == 9


def test_topology(timed, press):
    assert timed(build_topology, press).mobility == 3


def test_model_and_program(timed, system):
    program = timed(lambda: kernel_source(system.topology).program)
    assert "def rates" in program.text


def test_assembling_a_system(timed, press):
    assert timed(System, press).topology.free == ("r1",)


def test_loading_a_compiled_kernel(timed, system, flow):
    del flow  # compiled by now
    assert timed(build_flow, system).coordinates == 1


def test_one_call_of_the_kernel_from_python(timed, system, flow):
    rate = timed(derivative(flow), 0.0, system.state)
    assert rate[0] == system.state[1]
    assert np.isfinite(rate).all()


def test_rk4_hundred_thousand_steps(timed, system, flow):
    found = timed(lambda: integrate(flow, system.state, [0.0, 1.0], method="rk4", step=1e-5))
    assert found.steps == 100_000


@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5"])
def test_two_seconds_by_tolerance(timed, system, flow, method):
    found = timed(lambda: integrate(flow, system.state, [0.0, 2.0], method=method))
    assert found.time[-1] == 2.0


def test_two_seconds_with_two_thousand_samples(timed, system, solution):
    motion = timed(compute_motion, system, solution.settings)
    assert len(motion.time) == 2001


def test_evaluation_of_outputs(timed, solution):
    names = [str(name) for name in solution.data.data_vars if not str(name).endswith("_error")]
    values = timed(evaluate_variables, solution.motion, names)
    assert np.array_equal(values["bar_angle"], solution.data.bar_angle)


def test_a_driven_mechanism_from_start_to_end(timed):
    ideal = linkages.load("ninebar-ideal")
    assert timed(lambda: simulate(ideal)).completed


# The nine-bar's drives turn, its loads are constant, its clearance is closed, and it has no
# actuators: no figures of these.
MISSING = (
    "drive_force", "load_force", "load_torque", "clearance_orbit", "clearance_state",
    "rotary_actuator_angle", "rotary_actuator_speed", "linear_actuator_position",
    "linear_actuator_velocity", "actuator_power",
)  # fmt: skip


@pytest.mark.slow_except("slider_position", "phase")
@pytest.mark.parametrize("name", [name for name in OF_ALL if name not in MISSING])
def test_figure(timed, solution, name):
    def draw():
        figure = FIGURES[name](solution.data, solution.mechanism)
        stream = io.BytesIO()
        figure.savefig(stream, format="png")
        return stream.tell()

    assert timed(draw) > 1000
