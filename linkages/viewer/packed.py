"""Numbers as text that a page carries: 32-bit floats, shuffled, compressed, in base 64."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Place = tuple[int, int]
"""Where an array begins among all numbers, and how many it has."""


class Packed:
    """Arrays one behind the other; `assets/unpack.js` reads their text."""

    def __init__(self) -> None:
        self._arrays: list[NDArray[np.float32]] = []
        self._count = 0

    def add(self, values: ArrayLike) -> Place:
        """Append an array, rounded to 32 bits; return its place."""
        with np.errstate(over="ignore"):  # what is beyond the range of 32 bits is infinite
            array = np.asarray(values, dtype=np.float64).ravel().astype(np.float32)
        self._arrays.append(array)
        place = (self._count, len(array))
        self._count += len(array)
        return place

    def add_exact(self, values: Sequence[float] | NDArray[np.float64]) -> tuple[Place, Place]:
        """Append an array as two: rounded, and what rounding took away."""
        exact = np.asarray(values, dtype=np.float64)
        rounded = exact.astype(np.float32)
        return self.add(rounded), self.add(exact - rounded)

    def text(self) -> str:
        """All of it, about half as long as plain base 64.

        Neighbours are alike, so what is compressed are differences of bit patterns, first all of
        their lowest bytes, then the next ones.
        """
        whole = np.concatenate([np.zeros(0, np.float32), *self._arrays]).view(np.uint32)
        steps = np.diff(whole, prepend=np.uint32(0))
        planes = steps.astype("<u4").view(np.uint8).reshape(-1, 4).T
        return deflated(planes.tobytes())


def deflated(data: bytes) -> str:
    """Bytes as compressed text, which `assets/unpack.js` reads."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")
