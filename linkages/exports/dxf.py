"""DXF in millimetres, 1:1: a layer for every link with its holes, and one for every path."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from linkages.exports import Subject
from linkages.exports.writers.outlines import drawing

if TYPE_CHECKING:
    from linkages.exports.writers.outlines import Drawn, Outline

COLOURS = (7, 1, 5, 3, 6, 4, 2)
"""Of the AutoCAD colour index: what layers have one after the other."""

_FORBIDDEN = re.compile(r'[<>/\\":;?*|=`,]')


@drawing
def dxf(subject: Subject, drawn: Callable[[], Drawn]) -> Mapping[str, str | bytes]:
    """Write links where the motion begins, and the paths of joints, in millimetres 1:1.

    Parameters
    ----------
    subject
        What is exported.
    drawn
        What `drawn_of` returns.

    Raises
    ------
    ValueError
        Without the package ezdxf.
    """
    try:
        import ezdxf
    except ImportError:
        raise ValueError(
            "DXF needs the package ezdxf; install it with: pip install 'linkages[dxf]'"
        ) from None
    shown = drawn()
    document = ezdxf.new("R2010", units=ezdxf.units.MM)
    space = document.modelspace()

    def layer(name: str) -> dict[str, str]:
        clean = _FORBIDDEN.sub("_", name)
        document.layers.add(clean, color=COLOURS[(len(document.layers) - 2) % len(COLOURS)])
        return {"layer": clean}

    def edge(outline: Outline, where: dict[str, str]) -> None:
        points = [(x, y, bulge) for (x, y), bulge in zip(outline.corners.tolist(),
                  outline.bulges.tolist(), strict=True)]  # fmt: skip
        space.add_lwpolyline(points, format="xyb", close=True, dxfattribs=where)

    for part in shown.parts:
        where = layer(f"link {part.name}")
        for outline in (part.outline, *part.slots):
            edge(outline, where)
        for x, y in part.holes.values():
            space.add_circle((x, y), 0.5 * shown.sizes.hole, dxfattribs=where)
    for name, line in shown.paths.items():
        space.add_lwpolyline(line.tolist(), dxfattribs=layer(f"path {name}"))
    stream = io.StringIO()
    document.write(stream)
    return {f"{subject.name}.dxf": document.encode(stream.getvalue())}


EXPORT = dxf
