"""Layout of an animation: the mechanism, and beside or below it its clearances."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import ceil

import numpy as np

from linkages.plots.mechanism.plane_view import Box
from linkages.plots.style import BOTTOM, LEFT, RIGHT, TOP

Rectangle = tuple[float, float, float, float]
Size = tuple[float, float]

WIDTH = 6.6  # inches of a page whose size nobody asked for, without insets beside
MARGIN = 0.35  # inches around what the mechanism sweeps
SMALLEST, LARGEST, BELOW = 1.6, 3.5, 2.2  # sides of an inset in inches; of one below the picture
HEAD, FOOT, GAP = 0.3, 0.5, 0.2  # title of an inset, texts under it; between insets
LOWEST, HIGHEST = 1.3, 5.0  # of the main picture, in inches
WIDE = 1.8
"""Width over height from which on insets stand below if one column beside does not hold them."""

DPI, COARSEST = 120.0, 40.0
"""Pixels per inch of a picture whose size nobody asked for, and below which nobody can read."""

STRIP, LEAST = 1.0, 1.0
"""Inches: height of a strip with a curve, and of a main picture that shows anything."""


@dataclass(frozen=True)
class PageLayout:
    """A page: its size in inches, and rectangles (left, bottom, width, height) as parts of it."""

    size: Size  # width and height
    main: Rectangle  # the mechanism
    insets: tuple[Rectangle, ...]  # one for each clearance
    # One for each curve, over the whole width, from above to below
    strips: tuple[Rectangle, ...] = ()

    @classmethod
    def of(cls, box: Box, insets: int, size: Size | None = None, strips: int = 0) -> PageLayout:
        """Arrange a picture of a box and some insets, none of which covers another."""
        each = STRIP + TOP + BOTTOM
        under = strips * each
        room = None if size is None else (size[0], size[1] - under)
        if room is not None and strips and room[1] < LEAST:
            raise _too_small((room[0], room[1] + under))
        page, main, squares = _arranged(box, insets, room)
        whole = page[0], page[1] + under
        raised = [
            (left, bottom + under, wide, high) for left, bottom, wide, high in (main, *squares)
        ]
        lows = [under - (index + 1) * each + BOTTOM for index in range(strips)]
        curves = [(LEFT, bottom, page[0] - LEFT - RIGHT, STRIP) for bottom in lows]
        first, *others = (_part(each, whole) for each in (*raised, *curves))
        return cls(whole, first, tuple(others[:insets]), tuple(others[insets:]))


Arranged = tuple[Size, Rectangle, list[Rectangle]]
"""A page without strips, its main picture and its insets, all in inches."""


def _arranged(box: Box, insets: int, size: Size | None) -> Arranged:
    """The arrangement that suits the mechanism, or makes it largest in a page of a given size."""
    if size is None or not insets:
        return _beside(box, insets, size)
    result = []
    for arrange in (_beside, _below):
        with suppress(ValueError):
            found = arrange(box, insets, size)
            room = np.array(found[1][2:]) - 2 * MARGIN
            result.append((float(np.min(room / np.maximum(box.size, 1e-12))), found))
    if not result:
        raise _too_small(size)
    return max(result, key=lambda scaled: scaled[0])[1]


def _beside(box: Box, insets: int, size: Size | None) -> Arranged:
    """Insets in columns to the right; below, where the size is free and they fit better."""
    main = (WIDTH if size is None else size[0]) - LEFT - RIGHT
    height = _height(box, main) if size is None else size[1] - BOTTOM - TOP
    apart = HEAD + FOOT  # texts under the last one are beside those of the axis
    columns = max(1, ceil(insets / max(1, int((height + apart) / (SMALLEST + apart)))))
    stacked = max(1, ceil(insets / columns))
    wide = box.size[0] > WIDE * box.size[1]
    if size is None and insets and (height < SMALLEST or (wide and columns > 1)):
        return _below(box, insets, size)
    side = min(LARGEST, (height + apart) / stacked - apart)
    beside = ceil(insets / stacked) * (side + GAP)
    if size is not None:
        main -= beside
    page = (LEFT + main + RIGHT + beside, height + BOTTOM + TOP)
    places = [
        (LEFT + main + RIGHT + k // stacked * (side + GAP),
         BOTTOM + height - side - k % stacked * (side + apart))
        for k in range(insets)
    ]  # fmt: skip
    return _checked(page, (LEFT, BOTTOM, main, height), places, side)


def _below(box: Box, insets: int, size: Size | None) -> Arranged:
    """Insets in rows under a wide picture."""
    width = WIDTH if size is None else size[0]
    main = width - LEFT - RIGHT
    columns = max(1, min(insets, int((main + GAP) / (SMALLEST + GAP))))
    side = min(BELOW, (main + GAP) / columns - GAP)
    each = HEAD + side + FOOT
    under = BOTTOM + ceil(insets / columns) * each
    height = _height(box, main) if size is None else size[1] - under - TOP
    places = [
        (LEFT + k % columns * (side + GAP), under - BOTTOM - HEAD - side - k // columns * each)
        for k in range(insets)
    ]
    return _checked((width, under + height + TOP), (LEFT, under, main, height), places, side)


def _checked(page: Size, main: Rectangle, places: Sequence[Size], side: float) -> Arranged:
    if min(main[2:]) < LEAST:
        raise _too_small(page)
    return page, main, [(*place, side, side) for place in places]


def page(
    box: Box, insets: int, strips: int, size: tuple[int, int] | None, dpi: float | None
) -> tuple[PageLayout, float]:
    """The page of a picture, and its pixels per inch."""
    if size is None:
        return PageLayout.of(box, insets, None, strips), DPI if dpi is None else dpi
    if dpi is None:
        natural = PageLayout.of(box, insets, None, strips).size
        dpi = min(size[0] / natural[0], size[1] / natural[1])
        if dpi < COARSEST:
            raise ValueError(
                f"{size[0]}x{size[1]} pixels are too small for this picture; expected at least "
                f"{natural[0] * COARSEST:.0f}x{natural[1] * COARSEST:.0f}"
            )
    return PageLayout.of(box, insets, (size[0] / dpi, size[1] / dpi), strips), dpi


def _too_small(page: Size) -> ValueError:
    return ValueError(
        f"{page[0]:.3g} by {page[1]:.3g} inches are too small for this picture; "
        "expected a larger size or fewer dots per inch"
    )


def _height(box: Box, width: float) -> float:
    """Of a picture that shows a box with margins and is so wide, in inches."""
    inches = (width - 2 * MARGIN) / max(box.size[0], 1e-3 * box.size[1])
    return float(np.clip(inches * box.size[1] + 2 * MARGIN, LOWEST, HIGHEST))


def _part(rectangle: Rectangle, page: Size) -> Rectangle:
    left, bottom, width, height = rectangle
    return left / page[0], bottom / page[1], width / page[0], height / page[1]
