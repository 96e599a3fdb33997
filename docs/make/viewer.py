"""Take the pictures of the viewer that the pages show.

    python docs/figures_viewer.py

They go to docs/_static and are committed. It needs Chromium, as the tests of the viewer do.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import linkages

HERE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(HERE.parent / "tests"))

from browser import Browser, Page  # noqa: E402

DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"

LENGTH = 0.9
"""Metres of rocker 6 in the picture of changed numbers."""

SIZE = 960, 660
"""Pixels of the page: what is shown at three quarters of this can still be read."""

LARGER = 1060, 800
"""The same of the page of a plane."""

LOCUS = (
    "follow contact-slider-crank --set clearances.gap.size=0.12mm"
    " --vary clearances.gap.size=0.117mm:0.124mm --points 60 --no-figures"
    " --locus PD1 --and drives.crank.speed=4800rpm:5200rpm --out locus"
)
PLANE = (
    "map contact-slider-crank --indicator period --x clearances.gap.size=0.117mm:0.124mm:60"
    " --y drives.crank.speed=4800rpm:5200rpm:40 --page --no-figures"
    " --loci locus/follow.nc"
)
"""Commands of the plane in docs/chaos.md."""

POINT = 18, 18
"""Row and column of the point of the plane that plays."""


def main() -> None:
    """Take all pictures."""
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        files = {
            name: linkages.view(linkages.load(name), Path(folder) / f"{name}.html")
            for name in ("ninebar", "four-bar")
        }
        page = _opened(browser.page(*SIZE), files["ninebar"])
        page.evaluate(
            "document.getElementById('hint').hidden = true; v.player.seek(0.25);"
            " [...document.querySelectorAll('.chip')]"
            ".find((chip) => chip.textContent === 'Reactions').click();"
            " document.activeElement.blur()"
        )
        _take(page, "viewer")
        page = _opened(browser.page(*SIZE, dark=True), files["ninebar"])
        page.evaluate(
            "(async () => { v.player.seek(1.1); v.tabs.open('numbers');"
            " v.live.numbers.change(v.live.model.numbers.findIndex("
            f"(one) => one.path === 'bars.rocker6.length'), {LENGTH}); await v.live.shown;"
            " document.querySelector('.number.changed').scrollIntoView({ block: 'center' }); })()"
        )
        _take(page, "viewer-change", "#side")
        page = _opened(browser.page(*SIZE), files["four-bar"])
        page.evaluate("document.getElementById('edit').click()")
        x, y = page.evaluate(
            "(() => { const box = v.stage.canvas.getBoundingClientRect();"
            " const [x, y] = v.stage.camera.place(v.stage.scene(0).joint('B'));"
            " return [x + box.left, y + box.top]; })()"
        )
        page.drag((x, y), (x - 20, y + 15), (x - 44, y + 36))
        page.evaluate("v.live.shown")
        _take(page, "viewer-edit", "#picture")
        for command in (LOCUS, PLANE):
            arguments = [sys.executable, "-m", "linkages", *shlex.split(command)]
            subprocess.run(arguments, cwd=folder, check=True)
        file = Path(folder) / "results" / "contact-slider-crank" / "map.html"
        page = _opened(browser.page(*LARGER), file)
        page.evaluate(
            f"v.plane.choose({POINT[0]}, {POINT[1]}).then(() => {{ v.player.pause();"
            " v.player.seek(0.31 * v.player.motion.end);"
            " document.getElementById('hint').hidden = true; })"
        )
        _take(page, "chaos-plane-page")


def _opened(page: Page, file: Path) -> Page:
    page.open(file)
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    return page


def _take(page: Page, name: str, element: str = "body") -> None:
    page.evaluate(DRAWN)
    page.screenshot(HERE / "_static" / f"{name}.png", element)
    print(f"{name}.png")


if __name__ == "__main__":
    main()
