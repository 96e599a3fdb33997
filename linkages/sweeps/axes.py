"""A mechanism with other numbers: values along the paths of its definition."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at
from linkages.errors import InputError
from linkages.reading.overrides import NEXT, parse_assignment
from linkages.reading.paths import split
from linkages.spec.grammar import NumberError, leading_number

Point = TypeVar("Point")
Result = TypeVar("Result")

RANGE = "clearances.r1.size=0.01mm:0.5mm:200"


MOST_POINTS = 10_000_000
"""More than this would take days, and memory that few have."""

_QUICKEST = 1e-4
"""Seconds that a point takes at least."""


@dataclass(frozen=True)
class Axis:
    """Numbers that some paths of a definition take one after the other, in lockstep."""

    paths: tuple[str, ...]  # dotted paths of the definition
    values: NDArray[np.float64]  # for each path its numbers, in `unit`, shape (paths, points)
    unit: str = ""  # as the definition file would have it after the number; empty for SI

    def __len__(self) -> int:
        return self.values.shape[1]

    @property
    def label(self) -> str:
        """What the axis is called."""
        return self.paths[0]

    def at(self, index: int) -> dict[str, object]:
        """Overrides for one point."""
        numbers = self.values[:, index]
        return {
            path: f"{float(number)!r} {self.unit}" if self.unit else float(number)
            for path, number in zip(self.paths, numbers, strict=True)
        }


def axis(vary: Mapping[str, Sequence[Any] | NDArray[np.float64]]) -> Axis:
    """An axis from paths and their values: numbers in SI, texts with a unit, or a pint quantity."""
    if not vary:
        raise ValueError(f"nothing is varied; expected a path and its values, such as {RANGE}")
    measured = [_measured(path, values) for path, values in vary.items()]
    arrays, units = [array for array, _ in measured], {unit for _, unit in measured}
    if len(units) > 1:
        result = " and ".join(sorted(repr(unit) for unit in units))
        raise ValueError(f"paths that vary together need the same unit, found {result}")
    sizes = {array.shape for array in arrays}
    if len(sizes) > 1 or arrays[0].ndim != 1:
        raise ValueError(f"paths that vary together need equally many values, found {sizes}")
    if len(arrays[0]) < 2:
        raise ValueError(f"a range needs at least two values, found {len(arrays[0])}")
    if not all(np.isfinite(array).all() for array in arrays):
        raise ValueError("the values of a range must be finite")
    return Axis(tuple(vary), np.stack(arrays), units.pop())


def _measured(path: str, values: Any) -> tuple[NDArray[np.float64], str]:
    """Numbers, and the unit that all of them are in; none is SI."""
    if hasattr(values, "magnitude") and hasattr(values, "units"):
        unit = f"{values.units:C}".removesuffix("dimensionless")
        return np.atleast_1d(np.asarray(values.magnitude, dtype=float)), unit
    try:
        if not any(isinstance(value, str) for value in values):
            return np.atleast_1d(np.asarray(values, dtype=float)), ""
        pairs = [leading_number(str(value)) for value in values]
    except (TypeError, ValueError, NumberError) as error:
        raise ValueError(f"{path}: expected numbers, or texts with a unit; {error}") from None
    units = {unit for _, unit in pairs}
    if len(units) > 1:
        result = ", ".join(sorted(repr(unit) for unit in units))
        raise ValueError(f"{path}: its values need the same unit, found {result}")
    return np.array([number for number, _ in pairs]), units.pop()


Vary: TypeAlias = Mapping[str, Sequence[Any] | NDArray[np.float64]] | Axis | str | Sequence[str]
"""What is varied: dotted path → values in SI or with units, one or several ranges such as `RANGE`,
or an axis."""


def axis_of(vary: Vary) -> Axis:
    """An axis from paths and numbers in SI, from a text such as `RANGE`, or itself."""
    if isinstance(vary, Axis):
        return vary
    if isinstance(vary, str):
        return parse_range(vary)
    if isinstance(vary, Mapping):
        return axis(vary)
    if isinstance(vary, list | tuple) and vary and all(isinstance(text, str) for text in vary):
        return together([parse_range(text) for text in vary])
    raise TypeError(
        f"expected a mapping of paths to values, or a range such as {RANGE!r}, found {vary!r}"
    )


def coordinates(mechanism: Mechanism, axis: Axis, dim: str) -> dict[str, Any]:
    """Coordinates of a dataset along an axis, in the unit of its range, else in SI."""
    return {
        path: (dim, numbers, {"units": axis.unit or unit_at(mechanism.definition, path)})
        for path, numbers in zip(axis.paths, axis.values, strict=True)
    }


def parse_range(text: str) -> Axis:
    """Read ``"path=first:last:count"``; both ends may carry the same unit.

    Raises
    ------
    ValueError
        If it is not that.
    """
    path, equals, bounds = text.partition("=")
    parts = [part.strip() for part in bounds.split(":")]
    if not equals or not path.strip() or len(parts) != 3:
        raise ValueError(f"expected a range such as {RANGE}, found {text!r}")
    try:
        first, unit = leading_number(parts[0])
        last, other = leading_number(parts[1])
        count, nothing = leading_number(parts[2])
    except NumberError as error:
        raise ValueError(f"expected a range such as {RANGE}, found {text!r}: {error}") from None
    if unit != other:
        raise ValueError(f"both ends of a range need the same unit, found {unit!r} and {other!r}")
    if nothing or count != int(count) or count < 2:
        raise ValueError(f"a range needs at least two values, found {parts[2]!r}")
    require_feasible(int(count))
    values = np.linspace(first, last, int(count))
    return Axis((path.strip(),), values[None], unit)


def parse_axis(text: str) -> Axis:
    """Read an axis of ranges or lists of values; several paths in lockstep."""
    return together([_parse_values(part) for part in NEXT.split(text)])


def _parse_values(text: str) -> Axis:
    path, values = parse_assignment(text)
    if ":" in values:
        return parse_range(text)
    return axis({path: [value.strip() for value in values.split(",")]})


def together(axes: Sequence[Axis]) -> Axis:
    """Several ranges in lockstep."""
    if len({len(item) for item in axes}) != 1 or len({item.unit for item in axes}) != 1:
        raise ValueError("ranges that vary together need equally many values and the same unit")
    require_different(axes)
    paths = tuple(path for item in axes for path in item.paths)
    return Axis(paths, np.concatenate([item.values for item in axes]), axes[0].unit)


def require_different(axes: Iterable[Axis]) -> None:
    """Whether each path is varied once."""
    counts = Counter(split(path) or (path,) for item in axes for path in item.paths)
    paths = {split(path) or (path,): path for item in axes for path in item.paths}
    twice = [paths[path] for path, count in counts.items() if count > 1]
    if twice:
        raise ValueError(f"{twice[0]} is varied by two ranges; expected different paths")


def first_possible(
    task: Callable[[Point], Result],
    points: Iterable[Point],
    errors: type[Exception] | tuple[type[Exception], ...] = InputError,
) -> Result:
    """The result at the first point of a sweep that has one, for what is needed before it."""
    refusal: Exception | None = None
    for point in points:
        try:
            return task(point)
        except errors as error:
            refusal = refusal or error
    if refusal is None:
        raise ValueError("a sweep needs at least one point")
    raise refusal


def require_feasible(count: int, numbers: int = 1) -> None:
    """Refuse sweeps that nobody can wait for."""
    if count > MOST_POINTS:
        hours, size = count * _QUICKEST / 3600, count * 8 * (numbers + 3) / 1e9
        raise ValueError(
            f"{count:.3g} points would take at least {hours:.3g} hours at 0.1 ms each, and "
            f"{size:.3g} GB; expected at most {MOST_POINTS:.0e}"
        )
