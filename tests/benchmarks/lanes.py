"""Time of an evaluation in lanes against that of one state.

    python tests/benchmarks/lanes.py [--processor x86-64-v3]

Clock and accelerations, called from machine code. All widths of a mechanism are measured in turn,
many times, and of each the least time is taken: whatever else a machine does only adds to times.
Whole motions are compared with heyoka, where that is installed.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TypeAlias

import against_heyoka
import numpy as np
from chains import chain

import linkages
from linkages.kernel.code import machine
from linkages.kernel.code.instructions import INTEGER, PhiLoop
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.program import Program
from linkages.kernel.code.statements import Routine
from linkages.kernel.code.writer import Module, call_routine
from linkages.kernel.layout import Layout
from linkages.kernel.system import System
from linkages.solution.plan import kernel_source

LANES = (1, 2, 4, 8, 16)
ROUNDS = 41
SECONDS = 2e-3
"""Of one measurement."""


def repeated(routines: Sequence[Routine], lanes: int) -> str:
    """A module with a function that evaluates the same states many times."""
    module = Module(lanes)
    for routine in routines:
        module.add(routine, internal=routine.name != "prepare")
    code = module.instructions()
    time = code.load("%t", 0)
    loop = PhiLoop(code, [(INTEGER, "0")])
    for routine in routines[1:]:
        call_routine(code, routine, {name: f"%{name}" for name in routine.arguments} | {"t": time})
    count = code.assign(f"add {INTEGER} {loop.values[0]}, 1")
    loop.repeat(code.assign(f"icmp ult {INTEGER} {count}, %count"), [count])
    code.emit("ret i64 0")
    arrays = ", ".join(f"ptr %{name}" for name in ("t", "p", "timed", "y", "out"))
    module.define(f"i64 @repeat({arrays}, {INTEGER} %count)", code)
    return module.text


def aligned(rows: int, lanes: int) -> np.ndarray:
    """Zeros at the beginning of a line of the cache, shape (rows, lanes)."""
    room = np.zeros(rows * lanes + 8)
    first = -room.ctypes.data // 8 % 8
    return room[first : first + rows * lanes].reshape(rows, lanes)


def evaluation(of: System, program: Program, lanes: int) -> Callable[[int], float]:
    """A function of a number of evaluations that returns seconds per evaluation."""
    code = MachineCode(repeated(program.routines, lanes))
    sizes = {name: size for r in program.routines for name, size in r.arguments.items()}
    arrays = {n: aligned(max(1, sizes[n]), lanes) for n in ("t", "p", "timed", "y", "out")}
    arrays["p"][: program.parameters[0]] = of.parameters[:, None]
    arrays["y"][: len(of.state)] = of.state[:, None]
    status = np.zeros(lanes, dtype=np.int64)
    pointers = [array.ctypes.data for array in arrays.values()]
    prepare = [arrays["p"].ctypes.data, *([status.ctypes.data] if lanes > 1 else [])]
    code.function("prepare")(*prepare)
    repeat = code.function("repeat")

    def measure(count: int, _kept: object = (code, arrays)) -> float:
        begin = time.perf_counter()
        repeat(*pointers, count)
        return (time.perf_counter() - begin) / count / lanes

    return measure


def pendulums(count: int) -> linkages.Mechanism:
    """Equal bars hang one from the other."""
    pins = ["O", *(f"P{k}" for k in range(count))]
    lines = ["gravity: [0, -9.81]", "joints: {O: [0, 0]}", "bars:"]
    lines += [
        f"  b{k}: {{joints: [{pins[k]}, {pins[k + 1]}], length: 0.3, mass: 1}}"
        for k in range(count)
    ]
    lines += ["free:", *(f"  b{k}: {{angle: {0.2 * k}, speed: 0.1}}" for k in range(count))]
    return linkages.loads("\n".join(lines))


CONTACTS = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}
  rod: {joints: [A, B], length: 0.14, mass: 0.5, center: 0.07}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
clearances:
  gap:
    {joint: A, bar: rod, size: 0.1 mm, contact: hunt-crossley-constant, stiffness: 2e9 N/m^1.5,
     dissipation: 1.5 s/m, carries: hole, pin_radius: 8 mm, friction: 0.05, slip: 10 mm/s}
drives: {crank: {angle: 0, speed: 600 rpm}}
loads: [{slider: piston, force: -200 N}]
assembly: {B: [0.18, 0]}
"""

Evaluated: TypeAlias = tuple[System, Program]


def motion(mechanism: linkages.Mechanism, tangents: int = 0) -> Evaluated:
    """A mechanism, and its equations of motion with those of some tangents."""
    of = System(mechanism)
    layout = Layout.of(of.topology, tangents=tangents)
    return of, kernel_source(of.topology, layout).program


MECHANISMS: dict[str, Callable[[], Evaluated]] = {
    "nine-bar": lambda: motion(linkages.load("ninebar")),
    "nine-bar, 1 tangent": lambda: motion(linkages.load("ninebar"), 1),
    "nine-bar, 2 tangents": lambda: motion(linkages.load("ninebar"), 2),
    "contact, friction": lambda: motion(linkages.loads(CONTACTS)),
    "Andrews": lambda: motion(linkages.load("andrews")),
    "ten pendulums": lambda: motion(pendulums(10)),
    "forty four-bars": lambda: motion(chain(80)),
    "class III (Newton)": lambda: motion(linkages.load("class-three")),
}


@contextmanager
def compiled_for(processor: str | None) -> Iterator[None]:
    """Compile for another instruction set than this machine's."""
    usual = machine._host
    if processor is not None:
        machine._host = lambda: (usual()[0], processor, "")
    try:
        yield
    finally:
        machine._host = usual


def measured(evaluated: Evaluated) -> dict[int, float]:
    """Number of lanes → seconds per evaluation."""
    of, program = evaluated
    functions = {lanes: evaluation(of, program, lanes) for lanes in LANES}
    counts = {lanes: max(1, int(SECONDS / lanes / f(100))) for lanes, f in functions.items()}
    rounds = [[functions[n](counts[n]) for n in LANES] for _ in range(ROUNDS)]
    return dict(zip(LANES, np.min(rounds, axis=0).tolist(), strict=True))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--processor", help="an instruction set instead of this machine's")
    parser.add_argument("mechanisms", nargs="*", default=list(MECHANISMS))
    given = parser.parse_args()
    print(
        "ns per evaluation     " + "".join(f"{f'W = {n}':>10}" for n in LANES) + "      best ratio"
    )
    with compiled_for(given.processor):
        for name in given.mechanisms:
            found = measured(MECHANISMS[name]())
            ratio = found[1] / min(found.values())
            row = "".join(f"{1e9 * seconds:10.1f}" for seconds in found.values())
            print(f"{name:22}{row}{ratio:16.1f}", flush=True)
    if find_spec("heyoka") is not None:
        against_heyoka.main()


if __name__ == "__main__":
    main()
