"""Errors of adaptive methods follow the tolerance, over all of its range."""

import dataclasses
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from solver_kernels import ORBIT, PERIOD, arenstorf, pendulum, swing

import linkages
from linkages.kernel.system import System
from linkages.solution.plan import build_flow
from linkages.solvers import METHODS, choose, integrate, integration
from linkages.solvers.flow import Renormalisation

STATES = Path(__file__).parents[1] / "data" / "ninebar_states.json"
NAMES = ["dop853", "tsit5", "vern9"]
TOLERANCES = 10.0 ** -np.arange(5, 12.5, 0.5)


def swing_errors(**method):
    times = np.linspace(0, 30, 301)
    result = integrate(pendulum(), [2.0, 0.0], times, **method)
    return np.abs(result.state[:, 0] - swing(2.0, times)[0])


def orbit_errors(**method):
    result = integrate(arenstorf(), ORBIT, [0.0, PERIOD], **method)
    return np.abs(result.final_state[:2] - ORBIT[:2])


@pytest.fixture(scope="module")
def ninebar():
    """The nine-bar from the first of its reference states, and its angles later on."""
    angles = {
        "drives.crank1.angle": 0.5,
        "drives.crank4.angle": 1.0,
        "clearances.r1.angle": 0.0,
    }
    system = System(linkages.load("ninebar.yaml", set=angles))
    flow = build_flow(system)
    times = np.linspace(0, 2, 201)
    reference = integrate(flow, system.state, times, method="gauss8", step=2 / 60_000)
    return flow, system.state, times, reference.state[:, 0]


def test_memory_of_the_step_control_saves_rejected_steps(ninebar, monkeypatch):
    """PI control damps the step size where the error changes quickly, as in each swing."""
    flow, start, times, _ = ninebar
    rejected = {}
    for memory in (0.0, METHODS["tsit5"].memory):
        method = replace(METHODS["tsit5"], memory=memory)
        monkeypatch.setattr(integration, "METHODS", {"tsit5": method})
        found = integrate(flow, start, times, method="tsit5", rtol=1e-7)
        rejected[memory] = found.rejected / found.steps
    with_memory, without = rejected[METHODS["tsit5"].memory], rejected[0.0]
    assert with_memory < 0.95 * without


def ninebar_errors(ninebar, **method):
    flow, start, times, reference = ninebar
    result = integrate(flow, start, times, **method)
    return np.abs(np.angle(np.exp(1j * (result.state[:, 0] - reference))))


def test_gauss_reaches_the_reference_to_round_off(ninebar):
    _, _, times, angles = ninebar
    for state in json.loads(STATES.read_text())["states"]:
        if 0.0 < state["t"] <= times[-1]:
            found = angles[np.argmin(np.abs(times - state["t"]))]
            # Angles are doubles, and round-off has grown over 2 s of motion.
            assert found == pytest.approx(float(state["clearance_angle"]), abs=1e-12)


def spread(errors):
    """Largest factor between errors and what is proportional to the tolerance."""
    ratios = np.log10(np.array(errors) / TOLERANCES)
    return 10 ** np.abs(ratios - (ratios.max() + ratios.min()) / 2).max()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("errors_of", [swing_errors, orbit_errors], ids=["swing", "orbit"])
def test_error_is_proportional_to_the_tolerance(name, errors_of):
    errors = [errors_of(method=name, rtol=rtol).max() for rtol in TOLERANCES]
    assert spread(errors) < 10


@pytest.mark.slow_except("vern9")
@pytest.mark.parametrize("name", NAMES)
def test_error_of_the_ninebar_is_proportional_to_the_tolerance(name, ninebar):
    errors = [ninebar_errors(ninebar, method=name, rtol=rtol).max() for rtol in TOLERANCES]
    assert spread(errors) < 10


@pytest.mark.parametrize(("rtol", "name"), [(1e-3, "tsit5"), (1e-5, "tsit5"), (1e-9, "vern9")])
def test_automatic_choice_says_what_and_why(rtol, name):
    result = integrate(pendulum(), [1.0, 0.0], [0.0, 1.0], method="auto", rtol=rtol)
    assert (result.method, result.reason) == choose(rtol)
    assert result.method == name
    assert f"{rtol:g}" in result.reason


def test_stiff_flows_take_an_implicit_method():
    stiff = dataclasses.replace(pendulum(), stiff=True)
    result = integrate(stiff, [1.0, 0.0], [0.0, 1.0], method="auto", rtol=1e-5)
    assert (result.method, result.reason) == choose(1e-5, stiff=True)
    assert result.method == "radau"
    along = Renormalisation(size=0, columns=0, placed=0, grown=np.zeros(0))
    watched = integrate(stiff, [1.0, 0.0], [0.0, 1.0], method="auto", rtol=1e-5, tangents=along)
    assert watched.method == "tsit5"


def test_chosen_methods_exist():
    assert {choose(rtol).name for rtol in TOLERANCES} <= set(METHODS)
