"""The hand-written C program and SciPy compute the motion that is known to many digits."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from contact_in_c import REFERENCE, compiled, measure, run_c
from contact_in_python import integrate

CONTENT = json.loads(REFERENCE.read_text(encoding="utf-8"))
NAMES = ("gap.offset_x", "gap.offset_y", "gap.rate_x", "gap.rate_y")
SCALES = np.array([0.6e-3, 0.6e-3, 3.0, 3.0])


def expected(time: str) -> dict[str, float]:
    (state,) = (state for state in CONTENT["states"] if state["t"] == time)
    return {key: float(state[key]) for key in (*NAMES, "piston.velocity")}


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    found = compiled(tmp_path_factory.mktemp("c"))
    return found or pytest.skip("no C compiler on this machine")


@pytest.mark.parametrize(("rtol", "limit"), [(1e-8, 5e-8), (1e-10, 1e-9), (1e-12, 1e-11)])
def test_c_program_after_seven_contacts(program, rtol, limit):
    """Measured: 1.9e-8, 2e-10 and 2e-12 of the slider's velocity."""
    found, wanted = run_c(program, 0.002, rtol), expected("0.002")
    assert found.velocity == pytest.approx(wanted["piston.velocity"], rel=limit)
    off = (np.array(found.state) - [wanted[name] for name in NAMES]) / SCALES
    assert np.abs(off).max() < 30 * limit  # offsets are small differences of the large coordinates


def test_c_program_meets_every_event_of_a_revolution(program):
    """The motion loses 2.3 digits a revolution; 1e-9 s is what remains at 1e-12."""
    found = run_c(program, 0.012, 1e-12)
    assert [kind for _, kind in found.events] == [event["kind"] for event in CONTENT["events"]]
    times = [float(event["t"]) for event in CONTENT["events"]]
    assert [time for time, _ in found.events] == pytest.approx(times, abs=1e-9)


def test_without_location_the_first_rate_is_wrong(program):
    """Four orders less accurate at a tolerance of 1e-10, for more evaluations."""
    wanted = expected("0.002")["piston.velocity"]
    located, over = (run_c(program, 0.002, 1e-10, by) for by in (True, False))
    assert abs(over.velocity - wanted) > 1e4 * abs(located.velocity - wanted)


@pytest.mark.slow
def test_measuring_gives_all_figures(program):
    figures = measure(2, repeats=1)
    assert program.exists()
    assert {"seconds / C", "evaluations / C", "C located / not located", "SciPy / seconds"} <= {
        *figures
    }
    # Chaos differs from program to program, the cost of a revolution does not by a factor.
    assert 0.5 < figures["evaluations / C"] < 2


def test_equations_in_python_after_seven_contacts():
    """At 1e-8, located on an interpolant."""
    state, evaluations = integrate(0.002, 1e-8)
    off = (state - [expected("0.002")[name] for name in NAMES]) / SCALES
    assert np.abs(off).max() < 3e-6
    assert 2000 < evaluations < 8000
