"""What names in measures stand for in a mechanism, units, and parts of motions as sources."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at
from linkages.components.scene import Target
from linkages.kernel.number_effects import near_number, number_value
from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.reading.paths import split
from linkages.reading.wording import listed, suggestion
from linkages.solution.series import (
    TIME,
    Series,
    example_series,
    find_series,
    system_series,
    with_sizes,
)
from linkages.spec.formulas import PARAMETER, Call, Constant, Node, Sensed
from linkages.spec.grammar import NumberError
from linkages.spec.measures import DISTANCES, Measure, read_measure, spelled


def resolved(system: System, found: Measure) -> Measure:
    """A measure whose names are series of a mechanism and numbers of its definition.

    Lengths of vectors, such as ``P.reaction``, and distances from targets are formulas of series.
    Raises ValueError for a name that is nothing of these, and for what is no number.
    """
    known = system_series(system)
    sizes = with_sizes(known)

    def made(node: Sensed) -> Node:
        if node.word == PARAMETER:
            return node
        if node.word in DISTANCES:
            return _distances(system, node)
        return _meant(system, known, sizes, node)

    try:
        return found.with_names(made)
    except ValueError as error:
        own = f"measure {found.text!r}: "
        raise ValueError(own + str(error).removeprefix(own)) from None


def resolved_text(system: System, text: str) -> Measure:
    """The same of a measure as it is written."""
    return resolved(system, read_measure(text))


def _meant(
    system: System, known: Mapping[str, Series], sizes: Mapping[str, Series], node: Sensed
) -> Node:
    name, mechanism = node.word, system.mechanism
    try:
        find_series(known, name, spelled)
    except ValueError as unknown:
        vector = sizes.get(f"{name.rpartition('.')[0]}.{name.rpartition('.')[2].replace('_', ' ')}")
        if vector is not None:
            return _length(vector, node)
        path = split(name) or ("",)
        if len(path) < 2 or " " in name or mechanism.definition.value(path[:1]) is None:
            raise ValueError(str(unknown)) from None
        if number_value(mechanism, name) is None:
            example = f"; expected one, or an output, such as {spelled(example_series(system))!r}"
            near = near_number(name, mechanism) or example
            raise ValueError(f"{name!r} is no number of the definition{near}") from None
        return Sensed(PARAMETER, (name,), span=node.span)
    return node


def _length(vector: Series, node: Sensed) -> Node:
    element, _, quantity = vector.name.rpartition(".")
    return _root(
        [Sensed(f"{element}.{axis} {quantity}", (), span=node.span) for axis in ("x", "y")]
    )


def _root(parts: Sequence[Node]) -> Node:
    squares = [Call("power", (part, Constant(2.0))) for part in parts]
    return Call("sqrt", (Call("add", (squares[0], squares[1])),))


def _distances(system: System, node: Sensed) -> Node:
    """What the distances of points from the path of a joint come to: least ones over time."""
    joint, name = node.names
    targets = {c.name: c for c in system.mechanism.components if isinstance(c, Target)}
    if name not in targets:
        expected = f"one of its targets: {listed(targets)}" if targets else "'targets' in the file"
        near = suggestion(name, targets) or f"; expected {expected}"
        raise ValueError(f"unknown target {name!r}{near}")
    joints = labels(system.model, "joint")
    if joint not in joints:
        near = suggestion(joint, joints) or f"; expected one of: {listed(joints)}"
        raise ValueError(f"unknown joint {joint!r}{near}")
    path = [Sensed(f"{joint}.{axis} position", (), span=node.span) for axis in ("x", "y")]
    squares: list[Node] = []
    for place in targets[name].points:
        apart = [
            Call("power", (Call("sub", (each, Constant(at))), Constant(2.0)))
            for each, at in zip(path, place, strict=True)
        ]
        squares.append(Call("min", (Call("add", (apart[0], apart[1])),)))
    if node.word == "max_distance":
        return Call("sqrt", (_joined("max", squares),))
    whole = _joined("add", squares)
    if node.word == "sum_squared_distance":
        return whole
    return Call("sqrt", (Call("div", (whole, Constant(float(len(squares))))),))


def _joined(name: str, nodes: Sequence[Node]) -> Node:
    """Many terms as a balanced tree, which is not deep."""
    if len(nodes) == 1:
        return nodes[0]
    half = len(nodes) // 2
    return Call(name, (_joined(name, nodes[:half]), _joined(name, nodes[half:])))


def measured_series(system: System, found: Measure) -> dict[str, Series]:
    """Name → series that a measure names; spaces in names may be written as underscores."""
    return known_series(system, resolved(system, found).series)


def known_series(system: System, names: Iterable[str]) -> dict[str, Series]:
    """Name → series of a mechanism; raises ValueError for a name that is none of them."""
    known = system_series(system)
    return {name: find_series(known, name, spelled) for name in names}


def example_measure(mechanism: Mechanism) -> str:
    """A measure of this mechanism, for messages."""
    return f"max({spelled(example_series(System(mechanism)))})"


def measure_unit(system: System, found: Measure) -> str:
    """The unit of a measure of a mechanism, in SI."""
    known = resolved(system, found)
    series = known_series(system, known.series)

    def unit_of(name: str) -> str:
        if name in series:
            return series_unit(system, series[name])
        return unit_at(system.mechanism.definition, name)

    try:
        return known.units(unit_of)
    except NumberError as error:
        raise ValueError(f"measure {found.text!r}: {error.message}{error.hint}") from None


def measure_units(system: System, measures: Mapping[str, Measure]) -> dict[str, str]:
    """Name → unit of each measure, in SI; raises ValueError for what is no measure of it."""
    return {name: measure_unit(system, each) for name, each in measures.items()}


def needed_outputs(system: System, measures: Iterable[Measure]) -> list[str]:
    """Outputs that measures are made of."""
    result = [each.variable for one in measures for each in measured_series(system, one).values()]
    return [name for name in dict.fromkeys(result) if name != TIME]


def series_unit(system: System, series: Series) -> str:
    """The unit of a series, in SI."""
    if series.variable == TIME:
        return "s"
    variable = VARIABLES[series.variable]
    if variable.unit_of is not None:
        return variable.unit_of(system.model)[series.index(system.model)]
    name = series.place.get("drive")
    pushed = variable.pushed is not None and name is not None
    if pushed and variable.pushed and not system.mechanism.twisting(str(name)):
        return variable.pushed[0]
    return variable.units


Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


class Source(Protocol):
    """Motions with the same sample times."""

    @property
    def count(self) -> int:
        """Number of motions."""
        ...

    @property
    def time(self) -> Floats:
        """Sample times, shape (samples,)."""
        ...

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        ...

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the motions, shape (places,) each."""
        ...

    @property
    def intervals(self) -> tuple[Whole, Floats, Floats] | None:
        """Intervals between known jumps: motion, begin and end in s, shape (intervals,) each.

        None where no more is known than the samples.
        """
        ...

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        ...

    def number(self, path: str) -> Floats:
        """A number of the definition, in SI, shape (motions,)."""
        ...


