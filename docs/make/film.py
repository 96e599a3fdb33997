"""Films of the nine-bar: a WebP in full colour, large enough for fine screens, and a small GIF."""

from __future__ import annotations

from pathlib import Path

import linkages
from linkages.plots.films.film import too_fast
from make.registry import STATIC, makes_each

SHOWN = {"ninebar.gif": (80.0, 0.05), "ninebar.webp": (120.0, 0.027)}
"""Pixels per inch, and how much of the motion: five swings of the clearance, or three."""


@makes_each({(name,): (name,) for name in SHOWN})
def film(name: str) -> Path:
    """Write a film."""
    outputs = ["joint_position", "bar_angle", "slider_position", "clearance_angle"]
    solution = linkages.simulate(
        linkages.load("ninebar"), end=0.15, samples=3001, outputs=[*outputs, "clearance_force"]
    )
    dpi, duration = SHOWN[name]
    # the clearance swings 90 times a second: 22 frames for each
    shown = linkages.animate(
        solution, STATIC / name, start=0.1, duration=duration, slow=100, fps=20, dpi=dpi
    )
    if note := too_fast(solution, shown):
        raise SystemExit(note)
    return STATIC / name
