"""Routines of exported programs in a subset of Python.

`follow.txt` is Python. Its functions take numbers, arrays and records, and consist of assignments,
conditions, loops and calls: C and JavaScript are printed from its syntax tree.
"""

from __future__ import annotations

import ast
import re
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from linkages.exports.texts import fixed_text
from linkages.exports.writers.traced_loops import translated
from linkages.kernel.switches import LONGEST_STEP
from linkages.solution.change_points import COMPARED, STAGES, gauss
from linkages.solution.march import CLOSER, EARLY, PASSAGE_RTOL
from linkages.solvers.explicit_methods import dop853_tableau
from linkages.solvers.explicit_methods import rk4_tableau as classical_tableau
from linkages.solvers.loops import control, step_loop

if TYPE_CHECKING:
    from linkages.exports.writers.exported_model import Exported

Shape = tuple[str, ...]

RECORDS: Mapping[str, Mapping[str, str | Shape]] = {
    "Evaluation": {"timed": ("TIMED",), "work": ("WRITTEN",)},
    "Crossing": {
        "last": "int", "changes": "int", "crossing": "float",
        "t": ("PLACES",), "y": ("PLACES", "STATE"), "a": ("PLACES", "N"),
        "margins": ("PLACES", "2 * BLOCKS"),
    },
    "Motion": {
        "index": "int", "count": "int", "equal": "int", "prepared": "int", "changes": "int",
        "steps": "int", "evaluations": "int", "end": "int", "halved": "int", "pending": "int",
        "last": "int", "last_status": "int", "switch_kind": "int",
        "t": "float", "carry": "float", "finish": "float", "sign": "float", "longest": "float",
        "start": "float", "length": "float", "stop": "float", "next_carry": "float",
        "h": "float", "first": "float", "first_length": "float", "error": "float",
        "rejected_before": "float", "after_switch": "float", "part": "float",
        "rtol": "float", "atol": "float", "since": "float", "where": "float", "before": "float",
        "stopped_at": "float", "p": "Floats", "times": "Given",
        "y": ("STATE",), "next": ("STATE",), "trial": ("STATE",),
        "slopes": ("STAGES + 1 + FURTHER", "STATE"),
        "seen": ("STAGES + 1 + FURTHER", "2 * BLOCKS + 2 * MODES"), "settled": ("2 * CARRIED",),
        "written": ("VALUES + FIRST_CARRIED",), "first_steps": ("2 * MODES",),
        "least": ("BLOCKS",), "stopped": ("BLOCKS",), "e": "Evaluation",
    },
}  # fmt: skip
"""Record → field → what it is: a kind of number, an array's sizes, or what is set from outside."""

_ANNOTATION = r"(?:float|int|None|Given|Floats|Whole|Wholes|Evaluation|Motion|Crossing)"
_STRONGEST = 20
_BINDING: Mapping[type[ast.AST], tuple[str, int]] = {
    ast.Or: ("||", 1), ast.And: ("&&", 2), ast.Eq: ("==", 4), ast.NotEq: ("!=", 4),
    ast.Lt: ("<", 5), ast.LtE: ("<=", 5), ast.Gt: (">", 5), ast.GtE: (">=", 5),
    ast.Add: ("+", 6), ast.Sub: ("-", 6), ast.Mult: ("*", 7), ast.Div: ("/", 7),
    ast.Mod: ("%", 7),
}  # fmt: skip


def _shared() -> tuple[str, Mapping[str, int | float]]:
    """Functions that motions of this package have as well, and their constants."""
    whole = (name for name, kind in RECORDS["Motion"].items() if kind == "int")
    return translated(frozenset(whole))


def _text() -> str:
    """The routines that are written here, and those that motions of this package have as well."""
    return f"{fixed_text('follow.txt')}\n\n{_shared()[0]}\n"


def python_routines() -> str:
    """The functions in Python, and the records that they take."""
    text = re.sub(rf" -> {_ANNOTATION}:", ":", _text())
    text = re.sub(rf"(\w): {_ANNOTATION}(?=[,)\n]| = )", r"\1", text)
    records = "".join(
        f"class {name}:\n    def __init__(self):\n"
        + "".join(f"        self.{field} = {_python(kind)}\n" for field, kind in fields.items())
        + "\n\n"
        for name, fields in RECORDS.items()
    )
    return f"{records}def whole_zeros(size):\n    return [0] * size\n\n\n{text}"


