"""Notebooks print what they show."""

import pytest
from make import examples, notebooks
from test_docs_examples import ROOT


@pytest.mark.slow
@pytest.mark.parametrize("path", notebooks.notebooks(), ids=lambda path: path.stem)
def test_notebook_prints_what_it_shows(path):
    shown = notebooks.printed(notebooks.nbformat.read(path, as_version=4))
    found = notebooks.printed(notebooks.executed(path))
    outputs = map(examples.Output, [f"cell {place}" for place in range(len(shown))], shown, found)
    stale = [output for output in outputs if not output.agrees]
    assert len(found) == len(shown)
    assert stale == [], f"`python docs/make {path.stem}` runs it again"


def test_notebooks_stand_on_their_page():
    page = (ROOT / "docs" / "notebooks" / "index.md").read_text(encoding="utf-8")
    assert [path.name for path in notebooks.notebooks() if f"]({path.name})" not in page] == []