@dataclass(frozen=True, eq=False)
class Window:
    """A part of each motion of a source, with as many samples as the whole has.

    `begin`, `end`: times in s, shape (motions,).
    """

    source: Source
    begin: Floats
    end: Floats
    _known: dict[str, Floats] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of motions."""
        return self.source.count

    @cached_property
    def times(self) -> Floats:
        """Sample times, shape (motions, samples)."""
        part = np.linspace(0.0, 1.0, len(self.source.time))
        result = self.begin[:, None] + part * (self.end - self.begin)[:, None]
        result[:, -1] = self.end
        return np.asarray(result)

    def at(self, which: Whole, places: Floats) -> Floats:
        """Times of places, in samples from the first one of the window."""
        last = max(len(self.source.time) - 1, 1)
        part = places / last
        return np.asarray((1.0 - part) * self.begin[which] + part * self.end[which])

    def sampled(self, series: str) -> Floats:
        """A series at the samples, shape (motions, samples)."""
        if series not in self._known:
            which = np.repeat(np.arange(self.count), self.times.shape[1])
            (values,) = self.source.during([series], which, self.times.ravel())
            self._known[series] = values.reshape(self.times.shape)
        return self._known[series]

    def between(self, series: Sequence[str], which: Whole, places: Floats) -> list[Floats]:
        """Series anywhere in some of the windows, shape (places,) each."""
        return self.source.during(series, which, self.at(which, places))

    @cached_property
    def intervals(self) -> tuple[Whole, Floats, Floats] | None:
        """Those of the source within the windows."""
        result = self.source.intervals
        if result is None:
            return None
        which, begin, end = result
        low, high = np.minimum(self.begin, self.end)[which], np.maximum(self.begin, self.end)[which]
        begin, end = np.clip(begin, low, high), np.clip(end, low, high)
        kept = begin != end
        return which[kept], begin[kept], end[kept]

    def during(self, series: Sequence[str], which: Whole, times: Floats) -> list[Floats]:
        """Series at times in some of the motions, shape (times,) each."""
        return self.source.during(series, which, times)

    @property
    def time(self) -> Floats:
        """Sample times of the source, of which the window has as many."""
        return self.source.time

    def number(self, path: str) -> Floats:
        """A number of the definition, in SI, shape (motions,)."""
        return self.source.number(path)
