"""Defaults of a simulation, as the definition file states them."""

from __future__ import annotations

from typing import ClassVar, Literal

from linkages.components.component import Component, component
from linkages.spec.quantities import Duration, Name, PositiveInteger, Tolerance


@component
class SimulationDefaults(Component):
    """How the file's author wants the mechanism to be simulated.

    Parameters
    ----------
    end
        Simulated time in seconds.
    samples
        Number of equally spaced output times from 0 to `end`, both included.
    method
        Name of a solver.
    rtol, atol
        Tolerances of an adaptive solver; `atol` is `rtol` (in rad, m, rad/s, m/s) if not given.
    step
        Step of a fixed-step solver in seconds.
    change_points
        Whether to ``pass`` smoothly through positions from which the mechanism could go on in two
        ways, or to ``stop`` there. If it is not said, motions with a free coordinate other than a
        clearance pass, and those that drives impose stop.
    """

    section: ClassVar[str] = "simulate"

    end: Duration = 1.0
    samples: PositiveInteger = 1001
    method: Name = "dop853"
    rtol: Tolerance = 1e-10
    atol: Tolerance | None = None
    step: Duration | None = None
    change_points: Literal["pass", "stop"] | None = None

    def terms(self) -> tuple[()]:
        """None: it says nothing about the mechanism."""
        return ()
