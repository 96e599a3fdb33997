"""Where a unit ends that stands behind a number of a formula: ``20 N*s/m * piston.velocity``.

A unit goes on as long as names of units follow, with ``*``, ``/`` or nothing between them. What is
called, or has a quantity, is no unit (``5 N*min(…)``, ``5 N*m.angle``); nor are t, pi, and, or.
"""

from __future__ import annotations

import re

from linkages.spec.grammar import NumberError
from linkages.spec.units import UnitError, unit

_POWER = r"(?:[ \t]*(?:\*\*|\^)[ \t]*[-+]?[1-9](?![0-9.])|[²³])?"
_NAME = rf"(°|(?!(?:t|pi|π|and|or)\b)[^\W\d]\w*)(?!\w)(?![ \t]*[(.]){_POWER}"
_FIRST = re.compile(rf"[ \t]*(?:1[ \t]*/[ \t]*)?{_NAME}")
_NEXT = re.compile(rf"[ \t]*[*/·⋅×]?[ \t]*{_NAME}")


def unit_end(text: str, at: int) -> int:
    """Return the index where a unit ends that stands at another one: the same without a unit.

    Raises
    ------
    NumberError
        A word stands there that is no unit.
    """
    match = _FIRST.match(text, at)
    if match is None:
        return at
    try:
        unit(match[1])
    except UnitError as error:
        raise NumberError(str(error), "", match.start(1)) from None
    end = match.end()
    while (match := _NEXT.match(text, end)) and _is_unit(match[1]):
        end = match.end()
    return end


def _is_unit(name: str) -> bool:
    try:
        unit(name)
    except UnitError:
        return False
    return True
