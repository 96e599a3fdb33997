"""A compiled kernel: its text, machine code and arrays.

* ``prepare(p)`` fills the part of the parameter array that depends on parameters alone,
* ``clock(t, p, timed)`` fills what depends on time,
* ``rates(y, p, timed, out)`` does the rest.

Numbers are arguments; nothing of the text comes from a definition file.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import Function, Number, Table
from linkages.components.contributed.state_laws import leaves
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.statements import Entry, Place, Routine, build_block
from linkages.kernel.code.writer import write_assembly
from linkages.kernel.differentiation import SEVERAL
from linkages.kernel.model import Model
from linkages.kernel.scalars import Level, Scalar, reachable
from linkages.operations import ELEMENTARY, KINDS
from linkages.reading.paths import KeyPath

GENERATOR_VERSION = 6

_DOC = """Equations of motion of one topology; generated, do not edit (generator {}).

p: parameters, then values that depend on them alone
{}
timed: values that depend on time alone
y: {} coordinates, their rates, and their accelerations where they are used
out: {}

Returned is 0, or 1 + the number of the block that cannot be assembled.
"""


_PREPARE = "prepare", "Fill what depends on parameters alone.", ("p",)
_CLOCK = "clock", "Fill what depends on time alone.", ("t", "p", "timed")
_RATES = "rates", "Accelerations of the free coordinates, and how far blocks are from singular."
_STATE = ("y", "p", "timed", "out")
"""Routines by their names, in words, and their arguments, of which they fill the last."""


@dataclass(frozen=True)
class Program:
    """What a kernel does."""

    doc: str  # what its arrays hold
    routines: tuple[Routine, ...]  # ``prepare``, ``clock`` and ``rates``
    parameters: tuple[int, int]  # number of parameters, then of values derived from them
    timed: int  # number of values that depend on time alone
    groups: dict[Level, list[Scalar]]  # nodes by level, for counting operations
    # Number of modes, of numbers that the motion remembers and of their tangents: they follow
    # behind the derived values
    held: int = 0

    @cached_property
    def assembly(self) -> str:
        """What is compiled, in LLVM's assembly language."""
        return write_assembly(self.routines)

    @cached_property
    def text(self) -> str:
        """The same as Python source, to be read."""
        from linkages.kernel.code.languages import write_module

        return write_module(self.doc, self.routines)


def write_program(
    model: Model,
    accelerations: Sequence[Scalar],
    settled: Sequence[Scalar] | None = None,
    counted: Sequence[Scalar] = (),
    switched: Sequence[Scalar] = (),
) -> Program:
    """Generate the kernel of a model; `settled` is what replaces values and rates after a step."""
    settled = model.settled if settled is None else settled
    roots = [*accelerations, *model.margins, *model.margin_rates, *settled, *counted, *switched]
    n, blocks, carried = len(accelerations), len(model.margins), len(settled) // 2
    written = (
        f"accelerations ({n}), margins of the blocks ({blocks}), their rates ({blocks}),\n"
        f"     settled values of {carried} coordinates, their rates ({carried})"
    )
    if counted:
        count = len(counted) // 3
        written += f",\n     cosines, sines and speeds of dependent angles ({count} each)"
    if switched:
        count = len(switched) // 2
        written += f",\n     functions whose signs are modes, their rates ({count} each)"
    return write_functions_of(model, roots, written)


def write_functions_of(model: Model, roots: Sequence[Scalar], written: str) -> Program:
    """Generate a kernel that computes some nodes, which may depend on accelerations."""
    return write_routines(model, {_RATES: roots}, written)


