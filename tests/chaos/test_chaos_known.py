"""Systems whose motion is known are judged right, or honestly undecided."""

import json
from pathlib import Path

import pytest
from make.verdicts.flows import FLOWS
from make.verdicts.known import Known
from make.verdicts.maps import MAPS
from make.verdicts.table import CLASSES, SKIPS, TOLERANCES, VERDICTS, judged, systems

DOCS = Path(__file__).parents[2] / "docs"

HARD = {
    "Logistic, r = 3.828",  # intermittent, in long laminar phases
    "Logistic, r = 1 + √8",  # at the tangent bifurcation
    "Standard map, K = 1.2, near the separatrix",  # tangents grow by little in 300 steps
}
REPRESENTATIVE = {
    "Ball on a table, e = 0.5, Γ = 0.9",
    "Ball on a table, e = 0.5, Γ = 1.5",
    "Ball on a table, e = 0.5, Γ = 1.7",
    "Ball on a table, e = 0.5, Γ = 1.75",
    "Ball on a table, e = 0.2, Γ = 1.1",
    "Stick–slip, friction 1, force 2, ω = 0.25",
    "Friction without sticking, ω = 1.3",
    "Motor with inductance, 5 rad/s",
    "Ball on a rigid stop from the beginning, beside a driven oscillator",
    "Two cranks, 60 and 97.0820393 rpm",
    "Duffing of 1 µm beside 1 m, force 0.28",
    "Duffing of 1 µm beside 1 m, force 0.37",
}
"""Of every class; those that differ in their numbers alone are compiled once."""

QUICK = [
    *MAPS,
    *(flow for flow in FLOWS if flow.name.startswith("Linear")),
    *(known for known in systems() if known.name in REPRESENTATIVE),
]


@pytest.mark.slow_except(
    "Arnold's*",
    "Ball on a table, e = 0.5*",
    "Circle map*K = 0.9",
    "Delayed logistic, a = 1.9",
    "Friction*",
    "H*, a = 0.2",
    "Logistic, r = [02]*",
    "Logistic, r = 3.5*",
    "Logistic, r = 3.83",
    "Logistic, r = 4",
    "Ricker*",
    "Stick*",
)
@pytest.mark.parametrize("known", QUICK, ids=lambda known: known.name)
def test_quick_ones_are_judged_right(known: Known):
    found = judged(known, None, TOLERANCES[0])
    assert found.mark == "right" or (found.mark == "undecided" and known.name in HARD), found
    assert found.measured is not False, found


def test_classes_have_enough_systems():
    assert {len(some) >= 10 for some in CLASSES.values()} == {True}
    assert {known.name for known in QUICK} >= REPRESENTATIVE


@pytest.mark.long
@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("skip", SKIPS)
@pytest.mark.parametrize("known", systems(), ids=lambda known: known.name)
def test_nothing_is_judged_wrong(known: Known, skip: int | None, rtol: float):
    found = judged(known, skip, rtol)
    assert found.mark != "wrong", found
    assert found.measured is not False, found


def test_the_page_shows_none_wrong():
    rows = json.loads((DOCS / "_static" / "verdicts.json").read_text(encoding="utf-8"))
    names = {known.name for known in systems()}
    shown = {row["system"] for row in rows}
    assert len(names) == len(systems())
    assert shown == names
    assert len(shown) >= 200
    marks = [row["mark"] for row in rows]
    assert len(marks) == len(shown) * len(SKIPS) * len(TOLERANCES)
    assert "wrong" not in marks
    assert False not in [row["measured"] for row in rows]
    # more would be a verdict that dares nothing
    assert marks.count("undecided") < 0.1 * len(marks)
    assert {known.verdict for known in systems()} == set(VERDICTS)
