"""Limits of measures, ``stroke(x) > 79.9 mm``, and the share of copies within them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from linkages.spec.arithmetic import NumberError, leading_number
from linkages.spec.units import UnitError, unit

EXPECTED = "expected limits such as 'stroke(piston.position) > 79.9 mm' or '1 mm < … < 2 mm'"

CONFIDENCE = 0.95
"""Of the interval in which a yield is said to lie."""

_SIGN = re.compile(r"[<>]=?")


@dataclass(frozen=True)
class MeasureLimits:
    """What a measure must keep to.

    Parameters
    ----------
    text
        As it was written.
    measure
        Its text.
    low, high
        Numbers with a unit, or in SI; empty where there is no limit.
    """

    text: str
    measure: str
    low: str
    high: str

    def numbers(self, units: str) -> tuple[float, float]:
        """Both limits in SI; infinite where there is none.

        Parameters
        ----------
        units
            SI unit of the measure.

        Raises
        ------
        ValueError
            If a limit is in a unit of something else, or they exclude each other.
        """
        low = self._number(self.low, units, -math.inf)
        high = self._number(self.high, units, math.inf)
        if not low < high:
            raise ValueError(f"limits {self.text!r}: nothing lies between them")
        return low, high

    def _number(self, text: str, units: str, nothing: float) -> float:
        if not text:
            return nothing
        try:
            number, named = leading_number(text.replace("−", "-"))
            if not named:
                return number
            found = unit(named)
            if not units or found.exponents != unit(units).exponents:
                measured = f"in {units}" if units else "a number without a unit"
                raise UnitError(f"the measure is {measured}")
            return found.convert(number)
        except (NumberError, UnitError) as error:
            raise ValueError(f"limits {self.text!r}: cannot use {text!r}: {error}") from None


def read_limits(text: str) -> MeasureLimits:
    """Read limits: a measure, ``<`` or ``>``, and a number; or a measure between two numbers.

    Raises
    ------
    ValueError
        The text is none.
    """
    parts, signs = _split(text)
    rising = {sign[0] for sign in signs}
    if len(signs) == 2 and len(rising) == 1:
        low, measure, high = parts if rising == {"<"} else reversed(parts)
    elif len(signs) == 1:
        left, right = parts
        if _is_number(left):  # 2 mm > measure
            left, right = right, left
            rising = {"<" if rising == {">"} else ">"}
        measure = left
        low, high = ("", right) if rising == {"<"} else (right, "")
    else:
        raise ValueError(f"{EXPECTED}, found {text!r}")
    if not measure or _is_number(measure) or not (low or high):
        raise ValueError(f"{EXPECTED}, found {text!r}")
    return MeasureLimits(" ".join(text.split()), measure, low, high)


def _split(text: str) -> tuple[list[str], list[str]]:
    """The text at its comparisons outside of parentheses."""
    parts, signs, depth, at = [""], [], 0, 0
    while at < len(text):
        sign = _SIGN.match(text, at)
        if sign and depth == 0:
            signs.append(sign.group())
            parts.append("")
            at = sign.end()
            continue
        depth += {"(": 1, ")": -1}.get(text[at], 0)
        parts[-1] += text[at]
        at += 1
    return [part.strip() for part in parts], signs


def _is_number(text: str) -> bool:
    try:
        _, rest = leading_number(text.replace("−", "-"))
        if rest:
            unit(rest)
    except (NumberError, UnitError):
        return False
    return True


def share_within(count: int, whole: int) -> tuple[float, float, float]:
    """A share, and the interval of Clopper and Pearson in which it lies.

    Parameters
    ----------
    count, whole
        How many are within limits, and how many there are.

    References
    ----------
    .. [1] C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits illustrated in the
       case of the binomial, Biometrika 26, 1934.
    """
    from scipy.stats import binomtest

    interval = binomtest(count, whole).proportion_ci(CONFIDENCE, method="exact")
    return count / whole, float(interval.low), float(interval.high)
