"""The computations stand beside the page that shows them."""

import json
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path.append(str(DOCS))


@pytest.fixture(scope="session")
def page():
    """What the page was made from."""
    return json.loads((DOCS / "_static" / "paper.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def grades(page):
    """Letter of each claim → how it is judged on the page."""
    found = [one for part in page.values() for one in part.get("judgements", [])]
    return {one["letter"]: one["grade"] for one in found}
