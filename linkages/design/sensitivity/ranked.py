"""Sensitivities of measures as designers read them: in units of the file, and by size of effect."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.units import unit_at, unit_written
from linkages.spec.units import unit

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Effect:
    """How a measure changes with a number.

    Parameters
    ----------
    parameter
        Dotted path of the number.
    number, unit
        The number, in the unit that the definition has it in, or in SI.
    derivative
        Of the measure in SI, by the number in that unit.
    relative
        Change of the measure in percent for one percent of the number, d ln m / d ln n; None where
        one of the two is zero, or there is no derivative.
    """

    parameter: str
    number: float
    unit: str
    derivative: float
    relative: float | None


def effects_of(mechanism: Mechanism, data: xr.Dataset, measure: str) -> list[Effect]:
    """The effects of all numbers on a measure, the largest change for one percent first.

    Numbers that are zero, which have no percent, come last; so do those without any effect.

    Parameters
    ----------
    mechanism
        Whose definition says in which units numbers are read.
    data
        As `linkages.sensitivities` returns it.
    measure
        One of its variables.
    """
    value, found = float(data[measure].attrs["value"]), []
    rows = zip(
        data["parameter"].values.tolist(), data["parameter_value"].values.tolist(),
        data[measure].values.tolist(), strict=True,
    )  # fmt: skip
    for path, number, slope in rows:
        name, size = written_unit(mechanism, path)
        relative = slope * number / value if value and number and math.isfinite(slope) else None
        found.append(Effect(path, number / size, name, slope * size, relative))
    order = np.argsort([-abs(e.derivative * e.number) for e in found], kind="stable")
    ordered = [found[place] for place in order]
    return sorted(ordered, key=lambda effect: effect.derivative * effect.number == 0.0)


def written_unit(mechanism: Mechanism, path: str) -> tuple[str, float]:
    """The unit that a number of a definition is written in, and what one of it is in SI."""
    name = unit_written(mechanism.definition, path)
    if name:
        kind = unit(name)
        return name, kind.convert(1.0) - kind.convert(0.0)
    return unit_at(mechanism.definition, path), 1.0
