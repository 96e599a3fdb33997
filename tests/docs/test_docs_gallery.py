"""The examples show every mechanism that is shipped."""

import re
from pathlib import Path

import pytest
from PIL import Image

from linkages.reading.document import shipped

DOCS = Path(__file__).parents[2] / "docs"
PICTURES = DOCS / "_static" / "gallery"
EXAMPLES = (DOCS / "gallery.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_mechanism_is_an_example(name):
    (part,) = re.findall(rf"^### {name}\n(.*?)(?=^##|\Z)", EXAMPLES, re.DOTALL | re.MULTILINE)
    for picture in (f"{name}.webp", f"{name}.svg", f"{name}-drawing.svg"):
        assert f"(_static/gallery/{picture})" in part
    assert f"`python -m linkages view {name} --open`" in part
    assert f"](../mechanisms/{name}.yaml)" in part
    with Image.open(PICTURES / f"{name}.webp") as film:
        assert film.n_frames > 10
    assert (PICTURES / f"{name}.svg").stat().st_size <= 20_000


def test_pictures_of_examples_are_small():
    assert sum(file.stat().st_size for file in PICTURES.iterdir()) < 5_500_000
