"""The text of a compiled kernel: one Python module per topology.

The module has three functions, called through their addresses (see `linkages.solvers.flow`):

* ``prepare(p)`` fills the part of the parameter array that depends on parameters alone,
* ``clock(t, p, timed)`` fills what depends on time,
* ``rates(y, p, timed, out)`` does the rest.

Numbers are arguments; nothing of the text comes from a definition file.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from linkages.kernel.model import Model
from linkages.kernel.printing import Statements, write_functions
from linkages.kernel.scalars import Level, Scalar, reachable

GENERATOR_VERSION = 4

_HEADER = '''"""Equations of motion of one topology; generated, do not edit (generator {version}).

p: parameters, then values that depend on them alone
{parameters}
timed: values that depend on time alone
y: {coordinates} coordinates, their rates, and their accelerations where they are used
out: {written}

Returned is 0, or 1 + the number of the block that cannot be assembled.
"""

from math import atan, atan2, cos, exp, floor, log, sin, sqrt, tan, tanh

from numba import carray, cfunc, njit, types

_array = types.CPointer(types.float64)
_options = {{"cache": True, "error_model": "numpy", "fastmath": {{"contract"}}}}
_inline = _options
'''

_FUNCTION = '''

@cfunc(types.int64({signature}), **_options)
def {name}({arguments}):
    """{doc}"""
{body}
    return 0
'''


@dataclass(frozen=True)
class Program:
    """A printed kernel.

    Parameters
    ----------
    text
        Python source.
    parameters
        Number of parameters, then of values derived from them.
    timed
        Number of values that depend on time alone.
    groups
        Nodes by level, for counting operations.
    """

    text: str
    parameters: tuple[int, int]
    timed: int
    groups: dict[Level, list[Scalar]]


def write_program(
    model: Model,
    accelerations: Sequence[Scalar],
    settled: Sequence[Scalar] | None = None,
    counted: Sequence[Scalar] = (),
) -> Program:
    """Print the kernel that integrates a model.

    Parameters
    ----------
    model
        The equations.
    accelerations
        One node per integrated coordinate.
    settled
        Values, then rates, of the coordinates that are replaced after each step; those of the
        model that are carried along, if not given.
    counted
        Cosines, sines and speeds of dependent angles whose whole turns are counted.
    """
    settled = model.settled if settled is None else settled
    roots = [*accelerations, *model.margins, *model.margin_rates, *settled, *counted]
    n, blocks, carried = len(accelerations), len(model.margins), len(settled) // 2
    written = (
        f"accelerations ({n}), margins of the blocks ({blocks}), their rates ({blocks}),\n"
        f"     settled values of {carried} coordinates, their rates ({carried})"
    )
    if counted:
        count = len(counted) // 3
        written += f",\n     cosines, sines and speeds of dependent angles ({count} each)"
    return write_functions_of(model, roots, written)


def write_functions_of(model: Model, roots: Sequence[Scalar], written: str) -> Program:
    """Print a kernel that computes some nodes, which may depend on accelerations.

    Parameters
    ----------
    model
        The equations.
    roots
        What ``rates`` writes, in this order.
    written
        The same in words.
    """
    checks = {reach.radicand.index: reach for reach in model.reaches}
    nodes = reachable([*roots, *(reach.radicand for reach in model.reaches)])
    by_level = {level: [n for n in nodes if n.level == level and n.operands] for level in Level}
    needed = {root.index for root in roots}
    derived = _boundary(by_level, Level.PARAMETERS, by_level[Level.PARAMETERS], needed)
    # time itself is no argument of what depends on the state
    moments = [node for node in nodes if node.level == Level.TIME]
    timed = _boundary(by_level, Level.TIME, moments, needed)
    count = len(model.inputs.parameters)
    used = {n.arguments for n in nodes if n.operation == "input"}
    writer = _Writer(model, by_level, {i: 1 + r.block for i, r in checks.items()}, count)
    known = {node.index: f"p[{count + k}]" for k, node in enumerate(derived)}
    clocked = {node.index: f"timed[{k}]" for k, node in enumerate(timed)}
    sizes = (count + len(derived), len(timed))
    parts = [
        _HEADER.format(
            version=GENERATOR_VERSION,
            parameters="\n".join(
                f"    p[{index}] {text}"
                for index, text in enumerate(model.inputs.describe())
                if ("p", index) in used
            ),
            coordinates=model.inputs.coordinates,
            written=written,
        ),
        write_functions(nodes),
        writer.prepare(derived, known, sizes[0]),
        writer.clock(timed, clocked, known, sizes),
        writer.rates([*roots], clocked, known, sizes),
    ]
    return Program("".join(parts), (count, len(derived)), len(timed), by_level)


def _boundary(
    by_level: dict[Level, list[Scalar]], level: Level, nodes: list[Scalar], needed: set[int]
) -> list[Scalar]:
    """Those of a level's nodes that a higher level (or the result) uses."""
    used = {
        o.index
        for higher in by_level
        if higher > level
        for n in by_level[higher]
        for o in n.operands
    }
    return [node for node in nodes if node.index in used | needed]


