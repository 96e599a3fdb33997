"""Take the pictures of the viewer that the pages show.

    python docs/figures_viewer.py

They go to docs/_static and are committed. It needs Chromium, as the tests of the viewer do.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import linkages

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tests"))

from browser import Browser, Page  # noqa: E402

DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"

LENGTH = 0.9
"""Metres of rocker 6 in the picture of changed numbers."""


def main() -> None:
    """Take all pictures."""
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        file = linkages.view(linkages.load("ninebar"), Path(folder) / "ninebar.html")
        page = _opened(browser.page(1300, 860), file)
        page.evaluate(
            "v.player.seek(0.25); [...document.querySelectorAll('.chip')]"
            ".find((chip) => chip.textContent === 'Reactions').click()"
        )
        _take(page, "viewer")
        page = _opened(browser.page(1300, 860, dark=True), file)
        page.evaluate(
            "(async () => { v.player.seek(1.1); v.tabs.open('numbers');"
            " v.live.numbers.change(v.live.model.numbers.findIndex("
            f"(one) => one.path === 'bars.rocker6.length'), {LENGTH}); await v.live.shown; }})()"
        )
        _take(page, "viewer-change")


def _opened(page: Page, file: Path) -> Page:
    page.open(file)
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    return page


def _take(page: Page, name: str) -> None:
    page.evaluate(DRAWN)
    page.screenshot(HERE / "_static" / f"{name}.png")
    print(f"{name}.png")


if __name__ == "__main__":
    main()
