"""Make the film of the nine-bar that the pages show.

    python docs/film.py

It goes to docs/_static and is committed.
"""

from __future__ import annotations

from pathlib import Path

import linkages

PATH = Path(__file__).resolve().parent / "_static" / "ninebar.gif"
MOST_BYTES = 400_000


def main() -> None:
    """Write the film; it must stay small."""
    outputs = ["joint_position", "bar_angle", "slider_position", "clearance_force"]
    solution = linkages.simulate(linkages.load("ninebar"), outputs=outputs)
    film = linkages.animate(solution, PATH, fps=20)
    size = PATH.stat().st_size
    print(f"{PATH.name}: {film.frames} frames, {size} bytes")
    if size > MOST_BYTES:
        raise SystemExit(f"more than {MOST_BYTES} bytes")


if __name__ == "__main__":
    main()
