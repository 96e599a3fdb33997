"""Layout of an animation: the mechanism, and beside or below it its clearances."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import ceil

import numpy as np

from linkages.plots.mechanism.plane_view import Box
from linkages.plots.style import BOTTOM, LEFT, RIGHT, TOP

Rectangle = tuple[float, float, float, float]

WIDTH = 6.6  # inches of a page whose size nobody asked for, without insets beside
MARGIN = 0.35  # inches around what the mechanism sweeps
SMALLEST, LARGEST, BELOW = 1.6, 3.5, 2.2  # sides of an inset in inches; of one below the picture
HEAD, FOOT, GAP = 0.3, 0.5, 0.2  # title of an inset, texts under it; between insets
LOWEST, HIGHEST = 1.3, 5.0  # of the main picture, in inches
WIDE = 1.8
"""Width over height from which on insets stand below if one column beside does not hold them."""

DPI = 120.0
"""Pixels per inch of a picture whose size nobody asked for."""

COARSEST = 40.0
"""Pixels per inch below which texts cannot be read."""

STRIP = 1.0
"""Height of a strip with a curve, in inches."""

LEAST = 1.0
"""Inches; a main picture that is smaller shows nothing."""


@dataclass(frozen=True)
class PageLayout:
    """A page: its size in inches, and rectangles (left, bottom, width, height) as parts of it."""

    size: tuple[float, float]  # width and height
    main: Rectangle  # the mechanism
    insets: tuple[Rectangle, ...]  # one for each clearance
    # One for each curve, over the whole width, from above to below
    strips: tuple[Rectangle, ...] = ()

    @classmethod
    def of(
        cls, box: Box, insets: int, size: tuple[float, float] | None = None, strips: int = 0
    ) -> PageLayout:
        """Arrange a picture of a box and some insets, none of which covers another."""
        if not strips:
            return cls._without_strips(box, insets, size)
        under = strips * (STRIP + TOP + BOTTOM)
        room = None if size is None else (size[0], size[1] - under)
        if room is not None and room[1] < LEAST:
            raise _too_small((room[0], room[1] + under))
        above = cls._without_strips(box, insets, room)
        width, height = above.size
        page = (width, height + under)
        moved = [
            (left, (bottom * height + under) / page[1], wide, high * height / page[1])
            for left, bottom, wide, high in (above.main, *above.insets)
        ]
        low = [under - (index + 1) * (STRIP + TOP + BOTTOM) + BOTTOM for index in range(strips)]
        across = (width - LEFT - RIGHT, STRIP)
        return cls(page, moved[0], tuple(moved[1:]),
                   tuple(_part((LEFT, bottom, *across), page) for bottom in low))  # fmt: skip

    @classmethod
    def _without_strips(cls, box: Box, insets: int, size: tuple[float, float] | None) -> PageLayout:
        if size is None or not insets:
            return cls._with_insets_beside(box, insets, size)
        result = []
        for arranged in (cls._with_insets_beside, cls._with_insets_below):
            with suppress(ValueError):
                layout = arranged(box, insets, size)
                room = np.array(layout.main[2:]) * size - 2 * MARGIN
                result.append((float(np.min(room / np.maximum(box.size, 1e-12))), layout))
        if not result:
            raise _too_small(size)
        return max(result, key=lambda scaled: scaled[0])[1]

    @classmethod
    def _with_insets_beside(
        cls, box: Box, insets: int, size: tuple[float, float] | None
    ) -> PageLayout:
        """Insets in columns to the right; below, where the size is free and they fit better."""
        width = WIDTH if size is None else size[0]
        main = width - LEFT - RIGHT
        height = _height(box, main) if size is None else size[1] - BOTTOM - TOP
        apart = HEAD + FOOT  # texts under the last one are beside those of the axis
        fitting = max(1, int((height + apart) / (SMALLEST + apart)))
        columns = max(1, ceil(insets / fitting))
        stacked = max(1, ceil(insets / columns))
        wide = box.size[0] > WIDE * box.size[1]
        if size is None and insets and (height < SMALLEST or (wide and columns > 1)):
            return cls._with_insets_below(box, insets, size)
        side = min(LARGEST, (height + apart) / stacked - apart)
        beside = ceil(insets / stacked) * (side + GAP)
        if size is None:
            width += beside
        else:
            main -= beside
        page = (width, height + BOTTOM + TOP)
        left, top = LEFT + main + RIGHT, BOTTOM + height
        places = [
            (
                left + (index // stacked) * (side + GAP),
                top - side - index % stacked * (side + apart),
            )
            for index in range(insets)
        ]  # fmt: skip
        return cls._checked(page, (LEFT, BOTTOM, main, height), places, side)

    @classmethod
    def _with_insets_below(
        cls, box: Box, insets: int, size: tuple[float, float] | None
    ) -> PageLayout:
        """Insets in rows under a wide picture."""
        width = WIDTH if size is None else size[0]
        main = width - LEFT - RIGHT
        columns = max(1, min(insets, int((main + GAP) / (SMALLEST + GAP))))
        side = min(BELOW, (main + GAP) / columns - GAP)
        rows = ceil(insets / columns)
        under = BOTTOM + rows * (HEAD + side + FOOT)
        height = _height(box, main) if size is None else size[1] - under - TOP
        page = (width, under + height + TOP)
        places = [
            (LEFT + index % columns * (side + GAP),
             under - BOTTOM - HEAD - side - (index // columns) * (HEAD + side + FOOT))
            for index in range(insets)
        ]  # fmt: skip
        return cls._checked(page, (LEFT, under, main, height), places, side)

    @classmethod
    def _checked(
        cls, page: tuple[float, float], main: Rectangle, places: list[tuple[float, float]],
        side: float,
    ) -> PageLayout:  # fmt: skip
        """From inches to parts of the page."""
        if min(main[2:]) < LEAST:
            raise _too_small(page)
        insets = tuple(_part((*place, side, side), page) for place in places)
        return cls(page, _part(main, page), insets)


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


def _too_small(page: tuple[float, float]) -> ValueError:
    return ValueError(
        f"{page[0]:.3g} by {page[1]:.3g} inches are too small for this picture; "
        "expected a larger size or fewer dots per inch"
    )


def _height(box: Box, width: float) -> float:
    """Of a picture that shows a box with margins and is so wide, in inches."""
    inches = (width - 2 * MARGIN) / max(box.size[0], 1e-3 * box.size[1])
    return float(np.clip(inches * box.size[1] + 2 * MARGIN, LOWEST, HIGHEST))


def _part(rectangle: Rectangle, page: tuple[float, float]) -> Rectangle:
    left, bottom, width, height = rectangle
    return left / page[0], bottom / page[1], width / page[0], height / page[1]
