"""Make the film of the nine-bar that the pages show.

    python docs/film.py

It goes to docs/_static and is committed.
"""

from __future__ import annotations

from pathlib import Path

import linkages
from linkages.plots.films.pace import too_fast

PATH = Path(__file__).resolve().parent / "_static" / "ninebar.gif"
MOST_BYTES = 600_000


def main() -> None:
    """Write the film; it must stay small."""
    outputs = ["joint_position", "bar_angle", "slider_position", "clearance_angle"]
    solution = linkages.simulate(
        linkages.load("ninebar"), end=0.15, samples=3001, outputs=[*outputs, "clearance_force"]
    )
    # the clearance swings 90 times a second: 22 frames for each
    film = linkages.animate(solution, PATH, start=0.1, duration=0.05, slow=100, fps=20, dpi=80)
    if note := too_fast(solution, film):
        raise SystemExit(note)
    size = PATH.stat().st_size
    print(f"{PATH.name}: {film.frames} frames, {size} bytes")
    if size > MOST_BYTES:
        raise SystemExit(f"more than {MOST_BYTES} bytes")


if __name__ == "__main__":
    main()
