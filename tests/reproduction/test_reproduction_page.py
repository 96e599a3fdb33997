"""The page shows what was computed, all of it."""

import re
from pathlib import Path

import pytest
from make.registry import MAKERS
from make.reproduction import parts

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "reproduction.md").read_text(encoding="utf-8")
SHOWN = re.findall(r"!\[.*?\]\(_static/(\S+)\)", PAGE)
LARGEST = 400_000


def test_tables_are_made_from_the_evidence(page):
    """`python docs/make paper-numbers` makes them anew."""
    (maker,) = (maker for maker in MAKERS if maker.function is parts.of_evidence)
    made = dict(zip(maker.outputs, parts.of_evidence(page), strict=True))
    made["paper-verdicts"] = parts.tables.verdict_tables(page["verdicts"])
    for name, text in made.items():
        assert f"<!-- table: {name} -->\n\n{text.strip()}\n\n<!-- end of table -->" in PAGE


def test_every_part_was_measured(page):
    assert sorted(page) == ["motion", "numbers", "sizes", "speeds", "steps", "verdicts"]


def test_all_claims_are_judged(grades):
    assert "".join(sorted(grades)) == "abcdefgh"
    assert set(grades.values()) <= {"holds", "holds for some initial conditions", "does not hold"}


def test_all_figures_of_the_paper_are_there():
    found: set[int] = set()
    for first, last in re.findall(r"^Figures? (\d+)(?:–(\d+))?", PAGE, re.MULTILINE):
        found |= set(range(int(first), int(last or first) + 1))
    assert found == set(range(3, 16))


@pytest.mark.parametrize("name", SHOWN)
def test_files_are_there_and_small(name):
    assert 0 < (DOCS / "_static" / name).stat().st_size < LARGEST
