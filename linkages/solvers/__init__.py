"""Compiled integrators over any generated kernel: fixed RK4, adaptive DOP853."""

from linkages.solvers.flow import Flow
from linkages.solvers.integrate import integrate
from linkages.solvers.methods import ADAPTIVE_METHODS, FIXED_STEP_METHODS, METHODS
from linkages.solvers.outcome import Outcome
from linkages.solvers.trajectory import Trajectory

__all__ = [
    "ADAPTIVE_METHODS",
    "FIXED_STEP_METHODS",
    "METHODS",
    "Flow",
    "Outcome",
    "Trajectory",
    "integrate",
]
