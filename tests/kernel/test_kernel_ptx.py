"""Code for graphics processors: its rounding, what it calls, and its bits."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from kernel_lanes import run_routines, states_of
from linkage_models import system_of
from stand_in_driver import THERE, installed

from linkages.components.mechanisms.definition import load
from linkages.kernel.code.cuda import WIDTH, Device, DeviceError, write_ptx
from linkages.kernel.system import System
from linkages.reading.document import shipped
from linkages.solution.plan import kernel_source

STATES = 70  # two whole warps and a part of one
FLOATING = re.compile(
    r"^\s*(?:@\S+\s+)?((?:add|sub|mul|div|fma|mad|rcp|sqrt|cvt)\.\S*f64\S*)\s", re.M
)
LOADED = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {cart: {position: 0.1, speed: 3}}
loads: [{slider: cart, force: LAW}]
"""
LAWS = {
    "table": "{table: {times: [0, 1, 2.5, 3], values: [1, 4, 2, 1], periodic: true}}",
    "formula": "exp(-t)*tanh(cart.velocity) + log(3 + t)*atan(cart.position) + tan(sin(t))",
}


def program_of(of):
    return kernel_source(of.topology).program


def named(name):
    return system_of(LOADED.replace("LAW", LAWS[name])) if name in LAWS else System(load(name))


def blocks_of(values):
    """Columns in blocks of rows, as the kernels have them; the last block is filled with zeros."""
    rows, count = values.shape
    blocks = -(-count // WIDTH)
    filled = np.zeros((rows, blocks * WIDTH))
    filled[:, :count] = values
    return np.ascontiguousarray(filled.reshape(rows, blocks, WIDTH).transpose(1, 0, 2))


def columns_of(blocks, count):
    return blocks.transpose(1, 0, 2).reshape(blocks.shape[1], -1)[:, :count]


def arrays_for(program, given):
    """All arrays of a program, in blocks."""
    sizes = {name: size for r in program.routines for name, size in r.arguments.items()}
    arrays = {name: np.zeros((max(1, size), STATES)) for name, size in sizes.items()}
    for name, values in given.items():
        arrays[name][: len(values)] = values
    return {name: blocks_of(values) for name, values in arrays.items()}


def assert_bits_of_one_state(program, given, arrays, status):
    expected = run_routines(program.routines, given, 1)
    assert (expected.status == 0).any()
    np.testing.assert_array_equal(status, expected.status)
    good = status == 0
    for name in ("p", "timed", "out"):
        found = columns_of(arrays[name], STATES)[:, good]
        np.testing.assert_array_equal(found, expected.arrays[name][:, good], name)


@pytest.mark.slow_except("four-bar", "ninebar", "slider-crank-contact")
@pytest.mark.parametrize("name", [*shipped(), "table", "formula"])
def test_every_operation_says_how_it_rounds(name):
    program = program_of(named(name))
    text = write_ptx(program.routines)
    operations = FLOATING.findall(text)
    assert ("fma.rn.f64" in operations) == ("llvm.fma" in program.assembly)
    # others would be contracted by the driver; whole numbers and floors are exact
    unsure = [o for o in operations if not re.search(r"\.(rn|rni|rmi)(\.|$)", o)]
    assert not unsure
    assert not re.findall(r"\.extern|\.approx|\.ftz", text)
    assert len(re.findall(r"\.visible \.entry (?:prepare|clock|rates)_lanes\(", text)) == 3


@pytest.mark.skipif(not shutil.which("ptxas"), reason="needs NVIDIA's assembler")
def test_the_assembler_takes_it(tmp_path):
    path = tmp_path / "ninebar.ptx"
    path.write_text(write_ptx(program_of(System(load("ninebar"))).routines))
    command = ["ptxas", "-v", "-arch=sm_90", str(path), "-o", str(tmp_path / "code")]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stderr
    used = [int(number) for number in re.findall(r"Used (\d+) registers", said)]
    spilled = [int(number) for number in re.findall(r"(\d+) bytes spill", said)]
    assert len(used) == 3
    assert max(used) < 255, said  # all that a thread may have
    assert not any(spilled), said


@pytest.mark.parametrize("name", ["ninebar", "class-three", *LAWS])
def test_a_graphics_processor_has_the_same_bits(name, monkeypatch):
    """Where there is none, what threads do is done here: copies and arguments are the same."""
    of = named(name)
    program = program_of(of)
    given = states_of(of, program, STATES)
    arrays = arrays_for(program, given)
    status = np.zeros(STATES, dtype=np.int64)
    driver = installed(monkeypatch)
    with Device() as device:
        text = write_ptx(program.routines, device.architecture)
        places = {name: device.reserve(values.nbytes) for name, values in arrays.items()}
        for array, values in arrays.items():
            device.put(values, places[array])
        for routine in program.routines:
            ended = np.full(STATES, -1, dtype=np.int64)
            place = device.reserve(ended.nbytes)
            kernel = device.load(text, f"{routine.name}_lanes")
            kernel.run([*(places[a] for a in routine.arguments), place], STATES)
            device.get(place, ended)
            device.release([place])
            status = np.where(status, status, ended)
        for array, values in arrays.items():
            device.get(places[array], values)
    assert_bits_of_one_state(program, given, arrays, status)
    assert not driver.memory
    assert not driver.contexts


@pytest.mark.skipif(THERE, reason="there is a graphics processor")
def test_a_machine_without_one_says_so():
    with pytest.raises(DeviceError, match=r"no driver .* was found|refused cuInit|knows no"):
        Device()


def test_what_the_driver_refuses(monkeypatch):
    driver = installed(monkeypatch)
    message = r"refused cuModuleLoadDataEx \(218\): a PTX JIT compilation failed\nptxas"
    text = ".version 7.0\n.target sm_80\n.address_size 64\nnonsense\n"
    with Device() as device, pytest.raises(DeviceError, match=message):
        device.load(text, "rates_lanes")
    assert not driver.contexts


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ({"devices": 0}, "knows no graphics processor"),
        ({"capability": (5, 2)}, r"Stand-in has compute capability 5\.2; expected 6\.0"),
    ],
)
def test_what_is_no_device_for_linkages(properties, message, monkeypatch):
    driver = installed(monkeypatch, **properties)
    with pytest.raises(DeviceError, match=message):
        Device()
    assert not driver.contexts


@pytest.mark.parametrize(("capability", "architecture"), [((6, 1), "sm_61"), ((12, 0), "sm_80")])
def test_code_is_for_the_processor_or_an_older_one(capability, architecture, monkeypatch):
    installed(monkeypatch, capability=capability)
    with Device() as device:
        assert device.architecture == architecture