class _Writer:
    """Prints the three functions."""

    def __init__(
        self,
        model: Model,
        by_level: dict[Level, list[Scalar]],
        codes: dict[int, int],
        parameters: int,
    ) -> None:
        self._model = model
        self._by_level = by_level
        self._codes = codes
        inputs = [node for node in model.graph.nodes if node.operation == "input"]
        self._inputs = {node.index: self._input(node) for node in inputs}
        self._parameters = parameters

    def _input(self, node: Scalar) -> str:
        name, index = node.arguments
        if name == "a":  # a state is followed by the accelerations that were computed from it
            return f"y[{2 * self._model.inputs.coordinates + index}]"
        return "t" if name == "t" else f"{name}[{index}]"

    def _checks(self, level: Level) -> dict[int, Callable[[str], list[str]]]:
        members = {node.index for node in self._by_level[level]}

        def check(code: int) -> Callable[[str], list[str]]:
            return lambda name: [f"if not {name} >= 0.0:", f"    return {code}"]

        return {i: check(code) for i, code in self._codes.items() if i in members}

    def _function(
        self, name: str, arguments: str, doc: str, views: list[str], lines: list[str]
    ) -> str:
        signature = ", ".join(
            "types.float64" if a == "t" else "_array" for a in arguments.split(", ")
        )
        body = "\n".join(f"    {line}" if line else "" for line in [*views, *lines])
        return _FUNCTION.format(
            name=name, signature=signature, arguments=arguments, doc=doc, body=body
        )

    @staticmethod
    def _view(name: str, size: int) -> list[str]:
        return [f"{name} = carray({name}, ({size},))"] if size else []

    def prepare(self, derived: list[Scalar], stored: dict[int, str], size: int) -> str:
        nodes = self._by_level[Level.PARAMETERS]
        code = Statements(nodes, derived, self._inputs)
        lines = code.lines + [f"{stored[n.index]} = {code.text(n)}" for n in derived]
        doc = "Fill what depends on parameters alone."
        return self._function("prepare", "p", doc, self._view("p", size), lines)

    def clock(
        self, timed: list[Scalar], clocked: dict[int, str], known: dict[int, str], sizes: tuple
    ) -> str:
        nodes = self._by_level[Level.TIME]
        given = {**self._inputs, **known}
        code = Statements(nodes, timed, given, self._checks(Level.TIME))
        lines = code.lines + [f"{clocked[n.index]} = {code.text(n)}" for n in timed]
        views = self._view("p", sizes[0]) + self._view("timed", sizes[1])
        doc = "Fill what depends on time alone."
        return self._function("clock", "t, p, timed", doc, views, lines)

    def rates(
        self, roots: list[Scalar], clocked: dict[int, str], known: dict[int, str], sizes: tuple
    ) -> str:
        nodes = self._by_level[Level.STATE]
        given = {**self._inputs, **known, **clocked}
        code = Statements(nodes, roots, given, self._checks(Level.STATE))
        lines = code.lines + [f"out[{k}] = {code.text(root)}" for k, root in enumerate(roots)]
        views = (
            self._view("y", 3 * self._model.inputs.coordinates)
            + self._view("p", sizes[0])
            + self._view("timed", sizes[1])
            + self._view("out", len(roots))
        )
        doc = "Accelerations of the free coordinates, and how far blocks are from singular."
        return self._function("rates", "y, p, timed, out", doc, views, lines)
