"""Drawings in millimetres, 1:1: links with their holes, and paths of joints, as SVG and DXF."""

from __future__ import annotations

import inspect
import io
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial, wraps
from typing import Any, Concatenate, assert_never
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.contributed.terms import UNSEEN
from linkages.exports import Export, Subject
from linkages.options.option import OptionError
from linkages.plots.mechanism.drawing import shapes_of
from linkages.plots.mechanism.guide_symbols import slider_of
from linkages.plots.mechanism.inked_shapes import LIGHT
from linkages.plots.mechanism.placing import Cover, placed
from linkages.plots.mechanism.plane_view import Box
from linkages.plots.mechanism.pose import Pose, along_carrier, pose_at
from linkages.plots.mechanism.roles import convex_hull
from linkages.plots.mechanism.shapes import Disc, Look, Shape, Strokes, Word
from linkages.plots.mechanism.traces import moving_joints
from linkages.reading.wording import TOO_LARGE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Outline:
    """A closed line, counter-clockwise."""

    corners: Array  # shape (n, 2)
    # Of the side that begins at each corner, shape (n,): the tangent of a quarter of the angle of
    # its arc; 0 for a straight side
    bulges: Array


def rounded(points: ArrayLike, radius: float) -> Outline:
    """The hull of discs of a radius about all points: a stadium, or a plate with round corners."""
    hull = convex_hull(np.asarray(points, dtype=float))
    if len(hull) < 2:
        raise ValueError("expected two points or more that differ")
    if len(hull) == 2 and np.subtract(*hull[::-1])[0] < 0.0:
        hull = hull[::-1]
    ways = np.roll(hull, -1, axis=0) - hull
    ways /= np.hypot(*ways.T)[:, None]
    outward = radius * np.column_stack((ways[:, 1], -ways[:, 0]))
    before = np.roll(ways, 1, axis=0)
    turns = np.arctan2(
        before[:, 0] * ways[:, 1] - before[:, 1] * ways[:, 0], (before * ways).sum(axis=1)
    )
    corners = np.stack((hull + np.roll(outward, 1, axis=0), hull + outward), axis=1)
    bulges = np.column_stack((np.tan(np.abs(turns) / 4.0), np.zeros(len(hull))))
    return Outline(corners.reshape(-1, 2), bulges.ravel())


