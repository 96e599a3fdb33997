"""A kernel written by hand for one state or several lanes: Duffing's equation, forced."""

from __future__ import annotations

from functools import cache

import numpy as np

from linkages.kernel.code.elementary_functions import cosine_and_sine
from linkages.kernel.code.instructions import Instructions
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.operands import Real, fma
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
    time = Real(code, "%t" if lanes == 1 else code.load("%t", 0))
    away = abs(time - _read(code, "%p", 4))
    code.require((away >= 1e-9).text, 1)
    code.store(cosine_and_sine(time)[0].text, "%timed", 0)
    kind = "double" if lanes == 1 else "ptr"
    _written(module, "clock", f"{kind} %t, ptr %p, ptr %timed", code)
    code = module.instructions()
    q, v = _read(code, "%y", 0), _read(code, "%y", 1)
    damping, force, growth, reach = (_read(code, "%p", k) for k in range(4))
    left = reach - q
    code.require((left >= 0.0).text, 1)
    cube = q * q * q
    total = fma(-damping, v, q - cube)
    total = fma(force, _read(code, "%timed", 0), total)
    total = fma(growth, v * v * v, total)
    for value, place in ((total, 0), (left, 1), (-v, 2)):
        code.store(value.text, "%out", place)
    _written(module, "rates", "ptr %y, ptr %p, ptr %timed, ptr %out", code)
    return MachineCode(module.text)


def _read(code: Instructions, array: str, place: int) -> Real:
    return Real(code, code.load(array, place))


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