def _python(kind: str | Shape) -> str:
    if isinstance(kind, str):
        return {"int": "0", "float": "0.0", "Evaluation": "Evaluation()"}.get(kind, "None")
    return f"zeros(({', '.join(kind)},))"


@cache
def _functions() -> tuple[ast.FunctionDef, ...]:
    result = ast.parse(_text()).body
    return tuple(node for node in result if isinstance(node, ast.FunctionDef))


class _Braces(ABC):
    """Prints functions in a language with braces."""

    equality: ClassVar[Mapping[str, str]] = {}
    """Operators that it writes otherwise."""
    calls: ClassVar[Mapping[str, str]]
    """Its names of functions."""

    def routines(self) -> str:
        """All of them, records first."""
        functions = [self.function(node) for node in _functions()]
        return "\n".join([self.records(), *functions])

    def function(self, node: ast.FunctionDef) -> str:
        """One function, with all of its variables at its top."""
        self.kinds = {a.arg: ast.unparse(a.annotation) for a in node.args.args if a.annotation}
        self.given = set(self.kinds)
        for inner in ast.walk(node):
            self._known(inner)
        doc = ast.get_docstring(node) or ""
        comment = textwrap.fill(f"/* {' '.join(doc.split())} */", 98, subsequent_indent="   ")
        variables = [self.declared(n, k) for n, k in self.kinds.items() if n not in self.given]
        lines = [*variables, *self.block(node.body)]
        body = "\n".join(f"  {line}" for line in lines)
        return f"{comment}\n{self.head(node)} {{\n{body}\n}}\n"

    def _known(self, node: ast.AST) -> None:
        """Note what kind a variable is."""
        match node:
            case ast.For(target=ast.Name(name)):
                self.kinds.setdefault(name, "int")
            case ast.AnnAssign(target=ast.Name(name), annotation=kind):
                self.kinds.setdefault(name, ast.unparse(kind))
            case ast.Assign(targets=[ast.Name(name)], value=value):
                self.kinds.setdefault(name, _kind_of(value))

    def block(self, statements: list[ast.stmt]) -> list[str]:
        """Lines of some statements."""
        return [line for statement in statements for line in self.statement(statement)]

    def statement(self, node: ast.stmt) -> list[str]:
        """Lines of one statement."""
        match node:
            case ast.Expr(value=ast.Constant()):
                return []
            case ast.Expr(value=value):
                return [f"{self.text(value)};"]
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                return [f"{self.text(target)} = {self.text(value)};"]
            case ast.Assign(targets=[target], value=value):
                if _kind_of(value) in _MADE:
                    return []  # its declaration
                return [f"{self.text(target)} = {self.text(value)};"]
            case ast.AugAssign(target=target, op=op, value=value):
                return [f"{self.text(target)} {_BINDING[type(op)][0]}= {self.text(value)};"]
            case ast.Return(value=None):
                return ["return;"]
            case ast.Return(value=ast.expr() as value):
                return [f"return {self.text(value)};"]
            case ast.Break():
                return ["break;"]
            case ast.Continue():
                return ["continue;"]
            case ast.While(test=test, body=body):
                return self.braced(f"while ({self.text(test)})", body)
            case ast.For(target=ast.Name(k), iter=ast.Call(args=bounds), body=body):
                first, last = ["0", *map(self.text, bounds)][-2:]
                return self.braced(f"for ({k} = {first}; {k} < {last}; {k}++)", body)
            case ast.If(test=test, body=body, orelse=other):
                lines = self.braced(f"if ({self.text(test)})", body)
                if other:
                    lines[-1:] = self.braced("} else", other)
                return lines
        raise AssertionError(ast.dump(node))

    def braced(self, head: str, body: list[ast.stmt]) -> list[str]:
        """A head with a block."""
        return [f"{head} {{", *(f"  {line}" for line in self.block(body)), "}"]

    def text(self, node: ast.expr) -> str:
        """An expression."""
        return self.bound(node)[0]

    def bound(self, node: ast.expr) -> tuple[str, int]:
        """An expression, and how strongly it binds."""
        match node:
            case ast.Constant(value=value):
                return repr(value), _STRONGEST
            case ast.Name(id=name):
                return self.calls.get(name, name), _STRONGEST
            case ast.Attribute(value=ast.Name() as owner, attr=name):
                return f"{self.text(owner)}{self.owned(owner.id)}{name}", _STRONGEST
            case ast.Attribute(value=owner, attr=name):
                return f"{self.text(owner)}.{name}", _STRONGEST
            case ast.Subscript(value=array, slice=place):
                return f"{self.text(array)}[{self.text(place)}]", _STRONGEST
            case ast.Call(func=ast.Name(id=name), args=given):
                arguments = ", ".join(map(self.argument, given))
                return f"{self.calls.get(name, name)}({arguments})", _STRONGEST
            case ast.UnaryOp(op=op, operand=operand):
                sign = "!" if isinstance(op, ast.Not) else "-"
                return f"{sign}{self.within(operand, 9)}", 9
            case ast.BinOp(left=left, op=op, right=right):
                sign, strength = _BINDING[type(op)]
                one, other = self.within(left, strength), self.within(right, strength + 1)
                return f"{one} {sign} {other}", strength
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                sign, strength = _BINDING[type(op)]
                sign = self.equality.get(sign, sign)
                return f"{self.within(left, 6)} {sign} {self.within(right, 6)}", strength
            case ast.IfExp(test=test, body=one, orelse=other):
                parts = [self.within(each, 1) for each in (test, one, other)]
                return f"{parts[0]} ? {parts[1]} : {parts[2]}", 0
            case ast.BoolOp(op=op, values=values):
                sign, strength = _BINDING[type(op)]
                # compilers warn of && within ||
                return f" {sign} ".join(self.within(v, 3) for v in values), strength
        raise AssertionError(ast.dump(node))

    def within(self, node: ast.expr, strength: int) -> str:
        """An operand, in parentheses if it binds less."""
        text, own = self.bound(node)
        return text if own >= strength else f"({text})"

    def argument(self, node: ast.expr) -> str:
        """What is handed to a function."""
        return self.text(node)

    def owned(self, name: str) -> str:  # noqa: ARG002
        """What stands between a record and its field."""
        return "."

    @abstractmethod
    def records(self) -> str:
        """Their declarations."""

    @abstractmethod
    def head(self, node: ast.FunctionDef) -> str:
        """How a function begins."""

    @abstractmethod
    def declared(self, name: str, kind: str) -> str:
        """A variable."""


