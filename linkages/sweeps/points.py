"""The points of a sweep: axes of a grid, draws from distributions, and both together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.spec.units import unit
from linkages.sweeps.axes import Axis, axis, coordinates, require_different, require_feasible
from linkages.sweeps.distributions import (
    SEQUENCES,
    Distribution,
    Sequenced,
    distribution_of,
    is_distribution,
    probabilities,
)

Floats = NDArray[np.float64]

DRAW = "draw"


@dataclass(frozen=True)
class Points:
    """What is varied, and how.

    Parameters
    ----------
    axes
        Of a grid; the last one runs fastest.
    drawn
        Path → distribution; these are drawn together, anew for each draw.
    draws, seed, sequence
        How many, and how; draws run faster than axes.
    """

    axes: tuple[Axis, ...]
    drawn: Mapping[str, Distribution]
    draws: int
    seed: int
    sequence: Sequenced

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each dimension."""
        grid = tuple(len(axis) for axis in self.axes)
        return (*grid, self.draws) if self.drawn else grid

    @property
    def count(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of dimensions, as datasets have them."""
        labels = tuple(axis.label for axis in self.axes)
        return (*labels, DRAW) if self.drawn else labels

    @property
    def paths(self) -> tuple[str, ...]:
        """All paths that are varied."""
        return (*(path for axis in self.axes for path in axis.paths), *self.drawn)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of the numbers of each path."""
        along = [axis.unit for axis in self.axes for _ in axis.paths]
        return (*along, *(found.unit for found in self.drawn.values()))

    @cached_property
    def draw_values(self) -> Floats:
        """What is drawn, shape (drawn paths, draws)."""
        if not self.drawn:
            return np.zeros((0, 1))
        found = probabilities([*self.drawn], self.draws, self.seed, self.sequence)
        return np.array(
            [each.inverse(row) for each, row in zip(self.drawn.values(), found, strict=True)]
        )

    def matrix(self, first: int, last: int) -> Floats:
        """Numbers of some points in the units of their paths, shape (last - first, paths)."""
        places = np.unravel_index(np.arange(first, last), self.shape)
        rows = [axis.values[:, place] for axis, place in zip(self.axes, places, strict=False)]
        if self.drawn:
            rows.append(self.draw_values[:, places[-1]])
        return np.concatenate(rows).T

    def overrides(self, first: int, last: int, si: bool = False) -> list[dict[str, object]]:
        """Overrides of some points: texts with their units, or numbers in SI."""
        numbers = self.matrix(first, last)
        if si:
            kinds = [unit(text) if text else None for text in self.units]
            rows = [
                [found if kind is None else kind.convert(found) for found, kind in row]
                for row in (zip(row, kinds, strict=True) for row in numbers.tolist())
            ]
            return [dict(zip(self.paths, row, strict=True)) for row in rows]
        return [
            {
                path: f"{number!r} {unit_}" if unit_ else number
                for path, unit_, number in zip(self.paths, self.units, row, strict=True)
            }
            for row in numbers.tolist()
        ]

    @property
    def described(self) -> dict[str, Any]:
        """What tells them from other points, in terms of JSON; the numbers are elsewhere."""
        found: dict[str, Any] = {"paths": list(self.paths), "shape": list(self.shape)}
        if self.drawn:
            found["drawn"] = {path: each.text for path, each in self.drawn.items()}
            found |= {"draws": self.draws, "seed": self.seed, "sequence": self.sequence}
        return found

    def coordinates(self, mechanism: Mechanism) -> dict[str, Any]:
        """Coordinates of a dataset: values as they were set, with their units."""
        found: dict[str, Any] = {}
        for each in self.axes:
            found |= coordinates(mechanism, each, each.label)
        if self.drawn:
            found[DRAW] = np.arange(self.draws)
            for (path, drawn), row in zip(self.drawn.items(), self.draw_values, strict=True):
                along = Axis((path,), row[None], drawn.unit)
                found |= coordinates(mechanism, along, DRAW)
        return found


def points_of(over: Mapping[Any, Any], draws: int | None, seed: int, sequence: str) -> Points:
    """The points that are asked for.

    Parameters
    ----------
    over
        Path → values or a distribution; a tuple of paths → rows of values in lockstep.
    draws, seed, sequence
        As `Points` takes them.

    Raises
    ------
    ValueError, TypeError
        For what makes no sense, or contradicts itself.
    """
    if not isinstance(over, Mapping):
        raise TypeError(f"over must be a mapping of paths to values, found {over!r}")
    if not over:
        raise ValueError("nothing is varied; expected paths with values or distributions")
    if sequence not in SEQUENCES:
        raise ValueError(f"sequence must be {', '.join(SEQUENCES)}; found {sequence!r}")
    axes, drawn = [], {}
    for key, given in over.items():
        if isinstance(given, Axis):
            axes.append(given)
        elif isinstance(key, tuple):
            axes.append(axis(_lockstep(key, given)))
        elif is_distribution(given):
            drawn[key] = distribution_of(key, given)
        else:
            axes.append(axis({key: given}))
    require_different([*axes, *(Axis((path,), np.zeros((1, 1))) for path in drawn)])
    if drawn and draws is None:
        raise ValueError("distributions need a number of draws")
    if draws is not None and not drawn:
        raise ValueError(f"draws = {draws}, but nothing is drawn; expected a distribution")
    if draws is not None and draws < 1:
        raise ValueError(f"draws must be at least 1, found {draws}")
    found = Points(tuple(axes), drawn, draws or 1, seed, sequence)  # type: ignore[arg-type]
    require_feasible(found.count, len(found.paths))
    return found


def _lockstep(paths: tuple[str, ...], rows: Any) -> dict[str, Sequence[Any]]:
    """Path → values, from rows with a number for each path."""
    try:
        columns = list(zip(*rows, strict=True))
    except (TypeError, ValueError):
        columns = []
    if len(columns) != len(paths):
        names = ", ".join(paths)
        raise ValueError(f"({names}): expected rows with {len(paths)} values each")
    return dict(zip(paths, columns, strict=True))
