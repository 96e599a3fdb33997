"""What every named law is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, TypeVar

from linkages.components.contributed.functions import TIME, Function, Number
from linkages.components.contributed.terms import Parameter, Path

__all__ = ["NOTHING", "REFUSED", "TIME", "NamedLaw", "Rate", "Value", "argument"]

Value = TypeVar("Value")
Rate = TypeVar("Rate")
"""What a law gives, and its rate: quantities of a dimension that the field of the law fixes."""

NOTHING: Any = 0.0
"""The default of a quantity, whatever it measures."""

REFUSED = (
    "a drive prescribes a motion as a function of time alone; what depends on the motion is a "
    "load, a spring or a damper"
)
"""Why laws of drives do not depend on quantities of the mechanism."""


class NamedLaw(ABC):
    """A law that a mapping of the definition file describes."""

    @abstractmethod
    def function(self, path: Path) -> Function:
        """Return the function, of time unless it says otherwise; `path` is the mapping's place."""


def argument(path: Path, key: str, value: float, structural: bool = False) -> Number:
    """A number of the definition file."""
    return Number(Parameter((*path, key), value, structural))
