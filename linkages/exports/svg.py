"""SVG in millimetres, 1:1: links with their holes, and paths of joints, each with its name."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from linkages.exports import Subject
from linkages.exports.writers.outlines import drawing

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray

    from linkages.exports.writers.outlines import Drawn, Outline, Part

PEN = 0.25
"""Width of all lines in millimetres."""


@drawing
def svg(
    subject: Subject, drawn: Callable[[], Drawn], *, symbols: bool = False
) -> Mapping[str, str | bytes]:
    """Write links where the motion begins, and the paths of joints, in millimetres 1:1.

    Parameters
    ----------
    subject
        What is exported.
    drawn
        What `drawn_of` returns.
    symbols
        Whether to draw the mechanism as figures do: over the links, in symbols of printed size.
    """
    import numpy as np

    from linkages.exports.writers.outlines import symbols_of

    shown = drawn()
    low, high = shown.box
    body = [line for part in shown.parts for line in _part(part, shown.sizes.hole)]
    if symbols:
        elements, lowest, highest = symbols_of(subject)
        low, high = np.minimum(low, lowest), np.maximum(high, highest)
        body += ['<g id="drawing">', *elements, "</g>"]
    body += [
        f'<path id="path-{_text(name)}" class="path" d="{_polyline(line)}"/>'
        for name, line in shown.paths.items()
    ]
    size = high - low
    frame = f"{low[0]:.9g} {-high[1]:.9g} {size[0]:.9g} {size[1]:.9g}"
    text = "\n".join([
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]:.9g}mm" '
        f'height="{size[1]:.9g}mm" viewBox="{frame}">',
        f"<title>{_text(subject.mechanism.name)}</title>",
        f"<style>.edge, .path, .hole {{fill: none; stroke: #000000; stroke-width: {PEN}}} "
        ".path {stroke: #0072B2}</style>",
        *body,
        "</svg>",
        "",
    ])  # fmt: skip
    return {f"{subject.name}.svg": text}


def _part(part: Part, hole: float) -> list[str]:
    """A group with the edge of a link, its slots, and its holes."""
    holes = [
        f'<circle class="hole" id="{_text(part.name)}-{_text(joint)}" cx="{x:.9g}" cy="{-y:.9g}" '
        f'r="{0.5 * hole:.9g}"/>'
        for joint, (x, y) in part.holes.items()
    ]
    edges = [f'<path class="edge" d="{_closed(edge)}"/>' for edge in (part.outline, *part.slots)]
    return [f'<g id="link-{_text(part.name)}">', *edges, *holes, "</g>"]


def _closed(outline: Outline) -> str:
    """Sides and arcs; y points down in SVG, so that arcs turn the other way."""
    corners = outline.corners
    words = [f"M {corners[0, 0]:.9g} {-corners[0, 1]:.9g}"]
    for index, bulge in enumerate(outline.bulges):
        x, y = corners[(index + 1) % len(corners)]
        if bulge == 0.0:
            words.append(f"L {x:.9g} {-y:.9g}")
            continue
        chord = math.hypot(x - corners[index, 0], y - corners[index, 1])
        radius = 0.25 * chord * (bulge + 1.0 / bulge)
        words.append(f"A {radius:.9g} {radius:.9g} 0 0 0 {x:.9g} {-y:.9g}")
    return " ".join([*words, "Z"])


def _polyline(line: NDArray[float64]) -> str:
    return "M " + " ".join(f"{x:.9g} {-y:.9g}" for x, y in line)


def _text(text: str) -> str:
    return escape(text, {'"': "&quot;"})


EXPORT = svg
