"""Mechanisms as modules of Python that need nothing but NumPy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from linkages.exports.kernels.exported import Exported, exported
from linkages.exports.kernels.method import Constant, constants
from linkages.exports.kernels.routines import python_routines
from linkages.exports.kernels.texts import fixed_text
from linkages.kernel.code.printing import Python, call
from linkages.kernel.code.printing import python_function as function_of
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.several import system_size
from linkages.kernel.system import System
from linkages.operations import ELEMENTARY
from linkages.options.run import SimulationOptions

_ARRAYS = "array, asarray, errstate, float64, zeros"


def python_module(system: System, options: SimulationOptions) -> str:
    """The text of a module with equations, outputs, and a program that prints a motion.

    Parameters
    ----------
    system
        The mechanism.
    options
        Of the motion that is printed where nothing else is said: `end` and `samples` are taken.
    """
    found = exported(system, run=options)
    named = {
        row.numpy: row.name
        for row in ELEMENTARY.values()
        if isinstance(row.numpy, str) and row.operator is None
    }
    functions = [own if own == name else f"{own} as {name}" for own, name in sorted(named.items())]
    title = f"{system.mechanism.name}: equations of motion, written by linkages."
    return "\n".join([
        f'"""{_safe(title)}\n\n{_DOC}"""\n',
        "from math import ceil, isfinite",
        "",
        f"from numpy import {_ARRAYS}",
        "from numpy import (",
        *(f"    {name}," for name in functions),
        ")",
        "",
        *_numbers(found),
        f"END, SAMPLES = {float(options.end)!r}, {int(options.samples)}",
        "\n",
        fixed_text("functions.txt"),
        *(function_of(routine, _Numbers) for routine in found.routines),
        "\n",
        python_routines(),
        "\n",
        fixed_text("model.txt"),
    ])  # fmt: skip


_DOC = """Needs NumPy. Numbers are in SI, angles in radians; a state has COORDINATES in their order,
then their rates. For example:

    p, y = start(**{next(iter(NUMBERS)): 0.1})
    times = linspace(0.0, 1.0, 101)
    show = lambda t, state: print(t, dict(zip(NAMES, outputs(t, state, p))))
    integrate(times, p, y, visit=show)
"""


class _Numbers(Python):
    """Python on numbers of NumPy, whose divisions by zero are infinite."""

    def operation(self, node: Scalar) -> tuple[str, int]:
        """Python's own numbers refuse to be divided by zero."""
        text, strength = super().operation(node)
        plain = node.operation == "div" and all(o.constant is not None for o in node.operands)
        return text.replace(" / ", " / float64(") + ")" if plain else text, strength

    def solved(self, node: Scalar) -> str:
        """One function for all sizes."""
        entries = ", ".join(self.text(operand) for operand in node.operands)
        return call("solve", [str(system_size(node)), f"[{entries}]"])


def _numbers(found: Exported) -> Sequence[str]:
    return [
        _mapping("NUMBERS", {number.path: number.value for number in found.feed.numbers}),
        _list("COORDINATES", found.system.layout.coordinates),
        _list("NAMES", [quantity.name for quantity in found.quantities]),
        _list("UNITS", [quantity.unit for quantity in found.quantities]),
        _mapping("STATUSES", found.statuses),
        *(_constant(name, value) for name, value in constants(found).items()),
    ]


def _constant(name: str, value: Constant) -> str:
    if isinstance(value, int | float):
        return f"{name} = {value!r}"
    return _list(name, value.tolist() if isinstance(value, np.ndarray) else value)


def _list(name: str, values: Sequence[Any]) -> str:
    return f"{name} = [\n" + "".join(f"    {value!r},\n" for value in values) + "]"


def _mapping(name: str, values: Mapping[Any, Any]) -> str:
    rows = (f"    {key!r}: {value!r},\n" for key, value in values.items())
    return f"{name} = {{\n{''.join(rows)}}}"


def _safe(text: str) -> str:
    return text.replace("\\", "/").replace('"""', "'''")
