"""Kernels for several lanes against the kernel for one state, to the last bit."""

import platform
from functools import cache

import llvmlite.binding as llvm
import numpy as np
import pytest
from kernel_lanes import run_routines, states_of
from lagrange_mechanisms import LAWS, MORE_MECHANISMS
from lagrange_states import analysed
from linkage_models import system, system_of
from shared_definitions import loaded_engine

from linkages.components.mechanisms.definition import from_document, load
from linkages.kernel.code import machine, writer
from linkages.kernel.code.program import write_functions_of
from linkages.kernel.inputs import definition_vector
from linkages.kernel.layout import Layout
from linkages.kernel.state_jumps import transition_nodes, write_jacobian
from linkages.kernel.system import System
from linkages.reading.document import parse, shipped
from linkages.solution.plan import kernel_source

LANES = (2, 4, 8, 16)
STATES = 64

PINS = ["O", *(f"P{k}" for k in range(10))]
CHAIN = "gravity: [0, -9.81]\njoints: {O: [0, 0]}\nbars:\n"
CHAIN += "".join(
    f"  b{k}: {{joints: [{PINS[k]}, {PINS[k + 1]}], length: 0.3, mass: {1 + 0.1 * k}}}\n"
    for k in range(10)
)
CHAIN += "free:\n"
CHAIN += "".join(f"  b{k}: {{angle: {0.2 * k}, speed: {0.1 * k}}}\n" for k in range(10))

CONTACTS = loaded_engine("""\
clearances:
  gap:
    {joint: A, bar: rod, size: 0.1 mm, contact: hunt-crossley-constant, stiffness: 2e9 N/m^1.5,
     dissipation: 1.5 s/m, carries: hole, pin_radius: 8 mm, friction: 0.05, slip: 10 mm/s}
  end:
    {joint: B, bar: rod, size: 0.05 mm, contact: flores, stiffness: 1e9, restitution: 0.5,
     carries: pin, pin_radius: 6 mm, friction: 0.1, slip: 20 mm/s, offset: [10 um, 0]}
stops: [{slider: piston, upper: 0.175, stiffness: 1e6, damping: 100}]
drives: {crank: {angle: 0, speed: 600 rpm}}
""")

SPLINE = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {cart: {position: 0.1, speed: 3}}
springs:
  - {slider: cart, positions: [0.05, 0.08, 0.12, 0.16], forces: [-9, -1, 3, 7],
     interpolation: spline}
loads:
  - slider: cart
    force: {table: {times: [0, 1, 2.5, 3], values: [1, 4, 2, 1], periodic: true}}
