"""Files changed at random: refused with words, or run with finite numbers; nothing else.

`python -m pytest -m long -s tests/fuzz` judges 10,000 files and prints the table of outcomes.
"""

from collections import Counter

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from absolute_covered import NotCoveredError
from absolute_outputs import outputs
from changed_definitions_at_random import SOURCES, add, changed_files, places
from definition_parts import LAWS
from hypothesis import HealthCheck, Phase, given, seed, settings
from judged_definitions import Verdict, judge, non_finite
from kernel_values import COMPARED, at_sample, disagreements, state_at

from linkages.components.contributed.load_measures import Turn

QUICK, BLOCKS, BLOCK = 60, 10, 1000
EVERY = 3
"""One in so many of the files that run is compared with the absolute formulation."""
TAME = (1e-5, 1e5)
"""Sizes of lengths, masses, results, and condition numbers for which a comparison makes sense:
beyond, the linear systems of both roads lose more digits than are compared."""
TOLERANCE = 1e-6
"""In parts of the largest value of a variable, or of 1: systems of condition 1e5 squared, solved to
1e-16."""


@pytest.mark.slow
@given(changed_files())
@settings(max_examples=QUICK, deadline=None, derandomize=True, database=None,
          suppress_health_check=[HealthCheck.too_slow])  # fmt: skip
def test_changed_files(text):
    verdict = judge(text)
    assert not verdict.fault, f"{verdict.kind}\n{verdict.words}\n{text}"


def test_what_is_added_may_be_changed_without_changing_what_it_is_drawn_from():
    """Else a file depends on those before it, and cannot be drawn once more."""
    law = next(law for law in LAWS if isinstance(law, dict))
    content = {"bars": {"x": {"joints": ["A", "B"]}}}
    add(lambda _: ("loads", None, {"bar": "x", "torque": law}), content, places(content))
    assert content["loads"][0]["torque"] == law
    content["loads"][0]["torque"].clear()
    assert law


@pytest.mark.long
@pytest.mark.parametrize("block", range(BLOCKS))
def test_ten_thousand_changed_files(block):
    found: list[tuple[str, Verdict]] = []
    compared = Counter[str]()

    @seed(block)
    @settings(max_examples=BLOCK, deadline=None, database=None, phases=[Phase.generate],
              suppress_health_check=list(HealthCheck))  # fmt: skip
    @given(changed_files())
    def every(text):
        verdict = judge(text)
        if verdict.kind in ("ran", "stopped") and len(found) % EVERY == 0:
            try:
                compared[compare(verdict.solution)] += 1
            except NotCoveredError:  # contact, which tests/contact covers, or a law at its corner
                compared["not covered"] += 1
        verdict.solution = None
        found.append((text, verdict))

    every()
    kinds = Counter(verdict.kind for _, verdict in found)
    print(f"\nblock {block}: {dict(kinds)}, compared {dict(compared)}")
    faults = [(v.kind, v.words, text) for text, v in found if v.fault]
    faults.sort(key=lambda fault: len(fault[2]))
    assert not faults, f"{len(faults)} faults, the smallest:\n" + "\n".join(faults[0])
    assert kinds["ran"] > 0.05 * BLOCK  # files are not all refused at once
    assert compared["same"] > 0.01 * BLOCK
    assert not compared["different"]


def compare(solution):
    """Whether samples of a motion are as the absolute formulation has them."""
    data = solution.data
    if not data.sizes["time"] or not _tame(solution):
        return "beyond"
    model = AbsoluteModel(solution.mechanism)
    for sample in (0, data.sizes["time"] // 2):
        found = at_sample(data, sample)
        known = _within_half_a_turn(solution, found)
        solved = model.solve(state_at(model, known, float(data["time"][sample])))
        off = disagreements(found, outputs(model, solved), TOLERANCE)
        if model.redundant:  # reactions are not determined
            off = {name: part for name, part in off.items() if not name.endswith("_reaction")}
        if off:
            print(solution.mechanism.document.content, sample, off)
            return "different"
    return "same"


def _within_half_a_turn(solution, found):
    """What was found, with angles at which torques between two bodies begin as they should.

    Whole turns of a difference that depends on other links are taken away at t = 0
    (docs/components/spring.md); the absolute formulation does not know of a beginning.
    """
    mechanism, angles = solution.mechanism, dict(found.get("bar_angle", {}))
    first = at_sample(solution.data, 0).get("bar_angle", {})
    known = {*mechanism.prescribed, *mechanism.initial}
    for load in mechanism.loads:
        match load.measure:
            case Turn(body, str(reference)) if {body, reference} <= first.keys():
                own = next((name for name in (body, reference) if name not in known), None)
                turns = 2 * np.pi * np.round((first[body] - first[reference]) / (2 * np.pi))
                if own is not None:
                    angles[own] -= turns if own == body else -turns
    return {**found, "bar_angle": angles}


def _tame(solution):
    low, high = TAME
    bodies = solution.mechanism.bodies.values()
    lengths = [x.value for body in bodies for place in body.points.values() for x in place]
    sizes = np.abs([x for x in (*lengths, *(body.mass.value for body in bodies)) if x != 0])
    values = [np.abs(solution.data[name]).max() for name in COMPARED if name in solution.data]
    worst = max(1.0, *solution.system.conditions, *map(float, values))
    return worst < high and (sizes > low).all() and (sizes < high).all()


def test_what_is_not_finite_is_found():
    """A judge that finds no fault where there is one would be worth nothing."""
    solution = judge(SOURCES[-3]).solution
    data = solution.data.copy(deep=True)
    assert non_finite(data) == []
    data["joint_position"][3, 0, 0] = np.inf
    data["mechanical_advantage"][2, 0, 0] = np.inf  # where a drive does not move a body
    assert non_finite(data) == ["joint_position"]
    data["mechanical_advantage"][2, 0, 0] = np.nan
    assert non_finite(data) == ["joint_position", "mechanical_advantage"]


def test_a_traceback_and_an_endless_case_are_found(monkeypatch):
    monkeypatch.setattr("judged_definitions.check_content", lambda _: 1 / 0)
    assert judge(SOURCES[-1]).kind == "traceback"

    def forever(_):
        while True:
            pass

    monkeypatch.setattr("judged_definitions.check_content", forever)
    monkeypatch.setattr("judged_definitions.SECONDS", 0.1)
    assert judge(SOURCES[-1]).kind == "endless"
