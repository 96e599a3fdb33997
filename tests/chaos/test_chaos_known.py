"""Systems whose motion is known are judged right, or honestly undecided."""

import json
from pathlib import Path

import pytest
from verdicts.flows import FLOWS
from verdicts.known import Known
from verdicts.maps import MAPS
from verdicts.table import SKIPS, TOLERANCES, VERDICTS, judged, systems

DOCS = Path(__file__).parents[2] / "docs"

HARD = {
    "Logistic, r = 3.828",  # intermittent, in long laminar phases
    "Logistic, r = 1 + √8",  # at the tangent bifurcation
    "Standard map, K = 1.2, near the separatrix",  # tangents grow by little in 300 steps
}
QUICK = [*MAPS, *(flow for flow in FLOWS if flow.name.startswith("Linear"))]


@pytest.mark.parametrize("known", QUICK, ids=lambda known: known.name)
def test_maps(known: Known):
    found = judged(known, None, TOLERANCES[0])
    assert found.mark == "right" or (found.mark == "undecided" and known.name in HARD), found


@pytest.mark.long
@pytest.mark.parametrize("rtol", TOLERANCES)
@pytest.mark.parametrize("skip", SKIPS)
@pytest.mark.parametrize("known", systems(), ids=lambda known: known.name)
def test_nothing_is_judged_wrong(known: Known, skip: int | None, rtol: float):
    assert judged(known, skip, rtol).mark != "wrong"


def test_the_page_shows_none_wrong():
    rows = json.loads((DOCS / "_static" / "verdicts.json").read_text(encoding="utf-8"))
    names = {known.name for known in systems()}
    shown = {row["system"] for row in rows}
    assert len(names) == len(systems())
    assert shown == names
    assert len(shown) >= 60
    marks = [row["mark"] for row in rows]
    assert len(marks) == len(shown) * len(SKIPS) * len(TOLERANCES)
    assert "wrong" not in marks
    # more would be a verdict that dares nothing
    assert marks.count("undecided") < 0.15 * len(marks)
    assert {known.verdict for known in systems()} == set(VERDICTS)
