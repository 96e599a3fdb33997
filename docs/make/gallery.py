"""Make the pictures of the examples: film, curves and drawing of each shipped mechanism.

    python docs/gallery.py

They go to docs/_static/gallery and are committed.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import linkages
from linkages.kernel.system import System
from linkages.plots.films.film import SHOWN
from linkages.reading.document import shipped
from linkages.solution.series import requested
from make.gallery_pictures import outputs_of, write_curves, write_drawing

DOCS = Path(__file__).resolve().parents[1]
PICTURES = DOCS / "_static" / "gallery"
MOST_BYTES = 5_500_000
FPS, DPI = 7.0, 54.0


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


def main() -> None:
    """Write all pictures."""
    PICTURES.mkdir(exist_ok=True)
    with ProcessPoolExecutor() as pool:
        total = sum(pool.map(pictures, shipped()))
    print(f"{len(shipped())} mechanisms, {total} bytes")
    if total > MOST_BYTES:
        raise SystemExit(f"more than {MOST_BYTES} bytes")


if __name__ == "__main__":
    main()
