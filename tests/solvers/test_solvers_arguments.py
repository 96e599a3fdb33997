"""Arguments are checked before anything runs, and messages help."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from solver_kernels import free_rates, pendulum, pendulum_rates

from linkages.solvers import (
    ADAPTIVE_METHODS,
    FIXED_STEP_METHODS,
    METHODS,
    Flow,
    Outcome,
    integrate,
)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"method": "dopri853"}, "did you mean 'dop853'"),
        ({"method": "euler"}, "known are 'dop853', 'tsit5', 'vern9', 'radau', 'rk4', 'gauss8'"),
        ({"method": "rk4"}, "needs a step"),
        ({"method": "rk4", "step": -0.1}, "step must be .* > 0"),
        ({"rtol": 1e-16}, "rtol must be from 1e-14"),
        ({"atol": 0.0}, "atol must be > 0"),
        ({"atol": [1e-9, 1e-9, 1e-9]}, "atol must be one number or one for each"),
        ({"times": []}, "at least one time"),
        ({"times": [0.0, 2.0, 1.0]}, "times must increase, or decrease"),
        ({"times": [0.0, 1.0, 1.0]}, "times must increase, or decrease"),
        ({"times": [0.0, np.nan]}, "times must be finite"),
        ({"times": [1.0, 2.0], "start": 1.5}, "times must increase, or decrease"),
        ({"state": [1.0]}, "1 coordinates and as many speeds"),
        ({"state": [1.0, np.inf]}, "state must be finite"),
        ({"max_steps": 0}, "max_steps must be at least 1"),
        ({"max_steps": 2**63}, "max_steps must be less than 2"),
    ],
)
def test_arguments_that_make_no_sense(change, message):
    arguments = {"flow": pendulum(), "state": [1.0, 0.0], "times": [0.0, 1.0]} | change
    with pytest.raises(ValueError, match=message):
        integrate(**arguments)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rates": 0}, "addresses"),
        ({"rotates": [True, False]}, "one entry for each of 1 coordinates"),
        ({"margin_scale": [0.0]}, "margin_scale must be > 0"),
        ({"parameters": [[1.0]]}, "one dimension"),
    ],
)
def test_flows_that_make_no_sense(change, message):
    fields = {
        "clock": free_rates.address,
        "rates": pendulum_rates.address,
        "parameters": [1.0],
        "timed_size": 0,
        "coordinates": 1,
        "rotates": [True],
        "margin_scale": [],
    }
    with pytest.raises(ValueError, match=message):
        Flow(**(fields | change))


def test_names_of_methods():
    assert set(ADAPTIVE_METHODS) | set(FIXED_STEP_METHODS) == set(METHODS)
    assert all(name == method.name for name, method in METHODS.items())


def test_initial_state_is_left_alone():
    state = np.array([1.0, 0.0])
    integrate(pendulum(), state, [0.0, 1.0])
    assert state.tolist() == [1.0, 0.0]


@pytest.mark.parametrize("outcome", list(Outcome), ids=lambda outcome: outcome.name)
def test_outcomes_are_sentences_with_a_remedy(outcome):
    assert outcome.sentence.endswith(".")
    assert outcome is Outcome.DONE or outcome.remedy.endswith(".")
    assert Outcome(int(outcome)) is outcome


def test_listing_methods_loads_no_compiler():
    code = (
        "import sys; from linkages.solvers import METHODS; METHODS['rk4'].tableau;"
        "sys.exit('llvmlite' in sys.modules or 'scipy.integrate' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_runs_compile_only_their_own_loop():
    code = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r});"
        "from solver_kernels import pendulum; from linkages.solvers import integrate;"
        "integrate(pendulum(), [1.0, 0.0], [0.0, 1.0]);"
        "others = ['loops.step_loop', 'loops.collocation_steps', 'loops.crossings'];"
        "sys.exit(any('linkages.solvers.' + name in sys.modules for name in others))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
