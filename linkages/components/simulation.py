"""Defaults of a simulation, as the definition file states them."""

from __future__ import annotations

from typing import ClassVar

from linkages.components.contributed.component import Component, component
from linkages.options.run import SimulationOptions
from linkages.spec.quantities import Duration


@component
class SimulationDefaults(SimulationOptions, Component):
    """How the file's author wants the mechanism to be simulated.

    Parameters
    ----------
    end
        Simulated time in seconds.
    """

    section: ClassVar[str] = "simulate"

    end: Duration = 1.0

    def terms(self) -> tuple[()]:
        """None: it says nothing about the mechanism."""
        return ()
