"""Functions of a model, compiled for many states one after the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.instructions import INTEGER, PrintedLoop
from linkages.kernel.code.llvm import Module, call_routine
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.program import Program

Floats = NDArray[np.float64]


class SampledFunctions:
    """Values of functions at many times and states.

    Parameters
    ----------
    program
        The functions; without modes.
    lanes
        States side by side: bits do not depend on it.
    """

    def __init__(self, program: Program, lanes: int) -> None:
        self._lanes = lanes
        self._parameters = program.parameters
        (rates,) = (r for r in program.routines if r.name == "rates")
        self._rows, self._count = rates.arguments["y"], rates.arguments["out"]
        self._code = MachineCode(_written(program, lanes))
        self._prepare = self._code.function("prepare")
        self._evaluate = self._code.function("evaluate")

    def __call__(self, parameters: Floats, times: Floats, states: Floats) -> Floats:
        """Values, shape (functions, times); nan where a block cannot be assembled.

        Parameters
        ----------
        parameters
            Shape (p,).
        times
            Shape (times,).
        states
            Coordinates, their rates and accelerations, shape (3n, times) or fewer rows if those are
            all that is used.
        """
        lanes, count = self._lanes, len(times)
        if not count:
            return np.empty((self._count, 0))
        blocks = -(-count // lanes)
        p = np.zeros((sum(self._parameters), lanes))
        p[: len(parameters)] = parameters[:, None]
        t, y = np.empty(blocks * lanes), np.zeros((self._rows, blocks * lanes))
        t[:count], t[count:] = times, times[-1]
        y[: len(states), :count], y[: len(states), count:] = states, states[:, -1:]
        y = np.ascontiguousarray(y.reshape(-1, blocks, lanes).transpose(1, 0, 2))
        out = np.empty((blocks, self._count, lanes))
        unread = np.empty(lanes, dtype=np.int64)
        if lanes == 1:
            self._prepare(p.ctypes.data)
        else:
            self._prepare(p.ctypes.data, unread.ctypes.data)
        self._evaluate(t.ctypes.data, y.ctypes.data, p.ctypes.data, out.ctypes.data, blocks)
        return out.transpose(1, 0, 2).reshape(self._count, -1)[:, :count]


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
    rows = {
        name: code.address(f"%{name}", code.give(f"mul {INTEGER} {block}, {rates.arguments[name]}"))
        for name in ("y", "out")
    }
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
    module.define(f"void @evaluate(ptr %t, ptr %y, ptr %p, ptr %out, {INTEGER} %blocks)", code)
    return module.text
