"""Numbers of definition files with units and tolerances: ``140 ± 0.05 mm``, ``2*pi/3``.

A text is a nominal number, what it may differ by, and how it is distributed within that. ``±``
may be written ``+/-`` or ``+-``. A number without a unit has that of the other; a percentage is of
the nominal number. The rest of the package computes with the nominal number.
"""

from __future__ import annotations

import math
import numbers
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import Any

from linkages.reading.overrides import Column
from linkages.reading.paths import KeyPath
from linkages.reading.wording import shown, suggestion
from linkages.spec.grammar import NumberError, leading_number
from linkages.spec.units import (
    ANGULAR_SPEED,
    KNOWN,
    Bound,
    Dimension,
    Unit,
    UnitError,
    near_unit,
    unit,
)


class QuantityError(ValueError):
    """The value is not the number that is expected.

    `expected`, `found`: the two halves of the message: what should be there and what is.
    """

    def __init__(self, expected: str, found: str) -> None:
        super().__init__(f"expected {expected}, found {found}")
        self.expected = expected
        self.found = found


def parse_quantity(
    value: str | int | float, dimension: Dimension, bound: Bound = Bound.NONE
) -> float:
    """Return a number in SI.

    `value`: a number in SI, or text: arithmetic, with a unit after it where it is not in SI.
    """

    def refused(why: str = "") -> QuantityError:
        return QuantityError(dimension.expected(bound), f"{shown(value)}{why}")

    try:
        if isinstance(value, str):
            number = _from_text(value, dimension)
        elif isinstance(value, Column):
            number = value
        elif isinstance(value, numbers.Real) and not isinstance(value, bool):
            number = float(value)
        else:
            raise refused()
        if not abs(number) < math.inf:
            raise NumberError("not a finite number")
        if abs(number) > dimension.largest:
            raise NumberError(f"beyond {dimension.largest:g} rad its direction is lost in rounding")
    except OverflowError:
        raise refused(": too large for a number") from None
    except (NumberError, UnitError) as fault:
        raise refused(f": {fault}") from None
    if not bound.holds(number):
        raise refused()
    return number


@lru_cache(maxsize=4096)  # a sweep reads the same entries again and again
def _from_text(text: str, dimension: Dimension) -> float:
    # Printed formulas carry U+2212; it means nothing else.
    number, unit_text = leading_number(text.replace("−", "-").strip())
    if not unit_text:
        return number
    unit_text = " ".join(unit_text.split())
    if not unit_text[0].isalpha() and unit_text[0] not in "°(1":
        raise NumberError(_leftover(unit_text))
    if unit_text in ("pi", "π"):
        raise UnitError("write the product as *pi")
    return _measure(unit_text, dimension).convert(number)


def _measure(text: str, dimension: Dimension) -> Unit:
    """Return the unit if it measures the dimension."""
    if not dimension.unit:
        raise UnitError(f"this number has no unit, found {shown(text)}")
    result = unit(text)
    accepted = [unit(name).exponents for name in (dimension.unit, *dimension.accepts)]
    if result.exponents in accepted:
        return result
    kinds = [known for known in KNOWN if unit(known.unit).exponents == result.exponents]
    if not kinds:
        raise UnitError(f"{text} is not a unit of {dimension.name}{near_unit(text)}")
    remedy = ""
    if dimension is ANGULAR_SPEED and kinds[0].name == "frequency":
        remedy = ": write rad/s or rpm"
    raise UnitError(f"{text} is {kinds[0].article}, not {dimension.article}{remedy}")


def _leftover(text: str) -> str:
    if text[0] == "^":
        return "powers are written **"
    if text[0] == ",":
        return "decimals are written with a point"
    return f"cannot read {shown(text)} after the number"


SIGMAS = 3.0
"""How many standard deviations of a normal distribution a tolerance is, if nothing is said."""

_VARIANCES = {"normal": None, "uniform": 3.0, "triangular": 6.0}
"""Distribution → square of half a zone over the variance; None where sigmas say."""

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_UNIT = r"(?:%|[^\W\d_]|°)?.*"
_LAW = re.compile(r"\s\(([^()]*)\)$")
_SYMMETRIC = re.compile(rf"(.+?)\s*(?:±|\+/-|\+-)\s*([-+]?{_NUMBER})\s*({_UNIT})")
_LIMITS = re.compile(rf"(.+?)\s+([-+]{_NUMBER}|0)\s*/\s*([-+]{_NUMBER}|0)\s*({_UNIT})")
_CERTAIN = re.compile(r"±|\+/-")
_MARK = re.compile(r"±|\+/-|\+-|/\s*[-+0]")
_SAID = re.compile(rf"(?:([a-z]+)\b\s*)?,?\s*(?:({_NUMBER})\s*(?:sigma|σ))?")


@dataclass(frozen=True)
class ToleranceZone:
    """What a number may be, in SI.

    `low`, `high`: limits.
    """

    nominal: float  # what everything else computes with
    low: float
    high: float
    # ``"normal"``, ``"uniform"`` or ``"triangular"``; about the middle of the limits
    distribution: str = "normal"
    # How many standard deviations of a normal distribution lie between the middle and a limit
    sigmas: float = SIGMAS

    @property
    def middle(self) -> float:
        """Half way between the limits: the mean."""
        return 0.5 * (self.low + self.high)

    @property
    def half(self) -> float:
        """Half the distance of the limits."""
        return 0.5 * (self.high - self.low)

    @property
    def deviation(self) -> float:
        """Standard deviation."""
        squared = _VARIANCES[self.distribution]
        return self.half / (self.sigmas if squared is None else sqrt(squared))


