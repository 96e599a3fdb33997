"""Points of a sweep: grids, and draws from distributions."""

from __future__ import annotations

import hashlib
import math
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.wording import suggestion
from linkages.spec.grammar import NumberError, leading_number
from linkages.spec.units import unit
from linkages.sweeps.axes import Axis, axis, coordinates, require_different, require_feasible

Floats = NDArray[np.float64]

Sequenced = Literal["random", "sobol", "latin-hypercube"]
SEQUENCES = ("random", "sobol", "latin-hypercube")

SAMPLE = "bars.rod.length=normal(140 mm, 0.02 mm)"

_CALL = re.compile(r"\s*([a-z]+)\s*\((.*)\)\s*", re.DOTALL)
_TINY = 2.0**-54


def _normal(mean: float, deviation: float, u: Floats) -> Floats:
    from scipy.special import ndtri

    return np.asarray(mean + deviation * ndtri(u))


def _uniform(low: float, high: float, u: Floats) -> Floats:
    return low + (high - low) * u


def _triangular(low: float, mode: float, high: float, u: Floats) -> Floats:
    rising = (mode - low) / (high - low)
    left = low + np.sqrt(u * (high - low) * (mode - low))
    right = high - np.sqrt((1 - u) * (high - low) * (high - mode))
    return np.where(u < rising, left, right)


def _either(one: float, other: float, u: Floats) -> Floats:
    return np.where(u < 0.5, one, other)


_KINDS: Mapping[str, tuple[Callable[..., Floats], str]] = {
    "normal": (_normal, "mean, deviation"),
    "uniform": (_uniform, "low, high"),
    "triangular": (_triangular, "low, mode, high"),
    "either": (_either, "one, other"),
}
"""Name → inverse of the cumulative distribution, and what its numbers are."""


@dataclass(frozen=True)
class Distribution:
    """How a number is distributed."""

    text: str  # as it was written, or what tells it from others
    inverse: Callable[[Floats], Floats]  # probabilities → numbers in `unit`, shape (draws,) each
    unit: str = ""  # as the definition file would have it after the number; empty for SI


def distribution_of(path: str, given: Any) -> Distribution:
    """A distribution from a text such as ``"normal(40 mm, 0.02 mm)"``, or a frozen one of SciPy."""
    if isinstance(given, Distribution):
        return given
    if isinstance(given, str):
        return _read(path, given)
    if callable(getattr(given, "ppf", None)):
        name, args, kwds = given.dist.name, given.args, given.kwds
        return Distribution(f"scipy {name} {args!r} {sorted(kwds.items())!r}", given.ppf)
    raise TypeError(f"{path}: expected values or a distribution, found {given!r}")


def is_distribution(given: Any) -> bool:
    """Whether something is a distribution and not a list of values."""
    named = isinstance(given, str) and _CALL.fullmatch(given) is not None
    return named or isinstance(given, Distribution) or hasattr(given, "ppf")


def _read(path: str, text: str) -> Distribution:
    match = _CALL.fullmatch(text)
    if match is None:
        raise ValueError(f"{path}: expected a distribution such as {SAMPLE}, found {text!r}")
    name, inner = match.groups()
    if name not in _KINDS:
        near = suggestion(name, _KINDS) or f"; expected one of: {', '.join(_KINDS)}"
        raise ValueError(f"{path}: unknown distribution {name!r}{near}")
    words = _KINDS[name][1]
    try:
        pairs = [leading_number(part) for part in inner.split(",")]
    except NumberError as error:
        raise ValueError(f"{path}: {name}({words}), found {text!r}: {error}") from None
    if len(pairs) != len(words.split(", ")):
        raise ValueError(f"{path}: expected {name}({words}), found {text!r}")
    units = {unit for _, unit in pairs}
    if len(units) > 1:
        raise ValueError(f"{path}: the numbers of {text!r} need the same unit")
    numbers = tuple(number for number, _ in pairs)
    rising = all(a <= b for a, b in pairwise(numbers)) and numbers[0] < numbers[-1]
    wrong = numbers[1] <= 0 if name == "normal" else not rising
    if wrong:
        expected = "a deviation > 0" if name == "normal" else f"{words} in rising order"
        raise ValueError(f"{path}: expected {expected}, found {text!r}")
    return Distribution(" ".join(text.split()), partial(_KINDS[name][0], *numbers), units.pop())


