"""What kernels do is no text of a language: the same statements as Python, C and for lanes."""

import ctypes
import math
import shutil
import subprocess

import numpy as np
import pytest
from group_models import TRIAD
from linkage_models import program, system, system_of

from linkages.kernel.code.languages import c_function
from linkages.kernel.code.statements import Assign, Check, Entry, Iterate, Store
from linkages.kernel.differentiation import CLOSE, MOST_ITERATIONS, MOST_TURNED, evaluate

FORMULAS = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 3}}
loads:
  - {bar: rod, torque: 'sin(2*t)*exp(-t) + log(3 + t)*tan(t/9) + atan(t) - tanh(t)*cosh(t/2)'}
  - {bar: rod, torque: 'abs(t - 1) + max(t, 2)*min(t**3, 1) - acos(t/9) + asin(-t/9)/sinh(1 + t)'}
free: {rod: {angle: 0.3, speed: 1}}
"""


def as_c(written):
    parts = ["#include <math.h>"]
    parts += map(c_function, written.routines)
    return "\n".join(parts)


def as_python(written):
    scope = dict(vars(math))
    exec(written.text, scope)
    return scope


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("of", [system("ninebar"), system_of(FORMULAS)], ids=["ninebar", "laws"])
def test_statements_as_c_give_the_bits_of_python(of, tmp_path):
    """The same operations in the same order, with the same C library."""
    written = program(of)
    (tmp_path / "kernel.c").write_text(as_c(written), encoding="utf-8")
    options = ["-O0", "-ffp-contract=off", "-shared", "-fPIC", "kernel.c", "-o", "kernel.so", "-lm"]
    subprocess.run(["cc", *options], check=True, cwd=tmp_path)
    library = ctypes.CDLL(str(tmp_path / "kernel.so"))
    python = as_python(written)
    double = ctypes.POINTER(ctypes.c_double)
    state = np.array([*of.state, *np.zeros(len(of.state) // 2)])
    results = []
    for language in (python, library):
        p = np.zeros(sum(written.parameters) + written.held)
        p[: written.parameters[0]] = of.parameters
        timed, out = np.zeros(written.timed), np.zeros(written.routines[2].arguments["out"])
        for time in (0.0, 0.1, 1.3):
            arrays = {"y": state, "p": p, "timed": timed, "out": out, "t": time}
            for routine in written.routines:
                given = [arrays[a] for a in routine.arguments]
                if language is python:
                    status = python[routine.name](*given)
                else:
                    given = [
                        ctypes.c_double(g) if isinstance(g, float) else g.ctypes.data_as(double)
                        for g in given
                    ]
                    status = getattr(library, routine.name)(*given)
                results.append((status, p.tolist(), timed.tolist(), out.tolist()))
    half = len(results) // 2
    assert results[:half] == results[half:]
    assert any(any(out) for *_, out in results)


# --- many states at once, with masks in the place of early ends ---------------------------------


class Lanes:
    """Carries statements out for many states; nothing of a state that has ended matters."""

    def __init__(self, arrays, count):
        self.arrays, self.variables = arrays, {}
        self.status = np.zeros(count, dtype=int)

    def value(self, block, node):
        match block.places.get(node.index):
            case None:
                return self.computed(block, node)
            case Entry(array, offset):
                return self.arrays[array][offset]
            case name:
                return self.variables[name]

    def computed(self, block, node):
        operands = {o.index: self.value(block, o) for o in node.operands}
        return evaluate(node, operands, self.arrays)

    def end(self, failed, status):
        self.status = np.where((self.status == 0) & failed, status, self.status)

    def carry_out(self, block):
        for statement in block.statements:
            match statement:
                case Assign(name, node):
                    self.variables[name] = self.computed(block, node)
                case Store(entry, node):
                    self.arrays[entry.array][entry.offset] = self.value(block, node)
                case Check(node, status):
                    self.end(~(self.value(block, node) >= 0.0), status)
                case Iterate():
                    self.iterate(block, statement)

    def iterate(self, block, loop):
        starts = np.array([self.value(block, start) for start in loop.starts])
        scales = np.array(loop.iteration.scales)[:, None]
        found, running = starts.copy(), np.ones(starts.shape[1], dtype=bool)
        for _ in range(MOST_ITERATIONS):
            self.variables |= dict(zip(loop.unknowns, found, strict=True))
            self.carry_out(loop.body)
            updates = np.array([self.value(loop.body, u) for u in loop.iteration.updates])
            found = np.where(running, found + updates, found)
            running &= ~(abs(updates) <= CLOSE * scales).all(axis=0)
        far = ~(abs(found - starts) <= MOST_TURNED * scales).all(axis=0)
        self.end(running | far, loop.status)
        self.variables[loop.name] = found


CHAIN = """
joints: {O: [0, 0], C: [1, 0]}
bars: {crank: {joints: [O, A], length: 0.6, mass: 1}, rod: {joints: [A, B], length: 0.7, mass: 1},
  rocker: {joints: [B, C], length: 0.6, mass: 1}}
free: {crank: {angle: 1, speed: 1}}
assembly: {B: left}
"""


@pytest.mark.parametrize(
    "text", [CHAIN, TRIAD.replace("drives", "free")], ids=["closed form", "iteration"]
)
def test_statements_carried_out_for_many_states(text):
    """The accelerations of NumPy, and a status where it finds nan: half of the states are wild."""
    of, count = system_of(text), 60
    written, random = program(of), np.random.default_rng(1)
    n = of.model.inputs.coordinates
    spread = np.where(np.arange(count) % 2, 0.05, 3.0)
    y = np.zeros((3 * n, count))
    y[: 2 * n] = of.state[:, None] + spread * random.normal(size=(2 * n, count))
    p = np.zeros((sum(written.parameters), 1))
    p[: written.parameters[0], 0] = of.parameters
    sizes = written.routines[2].arguments
    arrays = {"y": y, "p": p, "t": np.zeros((1, 1)), "timed": np.zeros((written.timed, 1))}
    arrays["out"] = np.zeros((sizes["out"], count))
    with np.errstate(invalid="ignore"):
        for routine in written.routines:
            lanes = Lanes(arrays, count)
            lanes.carry_out(routine.block)
        expected = of.evaluate(of.model.free_accelerations, np.zeros(count), y[: 2 * n])
    good = lanes.status == 0
    assert 0.5 * count <= good.sum() < count
    assert set(lanes.status[~good]) <= {1 + block.index for block in of.topology.solved_blocks}
    assert np.array_equal(good, np.isfinite(expected[0]))
    assert np.array_equal(arrays["out"][: len(expected), good], expected[:, good])
