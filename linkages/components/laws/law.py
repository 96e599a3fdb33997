"""Fields that are a quantity or a law of time, and the functions that they stand for."""

from __future__ import annotations

from typing import Annotated, Any, assert_never

from linkages.components.contributed.functions import Function, Number, Operation, Time, applied
from linkages.components.contributed.terms import Parameter, Path
from linkages.components.laws.harmonic import HarmonicLaw
from linkages.components.laws.named import NamedLaw
from linkages.components.laws.rise import Rise
from linkages.components.laws.run_up import RunUpLaw
from linkages.components.laws.table import DriveTable, LoadTable
from linkages.discovery import plugged
from linkages.spec import dimensions
from linkages.spec.dimensions import Dimension
from linkages.spec.formulas import Call, Clock, Constant, Formula, Node
from linkages.spec.laws import LawRule
from linkages.spec.quantities import Angle, AngularSpeed, Force, Length, Speed, Torque

GROUP = "linkages.laws"
"""Entry points that name laws of other packages by the keys that tell them."""

Law = float | Formula | NamedLaw


def _rule(dimension: Dimension, value: Any, rate: Any = None) -> LawRule:
    named: dict[str, Any] = {"harmonic": HarmonicLaw[value], "rise": Rise[value]}
    if rate is not None:
        named["run-up"] = RunUpLaw[value, rate]
    named["table"] = LoadTable[value] if rate is None else DriveTable[value]
    named |= {name: law[value] for name, law in plugged(GROUP)}
    return LawRule(dimension, tuple(named.items()))


AngleLaw = Annotated[Law, _rule(dimensions.ANGLE, Angle, AngularSpeed)]
LengthLaw = Annotated[Law, _rule(dimensions.LENGTH, Length, Speed)]
ForceLaw = Annotated[Law, _rule(dimensions.FORCE, Force)]
TorqueLaw = Annotated[Law, _rule(dimensions.TORQUE, Torque)]


def function_of(law: Law, path: Path) -> Function:
    """Return the function of time of a law that stands at `path`.

    The numbers of a formula are parameters at ``(*path, 0)``, ``(*path, 1)``, … from left to
    right. A constant law of exactly zero is structure.
    """
    if isinstance(law, NamedLaw):
        return law.function(path)
    if isinstance(law, Formula):
        return _Translation(path).of(law.tree)
    return Number(Parameter(path, law, structural=True))


class _Translation:
    """Keeps what is translated: a part that `select` repeats stays one part, with its numbers."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.numbers = 0
        self.done: dict[int, Function] = {}

    def of(self, node: Node) -> Function:
        if id(node) not in self.done:
            self.done[id(node)] = self._translated(node)
        return self.done[id(node)]

    def _translated(self, node: Node) -> Function:
        match node:
            case Clock():
                return Time()
            case Constant(value):
                self.numbers += 1
                return Number(Parameter((*self.path, self.numbers - 1), value))
            case Call("power", (base, Constant(exponent))):
                return applied("power", self.of(base), exponent)  # how often to multiply: structure
            case Call(name, arguments):
                return Operation(name, tuple(self.of(argument) for argument in arguments))
            case _:
                assert_never(node)
