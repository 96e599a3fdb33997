"""Pictures of the viewer, in Chromium, as the tests of the viewer need it."""

from __future__ import annotations

import shlex
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import linkages
from make.registry import STATIC, makes_each

if TYPE_CHECKING:
    from browser import Browser, Page


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


def reactions(browser: Browser, folder: Path) -> tuple[Page, str]:
    """The nine-bar with its reactions."""
    page = _opened(browser.page(*SIZE), linkages.view(linkages.load("ninebar"), folder / "a.html"))
    page.evaluate(
        "document.getElementById('hint').hidden = true; v.player.seek(0.25);"
        " [...document.querySelectorAll('.chip')]"
        ".find((chip) => chip.textContent === 'Reactions').click();"
        " document.activeElement.blur()"
    )
    return page, "body"


def changed(browser: Browser, folder: Path) -> tuple[Page, str]:
    """A changed number, on a dark page."""
    file = linkages.view(linkages.load("ninebar"), folder / "a.html")
    page = _opened(browser.page(*SIZE, dark=True), file)
    page.evaluate(
        "(async () => { v.player.seek(1.1); v.tabs.open('numbers');"
        " v.live.numbers.change(v.live.model.numbers.findIndex("
        f"(one) => one.path === 'bars.rocker6.length'), {LENGTH}); await v.live.shown;"
        " document.querySelector('.number.changed').scrollIntoView({ block: 'center' }); })()"
    )
    return page, "#side"


def edited(browser: Browser, folder: Path) -> tuple[Page, str]:
    """A joint that is dragged, which changes lengths."""
    page = _opened(browser.page(*SIZE), linkages.view(linkages.load("four-bar"), folder / "a.html"))
    page.evaluate("document.getElementById('edit').click()")
    x, y = page.evaluate(
        "(() => { const box = v.stage.canvas.getBoundingClientRect();"
        " const [x, y] = v.stage.camera.place(v.stage.scene(0).joint('B'));"
        " return [x + box.left, y + box.top]; })()"
    )
    page.drag((x, y), (x - 20, y + 15), (x - 44, y + 36))
    page.evaluate("v.live.shown")
    return page, "#picture"


def plane(browser: Browser, folder: Path) -> tuple[Page, str]:
    """A plane of periods, of which a point plays."""
    for command in (LOCUS, PLANE):
        arguments = [sys.executable, "-m", "linkages", *shlex.split(command)]
        subprocess.run(arguments, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    file = folder / "results" / "contact-slider-crank" / "map.html"
    page = _opened(browser.page(*LARGER), file)
    page.evaluate(
        f"v.plane.choose({POINT[0]}, {POINT[1]}).then(() => {{ v.player.pause();"
        " v.player.seek(0.31 * v.player.motion.end);"
        " document.getElementById('hint').hidden = true; })"
    )
    return page, "body"


def _opened(page: Page, file: Path) -> Page:
    page.open(file)
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    return page


@makes_each(
    {
        ("viewer.png",): ("viewer.png", reactions),
        ("viewer-change.png",): ("viewer-change.png", changed),
        ("viewer-edit.png",): ("viewer-edit.png", edited),
        ("chaos-plane-page.png",): ("chaos-plane-page.png", plane),
    }
)
def taken(name: str, shown: Callable[[Browser, Path], tuple[Page, str]]) -> Path:
    """Write the picture of a part of a page."""
    from browser import Browser  # of the tests

    path = STATIC / name
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        page, element = shown(browser, Path(folder))
        page.evaluate(DRAWN)
        page.screenshot(path, element)
    return path