def write_routines(
    model: Model, wanted: Mapping[tuple[str, str], Sequence[Scalar]], written: str
) -> Program:
    """Generate a kernel with several routines of the state, which share what is prepared."""
    inputs = model.inputs
    radicands = [reach.radicand for reach in model.reaches]
    every = [root for roots in wanted.values() for root in roots]
    nodes = reachable([*every, *radicands])
    by_level = {level: [n for n in nodes if n.level == level and n.operands] for level in Level}
    needed = {root.index for root in every}
    derived = _boundary(by_level, Level.PARAMETERS, by_level[Level.PARAMETERS], needed)
    # time itself is no argument of what depends on the state
    moments = [node for node in nodes if node.level == Level.TIME]
    timed = _boundary(by_level, Level.TIME, moments, needed)
    count = len(inputs.parameters)
    begin = count + len(derived)
    places, held = _input_places(model, begin)
    sizes = {"t": 0, "y": 3 * inputs.coordinates, "p": begin + held, "timed": len(timed)}
    checks = {reach.radicand.index: 1 + reach.block for reach in model.reaches}

    def routine(
        of: tuple[str, str, tuple[str, ...]],
        nodes: Iterable[Scalar],
        stores: Mapping[Entry, Scalar],
        checks: Mapping[int, int] | None,
    ) -> Routine:
        name, doc, arguments = of
        block = build_block(nodes, places, checks=checks, stores=stores)
        own = sizes | {"out": len(stores)}
        return Routine(name, doc, {a: own[a] for a in arguments}, block)

    routines = []
    # nobody asks `prepare` how it ended
    for of, level, first, result, ending in (
        (_PREPARE, Level.PARAMETERS, count, derived, None),
        (_CLOCK, Level.TIME, 0, timed, checks),
    ):
        stores = {Entry(of[-1][-1], first + k): node for k, node in enumerate(result)}
        routines.append(routine(of, by_level[level], stores, ending))
        places |= {node.index: entry for entry, node in stores.items()}
    for (name, doc), roots in wanted.items():
        stores = {Entry("out", k): node for k, node in enumerate(roots)}
        own = {node.index for node in reachable([*roots, *radicands])}
        moving = [node for node in by_level[Level.STATE] if node.index in own]
        routines.append(routine((name, doc, _STATE), moving, stores, checks))
    used = {n.arguments for n in nodes if n.operation == "input"}
    described = "\n".join(
        f"    p[{k}] {text}" for k, text in enumerate(inputs.describe()) if ("p", k) in used
    )
    if held:
        last = begin + held - 1
        described += f"\n    p[{begin}] to p[{last}] modes, what is remembered, its tangents"
    heading = _DOC.format(GENERATOR_VERSION, described, inputs.coordinates, written)
    return Program(heading, tuple(routines), (count, len(derived)), len(timed), by_level, held)


def _input_places(model: Model, begin: int) -> tuple[dict[int, Place], int]:
    """Where inputs stand, and the number of modes, latched values and tangents from `begin` on."""
    inputs = [node for node in model.graph.nodes if node.operation == "input"]
    modes = len(model.switches.switches)
    known = modes + len(model.switches.memories)
    first = {
        "mode": Entry("p", begin),
        "memory": Entry("p", begin + modes),
        "memory_tangent": Entry("p", begin + known),
        "a": Entry("y", 2 * model.inputs.coordinates),  # accelerations follow the state
        "seed": Entry("y", 3 * model.inputs.coordinates),  # a direction follows accelerations
    }
    places: dict[int, Place] = {}
    for node in inputs:
        name, index = node.arguments
        array, offset = first.get(name, (name, 0))
        places[node.index] = Entry(array, offset + index)
    tangents = [node.arguments[1] for node in inputs if node.arguments[0] == "memory_tangent"]
    return places, known + max(tangents, default=-1) + 1


def _boundary(
    by_level: dict[Level, list[Scalar]], level: Level, nodes: list[Scalar], needed: set[int]
) -> list[Scalar]:
    """Those of a level's nodes that a higher level (or the result) uses."""
    wanted = needed | {
        o.index
        for higher in by_level
        if higher > level
        for n in by_level[higher]
        for o in n.operands
    }
    return [node for node in nodes if node.index in wanted]


