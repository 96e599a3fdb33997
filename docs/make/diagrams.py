"""Diagrams of the pages on the method and on components."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Polygon, Rectangle

import linkages
from linkages.kernel.system import System
from linkages.plots.style import BLACK, CLEARANCE, DRIVEN, FREE, GREY, LOAD, PALE, PASSIVE
from make.registry import makes

Point = tuple[float, float]
UP, RIGHT = (0, 6), (6, 0)


def panels(count: int, width: float = 2.9, height: float = 2.5) -> tuple[Figure, list[Axes]]:
    """A row of empty panels."""
    figure, axes = plt.subplots(1, count, figsize=(count * width, height), squeeze=False)
    for ax in axes[0]:
        ax.set_aspect("equal", anchor="NW")
        ax.axis("off")
    figure.subplots_adjust(0.01, 0.01, 0.99, 0.9, 0.05, 0.05)
    return figure, list(axes[0])


def along(start: Point, angle: float, length: float) -> Point:
    """The point so far from another, in a direction in degrees."""
    turned = np.radians(angle)
    return start[0] + length * float(np.cos(turned)), start[1] + length * float(np.sin(turned))


def vector(
    ax: Axes,
    start: Point,
    end: Point,
    text: str,
    colour: str,
    shift: Point,
    beside: float = 0.0,
) -> None:
    """An arrow, so far to the left of a line, with its name beside the middle."""
    turned = float(np.degrees(np.arctan2(end[1] - start[1], end[0] - start[0]))) + 90
    start, end = along(start, turned, beside), along(end, turned, beside)
    look = {"arrowstyle": "-|>", "color": colour, "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", end, start, arrowprops=look)
    middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    note(ax, middle, text, shift, colour)


def note(ax: Axes, at: Point, text: str, shift: Point = UP, colour: str = BLACK) -> None:
    """Text so many points beside a place; what stands between dollars is a formula."""
    horizontal = "center" if abs(shift[0]) < 3 else "left" if shift[0] > 0 else "right"
    vertical = "center" if abs(shift[1]) < 3 else "bottom" if shift[1] > 0 else "top"
    ax.annotate(
        text,
        at,
        shift,
        textcoords="offset points",
        color=colour,
        ha=horizontal,
        va=vertical,
        parse_math=True,
    )


def bar(ax: Axes, start: Point, end: Point, colour: str = PASSIVE) -> None:
    """A link without its pins."""
    ax.plot(*zip(start, end, strict=True), color=colour, lw=5, solid_capstyle="round", zorder=1)


def pin(ax: Axes, at: Point, *, known: bool = False) -> None:
    """A pin; a filled one where its place is known."""
    fill = BLACK if known else "white"
    ax.plot(*at, "o", color=BLACK, markerfacecolor=fill, markersize=6, zorder=5)


def angle(ax: Axes, at: Point, radius: float, begin: float, end: float, text: str) -> None:
    """An angle with its name, in degrees."""
    ax.add_patch(Arc(at, 2 * radius, 2 * radius, theta1=begin, theta2=end, color=FREE, lw=1.1))
    tip, before = along(at, end, radius), along(at, end - 6, radius)
    ax.annotate("", tip, before, arrowprops={"arrowstyle": "-|>", "color": FREE, "lw": 1.1})
    middle = along(at, (begin + end) / 2, radius)
    note(ax, middle, text, (5 * np.cos(np.radians((begin + end) / 2)) + 2, 5), FREE)


def axis(ax: Axes, start: Point, turned: float, length: float) -> None:
    """A thin line with an arrow."""
    look = {"arrowstyle": "-|>", "color": GREY, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", along(start, turned, length), start, arrowprops=look)


def block(ax: Axes, at: Point, turned: float, colour: str = PALE) -> None:
    """The block of a slider."""
    size = (0.42, 0.24)
    corner = (at[0] - size[0] / 2, at[1] - size[1] / 2)
    shape = Rectangle(corner, *size, angle=turned, rotation_point="center", zorder=3)
    shape.set(facecolor=colour, edgecolor=BLACK, linewidth=1)
    ax.add_patch(shape)


@makes("diagram-dyads.svg")
def dyads() -> Figure:
    """The three closed forms of method.md with their vectors."""
    figure, (turning, sliding, guided) = panels(3)
    a, b, c = (0.0, 0.0), (2.2, 0.2), (1.3, 1.35)
    turning.set_title("two turning links (RRR)")
    bar(turning, a, c), bar(turning, c, b)
    vector(turning, a, b, "$\\mathbf{g}$", BLACK, (0, -6))
    vector(turning, a, c, "$\\mathbf{f}$", DRIVEN, (-6, 4), beside=0.12)
    vector(turning, c, b, "$\\mathbf{s}$", FREE, (6, 4), beside=0.12)
    foot = (1.42, 0.13)
    turning.plot(*zip(c, foot, strict=True), ":", color=GREY)
    note(turning, (1.37, 0.7), "$h\\,g$", (-5, 0), GREY)
    for place, known in ((a, True), (b, True), (c, False)):
        pin(turning, place, known=known)
    note(turning, c, "σ = +1: left of $\\mathbf{g}$", (8, 6), GREY)
    turning.set(xlim=(-0.3, 2.9), ylim=(-0.4, 1.8))

    o, p = (0.0, 0.0), (0.5, 1.2)
    sliding.set_title("a turning link and a slider (RRP)")
    e = (1.75, 0.35)
    axis(sliding, o, 11.3, 2.6)
    bar(sliding, p, e)
    block(sliding, e, 11.3)
    vector(sliding, o, p, "$\\mathbf{g}$", BLACK, (-6, 2))
    vector(sliding, p, e, "$\\mathbf{l}$", DRIVEN, (5, 5), beside=0.12)
    vector(sliding, o, e, "$s\\,\\mathbf{a}$", FREE, (0, -6))
    pin(sliding, p, known=True), pin(sliding, e)
    note(sliding, o, "axis point", (4, -8), GREY)
    sliding.set(xlim=(-0.3, 2.9), ylim=(-0.4, 1.8))

    guided.set_title("a guide and a slider along it (RPR)")
    q, r = (0.0, 0.0), (1.75, 1.25)
    turned = 20.0
    at = along(q, turned, 2.0)
    bar(guided, q, along(q, turned, 2.6))
    block(guided, at, turned)
    vector(guided, q, r, "$\\mathbf{g}$", BLACK, (-6, 6))
    vector(guided, q, at, "$s\\,\\mathbf{a}$", FREE, (4, -6), beside=-0.12)
    vector(guided, at, r, "$\\mathbf{b}$", DRIVEN, (6, 0))
    pin(guided, q, known=True), pin(guided, r, known=True)
    guided.set(xlim=(-0.3, 2.9), ylim=(-0.4, 1.8))
    return figure


@makes("diagram-clearance.svg")
def clearance() -> Figure:
    """A journal in its bearing, and the massless link that stands for both."""
    figure, (real, model) = panels(2, 3.6, 2.7)
    direction, play = 35, 0.45
    hole, journal = 1.0, 1.0 - play
    centre = (0.0, 0.0)
    off = along(centre, direction, play)
    real.set_title("journal and bearing, the clearance enlarged")
    real.add_patch(Circle(off, hole + 0.28, facecolor=PALE, edgecolor=BLACK))
    real.add_patch(Circle(off, hole, facecolor="white", edgecolor=BLACK))
    real.add_patch(Circle(centre, journal, facecolor="#FBE3D4", edgecolor=BLACK))
    real.plot(*zip(centre, off, strict=True), color=CLEARANCE, lw=2)
    pin(real, centre), pin(real, off)
    touch = along(centre, direction + 180, journal)
    for at, end, text, colour in (
        (centre, (2.0, -0.75), "centre of the journal: C", BLACK),
        (off, (2.0, 0.9), "centre of the bearing: C.r1", CLEARANCE),
        (touch, (2.0, -1.15), "point of contact", BLACK),
    ):
        real.plot(*zip(at, end, strict=True), color=GREY, lw=0.6, zorder=2)
        note(real, end, text, (3, 0), colour)
    real.set(xlim=(-1.2, 4.4), ylim=(-1.25, 1.75))

    model.set_title("massless link of length r, free to turn")
    a, b = (0.0, 0.0), along((0.0, 0.0), direction, 1.1)
    bar(model, (-0.9, -0.75), a)
    bar(model, b, along(b, 15, 1.1))
    model.plot(*zip(a, b, strict=True), color=CLEARANCE, lw=2.4)
    axis(model, a, 0, 1.3)
    angle(model, a, 0.75, 0, direction, "α")
    note(model, along(a, direction, 0.62), "r", (-6, 5), CLEARANCE)
    pin(model, a), pin(model, b)
    note(model, a, "C", (-6, 4)), note(model, b, "C.r1", (0, 6), CLEARANCE)
    model.set(xlim=(-1.1, 2.4), ylim=(-1.0, 1.5))
    return figure


@makes("diagram-slider.svg")
def slider() -> Figure:
    """What the keys of a slider mean, on the ground and on a bar."""
    figure, (ground, carried) = panels(2, 3.6, 2.6)
    ground.set_title("on the ground")
    o, turned = (0.0, 0.0), 20
    at = along(o, turned, 2.1)
    axis(ground, o, 0, 1.5), axis(ground, o, turned, 3.0)
    angle(ground, o, 1.1, 0, turned, "angle")
    block(ground, at, turned)
    pin(ground, at), pin(ground, o, known=True)
    note(ground, o, "through", (0, -7)), note(ground, at, "joint", (4, -12))
    above = along(o, turned + 90, 0.42)
    vector(ground, above, along(above, turned, 2.1), "position > 0", FREE, (-8, 5))
    ground.set(xlim=(-0.4, 3.1), ylim=(-0.4, 1.9))

    carried.set_title("on a bar: angle 0 is along it")
    first, lean = (0.0, 0.0), 28
    bar(carried, first, along(first, lean, 3.0))
    at = along(first, lean, 1.8)
    block(carried, at, lean)
    pin(carried, first), pin(carried, at)
    note(carried, first, "through: the bar's first joint,\nif nothing is said", (6, -10))
    note(carried, at, "joint", (4, -9))
    above = along(first, lean + 90, 0.36)
    vector(carried, above, along(above, lean, 1.8), "position", FREE, (-6, 5))
    carried.set(xlim=(-0.4, 3.1), ylim=(-0.6, 1.8))
    return figure


@makes("diagram-plate.svg")
def plate() -> Figure:
    """The frame of a plate."""
    figure, (ax,) = panels(1, 4.2, 2.7)
    origin, lean = np.array([0.0, 0.0]), np.radians(18)
    frame = np.array([[np.cos(lean), -np.sin(lean)], [np.sin(lean), np.cos(lean)]])
    points = {"A [0, 0]": (0, 0), "B [120, 0]": (2.4, 0), "P [50, 45]": (1.0, 0.9)}
    placed = {name: tuple(origin + frame @ np.array(place)) for name, place in points.items()}
    corners = list(placed.values())
    ax.add_patch(
        Polygon(corners, facecolor=PALE, edgecolor=PASSIVE, linewidth=4, joinstyle="round")
    )
    axis(ax, corners[0], 18, 3.1), axis(ax, corners[0], 108, 1.5), axis(ax, corners[0], 0, 1.9)
    angle(ax, corners[0], 1.5, 0, 18, "angle of the plate")
    note(ax, along(corners[0], 18, 3.1), "x of the plate", (0, 5), GREY)
    note(ax, along(corners[0], 108, 1.5), "y of the plate", (5, 3), GREY)
    for name, place in placed.items():
        pin(ax, place)
        note(ax, place, name, (0, 8) if "P" in name else (4, -8))
    ax.set(xlim=(-0.8, 3.6), ylim=(-0.5, 1.9))
    return figure


@makes("diagram-guide.svg")
def guide() -> Figure:
    """A block with play in its guide."""
    figure, (ax,) = panels(1, 5.0, 2.3)
    wall, tilt, centre = 0.95, 8.0, (0.15, 0.14)
    for side in (1, -1):
        ax.plot((-2.1, 2.1), (side * wall, side * wall), color=BLACK, lw=1.2)
        for x in np.linspace(-2.1, 2.0, 32):
            ax.plot((x, x - 0.1), (side * wall, side * (wall + 0.1)), color=BLACK, lw=0.6)
    cosine, sine = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    corners = np.array([(-0.9, 0.5), (0.9, 0.5), (0.9, -0.5), (-0.9, -0.5)])
    corners = corners @ [[cosine, sine], [-sine, cosine]] + centre
    ax.add_patch(Polygon(corners, facecolor=PALE, edgecolor=BLACK, linewidth=1))
    axis(ax, (-2.1, 0.0), 0, 4.3)
    note(ax, (2.2, 0.0), "axis", (0, 6), GREY)
    places = {1: corners[0], 2: corners[1], 3: corners[3], 4: corners[2]}
    for number, place in places.items():
        side = -1 if place[0] < 0 else 1
        ax.plot(*place, "o", color=CLEARANCE, markersize=3.5, zorder=5)
        note(ax, tuple(place), f"corner{number}", (side * 6, 0), CLEARANCE)
    vector(ax, (centre[0], 0.0), centre, "e", FREE, (-9, 0))
    pin(ax, centre)
    ax.plot(*zip(centre, along(centre, tilt, 1.7), strict=True), ":", color=FREE, lw=1)
    ax.plot(*zip(centre, along(centre, 0, 1.7), strict=True), ":", color=FREE, lw=1)
    angle(ax, centre, 1.45, 0, tilt, "φ")
    ax.set(xlim=(-2.3, 2.5), ylim=(-1.1, 1.1))
    return figure


@makes("diagram-signs.svg")
def signs() -> Figure:
    """Angles, torques and forces as files and results count them."""
    figure, (turned, forces) = panels(2, 3.4, 2.5)
    turned.set_title("angles and torques: counter-clockwise")
    o, end = (0.0, 0.0), along((0.0, 0.0), 40, 2.0)
    bar(turned, o, end, DRIVEN)
    axis(turned, o, 0, 2.1), axis(turned, o, 90, 1.5)
    angle(turned, o, 0.9, 0, 40, "θ > 0")
    pin(turned, o, known=True), pin(turned, end)
    note(turned, along(o, 0, 2.1), "x", RIGHT, GREY), note(turned, along(o, 90, 1.5), "y", UP, GREY)
    note(turned, end, "from the first joint of\nthe bar to the second", (8, 0), GREY)
    turned.set(xlim=(-0.5, 3.6), ylim=(-0.4, 2.0))

    forces.set_title("joint reaction: of the first body of the file")
    a, b = (-1.2, -0.3), (1.5, 0.7)
    bar(forces, a, (0, 0)), bar(forces, (0, 0), b, FREE)
    pin(forces, (0, 0))
    note(forces, (0, 0), "A", (-6, 5))
    note(forces, a, "crank", (4, 10), PASSIVE), note(forces, b, "rod", (2, 8), FREE)
    vector(forces, (0, 0), (0.9, -0.55), "force of the crank\non the rod", LOAD, (12, -12))
    forces.set(xlim=(-1.4, 2.4), ylim=(-1.2, 1.3))
    return figure


@makes("diagram-order.svg")
def order() -> Figure:
    """The blocks of the nine-bar in their order of solution, and what each of them knows."""
    blocks = System(linkages.load("ninebar")).topology.blocks
    places = {"crank1": (0, 1), "crank4": (0, 0), "r1": (1.1, 0)}
    boxes: list[tuple[Point, str, str]] = []
    for name, text, colour in (
        ("crank1", "crank1\ndriven: A", DRIVEN),
        ("crank4", "crank4\ndriven: C", DRIVEN),
        ("r1", "r1\nfree: C.r1", CLEARANCE),
    ):
        boxes.append((places[name], text, colour))
    where = {"A": places["crank1"], "C": places["crank4"], "C.r1": places["r1"]}
    arrows = [(places["crank4"], places["r1"])]
    for place, block in enumerate(block for block in blocks if block.kind):
        at = (2.3 + 1.25 * place, 0.5)
        (loop,) = block.loops
        boxes.append((at, f"{' and '.join(block.unknowns)}\n{block.kind}: {loop.apex}", PASSIVE))
        arrows += [(where[name], at) for name in (loop.start, loop.end) if name in where]
        where[loop.apex] = at
    figure, (ax,) = panels(1, 7.2, 1.7)
    ax.set_aspect("auto")
    for begin, end in arrows:
        look = {"arrowstyle": "-|>", "color": GREY, "shrinkA": 38, "shrinkB": 42}
        ax.annotate("", end, begin, arrowprops=look)
    for at, text, colour in boxes:
        look = {"boxstyle": "round,pad=0.45", "facecolor": "white", "edgecolor": colour, "lw": 1.4}
        ax.annotate(text, at, ha="center", va="center", bbox=look)
    ax.set(xlim=(-0.5, 5.5), ylim=(-0.4, 1.4))
    return figure
