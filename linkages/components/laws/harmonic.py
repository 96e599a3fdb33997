"""A harmonic law of time."""

from __future__ import annotations

import math
from typing import Any, Generic

from pydantic import Field, model_validator

from linkages.components.contributed.component import component
from linkages.components.contributed.functions import TIME, Function, applied
from linkages.components.contributed.terms import Path
from linkages.components.laws.named import NOTHING, NamedLaw, Value, argument
from linkages.spec.quantities import Angle, AngularSpeed, Frequency


@component
class Harmonic(Generic[Value]):
    """mean + amplitude·sin(ω·t + phase) with ω = 2π·frequency or ω = angular_frequency.

    Parameters
    ----------
    amplitude, mean
        In the units of what the law gives.
    frequency
        Hertz.
    angular_frequency
        Radians per second; given instead of the frequency.
    phase
        Radians.
    """

    amplitude: Value
    mean: Value = Field(default=NOTHING)
    frequency: Frequency | None = None
    angular_frequency: AngularSpeed | None = None
    phase: Angle = 0.0

    @model_validator(mode="after")
    def _one_frequency(self) -> Any:
        if (self.frequency is None) == (self.angular_frequency is None):
            found = "neither" if self.frequency is None else "both"
            raise ValueError(f"expected either 'frequency' or 'angular_frequency', found {found}")
        return self


@component
class HarmonicLaw(NamedLaw, Generic[Value]):
    """A harmonic law of time; see `Harmonic`."""

    harmonic: Harmonic[Value]

    def function(self, path: Path) -> Function:
        """Its numbers are arguments; a mean or a phase of exactly zero is structure."""
        path = (*path, "harmonic")
        own = self.harmonic
        mean, amplitude = _number(own.mean), _number(own.amplitude)
        if own.frequency is not None:
            rate: Function = 2 * math.pi * argument(path, "frequency", own.frequency)
        else:
            rate = argument(path, "angular_frequency", _number(own.angular_frequency))
        angle = rate * TIME + argument(path, "phase", own.phase, structural=True)
        wave = argument(path, "amplitude", amplitude) * applied("sin", angle)
        return argument(path, "mean", mean, structural=True) + wave


def _number(value: Any) -> float:
    return float(value)
