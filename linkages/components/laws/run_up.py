"""A run-up (ramp-up) to constant speed."""

from __future__ import annotations

from typing import Any, Generic

from pydantic import Field

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import TIME, Function, applied
from linkages.components.contributed.terms import Path
from linkages.components.laws.named import NOTHING, NamedLaw, Rate, Value, argument
from linkages.spec.quantities import Duration


@component
class RunUp(Generic[Value, Rate]):
    """At rest until t = 0; then the speed rises smoothly and stays.

    The speed is speed·(3u² − 2u³) with u = t/duration from 0 to 1, so the acceleration is
    continuous.

    Parameters
    ----------
    speed
        The constant speed in the end.
    duration
        Seconds until it is reached, > 0.
    start
        Value until t = 0; called ``from`` in the file.
    """

    speed: Rate
    duration: Duration
    start: Value = Field(default=NOTHING, alias="from")


@component
class RunUpLaw(NamedLaw, Generic[Value, Rate]):
    """A run-up to constant speed; see `RunUp`."""

    run_up: RunUp[Value, Rate] = Field(alias="run-up")

    def function(self, path: Path) -> Function:
        """The integral of the speed: start + speed·duration·(u³ − u⁴/2), later a straight line."""
        path = (*path, "run-up")
        first: Any = self.run_up.start
        last: Any = self.run_up.speed
        duration = argument(path, "duration", self.run_up.duration)
        u = TIME / duration
        rising = applied("select", u, u**3 - 0.5 * u**4, 0)
        turned = applied("select", u - 1, u - 0.5, rising)
        speed = argument(path, "speed", float(last))
        start = argument(path, "from", float(first), structural=True)
        return start + speed * duration * turned
