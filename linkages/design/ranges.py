"""Numbers of a definition varied between bounds, and the definition with other numbers as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import yaml
from numpy.typing import NDArray

from linkages.components.mechanisms.definition import loads
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at, unit_written
from linkages.errors import InputError, Problem
from linkages.kernel.system import System
from linkages.reading.document import decode, find
from linkages.reading.paths import KeyPath, split
from linkages.spec.conversion import has_tolerance, with_nominal
from linkages.spec.grammar import NumberError, leading_number
from linkages.spec.units import Unit, UnitError, scale_to_si, unit
from linkages.sweeps.points import probabilities

Floats = NDArray[np.float64]

AT_BOUND = 1e-7
"""Part of a range within which a number is at its bound."""

SPAN = "bars.rod.length=120mm:160mm"

_MET = 1e-12
"""Part of a range within which a bound is met: searches stop beside it by round-off."""

Vary: TypeAlias = Mapping[str, Sequence[Any]] | Sequence[str]
"""Path → lowest and highest value, numbers in SI or texts with units; or texts such as `SPAN`."""


MOST_STARTS = 100_000
"""Points that local searches start from."""


@dataclass(frozen=True)
class Range:
    """Bounds of a number, in SI."""

    path: str  # of the definition
    lower: float
    upper: float
    unit: str = ""  # in which people see it; empty for SI
    si: str = ""  # its unit in SI
    text: object = None  # what the definition has, a number or a text with a unit or a tolerance
    own: str = ""  # the unit of that

    @property
    def label(self) -> str:
        """The unit in which people see it, in any case."""
        return self.unit or self.si

    @property
    def written_value(self) -> float:
        """What the definition has, in SI."""
        value, item = _number(self.text)
        kind = _kind(item, self.si)
        return value if kind is None else kind.convert(value)

    def shown(self, number: float) -> str:
        """A number in SI as people see it, with its unit and six digits."""
        return f"{self.of_si(number):.6g} {self.label}".rstrip()

    def of_si(self, number: float) -> float:
        """A number in SI in this unit."""
        return number / scale_to_si(self.unit)

    def written(self, number: float) -> str | float:
        """A number in SI as a definition has it, exactly; in the unit of bounds if without."""
        kept = self.text if has_tolerance(self.text) else ""
        named = self.own if self.own or kept else self.unit
        if not named and not kept:
            return number
        convert = unit(named).convert if named else float
        scaled = number / scale_to_si(named)
        texts = (f"{scaled:.{digits}g}" for digits in range(12, 18))
        result = next((text for text in texts if convert(float(text)) == number), repr(scaled))
        return with_nominal(str(kept), result, named)


@dataclass(frozen=True)
class Ranges:
    """All numbers that are varied; places in the box of their bounds go from 0 to 1."""

    each: tuple[Range, ...]  # in the order in which they were given

    def __len__(self) -> int:
        return len(self.each)

    @property
    def paths(self) -> list[str]:
        """Of the definition."""
        return [item.path for item in self.each]

    @property
    def lower(self) -> Floats:
        """In SI."""
        return np.array([item.lower for item in self.each])

    @property
    def upper(self) -> Floats:
        """In SI."""
        return np.array([item.upper for item in self.each])

    @property
    def width(self) -> Floats:
        """What a place of 1 is in SI: derivatives by places are these times those by numbers."""
        return self.upper - self.lower

    def numbers(self, places: Floats) -> Floats:
        """In SI, of places in the box, shape (…, paths); bounds are met exactly."""
        inside = self.lower + places * self.width
        met = np.where(places >= 1.0 - _MET, self.upper, np.minimum(inside, self.upper))
        return np.where(places <= _MET, self.lower, met)

    def places(self, numbers: Floats) -> Floats:
        """Where numbers in SI are in the box; the nearest place of those that are outside."""
        return np.clip((numbers - self.lower) / self.width, 0.0, 1.0)

    def starts(self, first: Floats, count: int, seed: int) -> list[Floats]:
        """Places from which to search: that of the first numbers, then of a Sobol sequence."""
        others = probabilities(self.paths, count - 1, seed, "sobol").T if count > 1 else ()
        return [self.places(first), *others]

    def overrides(self, numbers: Floats) -> dict[str, float]:
        """Path → number in SI, as `Mechanism.with_values` takes them."""
        return dict(zip(self.paths, map(float, numbers), strict=True))


def ranges_of(mechanism: Mechanism, vary: Vary, either_way: bool = False) -> Ranges:
    """What is varied; bounds may fall where ranges are walked along `either_way`."""
    pairs = [_pair(text) for text in vary] if not isinstance(vary, Mapping) else [*vary.items()]
    result, problems = [], []
    if not pairs:
        message = f"nothing is varied; expected a range such as {SPAN}"
        raise InputError(mechanism.source, [Problem(message=message)])
    for path, bounds in pairs:
        try:
            result.append(_range(mechanism, path, bounds, either_way))
        except (ValueError, UnitError) as error:
            problems.append(Problem(path=path, message=str(error)))
    twice = {path for path, _ in pairs if sum(path == other for other, _ in pairs) > 1}
    problems += [Problem(path=path, message="is varied twice") for path in sorted(twice)]
    if problems:
        raise InputError(mechanism.source, problems)
    mechanism.keeping([each.path for each in result])  # raises where there is no number
    return Ranges(tuple(result))


def require_starts(starts: int) -> None:
    """Refuse numbers of starting points that make no sense; raises ValueError."""
    if not 1 <= starts <= MOST_STARTS:
        raise ValueError(f"starts must be from 1 to {MOST_STARTS}, found {starts}")


def _pair(text: str) -> tuple[str, Sequence[str]]:
    path, equals, bounds = text.partition("=")
    parts = [part.strip() for part in bounds.split(":")]
    if not equals or split(path.strip()) is None or len(parts) != 2:
        message = f"expected a range such as {SPAN}, found {text!r}"
        raise InputError("vary", [Problem(message=message)])
    return path.strip(), parts


def _range(
    mechanism: Mechanism, path: str, bounds: Sequence[Any], either_way: bool = False
) -> Range:
    if isinstance(bounds, str) or len(bounds) != 2:
        raise ValueError(f"expected a lowest and a highest value, found {bounds!r}")
    if isinstance(mechanism.definition.value(split(path) or ()), dict | list):
        raise ValueError("expected the path of one number, found several there")
    si = unit_at(mechanism.definition, path)
    pairs = [_number(bound) for bound in bounds]
    # in 0:6 t the unit is of both
    units = [item or pairs[1][1] for _, item in pairs]
    kinds = [_kind(item, si) for item in units]
    low, high = (
        value if kind is None else kind.convert(value)
        for (value, _), kind in zip(pairs, kinds, strict=True)
    )
    rises = low < high or (either_way and low > high)
    if not (np.isfinite(low) and np.isfinite(high) and rises):
        raise ValueError(
            f"expected a range from a value to a larger one, found {low:g} to {high:g}"
        )
    text = mechanism.definition.value(split(path) or ())
    own = unit_written(mechanism.definition, path)
    return Range(path, low, high, units[1] or own, si, text, own)


def _number(bound: Any) -> tuple[float, str]:
    if not isinstance(bound, str):
        return float(bound), ""
    try:
        return leading_number(bound)
    except NumberError as error:
        raise ValueError(
            f"expected numbers with or without a unit, found {bound!r}: {error}"
        ) from None


def _kind(text: str, si: str) -> Unit | None:
    """The unit of a bound, which must measure what stands at the path."""
    if not text:
        return None
    result = unit(text)
    if si and result.exponents != unit(si).exponents:
        raise ValueError(f"expected bounds in {si}, or another unit of it, found {text!r}")
    return result


def kept(mechanism: Mechanism) -> list[str]:
    """Sentences on what a search does not vary beside numbers: assembly and sense of rotation."""
    system = System(mechanism)
    count = 2 if system.topology.iterated else len(system.modes())
    if count < 2:
        return []
    several = "" if system.topology.iterated else f" (one of {count} at the start)"
    turning = " and the sense of its drives" if system.topology.driven else ""
    return [
        f"the search keeps the assembly mode of the definition{several}{turning}; others may lead "
        "to better numbers: check --modes shows them, and assembly selects one"
    ]


def rewritten(
    mechanism: Mechanism, values: Mapping[str, object], remarks: Sequence[str]
) -> tuple[Mechanism, str]:
    """A mechanism with other numbers, and its definition, with the comments of the file."""
    changed = mechanism.with_values(values)
    head = "".join(f"# {line}\n" for remark in remarks for line in remark.splitlines())
    text = _exchanged(mechanism, values)
    if text is not None:
        text = head + text
        try:
            if loads(text).components == changed.components:
                return changed, text
        except InputError:
            pass  # names files that stand elsewhere
    return changed, head + changed.to_yaml()


def _exchanged(mechanism: Mechanism, values: Mapping[str, object]) -> str | None:
    """The text of the file with other scalars; None if there is none, or they are not in it."""
    if mechanism.definition.folder is None:
        return None
    try:
        path = find(mechanism.definition.source)
        text = decode(path.read_bytes(), str(path))
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except (InputError, OSError, ValueError, yaml.YAMLError):
        return None
    result = []
    for name, value in values.items():
        node = _node(root, split(name) or ())
        if node is None:
            return None
        quote = node.style if node.style in ("'", '"') and isinstance(value, str) else ""
        result.append((node.start_mark.index, node.end_mark.index, f"{quote}{value}{quote}"))
    for start, end, value in sorted(result, reverse=True):
        text = text[:start] + value + text[end:]
    return text


def _node(root: Any, path: KeyPath) -> yaml.ScalarNode | None:
    """The scalar at a path."""
    node = root
    for step in path:
        if isinstance(node, yaml.MappingNode):
            pairs = {key.value: value for key, value in node.value}
            node = pairs.get(str(step))
        elif isinstance(node, yaml.SequenceNode) and str(step).isdigit():
            node = node.value[int(step)] if int(step) < len(node.value) else None
        else:
            return None
    return node if isinstance(node, yaml.ScalarNode) else None
