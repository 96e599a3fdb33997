"""Symbols of springs and dampers: along a line between two points, and around a pin.

Lengths are typographic points; places are in the units of the axes.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.path import Path
from matplotlib.transforms import Transform
from numpy.typing import NDArray

from linkages.plots.mechanism.symbols import LAYER, Place, add_path, anchored, grid, stroked
from linkages.plots.mechanism.view import per_point, pixels
from linkages.plots.style import PALETTE

Array = NDArray[np.float64]

COLOUR = PALETTE[2]
WIDTH = 1.1
COILS, AMPLITUDE = 6, 4.5
COIL_LENGTH, CUP = (26.0, 70.0), (13.0, 4.2)  # of a zigzag; length and half width of a dashpot
WALL, WALL_COILS = 20.0, 4  # from a block to a wall beside it, and coils of a zigzag there
SPIRAL, TURNS, BENT = (4.6, 11.0), 2.25, 9.5


def zigzag(ax: Axes, start: Place, end: Place, shift: float = 0.0) -> Array:
    """A spring between two points, moved sideways by `shift`; return pixels it covers."""

    def strokes(length: float) -> list[list[Place]]:
        coiled = float(np.clip(0.7 * length, min(COIL_LENGTH[0], 0.9 * length), COIL_LENGTH[1]))
        first = 0.5 * (length - coiled)
        teeth = first + coiled * (np.arange(2 * COILS) + 0.5) / (2 * COILS)
        heights = AMPLITUDE * (-1.0) ** np.arange(2 * COILS)
        inner = [(float(x), shift + float(y)) for x, y in zip(teeth, heights, strict=True)]
        last = first + coiled
        begin: list[Place] = [(0.0, 0.0), (0.0, shift), (first, shift)]
        return [[*begin, *inner, (last, shift), (length, shift), (length, 0.0)]]

    return _between(ax, start, end, strokes, shift)


def dashpot(ax: Axes, start: Place, end: Place, shift: float = 0.0) -> Array:
    """A damper between two points, moved sideways by `shift`; return pixels it covers."""

    def strokes(length: float) -> list[list[Place]]:
        cup, half = min(CUP[0], 0.6 * length), CUP[1]
        left, piston = 0.5 * (length - cup), 0.5 * length
        return [
            [(0.0, 0.0), (0.0, shift), (left, shift)],
            _cup(left, left + cup, shift, half),
            [(piston, shift + 0.7 * half), (piston, shift - 0.7 * half)],
            [(piston, shift), (length, shift), (length, 0.0)],
        ]

    return _between(ax, start, end, strokes, shift)


def _cup(bottom: float, rim: float, middle: float, half: float) -> list[Place]:
    """The cylinder of a dashpot, open at its rim."""
    low, high = middle - half, middle + half
    return [(rim, high), (bottom, high), (bottom, low), (rim, low)]


def _between(
    ax: Axes, start: Place, end: Place, strokes: Callable[[float], list[list[Place]]], shift: float
) -> Array:
    """Draw strokes along the line from one place to another, given its length."""
    way = np.subtract(*pixels(ax, (end, start))) / per_point(ax)
    length = float(np.hypot(*way))
    transform = anchored(ax, start, float(np.arctan2(way[1], way[0])))
    path = stroked(strokes(length))
    add_path(ax, path, transform, edge=COLOUR, width=WIDTH, layer=LAYER - 1.5)
    x = np.linspace(0.0, length, int(min(length, 1000.0)) // 2 + 2)
    sides = [np.column_stack((x, np.full_like(x, shift + y))) for y in (-4.0, -1.5, 1.5, 4.0)]
    return np.asarray(transform.transform(np.vstack(sides)))


def wall_dashpot(ax: Axes, place: Place, angle: float, start: float, across: float) -> Array:
    """A damper from a block to a wall beside its axis; return pixels it covers."""
    transform = anchored(ax, place, angle)
    half, cup = 0.7 * CUP[1], 0.7 * CUP[0]
    left, piston = start + 4.0, start + 4.0 + 0.5 * cup
    strokes: list[list[Place]] = [
        [(start, across), (left, across)],
        _cup(left, left + cup, across, half),
        [(piston, across + 0.7 * half), (piston, across - 0.7 * half)],
        [(piston, across), (start + WALL, across)],
    ]
    return _against_wall(ax, transform, strokes, start, across)


def wall_zigzag(ax: Axes, place: Place, angle: float, start: float, across: float) -> Array:
    """A spring from a block to a wall beside its axis; return pixels it covers."""
    first, last = start + 2.0, start + WALL - 2.0
    teeth = np.linspace(first, last, 2 * WALL_COILS + 1)[1:-1]
    heights = across + 3.0 * (-1.0) ** np.arange(len(teeth))
    inner = [(float(x), float(y)) for x, y in zip(teeth, heights, strict=True)]
    line = [(start, across), (first, across), *inner, (last, across), (start + WALL, across)]
    return _against_wall(ax, anchored(ax, place, angle), [line], start, across)


def _against_wall(
    ax: Axes, transform: Transform, strokes: list[list[Place]], start: float, across: float
) -> Array:
    """Draw strokes that end at a wall."""
    wall = [(start + WALL, across - 5.0), (start + WALL, across + 5.0)]
    path = stroked([*strokes, wall])
    add_path(ax, path, transform, edge=COLOUR, width=WIDTH, layer=LAYER - 0.8)
    return grid(transform, np.linspace(start, start + WALL, 9), across + np.array([-4.0, 0.0, 4.0]))


def spiral(ax: Axes, place: Place, angle: float) -> Array:
    """A torsional spring about a pin that ends in a direction; return pixels it covers."""
    turn = np.linspace(-2.0 * np.pi * TURNS, 0.0, 120)
    radius = np.linspace(*SPIRAL, 120)
    curve = radius[:, None] * np.column_stack((np.cos(angle + turn), np.sin(angle + turn)))
    transform = anchored(ax, place)
    add_path(ax, Path(curve), transform, edge=COLOUR, width=WIDTH, layer=LAYER + 1.5)
    return np.asarray(transform.transform(curve))


def bent_dashpot(ax: Axes, place: Place, angle: float, radius: float = BENT) -> Array:
    """A torsional damper: a dashpot bent around a pin, with its middle in a direction."""

    def bent(points: list[Place]) -> list[Place]:
        """From (angle, distance from the circle) to points of the plane."""
        found: list[Place] = []
        for (a, r), (b, q) in pairwise(points):
            for share in np.linspace(0.0, 1.0, 9):
                turn, reach = angle + a + share * (b - a), radius + r + share * (q - r)
                found.append((float(reach * np.cos(turn)), float(reach * np.sin(turn))))
        return found

    strokes = [
        bent([(-1.3, 0.0), (-0.5, 0.0)]),
        bent([(0.5, 3.0), (-0.5, 3.0), (-0.5, -3.0), (0.5, -3.0)]),
        bent([(0.0, 2.0), (0.0, -2.0)]),
        bent([(0.0, 0.0), (1.3, 0.0)]),
    ]
    transform = anchored(ax, place)
    add_path(ax, stroked(strokes), transform, edge=COLOUR, width=WIDTH, layer=LAYER + 1.5)
    return np.asarray(transform.transform(np.vstack([np.array(stroke) for stroke in strokes])))
