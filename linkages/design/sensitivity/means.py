"""Means of what changes with time, with their derivatives, over all that bends or jumps in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.design.sensitivity.integrals import gauss, simpson
from linkages.design.sensitivity.moved import JUMP
from linkages.design.sensitivity.trees import Tree
from linkages.design.sensitivity.varied import Varied, applied, filled
from linkages.spec.formulas import Call, Node
from linkages.spec.measures import is_series

Floats = NDArray[np.float64]

_HALVINGS, _ASIDE = 60, 1e-5
"""How often an interval is halved in which something becomes zero, and how many samples beside that
place what is measured is looked at."""


class Means(Tree):
    """A measure that may have means in it."""

    def mean(self, node: Node, power: int) -> Varied:
        """The mean over time of a power of what changes with it.

        Where what is summed jumps, and numbers move the time of it, it changes by the jump.
        """
        moved = self.moved
        whole = float(len(moved.time) - 1)
        if not whole:
            found = self._power(node, power, np.zeros(1))
            return Varied(np.ravel(found.value)[0], filled(found, moved.count)[:, 0])
        kinks, jumps = self._kinks(node, power)
        if moved.breaks or len(kinks) or not moved.integrated:
            places, weights = gauss(np.union1d(moved.grid, kinks), moved.sides)
        else:
            places, weights = simpson(moved.grid)
        found = self._power(node, power, places)
        value = np.broadcast_to(found.value, places.shape) @ weights / whole
        if found.slopes is None:
            return Varied(value, None)
        size = float(np.abs(found.value).max())
        jumps = (jumps + self._jumps(node, power, size)) / (moved.time[-1] - moved.time[0])
        return Varied(value, found.slopes @ weights / whole + jumps)

    def _kinks(self, node: Node, power: int) -> tuple[Floats, Floats]:
        """Places where what is measured bends or jumps by itself, and what moving jumps add, (P,).

        They are the zeros of what ``abs``, ``sign``, ``where``, ``min`` and ``max`` decide by.
        """
        moved, grid = self.moved, self.moved.grid
        steady = ~np.isin(grid[:-1], moved.sides[:, 0])
        kinks, added = [np.zeros(0)], np.zeros(moved.count)
        for decides in dict.fromkeys(_conditions(node)):
            values = np.broadcast_to(self.series(decides, grid, slopes=False).value, grid.shape)
            crossed = steady & ((values[:-1] < 0.0) != (values[1:] < 0.0))
            low, high, below = grid[:-1][crossed], grid[1:][crossed], values[:-1][crossed] < 0.0
            if not len(low):
                continue
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                same = (self.series(decides, middle, slopes=False).value < 0.0) == below
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            kinks.append(high)
            if moved.count:
                added += self._pushed(node, decides, power, high)
        return np.concatenate(kinks), added

    def _pushed(self, node: Node, decides: Node, power: int, places: Floats) -> Floats:
        """What jumps where something else is zero add to an integral, shape (P,)."""
        around = places + _ASIDE * np.array([[-2.0], [-1.0], [1.0], [2.0]])
        around = np.clip(around, 0.0, float(self.last))
        found = self._power(node, power, around.ravel()).value.reshape(around.shape)
        beside = 2.0 * found[1:3] - found[::3]  # both sides at the place itself
        slopes = filled(self.series(decides, places, slopes=True), self.moved.count)
        whole = np.zeros(self.moved.count)
        for jump, slope, place in zip(beside[0] - beside[1], slopes.T, places, strict=True):
            if abs(jump) > JUMP * np.abs(beside).max():
                pace = self.near(decides, place).rate(place, 1)[0] / self.step(place)
                whole -= jump * slope / pace
        return whole

    def _power(self, node: Node, power: int, places: Floats) -> Varied:
        found = self.series(node, places, slopes=True)
        return applied("mul", [found, found]) if power == 2 else found

    def _jumps(self, node: Node, power: int, size: float) -> Floats:
        """What moving jumps add to an integral, (x⁻ − x⁺) ∂t*/∂p each, shape (P,)."""
        sides = self.moved.sides
        values = np.broadcast_to(self._power(node, power, sides.ravel()).value, sides.size)
        apart = -np.diff(values.reshape(-1, 2))[:, 0]
        whole = np.zeros(self.moved.count)
        for each, jump in zip(self.moved.breaks, apart, strict=True):
            if abs(jump) > JUMP * size:
                whole += jump * each.moved
        return whole


def _conditions(node: Node) -> list[Node]:
    """What decides between branches in something that changes with time."""
    if not isinstance(node, Call) or not is_series(node):
        return []
    own: list[Node] = []
    match node.name, node.arguments:
        case ("abs" | "sign", (inner,)) | ("where", (inner, _, _)):
            own = [inner]
        case "min" | "max", (one, other):
            own = [Call("sub", (one, other))]
    within = [each for argument in node.arguments for each in _conditions(argument)]
    return [each for each in own if is_series(each)] + within