@dataclass(frozen=True, kw_only=True)
class Kernel:
    """Addresses of two compiled functions, and the parameters that they need, shape (p,).

    Their C signatures are ::

        int64 clock(double t, double *parameters, double *timed)
        int64 rates(double *state, double *parameters, double *timed, double *out)

    `clock` computes what depends on time alone. Both return 0, or 1 + the index of the block that
    cannot be assembled.
    """

    clock: int
    rates: int
    parameters: NDArray[np.float64]
    timed_size: int  # length of what `clock` writes
    held: int = 0  # how many of the last parameters are modes and latched values
    keepalive: object = None  # whatever must live as long as the two addresses are in use
    # Compiles both functions for so many lanes, with rows of numbers in all arrays and statuses
    # behind the arguments; None if there are no such functions
    wide: Callable[[int], Kernel] | None = None


@dataclass(frozen=True)
class GeneratedProgram:
    """What is needed to call a `Program`, without the nodes that it was generated from."""

    assembly: str
    parameters: tuple[int, int]
    timed: int
    held: int = 0

    @classmethod
    def of(cls, program: Program) -> GeneratedProgram:
        """Without the nodes that it was generated from."""
        return cls(program.assembly, program.parameters, program.timed, program.held)


def bind_kernel(program: Program | GeneratedProgram, parameters: np.ndarray) -> Kernel:
    """Compile a program, or take it from the cache, and prepare it for parameters, shape (p,)."""
    code, prepare = _loaded(program.assembly)
    values = np.zeros(max(1, sum(program.parameters) + program.held))
    values[: program.parameters[0]] = parameters
    prepare(values.ctypes.data)
    return Kernel(
        clock=code.address("clock"),
        rates=code.address("rates"),
        parameters=values,
        timed_size=program.timed,
        held=program.held,
        keepalive=code,
    )


@lru_cache(maxsize=256)
def _loaded(assembly: str) -> tuple[MachineCode, Callable[[int], int]]:
    """The machine code of a text, which is found without hashing it again, and its ``prepare``."""
    code = MachineCode(assembly)
    return code, code.function("prepare")


PARTS = {
    "once per run": Level.PARAMETERS,
    "once per distinct time": Level.TIME,
    "once per state": Level.STATE,
}


@dataclass(frozen=True)
class KernelReport:
    """Operation counts of a kernel."""

    # Part (see `PARTS`) → kind of operation (see `linkages.operations.KINDS`) → number
    counts: dict[str, dict[str, int]]
    # Numbers of the definition file that the motion does not depend on
    left_out: tuple[KeyPath, ...]


def report_kernel(model: Model, program: Program) -> KernelReport:
    """Count the operations of a program, and find the inertia and loads that it does not need."""
    counts = {part: _count(program.groups[level]) for part, level in PARTS.items()}
    return KernelReport(counts, _left_out(model, program))


def _count(nodes: list[Scalar]) -> dict[str, int]:
    names = Counter(node.operation for node in nodes)
    result = dict.fromkeys(KINDS, 0)
    for name, number in names.items():
        row = ELEMENTARY.get(name) or SEVERAL.get(name)
        if row is not None:  # picking one of several results is no operation
            result[row.kind] += number
    return result


def _left_out(model: Model, program: Program) -> tuple[KeyPath, ...]:
    nodes = reachable(node for level in program.groups.values() for node in level)
    used = {n.arguments for n in nodes if n.operation == "input"}
    numbered = {path: ("p", index) for index, path in enumerate(model.inputs.parameters)}
    given = [
        (*body.path, key)
        for body in model.mechanism.bodies.values()
        for key, value in (("mass", body.mass), ("inertia", body.inertia))
        if not value.absent
    ]
    given += [term.mass.path for term in model.mechanism.point_masses if not term.mass.absent]
    result = (leaf for load in model.mechanism.loads for leaf in leaves(load.force))
    given += dict.fromkeys(path for leaf in result if (path := _number(leaf)))
    return tuple(path for path in given if numbered.get(path) not in used)


def _number(leaf: Function) -> KeyPath:
    """Path of a number of the definition file, the first one of a table; empty for others."""
    match leaf:
        case Number(parameter):
            return parameter.path
        case Table(path):
            return (*path, "spline", 0)
    return ()
