"""Rises: from one constant value to another in a given time, along a normalised profile.

References
----------
.. [1] R. L. Norton, *Cam Design and Manufacturing Handbook*, 2nd ed., Industrial Press, 2009:
   double-dwell cams (cycloidal, modified sine, 3-4-5 polynomial, simple harmonic).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Generic, Literal

from pydantic import Field

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import TIME, Function, Operation, applied
from linkages.components.contributed.terms import Path
from linkages.components.laws.named import NOTHING, NamedLaw, Value, argument
from linkages.spec.quantities import Duration, Instant

Profile = Literal["cycloidal", "modified-sine", "polynomial", "harmonic"]


@component
class Rise(NamedLaw, Generic[Value]):
    """Constant, then a rise (or a return) along a profile, then constant again.

    Parameters
    ----------
    rise
        The profile. ``cycloidal``, ``modified-sine`` and ``polynomial`` (3-4-5) have a continuous
        acceleration; that of ``harmonic`` jumps at both ends.
    start, to
        Values before and after; `start` is called ``from`` in the file.
    begin
        Time at which the rise begins, in seconds.
    duration
        Seconds, > 0.
    """

    rise: Profile
    to: Value
    duration: Duration
    start: Value = Field(default=NOTHING, alias="from")
    begin: Instant = 0.0

    def function(self, path: Path) -> Function:
        """Its numbers are arguments; a first value or a beginning of exactly 0 is structure."""
        first: Any = self.start
        last: Any = self.to
        start = argument(path, "from", float(first), structural=True)
        begin = argument(path, "begin", self.begin, structural=True)
        part = (TIME - begin) / argument(path, "duration", self.duration)
        inside = applied("select", part, PROFILES[self.rise](part), 0)
        share = applied("select", part - 1, 1, inside)
        return start + (argument(path, "to", float(last)) - start) * share


def _cycloidal(u: Operation) -> Operation:
    """Return u − sin(2πu)/(2π)."""
    return u - applied("sin", 2 * math.pi * u) / (2 * math.pi)


def _polynomial(u: Operation) -> Operation:
    """Return 10u³ − 15u⁴ + 6u⁵."""
    return 10 * u**3 - 15 * u**4 + 6 * u**5


def _harmonic(u: Operation) -> Operation:
    """Return (1 − cos πu)/2."""
    return (1 - applied("cos", math.pi * u)) / 2


def _modified_sine(u: Operation) -> Operation:
    """Quarter sines of the acceleration over 1/8, a half sine over 3/4, and 1/8 again [1]_.

    Each piece is (offset + π·u − a·sin(b·u + c))/(4 + π).
    """

    def piece(offset: float, a: float, b: float, c: float) -> Operation:
        return (offset + math.pi * u - a * applied("sin", b * u + c)) / (4 + math.pi)

    first = piece(0, 0.25, 4 * math.pi, 0)
    middle = piece(2, 2.25, 4 * math.pi / 3, math.pi / 3)
    last = piece(4, 0.25, 4 * math.pi, 0)
    beyond_first = applied("select", u - 0.125, middle, first)
    return applied("select", u - 0.875, last, beyond_first)


PROFILES: dict[str, Callable[[Operation], Operation]] = {
    "cycloidal": _cycloidal,
    "modified-sine": _modified_sine,
    "polynomial": _polynomial,
    "harmonic": _harmonic,
}
"""Normalised profiles s(u) with s(0) = 0 and s(1) = 1."""
