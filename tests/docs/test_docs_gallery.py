"""The gallery and the page on mechanisms show every mechanism that is shipped."""

import re
from pathlib import Path

import pytest
from PIL import Image

from linkages.reading.document import shipped

DOCS = Path(__file__).parents[2] / "docs"
PICTURES = DOCS / "_static" / "gallery"
GALLERY = (DOCS / "gallery.md").read_text(encoding="utf-8")
MECHANISMS = (DOCS / "mechanisms.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_mechanism_moves_in_the_gallery(name):
    assert f"(_static/gallery/{name}.webp)" in GALLERY
    with Image.open(PICTURES / f"{name}.webp") as film:
        assert film.n_frames > 10


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_mechanism_has_curves_and_a_drawing(name):
    assert f"(_static/gallery/{name}.svg)" in GALLERY
    assert (PICTURES / f"{name}.svg").stat().st_size <= 20_000
    (part,) = re.findall(rf"^### {name}\n(.*?)(?=^##|\Z)", MECHANISMS, re.DOTALL | re.MULTILINE)
    assert f"(_static/gallery/{name}-drawing.svg)" in part
    for page in (GALLERY, part):
        assert f"](../mechanisms/{name}.yaml)" in page


def test_the_gallery_says_what_the_page_on_mechanisms_says():
    assert re.findall(r"\(mechanisms\.md#([\w-]+)\)", GALLERY)[::2] == list(shipped())
    words = " ".join(MECHANISMS.split())
    for sentence in re.findall(r"^(.*)\. Its file: ", GALLERY, re.MULTILINE):
        assert sentence in words


def test_the_gallery_is_small():
    assert sum(file.stat().st_size for file in PICTURES.iterdir()) < 5_500_000
