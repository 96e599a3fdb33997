"""Make the gallery: a film of each shipped mechanism, and the page that shows them.

    python docs/gallery.py

Films go to docs/_static/gallery, the page to docs/gallery.md; both are committed. What is said of a
mechanism is what the page on mechanisms says.
"""

from __future__ import annotations

import re
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import linkages
from linkages.kernel.system import System
from linkages.plots.films.scenes import SHOWN
from linkages.reading.locate import shipped
from linkages.solution.values.requests import requested

DOCS = Path(__file__).resolve().parent
FILMS = DOCS / "_static" / "gallery"
MOST_BYTES = 3_800_000
FPS, DPI = 7.0, 45.0
HEAD = """# Gallery

The mechanisms that are shipped with the package, as `python -m linkages animate NAME --format webp`
draws them. [The page on mechanisms](mechanisms.md) says where their numbers come from.
`docs/gallery.py` makes this page.
"""


def described() -> dict[str, str]:
    """Mechanism → the first sentence that the page on mechanisms says of it."""
    text = (DOCS / "mechanisms.md").read_text(encoding="utf-8")
    found = {}
    entries = r"^- ((?:`[\w-]+`(?:, )?)+):\s+(.*\n(?:  .*\n)*)"
    for names, said in re.findall(entries, text, re.MULTILINE):
        sentence = re.split(r"\. (?=[A-Z\[])", " ".join(said.split()))[0].rstrip(".")
        found |= dict.fromkeys(re.findall(r"`([\w-]+)`", names), f"{sentence}.")
    return found


def entry(name: str, said: str) -> str:
    """A mechanism on the page."""
    title = linkages.load(name).name
    return (
        f"## {title}\n\n"
        f"[![{title}, moving](_static/gallery/{name}.webp)](mechanisms.md)\n\n"
        f"{said} Its file: `{name}`.\n"
    )


def film(name: str) -> int:
    """Write the film of a mechanism; returns its bytes."""
    mechanism = linkages.load(name)
    possible = requested(System(mechanism), "all")
    outputs = [output for output in SHOWN if output in possible]
    solution = linkages.simulate(mechanism, samples=721, outputs=outputs, throw=False)
    path = FILMS / f"{name}.webp"
    linkages.animate(solution, path, fps=FPS, dpi=DPI)
    return path.stat().st_size


def write_page() -> None:
    """Write the page that shows the films."""
    said = described()
    page = "\n".join([HEAD, *(entry(name, said[name]) for name in shipped())])
    (DOCS / "gallery.md").write_text(page, encoding="utf-8")


def main() -> None:
    """Write films and page."""
    FILMS.mkdir(exist_ok=True)
    with ProcessPoolExecutor() as pool:
        total = sum(pool.map(film, shipped()))
    write_page()
    print(f"{len(shipped())} films, {total} bytes")
    if total > MOST_BYTES:
        raise SystemExit(f"more than {MOST_BYTES} bytes")


if __name__ == "__main__":
    main()
