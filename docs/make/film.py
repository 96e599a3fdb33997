"""Make the films of the nine-bar that the pages show.

    python docs/film.py

They go to docs/_static and are committed: a WebP in full colour, large enough for screens with two
pixels where others have one, and a small GIF.
"""

from __future__ import annotations

from pathlib import Path

import linkages
from linkages.plots.films.film import too_fast

PATH = Path(__file__).resolve().parents[1] / "_static" / "ninebar.gif"
SHOWN = {".gif": (80.0, 0.05), ".webp": (120.0, 0.027)}
"""Pixels per inch, and how much of the motion: five swings of the clearance, or three."""

MOST_BYTES = 1_000_000


def main() -> None:
    """Write the films; they must stay small."""
    outputs = ["joint_position", "bar_angle", "slider_position", "clearance_angle"]
    solution = linkages.simulate(
        linkages.load("ninebar"), end=0.15, samples=3001, outputs=[*outputs, "clearance_force"]
    )
    for suffix, (dpi, duration) in SHOWN.items():
        path = PATH.with_suffix(suffix)
        # the clearance swings 90 times a second: 22 frames for each
        film = linkages.animate(
            solution, path, start=0.1, duration=duration, slow=100, fps=20, dpi=dpi
        )
        if note := too_fast(solution, film):
            raise SystemExit(note)
        size = path.stat().st_size
        print(f"{path.name}: {film.frames} frames, {size} bytes")
        if size > MOST_BYTES:
            raise SystemExit(f"more than {MOST_BYTES} bytes")


if __name__ == "__main__":
    main()