@dataclass(frozen=True)
class _Written:
    """The parts of a text: limits less the nominal number, as numbers with units or percentages."""

    nominal: str
    low: str
    high: str
    distribution: str
    sigmas: float


def zone_of(text: str) -> ToleranceZone | None:
    """The tolerance zone that a text of a definition states; None if it states none."""
    parts = _parts(text)
    if parts is None:
        return None
    nominal = _si(parts.nominal)
    low, high = sorted(
        nominal * _si(part[:-1]) / 100 if part.endswith("%") else _si(part)
        for part in (parts.low, parts.high)
    )
    if not low < high:
        raise NumberError("a tolerance is larger than 0")
    return ToleranceZone(nominal, nominal + low, nominal + high, parts.distribution, parts.sigmas)


def nominal_of(value: Any, dimension: Dimension, bound: Bound = Bound.NONE) -> Any:
    """A raw value without its tolerance, which is checked."""
    if not isinstance(value, str):
        return value

    def refused(why: str) -> QuantityError:
        return QuantityError(dimension.expected(bound), f"{shown(value)}: {why}")

    try:
        parts, zone = _parts(value), zone_of(value)
    except (NumberError, UnitError) as fault:
        raise refused(str(fault)) from None
    if parts is None or zone is None:
        return value
    for part in (parts.high, parts.low):
        if not part.endswith("%"):
            try:
                parse_quantity(part, dimension)
            except QuantityError as fault:
                raise refused(f"its tolerance is {fault.found}") from None
    if bound.holds(zone.nominal) and not bound.holds(zone.low):
        raise refused(f"its tolerance reaches down to {zone.low:g} {dimension.unit}".rstrip())
    return parts.nominal


def nominal_text(text: str) -> str:
    """A text that has been read without its tolerance."""
    parts = _parts(text)
    return text if parts is None else parts.nominal


def with_nominal(text: str, number: str, named: str) -> str:
    """A text with another nominal number and the same tolerance; the number if it has none.

    `number`, `named`: the number, and its unit, which is that of the one before.
    """
    whole = f"{number} {named}".rstrip()
    if _parts(text) is None:
        return whole
    plain = text.replace("−", "-").strip()
    said = _LAW.search(plain)
    part = plain[: said.start()].rstrip() if said else plain
    result = _SYMMETRIC.fullmatch(part) or _LIMITS.fullmatch(part)
    assert result is not None
    return (whole if leading_number(result[1])[1] else number) + plain[result.end(1) :]


def has_tolerance(value: object) -> bool:
    """Whether something is a text that states a tolerance, right or wrong."""
    if not isinstance(value, str):
        return False
    try:
        return _parts(value) is not None
    except NumberError:
        return True


def zones_in(content: Mapping[str, Any]) -> dict[KeyPath, ToleranceZone]:
    """Path → zone of all numbers with a tolerance in a definition that has been read."""
    return {path: zone for path, text in _texts(content, ()) if (zone := zone_of(text)) is not None}


def _texts(content: Any, path: KeyPath) -> Iterator[tuple[KeyPath, str]]:
    if isinstance(content, dict | list):
        entries = content.items() if isinstance(content, dict) else enumerate(content)
        for key, inner in entries:
            if path or key != "name":
                yield from _texts(inner, (*path, key))
    elif isinstance(content, str):
        yield path, content


def _parts(text: str) -> _Written | None:
    """The parts of a text with a tolerance; None if it has none."""
    if _MARK.search(text) is None:
        return None
    plain = text.replace("−", "-").strip()
    said = _LAW.search(plain)
    number = plain[: said.start()].rstrip() if said else plain
    if result := _SYMMETRIC.fullmatch(number):
        nominal, width, named = result.groups()
        if width.startswith("-"):
            raise NumberError("a tolerance is larger than 0")
        low, high = f"-{width.removeprefix('+')}", width.removeprefix("+")
    elif result := _LIMITS.fullmatch(number):
        nominal, high, low, named = result.groups()
    elif _CERTAIN.search(number):
        raise NumberError("expected a tolerance such as ± 0.05 mm or +0.1/-0.05 mm")
    else:
        return None
    named = named.strip()
    own = leading_number(nominal)[1]
    if named and not (named[0].isalpha() or named[0] in "°%"):
        if _CERTAIN.search(number):
            raise NumberError(f"cannot read {shown(named)} after the tolerance")
        return None  # arithmetic such as 3 +-2*4
    distribution, sigmas = _said(said[1]) if said else ("normal", SIGMAS)
    ending = f" {named}" if named and named != "%" else f" {own}" if own and not named else named
    nominal = nominal if own or not named or named == "%" else f"{nominal} {named}"
    return _Written(nominal, low + ending, high + ending, distribution, sigmas)


def _said(text: str) -> tuple[str, float]:
    """The distribution in parentheses: ``uniform``, ``normal, 2 sigma``, ``2 sigma``."""
    result = _SAID.fullmatch(text.strip())
    if result is None or not text.strip():
        raise NumberError(f"expected (uniform), (triangular) or (normal, 3 sigma), found ({text})")
    name, sigmas = result[1] or "normal", float(result[2] or SIGMAS)
    if name not in _VARIANCES:
        near = suggestion(name, _VARIANCES) or f"; expected one of: {', '.join(_VARIANCES)}"
        raise NumberError(f"unknown distribution {name!r}{near}")
    if result[2] and (name != "normal" or not sigmas > 0):
        raise NumberError("sigmas > 0 go with a normal distribution")
    return name, sigmas


def _si(text: str) -> float:
    number, named = leading_number(text.strip())
    return unit(named).convert(number) if named else number
