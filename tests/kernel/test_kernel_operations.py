"""The table of operations: every row agrees with itself, and one more row is all that one more
function takes."""

import cmath
import math
from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from generated_code import run_compiled
from kernel_lanes import run_routines, states_of
from kernel_motion import call
from linkage_models import program, system_of, values

from linkages.benchmark.problem import expressions
from linkages.equations import derive, render
from linkages.errors import ComputationError
from linkages.kernel.code.cuda import MissingFunctionError, write_ptx
from linkages.kernel.code.program import bind_kernel, report_kernel
from linkages.kernel.differentiation import Evaluator, derivative
from linkages.kernel.scalars import Level, ScalarGraph
from linkages.operations import COMPOSITE, ELEMENTARY, OTHERS, Elementary, formula_functions
from linkages.spec.formulas import formula
from linkages.spec.grammar import NumberError

OPERANDS = (0.7, 0.4, 0.9)
"""Within the domain of every operation."""


def applied(name, *numbers):
    """An operation by Python's complex numbers, which know nothing of the table."""
    match name:
        case "atan2":
            return cmath.atan(numbers[0] / numbers[1])  # in the right half plane
        case "floor":
            return math.floor(numbers[0].real)
        case "select":
            return numbers[1]  # the condition is positive
    plain = {"add": lambda a, b: a + b, "sub": lambda a, b: a - b, "neg": lambda a: -a}
    plain |= {"mul": lambda a, b: a * b, "div": lambda a, b: a / b}
    return plain[name](*numbers) if name in plain else getattr(cmath, name)(*numbers)


@pytest.mark.parametrize("name", ELEMENTARY)
def test_values_and_derivatives_of_a_row(name):
    """Float, NumPy, printed text and SymPy; derivatives against complex steps."""
    row, numbers = ELEMENTARY[name], OPERANDS[: ELEMENTARY[name].arity]
    exact = applied(name, *map(complex, numbers)).real
    graph = ScalarGraph()
    nodes = [graph.input("y", i, Level.STATE) for i in range(row.arity)]
    node = graph.apply(name, *nodes)
    found = [row.value(*numbers), *Evaluator([node])(y=np.array(numbers))]
    found += run_compiled([node], y=numbers)
    if name != "select":  # SymPy has none of its own; `linkages.equations.expressions` makes it one
        found.append(float(row.among(sympy)(*map(sympy.Float, numbers))))
    assert [float(value) for value in found] == pytest.approx([exact] * len(found), rel=1e-15)

    step = 1e-30  # a complex step has no cancellation
    expected = []
    for k in range(row.arity):
        moved = [x + step * 1j * (k == i) for i, x in enumerate(numbers)]
        expected.append(complex(applied(name, *moved)).imag / step)
    (rates,) = derivative([node], nodes)
    assert [float(v) for v in Evaluator(rates)(y=np.array(numbers))] == pytest.approx(
        expected,
        rel=4e-15,  # a few roundings
    )
    partials = row.partials(graph.apply, node, *nodes)
    assert [float(v) for v in Evaluator(map(graph.lift, partials))(y=np.array(numbers))] == (
        pytest.approx(expected, rel=4e-15)
    )


@pytest.mark.parametrize("name", [n for n, row in ELEMENTARY.items() if row.periodic])
def test_what_repeats(name):
    value = ELEMENTARY[name].value
    assert value(0.7 + 2 * math.pi) == pytest.approx(value(0.7), rel=1e-14)


@pytest.mark.parametrize("name", COMPOSITE)
@pytest.mark.parametrize("first", [-0.8, 0.4, 1.7])
def test_composite_functions_are_what_they_expand_to(name, first):
    row, graph = COMPOSITE[name], ScalarGraph()
    numbers = (first, 3 if name == "power" else 0.6, 0.9)[: row.arity]
    nodes = [graph.input("y", i, Level.STATE) for i in range(row.arity)]
    operands = (nodes[0], numbers[1]) if name == "power" else nodes
    (found,) = Evaluator([row.expanded(graph.apply, *operands)])(y=np.array(numbers))
    assert float(found) == pytest.approx(row.value(*numbers), rel=1e-15)


# --- one more function --------------------------------------------------------------------------

