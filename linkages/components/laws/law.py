"""Fields that are a quantity or a law, and the functions that they stand for."""

from __future__ import annotations

from typing import Annotated, Any

from linkages.components.contributed.functions import Function, Number
from linkages.components.contributed.terms import Parameter, Path
from linkages.components.laws.formula import translated
from linkages.components.laws.harmonic import HarmonicLaw
from linkages.components.laws.named import REFUSED, NamedLaw
from linkages.components.laws.rise import Rise
from linkages.components.laws.run_up import RunUpLaw
from linkages.components.laws.table import DriveTable, LoadTable
from linkages.discovery import plugged
from linkages.spec import dimensions
from linkages.spec.dimensions import Bound, Dimension
from linkages.spec.formulas import Formula
from linkages.spec.laws import LawRule
from linkages.spec.quantities import (
    Angle,
    AngularSpeed,
    Damping,
    Force,
    Length,
    Pressure,
    Speed,
    Stiffness,
    Torque,
    TorsionalDamping,
    TorsionalStiffness,
    Voltage,
)

GROUP = "linkages.laws"
"""Entry points that name laws of other packages by the keys that tell them."""

Law = float | Formula | NamedLaw


def _rule(dimension: Dimension, value: Any, rate: Any = None, bound: Bound = Bound.NONE) -> LawRule:
    named: dict[str, Any] = {"harmonic": HarmonicLaw[value], "rise": Rise[value]}
    if rate is not None:
        named["run-up"] = RunUpLaw[value, rate]
    named["table"] = LoadTable[value] if rate is None else DriveTable[value]
    named |= {name: law[value] for name, law in plugged(GROUP)}
    refused = "" if rate is None else REFUSED
    return LawRule(dimension, tuple(named.items()), refused, bound)


def _factor(dimension: Dimension, value: Any) -> LawRule:
    """Of a spring or damper: a number that is no law is not below zero."""
    return _rule(dimension, value, bound=Bound.NON_NEGATIVE)


AngleLaw = Annotated[Law, _rule(dimensions.ANGLE, Angle, AngularSpeed)]
LengthLaw = Annotated[Law, _rule(dimensions.LENGTH, Length, Speed)]
ForceLaw = Annotated[Law, _rule(dimensions.FORCE, Force)]
TorqueLaw = Annotated[Law, _rule(dimensions.TORQUE, Torque)]
StiffnessLaw = Annotated[Law, _factor(dimensions.STIFFNESS, Stiffness)]
DampingLaw = Annotated[Law, _factor(dimensions.DAMPING, Damping)]
TorsionalStiffnessLaw = Annotated[Law, _factor(dimensions.TORSIONAL_STIFFNESS, TorsionalStiffness)]
TorsionalDampingLaw = Annotated[Law, _factor(dimensions.TORSIONAL_DAMPING, TorsionalDamping)]
PressureLaw = Annotated[Law, _rule(dimensions.PRESSURE, Pressure)]
VoltageLaw = Annotated[Law, _rule(dimensions.VOLTAGE, Voltage)]


def function_of(law: Law, path: Path) -> Function:
    """Return the function that a law at `path` is, of time and of what it senses.

    A constant law of exactly zero is structure.
    """
    if isinstance(law, NamedLaw):
        return law.function(path)
    if isinstance(law, Formula):
        return translated(law, path)
    return Number(Parameter(path, law, structural=True))
