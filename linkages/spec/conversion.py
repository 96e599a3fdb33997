"""Numbers of definition files: plain SI, arithmetic with ``pi``, or with a unit."""

from __future__ import annotations

import math
import numbers
from functools import lru_cache

from linkages.reading.columns import Column
from linkages.reading.wording import shown
from linkages.spec.arithmetic import NumberError, leading_number
from linkages.spec.dimensions import ANGULAR_SPEED, KNOWN, Bound, Dimension
from linkages.spec.units import Unit, UnitError, near_unit, unit


class QuantityError(ValueError):
    """The value is not the number that is expected.

    Parameters
    ----------
    expected, found
        The two halves of the message: what should be there and what is.
    """

    def __init__(self, expected: str, found: str) -> None:
        super().__init__(f"expected {expected}, found {found}")
        self.expected = expected
        self.found = found


def parse_quantity(
    value: str | int | float, dimension: Dimension, bound: Bound = Bound.NONE
) -> float:
    """Return a number in SI.

    Parameters
    ----------
    value
        A number in SI, or text: arithmetic, with a unit after it where it is not in SI.
    dimension
        What the number measures.
    bound
        The limit that it must keep.

    Raises
    ------
    QuantityError
        The value is no finite number, is out of bounds, or has a unit of something else.
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
    found = unit(text)
    accepted = [unit(name).exponents for name in (dimension.unit, *dimension.accepts)]
    if found.exponents in accepted:
        return found
    kinds = [known for known in KNOWN if unit(known.unit).exponents == found.exponents]
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