ASINH = Elementary(
    "asinh", OTHERS, math.asinh, "arcsinh",
    lambda apply, _, x: (1.0 / apply("sqrt", 1.0 + x * x),), formula=True,
)  # fmt: skip
TIMES = np.array([0.0, 0.3, 1.7])
DRIVEN = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
drives: {rod: {law: 'asinh(2*t)'}}
"""
FREE = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 3}}
loads: [{bar: rod, torque: '4*asinh(t)'}]
free: {rod: {angle: 0.3, speed: 1}}
"""


@pytest.fixture
def one_more(monkeypatch):
    with pytest.raises(NumberError, match="unknown function 'asinh'"):
        formula("asinh(t)")
    monkeypatch.setitem(ELEMENTARY, "asinh", ASINH)


def exact_law():
    """asinh(2t) with its derivatives."""
    root = np.sqrt(1 + 4 * TIMES**2)
    return np.array([np.arcsinh(2 * TIMES), 2 / root, -8 * TIMES / root**3])


@pytest.mark.usefixtures("one_more")
def test_formulas_read_it_and_compute_with_it():
    assert "asinh" in formula_functions()
    assert formula("asinh(0.5)").tree.value == math.asinh(0.5)
    with pytest.raises(NumberError, match="'asinh' takes 1 argument, found 2"):
        formula("asinh(t, 1)")


@pytest.mark.usefixtures("one_more")
def test_the_graph_evaluates_differentiates_and_counts_it():
    of = system_of(DRIVEN)
    names = ("bar_angle", "bar_speed", "bar_acceleration")
    found = np.array([values(of, name, TIMES)[0] for name in names])
    assert found == pytest.approx(exact_law(), abs=1e-15)  # a few roundings
    counts = report_kernel(*(lambda of: (of.model, program(of)))(system_of(FREE))).counts
    assert [part["other functions"] for part in counts.values()] == [0, 1, 0]


@pytest.mark.usefixtures("one_more")
def test_equations_and_their_printed_module_have_it():
    equations = derive(system_of(DRIVEN).topology)
    assert "asinh(" in render(equations, "text")
    assert "asinh" in render(equations, "latex")
    module = {}
    exec(render(equations, "python"), module)
    functions = [module[f"drive{suffix}"] for suffix in ("s", "_rates", "_accelerations")]
    found = np.array([[function(time)[0] for time in TIMES] for function in functions])
    assert found == pytest.approx(exact_law(), abs=1e-15)


@pytest.mark.usefixtures("one_more")
def test_kernels_compile_it():
    """A rod of inertia ml²/3 = 1 about its end obeys q̈ = 4 asinh(t)."""
    of = system_of(FREE)
    kernel = bind_kernel(program(of), of.parameters)
    y = np.array([0.3, 1.0, 0.0])
    for time in TIMES.tolist():
        *statuses, out = call(kernel, time, y, 1)
        assert statuses == [0, 0]
        assert out[0] == pytest.approx(4 * math.asinh(time), rel=1e-14)
        (evaluated,) = of.evaluate(of.model.free_accelerations, time, y[:2])
        assert out[0] == pytest.approx(evaluated[0], rel=1e-14)


@pytest.mark.usefixtures("one_more")
def test_lanes_call_it_one_by_one_and_graphics_processors_do_not():
    of = system_of(FREE)
    written = program(of)
    given = states_of(of, written, 16)
    expected = run_routines(written.routines, given, 1)
    for lanes in (2, 16):
        run_routines(written.routines, given, lanes).assert_same_bits(expected)
    with pytest.raises(MissingFunctionError, match="kernels call asinh of the C library"):
        write_ptx(written.routines)


@pytest.mark.usefixtures("one_more")
def test_other_programs_compute_with_it():
    """Python's own functions in the place of a library's."""
    library = SimpleNamespace(**vars(math), expression=float, time=0.3)
    found = expressions(SimpleNamespace(system=system_of(FREE)), [0.3, 1.0], library)
    assert found == pytest.approx([4 * math.asinh(0.3)], rel=1e-14)
    absent = SimpleNamespace(**{**vars(library), "asinh": None})
    with pytest.raises(ComputationError, match="heyoka has no 'asinh'"):
        expressions(SimpleNamespace(system=system_of(FREE)), [0.3, 1.0], absent)
