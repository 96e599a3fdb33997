"""Steps for graphics processors: their rounding, and what a thread does, to the last bit."""

import ctypes
import re
import shutil
import subprocess

import numpy as np
import pytest

import linkages
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.ptx import WIDTH, link
from linkages.kernel.numbers.layout import Layout
from linkages.kernel.system import System
from linkages.solution.moving.plan import Plan, kernel_source
from linkages.solvers.integration import request
from linkages.solvers.methods.named import METHODS
from linkages.solvers.printed.device import (
    ARRAYS,
    GIVEN,
    KEPT,
    entries_of,
    lane_function,
    write_device_steps,
)
from linkages.solvers.printed.shape import Shape
from linkages.solvers.printed.step import write_step
from linkages.solvers.steps.views import ACTIVE, BEFORE, END, FIRST, FRAME, RTOL, SAMPLE, H, T

ADAPTIVE = ["tsit5", "dop853", "vern9"]
MOTIONS = 40  # one whole block of columns and a part of one
ROUNDED = re.compile(r"^\s*(?:@\S+\s+)?((?:add|sub|mul|div|fma|mad|rcp|sqrt)\.\S*f64)\s", re.M)


def parts(name, method, tangents=0):
    """A system, its flow, its kernel, and what its steps are made of."""
    of = System(linkages.load(name))
    flow = Plan.of(of, tangents=tangents).bind(of)
    layout = Layout.of(of.topology, tangents=tangents)
    routines = kernel_source(of.topology, layout).program.routines
    tableau, gain = METHODS[method].tableau, METHODS[method].memory
    return of, flow, routines, (tableau, Shape.of(flow)), gain


@pytest.mark.parametrize(
    ("name", "tangents", "method"),
    [("ninebar", 0, "vern9"), ("ninebar", 1, "tsit5"), ("andrews", 0, "dop853")],
)
def test_every_operation_says_how_it_rounds(name, tangents, method):
    _, _, routines, of, gain = parts(name, method, tangents)
    text = write_device_steps(*of, routines, gain)
    operations = ROUNDED.findall(text)
    assert len(operations) > 1000
    assert all(".rn" in operation for operation in operations)
    assert not re.findall(r"\.extern|\.approx|\.ftz", text)
    assert len(re.findall(r"\.visible \.entry advance_lanes\(", text)) == 1


@pytest.mark.skipif(not shutil.which("ptxas"), reason="needs NVIDIA's assembler")
def test_the_assembler_takes_it(tmp_path):
    """Without tangents nothing is spilled: a thread has 255 registers."""
    _, _, routines, of, gain = parts("ninebar", "dop853")
    path = tmp_path / "steps.ptx"
    path.write_text(write_device_steps(*of, routines, gain))
    command = ["ptxas", "-v", "-arch=sm_90", str(path), "-o", str(tmp_path / "code")]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    assert not any(int(number) for number in re.findall(r"(\d+) bytes spill", said)), said


def frame_of(system):
    """Addresses of a motion's arrays, by name."""
    words = (ctypes.c_int64 * len(FRAME)).from_address(system.frame)
    return dict(zip(FRAME, words, strict=True))


def view(address, entries):
    return np.ctypeslib.as_array((ctypes.c_double * entries).from_address(address))


def begun(of, flow, method, k):
    """A motion of its own start and first length, evaluated there."""
    start = of.state * (1 + 1e-3 * k)
    motion = (asked := request(flow, start, [10.0], start=0.0, method=method)).method.motion(
        asked.job
    )
    places, n = frame_of(motion.words[0]), flow.coordinates
    types = (ctypes.c_int64, *[ctypes.c_void_p] * 4)
    clock = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, *types[3:])(flow.clock)
    assert clock(0.0, places["parameters"], places["timed"]) == 0
    out = motion.rows[0, 2 * n :].ctypes.data
    arguments = (places["rows"], places["parameters"], places["timed"], out)
    assert ctypes.CFUNCTYPE(*types)(flow.rates)(*arguments) == 0
    pace = view(places["pace"], entries_of(Shape.of(flow))["pace"])
    pace[[END, SAMPLE]] = 10.0
    pace[[H, FIRST]] = 1e-4 * 1.1**k
    pace[[RTOL, BEFORE, ACTIVE]] = 1e-10, 1.0, 1.0
    return motion, places


@pytest.mark.parametrize("method", ADAPTIVE)
def test_what_a_thread_does_has_the_bits_of_single_motions(method):
    """Thirty trials each, on this processor."""
    of, flow, routines, made_of, gain = parts("ninebar", method)
    shape, ticks = Shape.of(flow), 30
    step = write_step(*made_of, gain)
    entries = entries_of(shape)
    motions = [begun(of, flow, method, k) for k in range(MOTIONS)]
    blocks = -(-MOTIONS // WIDTH)
    sizes = entries | {"p": len(flow.parameters)}
    columns = {name: np.zeros((blocks, max(1, size), WIDTH)) for name, size in sizes.items()}

    def column(name, k):
        return columns[name][k // WIDTH, : sizes[name], k % WIDTH]

    for k, (_, places) in enumerate(motions):
        for name in (*GIVEN, *KEPT):
            column(name, k)[:] = view(places[name], entries[name])
        column("p", k)[:] = view(places["parameters"], sizes["p"])
    found = np.zeros(blocks * WIDTH, dtype=np.int64)
    code = MachineCode(str(link([lane_function(*made_of, routines).text, step])))
    single = MachineCode(step)
    for k, (motion, places) in enumerate(motions):
        given = [*(columns[name].ctypes.data for name in ARRAYS[:-1]), found.ctypes.data]
        code.function("advance_lane")(*given, ticks, k)
        expected = single.function("advance")(motion.words[0].frame, ticks)
        assert found[k] == expected
        for name in KEPT:
            own = view(places[name], entries[name]).view(np.int64)
            first = T if name == "pace" else 0  # before are results of trials
            moved = np.ascontiguousarray(column(name, k)).view(np.int64)
            np.testing.assert_array_equal(moved[first:], own[first:], name)
    times = columns["pace"][0, T, :]
    assert len(np.unique(times)) == WIDTH
    assert times.min() > 1e-3