def probabilities(
    paths: Sequence[str], draws: int, seed: int, sequence: Sequenced = "random"
) -> Floats:
    """Probabilities between 0 and 1 for each path, shape (paths, draws).

    Those of ``random`` are a function of seed, path and number of the draw alone: blocks of Philox
    (J. K. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC11, 2011) under a key made
    of seed and path. Sequences depend on what else is drawn; a Latin hypercube on `draws` as well.
    """
    if sequence == "random":
        return np.array([_random(path, draws, seed) for path in paths])
    from scipy.stats import qmc

    kind = qmc.Sobol if sequence == "sobol" else qmc.LatinHypercube
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # balance needs powers of two: on the page
        result = kind(d=len(paths), seed=seed).random(draws).T
    return np.clip(result, _TINY, 1.0 - 2.0**-53)


def _random(path: str, draws: int, seed: int) -> Floats:
    digest = hashlib.sha256(f"{seed}\0{path}".encode()).digest()
    generator = np.random.Philox(key=np.frombuffer(digest[:16], dtype="<u8").copy())
    raw = generator.random_raw(4 * draws).reshape(draws, 4)[:, 0]  # a block of four for each draw
    return ((raw >> np.uint64(11)).astype(np.float64) + 0.5) * 2.0**-53


DRAW = "draw"


@dataclass(frozen=True)
class Points:
    """What is varied, and how; draws run faster than axes."""

    axes: tuple[Axis, ...]  # of a grid; the last one runs fastest
    # Path → distribution; these are drawn together, anew for each draw
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
        return (*along, *(item.unit for item in self.drawn.values()))

    @cached_property
    def draw_values(self) -> Floats:
        """What is drawn, shape (drawn paths, draws)."""
        if not self.drawn:
            return np.zeros((0, 1))
        result = probabilities([*self.drawn], self.draws, self.seed, self.sequence)
        return np.array(
            [each.inverse(row) for each, row in zip(self.drawn.values(), result, strict=True)]
        )

    def matrix_of(self, chosen: NDArray[np.intp]) -> Floats:
        """Numbers of chosen points in the units of their paths, shape (points, paths)."""
        places = np.unravel_index(chosen, self.shape)
        rows = [axis.values[:, place] for axis, place in zip(self.axes, places, strict=False)]
        if self.drawn:
            rows.append(self.draw_values[:, places[-1]])
        return np.concatenate(rows).T

    def overrides(self, first: int, last: int, si: bool = False) -> list[dict[str, object]]:
        """Overrides of some points: texts with their units, or numbers in SI."""
        return self.overrides_of(np.arange(first, last), si)

    def overrides_of(self, chosen: NDArray[np.intp], si: bool = False) -> list[dict[str, object]]:
        """The same of points with these numbers."""
        numbers = self.matrix_of(chosen)
        if si:
            kinds = [unit(text) if text else None for text in self.units]
            rows = [
                [item if kind is None else kind.convert(item) for item, kind in row]
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
        result: dict[str, Any] = {"paths": list(self.paths), "shape": list(self.shape)}
        if self.drawn:
            result["drawn"] = {path: each.text for path, each in self.drawn.items()}
            result |= {"draws": self.draws, "seed": self.seed, "sequence": self.sequence}
        return result

    def coordinates(self, mechanism: Mechanism) -> dict[str, Any]:
        """Coordinates of a dataset: values as they were set, with their units."""
        result: dict[str, Any] = {}
        for each in self.axes:
            result |= coordinates(mechanism, each, each.label)
        if self.drawn:
            result[DRAW] = np.arange(self.draws)
            for (path, drawn), row in zip(self.drawn.items(), self.draw_values, strict=True):
                along = Axis((path,), row[None], drawn.unit)
                result |= coordinates(mechanism, along, DRAW)
        return result


def points_of(over: Mapping[Any, Any], draws: int | None, seed: int, sequence: str) -> Points:
    """The points that are asked for."""
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
    result = Points(tuple(axes), drawn, draws or 1, seed, sequence)  # type: ignore[arg-type]
    require_feasible(result.count, len(result.paths))
    return result


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