_MADE = ("zeros", "whole_zeros", "Crossing")


def _kind_of(value: ast.expr) -> str:
    """The kind of a variable that has this value first; for arrays with their size in brackets."""
    match value:
        case ast.Compare() | ast.BoolOp():
            return "int"
        case ast.Call(func=ast.Name(id="Crossing")):
            return "Crossing"
        case ast.Call(func=ast.Name(id=("zeros" | "whole_zeros") as name), args=[size]):
            return _Sized(name, ast.unparse(size))
    return "float"


class _Sized(str):
    """The kind of an array, with its size."""

    size: str

    def __new__(cls, name: str, size: str) -> _Sized:
        result = super().__new__(cls, name)
        result.size = size
        return result


class CRoutines(_Braces):
    """Functions in C99; they are declared before them all."""

    def routines(self) -> str:
        """All of them, behind their heads."""
        text = super().routines()
        heads = re.findall(r"^static [^;]*?\)(?= \{$)", text, re.MULTILINE)
        first, *others = text.split("\n/* ", 1)
        return "\n/* ".join([f"{first}\n" + "".join(f"{head};\n" for head in heads), *others])

    calls: ClassVar = {
        "abs": "fabs", "min": "fmin", "max": "fmax", "clock": "clock_",
        "OWN_NUMBERS": "linkage_numbers",
    }  # fmt: skip
    kind_of: ClassVar = {
        "float": "double ", "int": "int ", "None": "void ", "Given": "const double *",
        "Floats": "double *", "Whole": "const int *", "Wholes": "int *",
        "Evaluation": "evaluation *", "Motion": "motion *", "Crossing": "crossing *",
    }  # fmt: skip

    def records(self) -> str:
        """Structures, whose arrays have at least one number."""
        result = []
        for name, fields in RECORDS.items():
            lines = []
            for field, kind in fields.items():
                if isinstance(kind, str):
                    own = "evaluation " if kind == "Evaluation" else self.kind_of[kind]
                    lines.append(f"  {own}{field};")
                else:
                    number = "int" if field == "stopped" else "double"
                    lines.append(f"  {number} {field}" + "".join(f"[{s} + 1]" for s in kind) + ";")
            if name == "Motion":
                lines += ["  linkage_visit visit;", "  void *data;"]
            result.append("typedef struct {\n" + "\n".join(lines) + f"\n}} {name.lower()};\n")
        tell = "  m->visit(t, y, m->p, m->data);\n"
        result.append(f"static void tell(motion *m, double t, const double *y) {{\n{tell}}}\n")
        result.append("#define about_to_step(m)\n")
        return "\n".join(result)

    def head(self, node: ast.FunctionDef) -> str:
        """A static function."""
        arguments = [f"{self.kind_of[self.kinds[a.arg]]}{a.arg}" for a in node.args.args]
        assert node.returns is not None
        result = self.kind_of[ast.unparse(node.returns)]
        return f"static {result}{node.name}({', '.join(arguments)})"

    def declared(self, name: str, kind: str) -> str:
        """A variable that is zero first."""
        if isinstance(kind, _Sized):
            number = "double" if kind == "zeros" else "int"
            return f"{number} {name}[{kind.size} + 1] = {{0}};"
        if kind == "Crossing":
            return f"crossing {name} = {{0}};"
        return f"{self.kind_of[kind]}{name} = 0;"

    def owned(self, name: str) -> str:
        """Records are handed over by their address."""
        return "->" if name in self.given else "."

    def argument(self, node: ast.expr) -> str:
        """Records by their address."""
        text = self.text(node)
        own = isinstance(node, ast.Name) and self.kinds.get(node.id) == "Crossing"
        if (own and text not in self.given) or text == "m->e":
            return f"&{text}"
        return text