def thinned(path: ArrayLike, apart: float) -> Array:
    """Points of a path, first and last among them, between which lines are no farther from others.

    `path`: shape (n, 2).

    References
    ----------
    .. [1] D. H. Douglas, T. K. Peucker, "Algorithms for the reduction of the number of points
       required to represent a digitized line or its caricature", Cartographica 10 (1973) 112-122.
    """
    points = np.asarray(path, dtype=float)
    kept, spans = {0, len(points) - 1}, [(0, len(points) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        away = _distances(points[first + 1 : last], points[first], points[last])
        farthest = first + 1 + int(np.argmax(away))
        if away.max() > apart:
            kept.add(farthest)
            spans += [(first, farthest), (farthest, last)]
    return points[sorted(kept)]


def _distances(points: Array, start: Array, end: Array) -> Array:
    """From a segment, shape (n,)."""
    way = end - start
    square = float(way @ way)
    share = np.clip((points - start) @ way / square, 0.0, 1.0) if square else np.zeros(len(points))
    return np.asarray(np.hypot(*(points - start - share[:, None] * way).T))


def rectangle(centre: ArrayLike, angle: float, length: float, height: float) -> Outline:
    """A rectangle about a point, with its length in a direction."""
    along = 0.5 * length * np.array([np.cos(angle), np.sin(angle)])
    across = 0.5 * height * np.array([-np.sin(angle), np.cos(angle)])
    corners = np.asarray(centre) + np.array(
        [-along - across, along - across, along + across, -along + across]
    )
    return Outline(corners, np.zeros(4))


MILLIMETRES = 1000.0
HOLE = 0.03
"""Diameter of a hole over the size of the mechanism, where nobody says it."""

WIDTH = 2.5
"""Width of a link over the diameter of its holes, where nobody says it."""

NARROW = 1e-5
"""Of the size of all paths: how far a line may be from the samples that it stands for."""

NEAR = 1e-6
"""Of the size of the mechanism: what a slider moves less than this has no slot."""


@dataclass(frozen=True)
class Part:
    """A link where the motion begins, in millimetres."""

    name: str  # of the body
    outline: Outline  # its edge
    holes: Mapping[str, Array]  # joint → centre of its hole, shape (2,)
    slots: list[Outline]  # edges of slots that others slide in


@dataclass(frozen=True)
class Sizes:
    """Diameter of holes and width of links in millimetres."""

    hole: float
    width: float


@dataclass(frozen=True)
class Drawn:
    """What a drawing shows, in millimetres.

    `parts`, `paths`: links, and joints with the places that they go through, shape (time, 2).
    """

    parts: list[Part]
    paths: dict[str, Array]
    sizes: Sizes  # of holes and links

    @property
    def box(self) -> tuple[Array, Array]:
        """Low and high corner of everything."""
        corners = [part.outline.corners for part in self.parts]
        everything = np.vstack([*corners, *self.paths.values()])
        margin = self.sizes.width  # round ends reach beyond corners
        return everything.min(axis=0) - margin, everything.max(axis=0) + margin


def first_pose(subject: Subject) -> Pose:
    """Where the motion begins, in millimetres; InputError if it is too large for that."""
    with np.errstate(over="ignore", invalid="ignore"):
        pose = pose_at(subject.solution.data, subject.mechanism, 0).scaled(MILLIMETRES)
        sound = np.isfinite(pose.extent) and np.isfinite([*pose.positions.values()]).all()
    if not sound:
        message = f"the mechanism is too large to draw in millimetres. {TOO_LARGE}"
        raise subject.mechanism.error([((), message)])
    return pose


def sizes_of(pose: Pose, hole: float | None, width: float | None) -> Sizes:
    """Sizes in millimetres from those that are given in metres, or a default for either."""
    diameter = HOLE * pose.extent if hole is None else MILLIMETRES * hole
    wide = WIDTH * diameter if width is None else MILLIMETRES * width
    if not 0.0 < diameter < np.inf:
        raise OptionError("hole", f"hole must be > 0 m, found {diameter / MILLIMETRES:g}")
    if not diameter < wide < np.inf:
        raise OptionError(
            "width", f"width must be larger than the holes of {diameter:g} mm, found {wide:g} mm"
        )
    return Sizes(diameter, wide)


def parts_of(pose: Pose, sizes: Sizes) -> list[Part]:
    """All links whose places are known: bars, plates, blocks; clearances are none."""
    parts = []
    for name, body in pose.mechanism.bodies.items():
        holes = {joint: np.array(place) for joint, place in pose.shown(name).items()}
        slots, angle = travels_on(pose, name), pose.angle(name)
        if body.kind in UNSEEN or not holes or (len(holes) < 2 and angle is None):
            continue
        if len(holes) > 1 or slots:
            outline = rounded(np.vstack([*holes.values(), *slots]), 0.5 * sizes.width)
        else:
            (centre,) = holes.values()
            outline = rectangle(centre, float(angle or 0.0), 2.0 * sizes.width, sizes.width)
        parts.append(Part(name, outline, holes, [rounded(e, 0.5 * sizes.hole) for e in slots]))
    return parts


def travels_on(pose: Pose, carrier: str) -> list[Array]:
    """First and last place of every slider in a slot of a body, shape (2, 2) each.

    One that leaves the bar that carries it along its own line is a rod and has no slot.
    """
    result = []
    for name, body in pose.mechanism.bodies.items():
        if body.kind in UNSEEN or body.guide is None or body.guide.body != carrier:
            continue
        slider, ends = slider_of(pose, name), along_carrier(pose, name)
        if slider is None:
            continue
        low, high = slider.travel
        near = NEAR * pose.extent
        if high - low > near and (ends is None or ends[0] - near < low < high < ends[1] + near):
            result.append(np.array([slider.axis.at(low), slider.axis.at(high)]))
    return result


def paths_of(subject: Subject) -> dict[str, Array]:
    """Moving joint → places that it goes through, shape (n, 2), in millimetres.

    They are samples, as many as the path needs: lines between them leave it by at most `NARROW`.
    Samples where the joint is not known are left out at both ends.
    """
    result = {}
    moving = moving_joints(subject.solution.data, subject.mechanism)
    size = Box.around(np.vstack([*moving.values()])).extent if moving else 0.0
    for name, path in moving.items():
        known = np.flatnonzero(np.isfinite(path).all(axis=1))
        if not len(known):
            continue
        part = path[known[0] : known[-1] + 1]
        if len(part) != len(known):
            raise ValueError(f"the path of joint {name} has gaps: it cannot be one line")
        result[name] = MILLIMETRES * thinned(part, NARROW * size)
    return result


Content = Mapping[str, str | bytes]

_ENTRY = "drawn\n    What `drawn_of` returns.\n"
_OPTIONS = """\
hole, width
    Diameter of holes and width of links in metres; default: as the mechanism's size wants.
paths, links
    Whether to write either.
"""


def drawn_of(
    subject: Subject,
    *,
    hole: float | None = None,
    width: float | None = None,
    paths: bool = True,
    links: bool = True,
) -> Drawn:
    """What a drawing shows, in millimetres; its options are those of all formats of drawings."""
    pose = first_pose(subject)
    sizes = sizes_of(pose, hole, width)
    shown = parts_of(pose, sizes) if links else []
    lines = paths_of(subject) if paths else {}
    if not shown and not lines:
        raise ValueError("nothing to export: no link and no path of a joint is asked for")
    return Drawn(shown, lines, sizes)


def drawing(
    write: Callable[Concatenate[Subject, Callable[[], Drawn], ...], Content],
) -> Export:
    """Let a format have the options of drawings before its own, and write what they ask for.

    `write`: a function of a `Subject`, of what returns the drawing, and of options of its own. The
    entry of the second in its docstring makes way for the options.
    """
    subject, _, *own = inspect.signature(write).parameters.values()
    _, *shared = inspect.signature(drawn_of).parameters.values()
    names = [parameter.name for parameter in own]

    @wraps(write)
    def written(subject: Subject, **options: Any) -> Content:
        kept: Any = {name: options.pop(name) for name in names if name in options}
        return write(subject, partial(drawn_of, subject, **options), **kept)

    made: Any = written
    made.__signature__ = inspect.Signature([subject, *shared, *own])
    made.__doc__ = inspect.cleandoc(write.__doc__ or "").replace(_ENTRY, _OPTIONS)
    return written


POINT = 25.4 / 72.0
"""Millimetres."""

MARGIN = 1.0
"""Millimetres around symbols."""


def symbols_of(subject: Subject) -> tuple[list[str], Array, Array]:
    """The drawing of a mechanism where its motion begins; low and high corner of its box."""
    pose = pose_at(subject.solution.data, subject.mechanism, 0)
    shapes = shapes_of(pose, MILLIMETRES / POINT)
    scaled = pose.scaled(MILLIMETRES)
    box = Cover.of(scaled, shapes).box(POINT)
    return svg_elements(scaled, shapes), box.low - MARGIN, box.high + MARGIN


def svg_elements(pose: Pose, shapes: Sequence[Shape]) -> list[str]:
    """One element for each shape and each casing, in the order of drawing; y points down.

    `pose`: in millimetres.
    `shapes`: words are left out: where there is room for them is not known.
    """
    result = []
    for shape in shapes:
        match shape:
            case Strokes():
                result += _both(f'<path d="{_path(pose, shape)}"', shape)
            case Disc():
                ((x, y),) = placed(pose, [shape.centre], shape.direction, POINT)
                radius = shape.metres * pose.unit + shape.points * POINT
                circle = f'<circle cx="{x:.9g}" cy="{-y:.9g}" r="{radius:.9g}"'
                result += _both(circle, shape)
            case Word():
                continue
            case _:
                assert_never(shape)
    return result


def _both(element: str, shape: Strokes | Disc) -> list[str]:
    """The casing of a shape, if it has one, and the shape."""
    look, name = shape.look, f" data-name={quoteattr(shape.name)}" if shape.name else ""
    result = [f'{element}{name} style="{_style(look)}"/>']
    if look.casing:
        under = Look("paper", look.width + 2.0 * look.casing)
        result.insert(0, f'{element} style="{_style(under)}"/>')
    return result


def _path(pose: Pose, shape: Strokes) -> str:
    words = []
    for stroke in shape.strokes:
        places = placed(pose, stroke, shape.direction, POINT)
        words.append(_polyline(places))
        words += ["Z"] * shape.closed
    return " ".join(words)


def _style(look: Look) -> str:
    words = {
        "fill": LIGHT[look.fill] if look.fill else "none",
        "stroke": LIGHT[look.role] if look.width else "none",
        "stroke-width": f"{look.width * POINT:.4g}",
        "stroke-linecap": "butt" if look.dashes else "round",
        "stroke-linejoin": "round",
    }
    if look.fill and look.opacity < 1.0:
        words["fill-opacity"] = f"{look.opacity:g}"
    if look.dashes:
        lengths = (length * look.width * POINT for length in look.dashes)
        words["stroke-dasharray"] = " ".join(f"{length:.4g}" for length in lengths)
    return "; ".join(f"{key}: {value}" for key, value in words.items())


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


def _polyline(line: Array) -> str:
    return "M " + " ".join(f"{x:.9g} {-y:.9g}" for x, y in line)


def _text(text: str) -> str:
    return escape(text, {'"': "&quot;"})


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


EXPORTS = (dxf, svg)
