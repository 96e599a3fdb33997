"""Parts of the package's step loop as routines of exported programs.

The loop consists of traced functions: Python that runs once, on operands, and writes instructions
(`kernel.code.procedure`). Their syntax trees say the same: a block ``with code.if_(…)`` is a
condition, ``x.set(…)`` an assignment. Here they are read as plain functions in the subset of Python
that `routines` prints in other languages. Where a motion of the package has more than one of an
exported program (events, deviation vectors, counters), its part is left out.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import ModuleType
from typing import Any

from linkages.exports.texts import fixed_text
from linkages.kernel.code.procedure import TracedFunction
from linkages.solvers.loops import control, mode_changes, mode_transitions, step_loop

PARTS: Sequence[tuple[ModuleType, str]] = (
    (
        control,
        "begin_trial finest_step passes_zero is_small meeting with_sign_of_mode round_off_of "
        "least_of_stages",
    ),
    (
        mode_changes,
        "is_watched first_zero least_place try_part locate locate_switch locate_dip find_switch "
        "estimate_switch",
    ),
    (
        mode_transitions,
        "activate_dependents choose_side resolve_modes propagate_modes chatters release_sticking "
        "take_back apply_switch",
    ),
    (step_loop, "change_mode accept reject"),
)
"""Modules of the loop, each with its functions that exported programs have."""

_NAMES: Mapping[str, str] = {
    "motion.held": "m.p[HELD + _]",
    "motion.rows": "m.y[_]",
    "motion.end": "m.end",
    "motion.c": "node(m, _)",
    "motion.equal": "m.equal",
    "motion.n": "N",
    "motion.cost": "1",
    "motion.counters.evaluations": "m.evaluations",
    "motion.events.number": "0",
    "motion.stepper.end": "m.finish",
    "motion.switches.modes": "MODES",
    "motion.switches.tangents": "0",
    "motion.switches.free": "FIRST_CARRIED",
    "motion.switches.active": "ACTIVE[_]",
    "motion.switches.jumps": "JUMPS[_]",
    "motion.switches.sticks": "STICKS[_]",
    "motion.switches.couples_others": "COUPLES_OTHERS[_]",
    "motion.switches.written": "m.written[_]",
    "motion.switches.first_steps": "m.first_steps[_]",
    "motion.switches.pending[0]": "m.pending",
    "motion.switches.pending[1]": "m.changes",
    "motion.switches.last[0]": "m.last",
    "motion.switches.since[0]": "m.since",
    "motion.switches.find.exists": "MODES > 0",
    "motion.switches.transition.clock.exists": "VALUES > 0",
    "functions_of(motion, 0)": "m.seen[0][2 * BLOCKS + _]",
    "Outcome.DONE": "0",
    "Outcome.STEP_TOO_SMALL": "STEP_TOO_SMALL",
    "Outcome.SLIDING": "SLIDING + which",
}
"""What stands for an expression; for an array with its index in the place of ``_``."""

_INDEXED = re.compile(r"\b_(?=[\])])")

_CALLS: Mapping[str, str] = {
    "switches.apply": "apply_switch",
    "switches.estimate": "estimate_switch",
    "motion.first": "set_first_step",
    "maximum": "max",
    "minimum": "min",
    "settle": "take_settled",
}
"""Functions of other names."""

_TAKEN: Mapping[str, int] = {"commit": 1, "latch_values": 2}
"""How many of their arguments functions of exported programs take, if not all."""

_PAIRS: Mapping[str, tuple[str, str]] = {
    "switch_value": ("switch_function", "switch_rate"),
    "ahead": ("function_ahead", "rate_ahead"),
    "cubic_through": ("square_term", "cube_term"),
}
"""Functions with two results, and those with one of them each."""

_DROPPED = ("observe", "motion.counters", "switches.before.take", "Outcome.NOT_FINITE")
"""What exported programs have nothing of."""

_TABLES = (
    "motion.switches", "motion.counters", "motion.stepper", "motion.events",
    "motion.switches.pending", "motion.switches.since",
)  # fmt: skip
"""Parts of the memory of a motion, whose entries have names."""

_RENAMED = {"switch": "which", "motion": "m"}
"""Names that are words of other languages, or short in exported programs."""

_KINDS = {
    "Real": "float", "Int": "int", "Bool": "int", "None": "None",
    "tuple[Real, Real, Real]": "None", "Motion": "Motion", "Stepper": "Motion",
    "int": "int", "float": "float", "Any": "float",
}  # fmt: skip
_WHOLE = frozenset(("ACTIVE", "JUMPS", "STICKS", "COUPLES_OTHERS", "MODES", "BLOCKS", "N"))


@cache
def translated(whole: frozenset[str]) -> tuple[str, Mapping[str, int | float]]:
    """The text of all parts, and the constants that they name.

    `whole`: names of the fields of the record of a motion that are integers.
    """
    texts, constants = [], dict[str, int | float]()
    for module, names in PARTS:
        for name in names.split():
            made = _Translation(getattr(module, name), module, whole)
            texts.append(ast.unparse(ast.fix_missing_locations(made.function())))
            for constant, value in made.constants.items():
                if constants.setdefault(constant, value) != value:
                    raise AssertionError(f"two constants are called {constant}")
    return "\n\n\n".join(texts), constants


@cache
def _results() -> Mapping[str, str]:
    """Name → kind of the result of each function of exported programs."""
    parts = [_parsed(getattr(module, name)) for module, names in PARTS for name in names.split()]
    own = [n for n in ast.parse(fixed_text("follow.txt")).body if isinstance(n, ast.FunctionDef)]
    return {n.name: _KINDS.get(ast.unparse(n.returns), "") for n in [*own, *parts] if n.returns}


def _parsed(function: Callable[..., Any]) -> ast.FunctionDef:
    """The syntax tree of a function, traced or not."""
    plain = function.function if isinstance(function, TracedFunction) else function
    node = ast.parse(textwrap.dedent(inspect.getsource(plain))).body[0]
    assert isinstance(node, ast.FunctionDef)
    return node


def _expression(text: str) -> ast.expr:
    return ast.parse(text, mode="eval").body


class _Translation(ast.NodeTransformer):
    """One function of the loop as a plain one."""

    def __init__(
        self, function: Callable[..., Any], module: ModuleType, whole: frozenset[str]
    ) -> None:
        self._node, self._module, self._whole = _parsed(function), module, whole
        self._aliases: dict[str, ast.expr] = {}
        self._kinds: dict[str, str] = {}
        self.constants: dict[str, int | float] = {}

    def function(self) -> ast.FunctionDef:
        """The function, with the record of a motion for tables of memory."""
        node = self._node
        given = [a for a in node.args.args if a.arg.lstrip("_") != "code"]
        arguments, kinds = [], [_KINDS[ast.unparse(a.annotation)] for a in given if a.annotation]
        for argument, kind in zip(given, kinds, strict=True):
            name = _RENAMED.get(argument.arg, argument.arg)
            if kind == "Motion":
                self._aliases[argument.arg] = _expression("motion")
                self._aliases["stepper"] = _expression("motion.stepper")
                name = "m"
            self._kinds[name] = kind
            arguments.append(ast.arg(name, _expression(kind)))
        assert node.returns is not None
        made = ast.parse("def name(): pass").body[0]
        assert isinstance(made, ast.FunctionDef)
        made.name = _CALLS.get(node.name, node.name)
        made.args.args = arguments
        made.body = self._block(node.body)
        made.returns = _expression(_KINDS[ast.unparse(node.returns)])
        return made

    # --- statements ---

    def _block(self, statements: Sequence[ast.stmt]) -> list[ast.stmt]:
        result: list[ast.stmt] = []
        for statement in statements:
            match statement:
                case ast.With(items=[first, *others], body=body) if _is_else(first):
                    inner = ast.With(others, body, lineno=0) if others else None
                    last = result[-1]
                    assert isinstance(last, ast.If)
                    last.orelse = self._block([inner] if inner else body)
                case _:
                    result += self._statement(statement)
        return result

    def _statement(self, node: ast.stmt) -> list[ast.stmt]:
        text = ast.unparse(node)
        match node:
            case ast.With(items=[first, *others], body=body):
                inner: list[ast.stmt] = [ast.With(others, body, lineno=0)] if others else body
                return self._with(first, inner)
            case ast.Expr(value=ast.Constant()):
                return [node]
            case ast.Assign(targets=[ast.Tuple() as names], value=value):
                return self._several(names.elts, value)
            case _ if any(part in text for part in _DROPPED) and "evaluations" not in text:
                return []
            case ast.Assign(targets=[target], value=value):
                return self._assigned(target, value)
            case ast.AugAssign(target=target, op=op, value=value):
                return [ast.AugAssign(self.visit(target), op, self.visit(value))]
            case ast.Return(value=ast.Tuple()):  # all of it is in memory
                return []
            case ast.Return(value=ast.expr() as value):
                return [ast.Return(self.visit(value))]
            case ast.Expr(value=ast.Call() as call):
                return self._called(call)
        raise AssertionError(text)

    def _with(self, item: ast.withitem, body: Sequence[ast.stmt]) -> list[ast.stmt]:
        """A block: of a condition, or of a loop."""
        call = item.context_expr
        assert isinstance(call, ast.Call)
        match ast.unparse(call.func):
            case "code.if_":
                test = self.visit(call.args[0])
                inner = [] if ast.unparse(test) == "0 > 0" else self._block(body)
                # what a condition is for may be none of an exported program's business
                return [ast.If(test, inner, [])] if inner else []
            case "code.for_range":
                end = self.visit(call.args[0])
                name = item.optional_vars or ast.Name("turn")
                if ast.unparse(end) == "0":
                    return []
                assert isinstance(name, ast.Name)
                counter = ast.Name(_RENAMED.get(name.id, name.id))
                self._kinds[counter.id] = "int"
                loop = ast.Call(ast.Name("range"), [end], [])
                return [ast.For(counter, loop, self._block(body), [], lineno=0)]
            case "code.while_":
                condition = call.args[0]
                assert isinstance(condition, ast.Lambda)
                return [ast.While(self.visit(condition.body), self._block(body), [])]
        raise AssertionError(ast.unparse(call))

    def _called(self, call: ast.Call) -> list[ast.stmt]:
        """A call that is a statement."""
        given = call.args
        match call.func:
            case ast.Attribute(value=ast.Name("code"), attr="return_if"):
                return [ast.If(self.visit(given[0]), [ast.Return(self.visit(given[1]))], [])]
            case ast.Attribute(value=ast.Name("code"), attr="return_"):
                return [ast.Return(self.visit(given[0]))]
            case ast.Attribute(value=ast.Name("code"), attr="break_if"):
                return [ast.If(self.visit(given[0]), [ast.Break()], [])]
            case ast.Attribute(value=ast.Name("code"), attr="break_"):
                return [ast.Break()]
            case ast.Attribute(value=ast.Name("code"), attr="continue_"):
                return [ast.Continue()]
            case ast.Attribute(value=target, attr="set"):
                return self._assigned(target, given[0])
            case ast.Attribute(value=target, attr="take"):
                return self._copied(target, *given)
        return [ast.Expr(self.visit(call))]

    def _copied(self, target: ast.expr, source: ast.expr, count: ast.expr) -> list[ast.stmt]:
        """Entries of one array into another: ``a.after(i).take(b.after(k), count)``."""
        assert isinstance(target, ast.Call)
        assert isinstance(source, ast.Call)
        places = []
        for each in (target, source):
            assert isinstance(each.func, ast.Attribute)
            place = ast.BinOp(each.args[0], ast.Add(), ast.Name("i"))
            places.append(self.visit(ast.Subscript(each.func.value, place)))
        loop = ast.Call(ast.Name("range"), [self.visit(count)], [])
        body: list[ast.stmt] = [ast.Assign([places[0]], places[1], lineno=0)]
        return [ast.For(ast.Name("i"), loop, body, [], lineno=0)]

    def _several(self, names: Sequence[ast.expr], value: ast.expr) -> list[ast.stmt]:
        """Some names that get their values at once; none of them is used by a later one's."""
        match value:
            case ast.Call(func=ast.Name("map"), args=[_, inner]):  # of `code.variable`
                return self._several(names, inner)
            case ast.Call(func=ast.Name("bisect"), args=given):
                return self._bisected(names, given)
            case ast.Call(func=ast.Name(id=pair), args=given) if pair in _PAIRS:
                values: list[ast.expr] = [ast.Call(ast.Name(n), given, []) for n in _PAIRS[pair]]
            case ast.Tuple(elts=values):
                pass
            case _:
                raise AssertionError(ast.unparse(value))
        result = []
        for name, each in zip(names, values, strict=True):
            if ast.unparse(name) != "_":
                result += self._assigned(name, each)
        return result

    def _bisected(self, names: Sequence[ast.expr], given: Sequence[ast.expr]) -> list[ast.stmt]:
        """`scalar_stages.bisect`, written out."""
        _, rounds, condition, *last = given
        assert isinstance(condition, ast.Lambda)
        low, high = map(ast.unparse, names)
        self._kinds |= {low: "float", high: "float"}
        x = condition.args.args[0].arg
        head = f"{low} = 0.0\n{high} = {ast.unparse(last[0]) if last else '1.0'}\n"
        loop = f"{head}for turn in range(0):\n    {x} = 0.5 * ({low} + {high})\n"
        text = f"{loop}    if 0:\n        {low} = {x}\n    else:\n        {high} = {x}\n"
        result = ast.parse(text).body
        repeated = result[2]
        assert isinstance(repeated, ast.For)
        repeated.iter = ast.Call(ast.Name("range"), [self.visit(rounds)], [])
        case = repeated.body[1]
        assert isinstance(case, ast.If)
        case.test = self.visit(condition.body)
        return result

    def _assigned(self, target: ast.expr, value: ast.expr) -> list[ast.stmt]:
        """A name for a part of memory, or a variable with a value."""
        if isinstance(target, ast.Name):
            full = self._resolved(value)
            text = ast.unparse(full)
            if text in _TABLES or _INDEXED.search(_NAMES.get(text, "")):
                self._aliases[target.id] = full
                return []
        result, made = self.visit(target), self.visit(value)
        if not isinstance(result, ast.Name):
            return [ast.Assign([result], made, lineno=0)]
        kind = self._kinds.setdefault(result.id, self._kind(made))
        if kind == "int":
            return [ast.AnnAssign(result, ast.Name("int"), made, simple=1)]
        return [ast.Assign([result], made, lineno=0)]

    def _kind(self, node: ast.expr) -> str:
        """Whether a value is whole."""
        match node:
            case ast.Constant(value=value):
                return "int" if isinstance(value, int) else "float"
            case ast.Compare() | ast.BoolOp() | ast.UnaryOp(op=ast.Not()):
                return "int"
            case ast.UnaryOp(operand=operand):
                return self._kind(operand)
            case ast.Name(id=name):
                return "int" if name in _WHOLE else self._kinds.get(name, "float")
            case ast.Attribute(attr=name):
                return "int" if name in self._whole else "float"
            case ast.Subscript(value=ast.Name(id=name)):
                return "int" if name in _WHOLE else "float"
            case ast.BinOp(left=left, right=right):
                return "int" if {self._kind(left), self._kind(right)} == {"int"} else "float"
            case ast.IfExp(body=one, orelse=other):
                return "int" if {self._kind(one), self._kind(other)} == {"int"} else "float"
            case ast.Call(func=ast.Name(id=name)):
                return _results().get(name, "float")
        return "float"

    # --- expressions ---

    def _resolved(self, node: ast.expr) -> ast.expr:
        """An expression with what names of parts of memory stand for."""
        aliases = self._aliases

        class Resolved(ast.NodeTransformer):
            def visit_Name(self, name: ast.Name) -> ast.expr:
                return aliases.get(name.id, name)

        return Resolved().visit(ast.parse(ast.unparse(node), mode="eval").body)

    def visit(self, node: ast.AST) -> Any:
        """An expression."""
        if isinstance(node, ast.expr):
            full = self._resolved(node)
            text = ast.unparse(full)
            known = _NAMES.get(text)
            if known is not None and not _INDEXED.search(known):
                return _expression(known)
            if isinstance(full, ast.Subscript):
                known = _NAMES.get(ast.unparse(full.value))
                if known is not None:
                    place = ast.unparse(self.visit(full.slice))
                    return _expression(_INDEXED.sub(place, known))
            if isinstance(full, ast.Attribute) and ast.unparse(full.value) == "motion.stepper":
                return ast.Attribute(ast.Name("m"), full.attr)
        return super().visit(node)

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """A variable, or a constant of its module."""
        value = getattr(self._module, node.id, None)
        if node.id not in self._kinds and isinstance(value, int | float) and node.id.isupper():
            self.constants[node.id] = value
        return ast.Name(_RENAMED.get(node.id, node.id))

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        """A number: truth is 1 or 0."""
        return ast.Constant(int(node.value)) if isinstance(node.value, bool) else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """What conversions convert."""
        if node.attr in ("to_int", "to_real"):
            converted: ast.expr = self.visit(node.value)
            return converted
        raise AssertionError(ast.unparse(node))

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Arithmetic, or a part of a condition."""
        left, right = self.visit(node.left), self.visit(node.right)
        match node.op:
            case ast.BitAnd():
                return ast.BoolOp(ast.And(), [left, right])
            case ast.BitOr():
                return ast.BoolOp(ast.Or(), [left, right])
        return ast.BinOp(left, node.op, right)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        """A sign, or what does not hold."""
        operation = ast.Not() if isinstance(node.op, ast.Invert) else node.op
        return ast.UnaryOp(operation, self.visit(node.operand))

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """One of two results."""
        match node:
            case ast.Subscript(
                value=ast.Call(func=ast.Name(id=pair), args=given),
                slice=ast.Constant(value=int(place)),
            ) if pair in _PAIRS:
                result: ast.expr = self.visit(ast.Call(ast.Name(_PAIRS[pair][place]), given, []))
                return result
        raise AssertionError(ast.unparse(node))

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """A call of a function, which takes the record of the motion for its memory."""
        name, given = ast.unparse(node.func), node.args
        match name:
            case "code.variable" | "code.value":
                value: ast.expr = self.visit(given[0])
                return value
            case "select" | "select_of":
                test, one, other = map(self.visit, given[-3:])
                return ast.IfExp(test, one, other)
            case "fma":
                a, b, c = map(self.visit, given)
                return ast.BinOp(ast.BinOp(a, ast.Mult(), b), ast.Add(), c)
            case "copysign":  # of the length of a step, with the direction of time
                size = self.visit(given[0])
                return ast.BinOp(ast.Attribute(ast.Name("m"), "sign"), ast.Mult(), size)
            case "outcome_of":
                status: ast.expr = self.visit(given[1])
                return status
            case "margin_outcome":  # `singular_within` looks at both ends of a step
                return ast.Constant(0)
            case "record_switch" | "behind_switch":
                return _expression("CHATTER + which if chatters(m, t) else 0")
        given = [g for g in given if ast.unparse(g) not in ("Int", "Real", "code")]
        arguments: list[ast.expr] = [
            ast.Name("m") if ast.unparse(self._resolved(g)).startswith("motion") and
            ast.unparse(self._resolved(g)) in ("motion", "motion.stepper") else self.visit(g)
            for g in given
        ]  # fmt: skip
        return ast.Call(ast.Name(_CALLS.get(name, name)), arguments[: _TAKEN.get(name)], [])


def _is_else(item: ast.withitem) -> bool:
    return ast.unparse(item.context_expr) == "case.else_()"
