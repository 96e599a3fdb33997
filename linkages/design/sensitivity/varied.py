"""Numbers that change with others: operations of formulas on values with derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.operations import COMPOSITE, ELEMENTARY

Floats = NDArray[np.float64]


class Varied(NamedTuple):
    """Values, shape (…), and their derivatives, shape (P, …); None where there are none."""

    value: Floats
    slopes: Floats | None


def filled(found: Varied, count: int) -> Floats:
    """Derivatives by so many numbers, zero where there are none."""
    nothing = np.zeros((count, *np.shape(found.value)))
    return nothing if found.slopes is None else nothing + found.slopes


def applied(name: str, operands: Sequence[Varied | float]) -> Varied:
    """An operation of formulas on values with derivatives."""
    given = [o if isinstance(o, Varied) else Varied(np.array(o), None) for o in operands]
    if name == "power":
        base, exponent = given[0], int(given[1].value)
        slope = exponent * base.value ** (exponent - 1) if exponent else np.zeros(())
        changed = None if base.slopes is None else slope * base.slopes
        return Varied(base.value**exponent, changed)
    if name in COMPOSITE:
        found: Varied = COMPOSITE[name].expanded(lambda own, *each: applied(own, each), *given)
        return found
    if name not in ELEMENTARY:
        raise ValueError(f"no derivative is known of {name!r}")
    values = [operand.value for operand in given]
    value = np.asarray(_plain(name, *values))
    slopes: Floats | None = None
    if any(operand.slopes is not None for operand in given):
        partials = ELEMENTARY[name].partials(_plain, value, *values)
        for operand, partial in zip(given, partials, strict=True):
            if operand.slopes is not None:
                part = partial * operand.slopes
                slopes = part if slopes is None else slopes + part
    return Varied(value, slopes)


def _plain(name: str, *operands: Any) -> Any:
    """An operation of formulas on arrays."""
    if name not in ELEMENTARY:
        return COMPOSITE[name].expanded(_plain, *operands)
    function = ELEMENTARY[name].numpy
    return (getattr(np, function) if isinstance(function, str) else function)(*operands)
