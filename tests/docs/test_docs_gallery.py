"""The gallery shows every mechanism that is shipped."""

from pathlib import Path

import pytest
from PIL import Image

from linkages.reading.locate import shipped

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_mechanism_moves_in_the_gallery(name):
    assert f"(_static/gallery/{name}.webp)" in (DOCS / "gallery.md").read_text(encoding="utf-8")
    with Image.open(DOCS / "_static" / "gallery" / f"{name}.webp") as film:
        assert film.n_frames > 10
