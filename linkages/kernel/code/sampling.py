"""Functions of a model, compiled for many states of some motions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.instructions import INTEGER, PrintedLoop
from linkages.kernel.code.llvm import Module, call_routine
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.program import Program

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]


class SampledFunctions:
    """Values of functions at many times and states of some motions.

    Parameters
    ----------
    program
        The functions.
    lanes
        States side by side: bits do not depend on it.
    """

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
        found = np.zeros((len(parameters), sum(self._parameters) + self._held, lanes))
        found[:, : parameters.shape[1]] = parameters[:, :, None]
        unread = np.empty(lanes, dtype=np.int64)
        statuses = () if lanes == 1 else (unread.ctypes.data,)
        first, stride = found.ctypes.data, found.strides[0]
        for motion in range(len(parameters)):
            self._prepare(first + motion * stride, *statuses)
        return found

    def __call__(
        self, prepared: Floats, which: Whole, times: Floats, states: Floats, held: Floats | None
    ) -> Floats:
        """Values, shape (functions, times); nan where a block cannot be assembled.

        Parameters
        ----------
        prepared, which
            Numbers of motions, and of which of them each state is, shape (times,).
        times
            Shape (times,).
        states
            Coordinates, their rates and accelerations, shape (3n, times) or fewer rows if those are
            all that is used.
        held
            Modes and what is remembered, shape (h, times), of functions that have them.
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
        found = np.empty((self._count, len(times)))
        own = place < counts[owner]
        found[:, source[own]] = out.transpose(1, 0, 2).reshape(self._count, -1)[:, own]
        return found

    def _in_rows(self, values: Floats, source: Whole, size: int) -> Floats:
        """Values in rows of lanes, shape (blocks, size, lanes); zeros for rows that are missing."""
        found = np.zeros((size, len(source)))
        found[: len(values)] = values[:size, source]
        blocks = len(source) // self._lanes
        return np.ascontiguousarray(found.reshape(size, blocks, self._lanes).transpose(1, 0, 2))


def _written(program: Program, lanes: int) -> str:
    """The routines, and a loop over blocks of states around them."""
    module = Module(lanes)
    for routine in program.routines:
        module.add(routine, internal=routine.name != "prepare")
    _, clock, rates = program.routines
    code = module.instructions()
    timed = code.reserve(max(1, program.timed))
    loop = PrintedLoop(code, [(INTEGER, "0")])
    (block,) = loop.values
    sizes = {"y": rates.arguments["y"], "held": program.held, "out": rates.arguments["out"]}
    rows = {
        name: code.address(f"%{name}", code.give(f"mul {INTEGER} {block}, {size}"))
        for name, size in sizes.items()
    }
    for place in range(program.held):  # which stands behind the parameters proper
        code.store(code.load(rows["held"], place), "%p", sum(program.parameters) + place)
    given = {"t": code.load("%t", block), "p": "%p", "timed": timed, **rows}
    statuses = [call_routine(code, each, given) for each in (clock, rates)]
    sound = code.all_of(
        [code.give(f"icmp eq {code.integer} {each}, {code.whole(0)}") for each in statuses]
    )
    for place in range(rates.arguments["out"]):
        value = code.select(sound, code.load(rows["out"], place), code.constant(float("nan")))
        code.store(value, rows["out"], place)
    following = code.give(f"add {INTEGER} {block}, 1")
    loop.repeat(code.give(f"icmp ult {INTEGER} {following}, %blocks"), [following])
    code.say("ret void")
    arguments = f"ptr %t, ptr %p, ptr %y, ptr %held, ptr %out, {INTEGER} %blocks"
    module.define(f"void @evaluate({arguments})", code)
    return module.text
