"""Integrators over any generated kernel, explicit and implicit, with events."""

from linkages.solvers.flow import Flow, Kernel
from linkages.solvers.integration import ADAPTIVE_METHODS, FIXED_STEP_METHODS, METHODS, integrate
from linkages.solvers.job import choose
from linkages.solvers.trajectory import Crossings, Event, Outcome, Trajectory

__all__ = [
    "ADAPTIVE_METHODS",
    "FIXED_STEP_METHODS",
    "METHODS",
    "Crossings",
    "Event",
    "Flow",
    "Kernel",
    "Outcome",
    "Trajectory",
    "choose",
    "integrate",
]