class JavaScriptRoutines(_Braces):
    """Functions in JavaScript."""

    equality: ClassVar = {"==": "===", "!=": "!=="}
    calls: ClassVar = {
        **{name: f"Math.{name}" for name in ("abs", "min", "max", "pow", "sqrt", "ceil")},
        "isfinite": "Number.isFinite",
    }  # fmt: skip

    def records(self) -> str:
        """Functions that make them."""
        result = []
        for name, fields in RECORDS.items():
            inner = ", ".join(f"{field}: {self.made(kind)}" for field, kind in fields.items())
            result.append(f"const new{name} = () => ({{ {inner} }});\n")
        result.append("const tell = (m, t, y) => m.visit(m.index, t, y);")
        result.append("const about_to_step = (m) => m.check?.();\n")
        return "\n".join(result)

    @staticmethod
    def made(kind: str | Shape) -> str:
        """The first value of a field."""
        if isinstance(kind, str):
            return {"Evaluation": "newEvaluation()"}.get(kind, "0")
        rows, *columns = kind
        if columns:
            return f"Array.from({{ length: {rows} }}, () => new Float64Array({columns[0]}))"
        return f"new Float64Array({rows})"

    def head(self, node: ast.FunctionDef) -> str:
        """A function."""
        return f"function {node.name}({', '.join(a.arg for a in node.args.args)})"

    def declared(self, name: str, kind: str) -> str:
        """A variable that is zero first."""
        if isinstance(kind, _Sized):
            return f"const {name} = new Float64Array({kind.size});"
        return f"const {name} = newCrossing();" if kind == "Crossing" else f"let {name} = 0;"


Floats = NDArray[np.float64]
Constant = int | float | tuple[int, ...] | Floats


_LIMITS = (
    "SAFETY", "SHRINK_MOST", "SHRINK_TURNING", "SHRINK_BLOCKED", "GROW_MOST", "LEAST_ERROR",
    "OVERFLOW", "MOST_CHANGE", "ROUNDING", "WILD",
)  # fmt: skip
"""Constants of the control of steps, as the package has them."""


