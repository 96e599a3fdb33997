"""Output variables at the sample times, by NumPy from the nodes of the model, or compiled.

Functions for many states of integrated motions are compiled once for a structure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.load_measures import Turn
from linkages.kernel.code.instructions import INTEGER, PhiLoop
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import Int, Real, select
from linkages.kernel.code.program import Program, write_functions_of
from linkages.kernel.code.writer import Module, call_routine
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES, Variable, labels
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import MOST_STRUCTURES, System
from linkages.solution.motion import Motion, Piece

if TYPE_CHECKING:
    pass

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

_CHUNK = 2048
"""Samples evaluated at once: small enough for intermediate values to stay in the cache."""

Values = dict[str, Floats]

ValuesOf = Callable[[Piece, Sequence[str]], Floats]
"""A piece and names of variables → values of their nodes, as `variable_values` has them."""


def evaluate_variables(
    motion: Motion, names: Sequence[str], values: ValuesOf | None = None
) -> Values:
    """Values of variables, each of shape (samples, …)."""
    values = values or variable_values
    # between two samples a motion may pass many change points
    pieces = [piece for piece in motion.pieces if len(piece.wanted)] or motion.pieces[:1]
    smooth = [name for name in names if not VARIABLES[name].unbounded]
    poles = [name for name in names if VARIABLES[name].unbounded]
    parts = [
        piece_variables(piece, smooth, values) | piece_variables(piece.direct(), poles, values)
        for piece in pieces
    ]
    joined = {name: np.concatenate([part[name] for part in parts], axis=1) for name in names}
    system = motion.pieces[0].system
    result: Values = {}
    for name, rows in joined.items():
        shape = tuple(len(labels(system.model, dim)) for dim in VARIABLES[name].dims)
        result[name] = np.ascontiguousarray(rows.T).reshape(rows.shape[1], *shape)
    return result


def variable_values(piece: Piece, names: Sequence[str]) -> Floats:
    """Values of the nodes of variables, one after the other, shape (nodes, times)."""
    model = piece.system.model
    return evaluate_nodes(piece, [n for name in names for n in VARIABLES[name].evaluated(model)])


def piece_variables(piece: Piece, names: Sequence[str], of: ValuesOf = variable_values) -> Values:
    """Values of variables in a piece of a motion, each of shape (elements, wanted samples)."""
    count, places = 0, {}
    for name in names:
        own = len(VARIABLES[name].evaluated(piece.system.model))
        places[name], count = slice(count, count + own), count + own
    values = of(piece, names)
    result: Values = {}
    for name, place in places.items():
        rows, variable = values[place], VARIABLES[name]
        if variable.angle:
            rows = _with_turns(piece, rows, variable.dims[0])
        if variable.reduced is not None:
            rows = variable.reduced(rows)
        result[name] = _interpolated(piece, rows, variable)
    return result


def _interpolated(piece: Piece, rows: Floats, variable: Variable) -> Floats:
    """Values at the wanted times; of what may be infinite, the reciprocal is smooth."""
    if piece.samples is None or not variable.reciprocal:
        return piece.interpolated(rows)
    with np.errstate(divide="ignore"):
        return 1.0 / piece.interpolated(1.0 / rows)


def evaluate_nodes(piece: Piece, nodes: list[Scalar]) -> Floats:
    """Values of nodes of a piece's model at its times, shape (nodes, times)."""
    values = np.empty((len(nodes), len(piece.time)))
    for start in range(0, len(piece.time), _CHUNK):
        part = slice(start, start + _CHUNK)
        flipped = {block: where[part] for block, where in piece.flipped.items()}
        values[:, part] = piece.system.evaluate(
            nodes,
            piece.time[part],
            piece.state[:, part],
            piece.acceleration[:, part],
            flipped=flipped,
            held=None if piece.held is None else piece.held[:, part],
        )
    return values


def _with_turns(piece: Piece, angles: Floats, dim: str) -> Floats:
    """Continuous angles, (bodies, samples); those without counted turns stay within one turn."""
    model = piece.system.model
    if dim == "rotary_actuator":
        return _with_relative_turns(piece, angles)
    return _continuous(piece, angles, labels(model, dim))


def _with_relative_turns(piece: Piece, values: Floats) -> Floats:
    """Angles of actuators, with the turns that their bodies have made."""
    model = piece.system.model
    turns = [own.measure for own in model.actuators if isinstance(own.measure, Turn)]
    for value, turn in zip(values, turns, strict=True):
        own = evaluate_nodes(piece, [model.positions.angle(name) for name in turn.bodies])
        angle, *others = _continuous(piece, own, turn.bodies)
        value += 2 * np.pi * np.round((angle - sum(others) - value) / (2 * np.pi))
    return values


