"""A kernel written by hand for one state or several lanes: Duffing's equation, forced."""

from __future__ import annotations

from functools import cache

import numpy as np

from linkages.kernel.code.elementary_functions import cosine_and_sine
from linkages.kernel.code.instructions import Instructions
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import Real
from linkages.kernel.code.writer import Module
from linkages.solvers import Flow, Kernel

# a = q - q³ - p0 v + p1 cos t + p2 v³; the only block reaches as far as q = p3, and not at t = p4
QUIET = (0.25, 0.3, 0.0, 10.0)


def _written(module: Module, name: str, arguments: str, code: Instructions) -> None:
    code.end()
    lanes = ", ptr %status" if code.lanes > 1 else ""
    result = "void" if code.lanes > 1 else "i64"
    module.define(f"{result} @{name}({arguments}{lanes})", code)


@cache
def duffing_code(lanes: int) -> MachineCode:
    """Machine code of ``clock`` and ``rates``."""
    module = Module(lanes)
    code = module.instructions()
    time = "%t" if lanes == 1 else code.load("%t", 0)
    away = code.absolute(code.subtract(time, code.load("%p", 4)))
    code.require(code.compare("oge", away, code.constant(1e-9)), 1)
    code.store(cosine_and_sine(Real(code, time))[0].text, "%timed", 0)
    kind = "double" if lanes == 1 else "ptr"
    _written(module, "clock", f"{kind} %t, ptr %p, ptr %timed", code)
    code = module.instructions()
    q, v = code.load("%y", 0), code.load("%y", 1)
    damping, force, growth, reach = (code.load("%p", k) for k in range(4))
    left = code.subtract(reach, q)
    code.require(code.compare("oge", left, code.constant(0.0)), 1)
    cube = code.multiply(code.multiply(q, q), q)
    total = code.fma(code.negate(damping), v, code.subtract(q, cube))
    total = code.fma(force, code.load("%timed", 0), total)
    total = code.fma(growth, code.multiply(code.multiply(v, v), v), total)
    for value, place in ((total, 0), (left, 1), (code.negate(v), 2)):
        code.store(value, "%out", place)
    _written(module, "rates", "ptr %y, ptr %p, ptr %timed, ptr %out", code)
    return MachineCode(module.text)


def _companion(lanes: int) -> Kernel:
    code = duffing_code(lanes)
    return Kernel(
        clock=code.address("clock"),
        rates=code.address("rates"),
        parameters=np.zeros(5),
        timed_size=1,
        keepalive=code,
    )


def duffing(*parameters: float, without: float = 1e300) -> Flow:
    """The flow with some parameters, see `QUIET`, and a time at which it cannot be evaluated."""
    one = _companion(1)
    return Flow(
        clock=one.clock,
        rates=one.rates,
        parameters=np.array([*parameters, without]),
        timed_size=1,
        coordinates=1,
        rotates=np.array([True]),
        margin_scale=np.ones(1),
        keepalive=one,
        wide=_companion,
    )
