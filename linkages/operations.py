"""Elementary operations, one row each: value, derivatives, cost, and how languages write them.

Formulas, kernels, equations and printed programs look operations up here, so a further function of
formulas is one further row. Operations with several results are rows of
`linkages.kernel.differentiation`.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

KINDS = (
    "additions", "multiplications", "divisions", "square roots", "trigonometric calls",
    "other functions", "linear systems", "iterations",
)  # fmt: skip
"""What operations cost, as `check --kernel` counts them."""

ADDITIONS, MULTIPLICATIONS, DIVISIONS, ROOTS, TURNS, OTHERS, SYSTEMS, ITERATIONS = KINDS

ATOM = 4
"""How strongly names, numbers and calls bind: they never need parentheses."""

Apply: TypeAlias = Callable[..., Any]
"""``apply(name, *operands)`` applies an elementary operation to nodes of some kind."""


class Form(NamedTuple):
    """How a language writes an operation, how strongly that binds, and how strongly each operand
    must bind to stand without parentheses.
    """  # noqa: D205

    template: str
    strength: int = ATOM
    operands: tuple[int, ...] = (0, 0, 0)


@dataclass(frozen=True)
class Elementary:
    """An operation on real numbers with one result.

    `partials`: ``partials(apply, f, *operands)``, where f is the result and ``apply(name,
    *operands)`` another operation: the derivatives with respect to the operands, nodes or plain
    numbers.
    `python`, `c`: how one language alone writes it; JavaScript writes expressions as C does.
    `llvm`: LLVM's instruction or intrinsic function (without the type in its name); others are
    written in `linkages.kernel.code.elementary_functions`, or come from the C library.
    """

    # In graphs and formulas, and of the function in C, Python's ``math``, SymPy and heyoka
    name: str
    kind: str  # what it counts as, one of `KINDS`
    # On floats; raises ValueError or ArithmeticError where there is no real result
    value: Callable[..., float]
    numpy: str | Callable[..., Any]  # name in NumPy, or the function of arrays if it has none
    partials: Callable[..., tuple[Any, ...]]
    arity: int = 1  # number of operands
    operator: Form | None = None  # how all languages write it; None for a call by its name
    python: Form | None = None
    c: Form | None = None
    llvm: str | None = None
    # ``tangent(f, *operands, *rates)``: the rate, where there is a shorter way than the sum of
    # partial derivatives times rates
    tangent: Callable[..., Any] | None = None
    formula: bool = False  # whether formulas may call it
    periodic: bool = False  # whether it repeats when its operand grows by 2π

    def among(self, library: Any) -> Callable[..., Any] | None:
        """The operation on the symbols of a library, if it has it: an operator or its function."""
        return self.value if self.operator else getattr(library, self.name, None)


class Composite(NamedTuple):
    """A function of formulas; ``expanded(apply, *operands)`` consists of elementary operations."""

    arity: int
    value: Callable[..., float]
    expanded: Callable[..., Any]
    formula: bool = True


def _function(
    name: str, numpy: str, partial: Callable[..., Any], kind: str = OTHERS, **more: Any
) -> Elementary:
    """A function of one operand that formulas may call; `partial` is its one derivative."""
    value = getattr(math, name)
    return Elementary(name, kind, value, numpy, lambda *a: (partial(*a),), formula=True, **more)


def _where(c: Any, a: Any, b: Any) -> Any:
    import numpy as np  # numbers of a definition file are read without it

    return np.where(np.asarray(c) >= 0.0, a, b)


def _atan2(_apply: Apply, _f: Any, y: Any, x: Any) -> tuple[Any, Any]:
    square = x * x + y * y
    return x / square, -y / square


# operands on the right of a sum or product keep their parentheses: rounding does not associate
_ROWS = (
    Elementary("add", ADDITIONS, operator.add, "add", lambda apply, f, a, b: (1.0, 1.0),
               2, Form("{} + {}", 1, (1, 2))),
    Elementary("sub", ADDITIONS, operator.sub, "subtract", lambda apply, f, a, b: (1.0, -1.0),
               2, Form("{} - {}", 1, (1, 2))),
    Elementary("mul", MULTIPLICATIONS, operator.mul, "multiply", lambda apply, f, a, b: (b, a),
               2, Form("{} * {}", 2, (2, 3)), llvm="fmul"),
    Elementary("div", DIVISIONS, operator.truediv, "divide",
               lambda apply, f, a, b: (1.0 / b, -f / b),
               2, Form("{} / {}", 2, (2, 3)), llvm="fdiv",
               tangent=lambda f, a, b, da, db: (da - f * db) / b),
    Elementary("neg", ADDITIONS, operator.neg, "negative", lambda apply, f, a: (-1.0,),
               1, Form("-{}", 3, (3,))),
    _function("sin", "sin", lambda apply, f, x: apply("cos", x), TURNS, periodic=True),
    _function("cos", "cos", lambda apply, f, x: -apply("sin", x), TURNS, periodic=True),
    _function("tan", "tan", lambda apply, f, x: 1.0 + f * f, TURNS, periodic=True),
    _function("asin", "arcsin", lambda apply, f, x: 1.0 / apply("sqrt", 1.0 - x * x), TURNS),
    _function("acos", "arccos", lambda apply, f, x: -1.0 / apply("sqrt", 1.0 - x * x), TURNS),
    _function("atan", "arctan", lambda apply, f, x: 1.0 / (1.0 + x * x), TURNS),
    _function("sinh", "sinh", lambda apply, f, x: apply("cosh", x)),
    _function("cosh", "cosh", lambda apply, f, x: apply("sinh", x)),
    _function("tanh", "tanh", lambda apply, f, x: 1.0 - f * f),
    _function("exp", "exp", lambda apply, f, x: f),
    _function("log", "log", lambda apply, f, x: 1.0 / x),
    _function("sqrt", "sqrt", lambda apply, f, x: 0.5 / f, ROOTS, llvm="llvm.sqrt"),
    Elementary("floor", OTHERS, math.floor, "floor", lambda apply, f, x: (0.0,),
               llvm="llvm.floor"),
    Elementary("atan2", TURNS, math.atan2, "arctan2", _atan2, 2, formula=True),
    # the first value where the condition is not negative, otherwise the second
    Elementary("select", OTHERS, lambda c, a, b: a if c >= 0.0 else b,
               _where,
               lambda apply, f, c, a, b:
                   (0.0, apply("select", c, 1.0, 0.0), apply("select", c, 0.0, 1.0)),
               3, python=Form("({1} if {0} >= 0.0 else {2})"), c=Form("({0} >= 0.0 ? {1} : {2})")),
)  # fmt: skip

ELEMENTARY: dict[str, Elementary] = {row.name: row for row in _ROWS}
"""All elementary operations by their names."""


def _power(apply: Apply, base: Any, exponent: int) -> Any:
    """A whole power by repeated squaring."""
    if exponent < 0:
        return apply("div", 1.0, _power(apply, base, -exponent))
    result: Any = 1.0
    while exponent:
        if exponent % 2:
            result = apply("mul", result, base)
        base, exponent = apply("mul", base, base), exponent // 2
    return result


COMPOSITE = {
    "abs": Composite(1, abs, lambda apply, x: apply("select", x, x, apply("neg", x))),
    "min": Composite(2, min, lambda apply, a, b: apply("select", apply("sub", b, a), a, b)),
    "max": Composite(2, max, lambda apply, a, b: apply("select", apply("sub", a, b), a, b)),
    "sign": Composite(1, lambda x: 1.0 if x >= 0.0 else -1.0,
                      lambda apply, x: apply("select", x, 1.0, -1.0)),
    # its first argument is a difference: formulas write a comparison
    "where": Composite(3, lambda c, a, b: a if c >= 0.0 else b,
                       lambda apply, c, a, b: apply("select", c, a, b)),
    "power": Composite(2, math.pow, _power, formula=False),
}  # fmt: skip
"""All composite functions by their names."""


def value_of(name: str, *operands: float) -> float:
    """The result of an elementary operation or a composite function, as a float."""
    row: Elementary | Composite = ELEMENTARY.get(name) or COMPOSITE[name]
    return float(row.value(*operands))


def formula_functions() -> dict[str, int]:
    """Names that formulas may call, with their numbers of arguments."""
    rows: dict[str, Elementary | Composite] = {**ELEMENTARY, **COMPOSITE}
    return {name: row.arity for name, row in rows.items() if row.formula}
