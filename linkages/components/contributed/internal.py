"""Internal states: quantities beside positions and rates whose own rate a law gives."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.components.contributed.functions import Function, Internal
from linkages.components.contributed.terms import Path
from linkages.reading.paths import dotted


@dataclass(frozen=True)
class InternalState:
    """A quantity z of a load with dz/dt = f(z, x, v, t): a current, a deflection, an integral.

    Parameters
    ----------
    path
        Where it would stand in the definition file: that of the load and a word.
    unit
        In SI.
    rate
        f: a function of what the law of the load is a function of, and of internal states.
    scale
        What is large for it, in its unit: absolute tolerances are parts of this.
    initial
        Its value at the start.
    """

    path: Path
    unit: str
    rate: Function
    scale: float = 1.0
    initial: float = 0.0

    @property
    def name(self) -> str:
        """What laws and results call it; no body has a name with dots."""
        return dotted(self.path)

    @property
    def value(self) -> Internal:
        """Its value, in laws."""
        return value_of(self.path)


def value_of(path: Path) -> Internal:
    """The value of the internal state at a path, in laws."""
    return Internal(dotted(path))
