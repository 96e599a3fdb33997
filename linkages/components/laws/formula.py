"""Formulas as functions."""

from __future__ import annotations

from typing import assert_never

from linkages.components.contributed.functions import TIME, Function, Number, Operation, applied
from linkages.components.contributed.sensing import measured_by
from linkages.components.contributed.terms import Parameter, Path, named_number
from linkages.operations import ELEMENTARY
from linkages.spec.formulas import PARAMETER, Call, Clock, Constant, Formula, Node, Sensed


def translated(formula: Formula, path: Path) -> Function:
    """Return the function that a formula at `path` is.

    Its numbers are parameters at ``(*path, 0)``, ``(*path, 1)``, … from left to right. Equal ones
    are one parameter, so that jumps of equal arguments have one mode. How often to multiply in a
    power, a whole number of turns within a sine, and zeros are structure.
    """
    return _Translation(path).of(formula.tree)


class _Translation:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.numbers: dict[float, Parameter] = {}
        self.repeating = False
        self._known: dict[tuple[int, bool], Function] = {}

    def of(self, node: Node) -> Function:
        """The function of a part, which stands behind several conditions but once in the text."""
        key = id(node), self.repeating
        if key not in self._known:
            self._known[key] = self._of(node)
        return self._known[key]

    def _of(self, node: Node) -> Function:
        match node:
            case Clock():
                return TIME
            case Constant(value):
                own = Parameter((*self.path, len(self.numbers)), value, structural=True)
                return Number(self.numbers.setdefault(value, own))
            case Sensed(word, (name, *_)) if word == PARAMETER:
                return Number(named_number(name))
            case Sensed():
                return measured_by(node)
            case Call("power", (base, Constant(exponent))):
                return applied("power", self.of(base), exponent)
            case Call("mul", (Constant(turns, None), Sensed("angle") as angle)) if (
                self.repeating and turns.is_integer()
            ):
                return applied("mul", turns, measured_by(angle))
            case Call(name, arguments):
                before = self.repeating
                self.repeating = (name in ELEMENTARY and ELEMENTARY[name].periodic) or (
                    before and name in ("add", "sub", "neg")
                )
                found = tuple(self.of(argument) for argument in arguments)
                self.repeating = before
                return Operation(name, found)
            case _:
                assert_never(node)
