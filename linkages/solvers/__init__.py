"""Integrators over any generated kernel, explicit and implicit, with events."""

from linkages.solvers.choice import choose
from linkages.solvers.events import Crossings, Event
from linkages.solvers.flow import Companion, Flow
from linkages.solvers.integration import integrate
from linkages.solvers.methods.named import ADAPTIVE_METHODS, FIXED_STEP_METHODS, METHODS
from linkages.solvers.outcome import Outcome
from linkages.solvers.trajectory import Trajectory

__all__ = [
    "ADAPTIVE_METHODS",
    "FIXED_STEP_METHODS",
    "METHODS",
    "Companion",
    "Crossings",
    "Event",
    "Flow",
    "Outcome",
    "Trajectory",
    "choose",
    "integrate",
]
