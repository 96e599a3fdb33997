"""Make the gallery: film, curves and drawing of each shipped mechanism, and the page of them.

    python docs/gallery.py

Pictures go to docs/_static/gallery, the page to docs/gallery.md; all are committed. Drawings are
for the page on mechanisms, which says what the gallery says of a mechanism.
"""

from __future__ import annotations

import re
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from gallery_pictures import CURVES, outputs_of, write_curves, write_drawing

import linkages
from linkages.kernel.system import System
from linkages.plots.films.film import SHOWN
from linkages.reading.document import shipped
from linkages.solution.series import requested

DOCS = Path(__file__).resolve().parent
PICTURES = DOCS / "_static" / "gallery"
MOST_BYTES = 5_500_000
FPS, DPI = 7.0, 54.0
HEAD = """# Gallery

The mechanisms that are shipped with the package: each as
`python -m linkages animate NAME --format webp --bare` draws it, with three curves that
`python -m linkages plot NAME --y SERIES` would draw. The files run without changes. [The page on
mechanisms](mechanisms.md) cites the sources of the numbers. `docs/gallery.py` makes this page.
"""


def described() -> dict[str, str]:
    """Mechanism → the first sentence that the page on mechanisms says of it."""
    text = (DOCS / "mechanisms.md").read_text(encoding="utf-8")
    found = {}
    for part in text.split("\n### ")[1:]:
        name, _picture, said, *_ = part.split("\n\n")
        sentence = re.split(r"\. (?=[A-Z\[])", " ".join(said.split()))[0].rstrip(".")
        found[name] = f"{sentence}."
    return found


def entry(name: str, said: str) -> str:
    """A mechanism on the page."""
    title = linkages.load(name).name
    shown = ", ".join(CURVES[name])
    return (
        f"## {title}\n\n"
        f"[![{title}, moving](_static/gallery/{name}.webp)](mechanisms.md#{name})\n\n"
        f"{said} Its file: [`{name}.yaml`](../mechanisms/{name}.yaml); more of it: "
        f"[`{name}`](mechanisms.md#{name}).\n\n"
        f"![{title}: {shown}](_static/gallery/{name}.svg)\n"
    )


def turn(solution: linkages.Solution) -> float | None:
    """How long the slowest drive takes to turn once; None for a motion that nothing repeats."""
    topology, time = solution.system.topology, solution.data["time"].to_numpy()
    found = []
    for name in () if topology.free else topology.driven:
        if name not in solution.data["bar"]:
            return None
        angle = solution.data["bar_angle"].sel(bar=name).to_numpy()
        turned = np.abs(angle - angle[0])
        if turned[-1] < 2 * np.pi:
            return None
        found.append(float(np.interp(2 * np.pi, turned, time)))
    return max(found, default=None)


def pictures(name: str) -> int:
    """Write film, curves and drawing of a mechanism; returns their bytes."""
    mechanism = linkages.load(name)
    system = System(mechanism)
    possible = requested(system, "all")
    outputs = {output for output in SHOWN if output in possible} | outputs_of(system, name)
    solution = linkages.simulate(mechanism, samples=721, outputs=sorted(outputs), throw=False)
    film = PICTURES / f"{name}.webp"
    linkages.animate(solution, film, duration=turn(solution), fps=FPS, dpi=DPI, bare=True)
    curves = write_curves(name, solution, PICTURES)
    return film.stat().st_size + curves + write_drawing(name, PICTURES)


def write_page() -> None:
    """Write the page that shows the films."""
    said = described()
    page = "\n".join([HEAD, *(entry(name, said[name]) for name in shipped())])
    (DOCS / "gallery.md").write_text(page, encoding="utf-8")


def main() -> None:
    """Write pictures and page."""
    PICTURES.mkdir(exist_ok=True)
    with ProcessPoolExecutor() as pool:
        total = sum(pool.map(pictures, shipped()))
    write_page()
    print(f"{len(shipped())} mechanisms, {total} bytes")
    if total > MOST_BYTES:
        raise SystemExit(f"more than {MOST_BYTES} bytes")


if __name__ == "__main__":
    main()