@cache
def _methods() -> dict[str, Constant]:
    """Coefficients as their tableaus have them, and limits as motions of this package do."""
    dop853, classical = dop853_tableau(), classical_tableau()
    limits = vars(control) | vars(step_loop)
    assert dop853.dense_A is not None
    assert dop853.dense_c is not None
    assert dop853.dense is not None
    rows = np.zeros((3, 2, STAGES * STAGES))
    for k, stages in enumerate((COMPARED, STAGES)):
        for own, values in zip(rows, gauss(stages), strict=True):
            own[k, : values.size] = values.ravel()
    return {
        "STAGES": len(dop853.b),
        "FURTHER": len(dop853.dense_A),
        "POWERS": dop853.dense.shape[1],
        "RK4_STAGES": len(classical.b),
        "NODES": STAGES,
        "PLACES": STAGES + 2,
        "EARLY": EARLY,
        "CLOSER": CLOSER,
        "PASSAGE_RTOL": PASSAGE_RTOL,
        "UNLIKE": control.UNLIKE,
        "FAR": control.FAR,
        "COMPARED": len(dop853.quarters),
        "QUARTERS": dop853.quarters,
        "LONGEST_STEP": LONGEST_STEP,
        "ERROR_ORDER": dop853.error_order,
        **{name: limits[name] for name in _LIMITS},
        "DOP853_A": dop853.A,
        "DOP853_B": dop853.b,
        "DOP853_C": dop853.c,
        "DOP853_ERROR": np.asarray(dop853.error),
        "DOP853_FURTHER_A": dop853.dense_A,
        "DOP853_FURTHER_C": dop853.dense_c,
        "DOP853_DENSE": dop853.dense,
        "RK4_A": classical.A,
        "RK4_B": classical.b,
        "RK4_C": classical.c,
        "GAUSS_COUNTS": (COMPARED, STAGES),
        "GAUSS_NODES": rows[0, :, :STAGES],
        "GAUSS_WEIGHTS": rows[1, :, :STAGES],
        "GAUSS_ONCE": rows[2],
        **_shared()[1],
    }


def constants(found: Exported) -> dict[str, Constant]:
    """Name → what routines look up: numbers, lists of whole numbers, and tables."""
    from linkages.exports.writers.exported_model import (
        CHATTER,
        NOT_BACK,
        SINGULAR,
        SLIDING,
        STEP_TOO_SMALL,
    )

    layout, own, switching = found.system.layout, found.program, found.switching
    n, modes = len(layout.coordinates), len(found.modes)
    function = n + 2 * len(layout.carried)
    places = found.system.model.inputs.parameters
    sampled = found.system.mechanism.sampled.values()
    periods = tuple(places[s.period.parameter.path] for s in sampled if s.period is not None)
    given = {
        name: tuple(int(value) for value in getattr(switching, name)) if switching else ()
        for name in ("active", "owners", "jumps", "sticks", "couples_others")
    }
    return {
        "N": n,
        "STATE": 2 * n,
        "FREE": len(layout.free),
        "FIRST_CARRIED": layout.moved,
        "CARRIED": len(layout.carried),
        "NUMBER_COUNT": len(found.feed.numbers),
        "PARAMETERS": len(found.p),
        "QUANTITIES": len(found.quantities),
        "TIMED": own.timed,
        "WRITTEN": found.written,
        "VALUES": own.routines[-1].arguments["out"],
        "MODES": modes,
        "MEMORIES": len(given["owners"]),
        "HELD": len(found.p) - own.held,
        "FUNCTION": function,
        "MARGIN": function + 2 * modes,
        "BLOCKS": len(found.blocks),
        "TURNED": len(found.turned),
        "STUCK": len(found.stuck),
        "PASSING": int(found.passing),
        "STEP_TOO_SMALL": STEP_TOO_SMALL,
        "NOT_BACK": NOT_BACK,
        "SINGULAR": SINGULAR,
        "SLIDING": SLIDING,
        "CHATTER": CHATTER,
        **{name.upper(): values for name, values in given.items()},
        "SCALES": found.margin_scale,
        "BLOCK_NUMBERS": found.blocks,
        "SIDES": found.sides,
        "STUCK_MODES": found.stuck,
        "TURNED_PLACES": found.turned,
        "SAMPLED": len(periods),
        "SAMPLED_PLACES": periods,
        "OWN_NUMBERS": np.array([number.value for number in found.feed.numbers]),
        "OWN_PARAMETERS": found.p,
        "OWN_STATE": found.state,
        **_methods(),
    }