"""

LOADED = """
joints: {O: [0, 0]}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {cart: {position: 0.1, speed: 3}}
loads: [{slider: cart, force: LAW}]
"""


def _of(of: System, **layout):
    return of, kernel_source(of.topology, Layout.of(of.topology, **layout)).program


def _jacobian(of: System):
    source = kernel_source(of.topology)
    return of, write_jacobian(source.model, source.accelerations)


def _transitions(of: System):
    layout = Layout.of(of.topology, tangents=1)
    model = kernel_source(of.topology, layout).model
    return of, write_functions_of(model, transition_nodes(model, layout), "")


CASES = {
    **{name: lambda name=name: _of(System(load(name))) for name in shipped()},
    "chain of ten": lambda: _of(system_of(CHAIN)),
    "contacts and a stop": lambda: _of(system_of(CONTACTS)),
    "spline": lambda: _of(system_of(SPLINE)),
    **{
        f"law: {name}": lambda law=law: _of(system_of(LOADED.replace("LAW", law)))
        for name, law in LAWS.items()
        if name != "run-up"  # of drives
    },
    "tangents": lambda: _of(System(load("ninebar")), work=True, tangents=2),
    "tangents of contacts": lambda: _of(system_of(CONTACTS), tangents=1, counting=True),
    "Jacobian": lambda: _jacobian(System(load("ninebar"))),
    "what becomes of a state that touches": lambda: _transitions(system_of(CONTACTS)),
}


@cache
def case(name):
    """A program, states, and what the kernel for one state makes of them."""
    of, program = CASES[name]()
    given = states_of(of, program, STATES)
    return program, given, run_routines(program.routines, given, 1)


@pytest.mark.slow_except(
    "four-bar", "ninebar", "quick-return", "law: *", "spline", "Jacobian", "contacts*", "what*"
)
@pytest.mark.parametrize("name", CASES)
def test_lanes_have_the_bits_of_one_state(name):
    program, given, expected = case(name)
    assert not expected.status.all()
    for lanes in LANES:
        run_routines(program.routines, given, lanes).assert_same_bits(expected)


# one with redundant blocks takes ten seconds to be assembled
@pytest.mark.slow_except("cylinder-table", "planetary", "rack", "cam-free", "welded")
@pytest.mark.parametrize("name", [name for name in MORE_MECHANISMS if name != "pulled-table"])
def test_lanes_of_further_mechanisms(name):
    """At random states, most of which are near none that can be assembled."""
    mechanism = from_document(parse(MORE_MECHANISMS[name], "m.yaml"))
    topology = analysed(mechanism)
    program = kernel_source(topology).program
    random = np.random.default_rng(6)
    paths = kernel_source(topology).model.inputs.parameters
    numbers = definition_vector(topology.mechanism, tuple(paths))[:, None]
    coordinates = next(r for r in program.routines if r.name == "rates").arguments["y"]
    given = {
        "p": numbers * random.uniform(0.98, 1.02, (len(numbers), STATES)),
        "t": random.uniform(0, 3, (1, STATES)),
        "y": random.uniform(-2, 2, (max(1, coordinates), STATES)),
    }
    expected = run_routines(program.routines, given, 1)
    run_routines(program.routines, given, 8).assert_same_bits(expected)


@pytest.mark.parametrize(
    ("name", "numbers", "spread"),
    [
        # the rocker is out of reach of some states, see test_kernel_compiled
        ("clearance", {"bars.rocker.length": 0.4, "bars.crank.length": 0.4}, 1.0),
        # another block of the clock, at some times
        ("stephenson", {"bars.arm.length": 0.52}, 0.0),
    ],
)
def test_failing_lanes_amid_good_ones(name, numbers, spread):
    of = system(name, **numbers)
    program = kernel_source(of.topology).program
    given = states_of(of, program, STATES, spread)
    expected = run_routines(program.routines, given, 1)
    assert 1 < np.count_nonzero(expected.status) < STATES / 2
    for lanes in LANES:
        run_routines(program.routines, given, lanes).assert_same_bits(expected)


@pytest.mark.slow
def test_lanes_of_an_iteration_that_does_not_end():
    """Starts far from any solution, and nan: the others neither wait nor change."""
    program, given, _ = case("class-three")
    random = np.random.default_rng(5)
    far = given | {"y": given["y"].copy()}
    far["y"][:, ::3] += 3.0 * random.normal(size=far["y"][:, ::3].shape)
    far["y"][0, 7] = np.nan
    expected = run_routines(program.routines, far, 1)
    assert expected.status[7] == expected.status.max()
    assert 4 < np.count_nonzero(expected.status) < STATES / 2
    for lanes in LANES:
        run_routines(program.routines, far, lanes).assert_same_bits(expected)


@pytest.mark.slow_except(
    "four-bar", "quick-return", "class-three", "chain*", "law: formula", "spline", "contacts*"
)
@pytest.mark.parametrize("name", CASES)
def test_pieces_have_the_bits_of_one_function(name, monkeypatch):
    """Cut wherever that is possible, so that everything passes through memory."""
    program, given, expected = case(name)
    monkeypatch.setattr(writer, "MANY", 0)
    monkeypatch.setattr(writer, "LONGEST", 5)
    divisible = max(len(routine.block.statements) for routine in program.routines) > 2
    for lanes in (1, 4):
        assert (".1(" in writer.write_assembly(program.routines, lanes)) == divisible
        run_routines(program.routines, given, lanes).assert_same_bits(expected)


@pytest.mark.parametrize("lanes", [1, 4])
def test_a_state_that_fails_in_an_early_piece_keeps_its_status(lanes, monkeypatch):
    of = system("clearance", **{"bars.rocker.length": 0.4, "bars.crank.length": 0.4})
    program = kernel_source(of.topology).program
    given = states_of(of, program, STATES, 1.0)
    expected = run_routines(program.routines, given, 1)
    assert 1 < np.count_nonzero(expected.status) < STATES / 2
    monkeypatch.setattr(writer, "MANY", 0)
    monkeypatch.setattr(writer, "LONGEST", 5)
    run_routines(program.routines, given, lanes).assert_same_bits(expected)


FAMILY = platform.machine().lower() in ("x86_64", "amd64")
"""Processors whose instruction sets the tests below name."""
TELLING = ("ninebar", "spline", "law: formula", "tangents of contacts")


@pytest.mark.slow_except("*-spline", "x86-64-v3-law*")
@pytest.mark.skipif(not FAMILY, reason="names processors of another family")
@pytest.mark.parametrize("name", TELLING)
@pytest.mark.parametrize("processor", ["x86-64", "x86-64-v2", "x86-64-v3"])
def test_bits_do_not_depend_on_the_instruction_set(name, processor, monkeypatch):
    program, given, expected = case(name)
    monkeypatch.setattr(machine, "_host", lambda: (processor, processor, ""))
    for lanes in (1, 4, 16):
        run_routines(program.routines, given, lanes).assert_same_bits(expected)


@pytest.mark.slow_except("0-*", "3-spline")
@pytest.mark.parametrize("name", TELLING)
@pytest.mark.parametrize("level", [0, 1, 3])
def test_bits_do_not_depend_on_the_optimiser(name, level, monkeypatch):
    program, given, expected = case(name)

    usual = machine._compiled

    def compiled(text: str) -> bytes:
        """Through all passes of a level, which kernels are not."""
        heading = usual(text).split(b"\n", 2)[:2]
        target = llvm.Target.from_default_triple().create_target_machine(
            cpu=llvm.get_host_cpu_name(),
            features=llvm.get_host_cpu_features().flatten(),
            opt=level,
            jit=True,
        )
        module = llvm.parse_assembly(text)
        builder = llvm.create_pass_builder(target, llvm.create_pipeline_tuning_options(level))
        builder.getModulePassManager().run(module, builder)
        return b"\n".join([*heading, bytes(target.emit_object(module))])

    monkeypatch.setattr(machine, "_compiled", compiled)
    monkeypatch.setattr(machine, "kept", lambda _key, _suffix, make: (make(), False))
    for lanes in (1, 8):
        run_routines(program.routines, given, lanes).assert_same_bits(expected)
