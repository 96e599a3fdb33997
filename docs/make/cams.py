"""The figure of the page on cams."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.plots.panels import panels
from linkages.plots.style import BLACK, line_style
from make.registry import definition, makes

SPEEDS = np.linspace(3300.0, 6000.0, 181)
"""Of the cam, in revolutions per minute."""
TURNS = (30, 40)
"""Revolutions that are left out, and the last one that is shown."""


Met = tuple[list[float], list[float], float]
"""Angles of lifting off and of landing in degrees, and the largest gap in millimetres."""


def met(mechanism: linkages.Mechanism, speed: float) -> Met:
    """What happens at a speed in revolutions per minute."""
    begin, end = (turns * 60.0 / speed for turns in TURNS)
    found = linkages.simulate(
        mechanism.with_values({"drives.cam.speed": f"{speed} rpm"}),
        times=np.concatenate([[0.0], np.linspace(begin, end, 4001)]),
        outputs=["clearance_indentation"],
    )
    angles = []
    for name, rises in (("press", False), ("touch", True)):
        change = found.motion.changes[f"cams[0]: {name}"]
        times = change.time[(change.rises == rises) & (change.time >= begin)]
        angles.append(np.mod(180.0 + 6.0 * speed * times, 360.0).tolist())
    gap = -1e3 * float(found.data.clearance_indentation[1:].min())
    return angles[0], angles[1], gap


@makes("cam-jump.png")
def jump() -> Figure:
    """Where the valve lifts off and lands, and how far it flies, over the speed."""
    mechanism = definition("components/cam.md", "valve-train.yaml")
    found = [met(mechanism, speed) for speed in SPEEDS.tolist()]
    figure, (above, below) = panels(2, 1, 1.8)
    for place, label in enumerate(("lifts off", "lands")):
        points = [(s, a) for s, own in zip(SPEEDS, found, strict=True) for a in own[place]]
        colour = line_style(place)["color"]
        x, y = zip(*points, strict=True)
        above.plot(x, y, ".", color=colour, markersize=2.5, label=label)
    first = next(s for s, own in zip(SPEEDS, found, strict=True) if own[0])
    for ax in (above, below):
        ax.axvline(first, color=BLACK, linewidth=0.6, linestyle=":")
        ax.set_xlim(SPEEDS[0], SPEEDS[-1])
    above.set(ylim=(0, 360), ylabel="cam angle [°]")
    above.set_yticks([0, 90, 180, 270, 360])
    above.legend(loc="center right", bbox_to_anchor=(1.0, 0.36), markerscale=3.0)
    below.plot(SPEEDS, [own[2] for own in found], color=BLACK)
    below.set(ylim=(0, None), ylabel="largest gap [mm]", xlabel="speed of the cam [rpm]")
    return figure