def _continuous(piece: Piece, angles: Floats, names: Sequence[str]) -> Floats:
    """Angles of bodies with their turns."""
    topology = piece.system.topology
    for row, name in enumerate(names):
        if name in topology.coordinates:
            angles[row] += 2 * np.pi * piece.turns[topology.coordinates.index(name)]
        elif name in piece.counted:
            angles[row] += 2 * np.pi * np.round((piece.counted[name] - angles[row]) / (2 * np.pi))
    return angles


class SampledFunctions:
    """Compiled values of functions at many states; bits do not depend on the number of lanes."""

    def __init__(self, program: Program, lanes: int) -> None:
        self._lanes, self._held = lanes, program.held
        self._parameters = program.parameters
        (rates,) = (r for r in program.routines if r.name == "rates")
        self._rows, self._count = rates.arguments["y"], rates.arguments["out"]
        self._code = MachineCode(_written(program, lanes))
        self._prepare = self._code.function("prepare")
        self._evaluate = self._code.function("evaluate")

    def prepared(self, parameters: Floats) -> Floats:
        """Numbers of motions, shape (motions, p), as calls take them."""
        lanes = self._lanes
        result = np.zeros((len(parameters), sum(self._parameters) + self._held, lanes))
        result[:, : parameters.shape[1]] = parameters[:, :, None]
        unread = np.empty(lanes, dtype=np.int64)
        statuses = () if lanes == 1 else (unread.ctypes.data,)
        first, stride = result.ctypes.data, result.strides[0]
        for motion in range(len(parameters)):
            self._prepare(first + motion * stride, *statuses)
        return result

    def __call__(
        self, prepared: Floats, which: Whole, times: Floats, states: Floats, held: Floats | None
    ) -> Floats:
        """Values, shape (functions, times); nan where a block cannot be assembled.

        `which` is the motion of each state, `states` has up to 3n rows (coordinates, rates,
        accelerations), `held` modes and latched values, shape (h, times).
        """
        lanes = self._lanes
        order = np.argsort(which, kind="stable")
        counts = np.bincount(which, minlength=len(prepared))
        blocks = -(-counts // lanes)
        # rows of lanes are full: where states of a motion end, its last one is repeated
        first, begin = np.cumsum(counts) - counts, np.cumsum(blocks) - blocks
        owner = np.repeat(np.arange(len(prepared)), blocks * lanes)
        place = np.arange(len(owner)) - lanes * begin[owner]
        source = order[first[owner] + np.minimum(place, counts[owner] - 1)]
        y = self._in_rows(states, source, self._rows)
        h = self._in_rows(np.zeros((0, len(times))) if held is None else held, source, self._held)
        t, out = times[source], np.empty((len(owner) // lanes, self._count, lanes))
        some = np.flatnonzero(blocks)
        numbers = prepared.ctypes.data + prepared.strides[0] * some
        rows = (
            array.ctypes.data + stride * begin[some]
            for array, stride in (
                (t, lanes * t.itemsize),
                *((each, each.strides[0]) for each in (y, h, out)),
            )
        )
        t_at, *others = (each.tolist() for each in rows)
        for call in zip(t_at, numbers.tolist(), *others, blocks[some].tolist(), strict=True):
            self._evaluate(*call)
        result = np.empty((self._count, len(times)))
        own = place < counts[owner]
        result[:, source[own]] = out.transpose(1, 0, 2).reshape(self._count, -1)[:, own]
        return result

    def _in_rows(self, values: Floats, source: Whole, size: int) -> Floats:
        """Values in rows of lanes, shape (blocks, size, lanes); zeros for rows that are missing."""
        result = np.zeros((size, len(source)))
        result[: len(values)] = values[:size, source]
        blocks = len(source) // self._lanes
        return np.ascontiguousarray(result.reshape(size, blocks, self._lanes).transpose(1, 0, 2))


def _written(program: Program, lanes: int) -> str:
    """The routines, and a loop over blocks of states around them."""
    module = Module(lanes)
    for routine in program.routines:
        module.add(routine, internal=routine.name != "prepare")
    _, clock, rates = program.routines
    code = module.instructions()
    timed = code.alloca(max(1, program.timed))
    loop = PhiLoop(code, [(INTEGER, "0")])
    (block,) = loop.values
    sizes = {"y": rates.arguments["y"], "held": program.held, "out": rates.arguments["out"]}
    rows = {
        name: code.address(f"%{name}", code.assign(f"mul {INTEGER} {block}, {size}"))
        for name, size in sizes.items()
    }
    for place in range(program.held):  # which stands behind the parameters proper
        code.store(code.load(rows["held"], place), "%p", sum(program.parameters) + place)
    given = {"t": code.load("%t", block), "p": "%p", "timed": timed, **rows}
    statuses = [call_routine(code, each, given) for each in (clock, rates)]
    early, late = (Int(code, status) == 0 for status in statuses)
    sound = early & late
    for place in range(rates.arguments["out"]):
        value = select(sound, Real(code, code.load(rows["out"], place)), math.nan)
        code.store(value.text, rows["out"], place)
    following = code.assign(f"add {INTEGER} {block}, 1")
    loop.repeat(code.assign(f"icmp ult {INTEGER} {following}, %blocks"), [following])
    code.emit("ret void")
    arguments = f"ptr %t, ptr %p, ptr %y, ptr %held, ptr %out, {INTEGER} %blocks"
    module.define(f"void @evaluate({arguments})", code)
    return module.text


def accelerated(piece: Piece) -> Piece:
    """A piece with the accelerations that follow from its states."""
    if piece.samples is not None or not len(piece.acceleration):
        return piece
    model = piece.system.model
    nodes = model.integrated_accelerations(model.changes)
    values = piece.system.evaluate(
        nodes, piece.time, piece.state, flipped=piece.flipped, held=piece.held
    )
    return replace(piece, acceleration=values)


LANES = 8
"""States side by side; bits do not depend on it."""


class Numbers:
    """Systems of motions of one structure, and which of them each state of a piece belongs to."""

    def __init__(self, systems: Sequence[System], which: Whole) -> None:
        self.systems, self.which = systems, which
        self._prepared: dict[SampledFunctions, Floats] = {}

    @classmethod
    def alone(cls, piece: Piece) -> Numbers:
        """Those of the one motion of a piece."""
        return cls([piece.system], np.zeros(len(piece.time), dtype=int))

    def part(self, part: NDArray[np.bool_] | NDArray[np.intp]) -> Numbers:
        """Those of some of the states."""
        return self.of(self.which[part])

    def of(self, which: Whole) -> Numbers:
        """The same for other states."""
        result = Numbers(self.systems, which)
        result._prepared = self._prepared
        return result

    def prepared(self, functions: SampledFunctions) -> Floats:
        """What functions take of them."""
        if functions not in self._prepared:
            parameters = np.array([system.parameters for system in self.systems])
            self._prepared[functions] = functions.prepared(parameters)
        return self._prepared[functions]


def compiled_values(piece: Piece, names: Sequence[str], numbers: Numbers | None = None) -> Floats:
    """The same as `variable_values`, to round-off; `numbers` are those of several motions."""

    def nodes(model: Model) -> list[Scalar]:
        return [node for name in names for node in VARIABLES[name].evaluated(model)]

    functions = _functions(piece, ("variables", *names), nodes) if names else None
    if functions is None:
        return variable_values(piece, names)
    states = np.concatenate([piece.state, piece.acceleration])
    return _called(functions, piece, states, numbers)


def compiled_accelerated(piece: Piece, numbers: Numbers | None = None) -> Piece:
    """A piece with the accelerations that follow from its states, as `accelerated` gives it."""

    def nodes(model: Model) -> list[Scalar]:
        return list(model.integrated_accelerations(model.changes))

    functions = _functions(piece, ("accelerations",), nodes)
    if functions is None:
        return accelerated(piece)
    return replace(piece, acceleration=_called(functions, piece, piece.state, numbers))


def can_be_compiled(piece: Piece) -> bool:
    """Whether outputs of a piece are evaluated by compiled functions.

    Not those of driven motions, of other assembly branches than that of the start, of sticking
    friction, whose force solves a system of its own, and of systems with derivatives by numbers.
    """
    sticking = [*piece.system.model.switches.equivalent]
    sticks = piece.held is not None and bool((piece.held[sticking] == 0.0).any())
    otherwise = bool(piece.flipped) or piece.samples is not None or sticks
    return len(piece.state) > 0 and not otherwise and piece.system.effects is None


def _called(
    functions: SampledFunctions, piece: Piece, states: Floats, numbers: Numbers | None
) -> Floats:
    own = Numbers.alone(piece) if numbers is None else numbers
    return functions(own.prepared(functions), own.which, piece.time, states, piece.held)


_FUNCTIONS: LRUCache[Hashable, SampledFunctions | None] = LRUCache(MOST_STRUCTURES)


def _functions(
    piece: Piece, what: tuple[str, ...], nodes: Callable[[Model], Sequence[Scalar]]
) -> SampledFunctions | None:
    """Compiled functions of a piece; None for NumPy."""
    if not can_be_compiled(piece):
        return None
    system = piece.system

    def made() -> SampledFunctions | None:
        model = Model(system.topology)
        wanted = nodes(model)
        if not wanted:
            return None
        return SampledFunctions(write_functions_of(model, wanted, ", ".join(what)), LANES)

    return _FUNCTIONS.get((system.structure.key, system.topology.coordinates, what), made)
