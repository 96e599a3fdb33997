import math

import numpy as np
import pytest
from generated_code import run_compiled
from hypothesis import assume, given
from hypothesis import strategies as st

from linkages.kernel.differentiation import Evaluator
from linkages.kernel.scalars import Level, ScalarGraph, reachable


@pytest.fixture
def x(graph):
    return graph.input("y", 0, Level.STATE)


@pytest.fixture
def z(graph):
    return graph.input("y", 1, Level.STATE)


def test_zeros_and_ones_fold_away(graph, x):
    assert x + 0.0 is x
    assert 0.0 + x is x
    assert x - 0.0 is x
    assert x * 1.0 is x
    assert x / 1.0 is x
    assert x - x is graph.zero
    assert x * 0.0 is graph.zero
    assert 0.0 / x is graph.zero
    assert (0.0 - x) is -x
    assert x * -1.0 is -x
    opposite = -x
    assert -opposite is x
    assert graph.number(-0.0) is graph.zero


def test_constants_are_computed(graph):
    two, three = graph.number(2), graph.number(3)
    found = [two + three, two - three, two * three, two / three, -two, graph.sqrt(two)]
    assert [f.constant for f in found] == [5, -1, 6, 2 / 3, -2, math.sqrt(2)]
    angles = [graph.sin(two), graph.cos(two), graph.apply("atan2", two, three)]
    assert [a.constant for a in angles] == [math.sin(2), math.cos(2), math.atan2(2, 3)]


def test_division_by_a_constant_zero_stays_for_run_time(graph, x):
    assert (x / 0.0).operation == "div"
    assert (graph.one / 0.0).operation == "div"


def test_signs_move_outwards(x, z):
    assert x + (-z) is x - z
    assert (-x) + z is z - x
    assert x - (-z) is x + z
    assert (-x) - z is -(x + z)
    assert (-x) * z is -(x * z)
    assert x * (-z) is -(x * z)
    assert (-x) / z is -(x / z)
    assert -(x - z) is z - x


def test_equal_operations_are_one_node(graph, x, z):
    assert x + z is z + x
    assert x * z is z * x
    assert (x + z) * 2.0 is (z + x) * 2.0
    assert x - z is not z - x
    assert graph.sin(x) is graph.sin(x)
    assert graph.input("y", 0, Level.STATE) is x
    before = len(graph.nodes)
    for _ in range(3):
        graph.sqrt(x * x + 1.0)
    assert len(graph.nodes) == before + 3


def test_level_is_the_highest_of_the_arguments(graph, x):
    p = graph.input("p", 0, Level.PARAMETERS)
    t = graph.input("t", 0, Level.TIME)
    assert graph.one.level == Level.CONSTANT
    assert (p * 2.0).level == Level.PARAMETERS
    assert graph.cos(p * t).level == Level.TIME
    assert (p * t + x).level == Level.STATE
    assert (x * 0.0 + p).level == Level.PARAMETERS


def test_total_adds_from_the_first_to_the_last(graph, x, z):
    assert graph.total([]) is graph.zero
    assert graph.total([x, z, x]) is (x + z) + x


def test_reachable_nodes_come_after_their_operands(graph, x, z):
    unused = x * 17.0
    root = graph.sin(x) / (graph.sqrt(z) + 2.0)
    nodes = reachable([root, x])
    assert unused not in nodes
    seen = set()
    for node in nodes:
        assert all(o.index in seen for o in node.operands)
        seen.add(node.index)
    assert nodes[-1] is root
    assert len(nodes) == len(seen)


def test_repr_says_what_it_is(x):
    assert repr(x * 2.0).endswith(": mul>")
    (x * 2.0).label = "twice"
    assert repr(x * 2.0) == "<twice: mul>"


def test_evaluator_broadcasts(graph, x, z):
    t = graph.input("t", 0, Level.TIME)
    times = np.linspace(0, 1, 5)
    total, number, plain = Evaluator([x * z + t, graph.number(3), x])(
        y=np.array([[2.0], [3.0]]), t=times[None]
    )
    assert total.tolist() == (6 + times).tolist()
    assert number == 3
    assert plain.tolist() == [2.0]


def test_evaluator_can_be_called_again(graph, x):
    evaluate = Evaluator([graph.sin(x), x, graph.sin(x) * 2.0])
    for value in (0.3, -1.2):
        found = [float(v) for v in evaluate(y=np.array([value]))]
        assert found == [np.sin(value), value, 2 * np.sin(value)]


def test_unreachable_positions_are_nan_without_warning(graph, x):
    root, quotient = Evaluator([graph.sqrt(x), graph.one / (x + 1.0)])(y=np.array([-1.0]))
    assert np.isnan(root)
    assert np.isinf(quotient)


# --- random expressions: the graph, its printed text and Python agree ---------------------------

LEAVES = ["y0", "y1", "y2", "p0", "t"]
BINARY = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
}


def expressions():
    numbers = st.sampled_from([0.0, 1.0, -1.0, 0.5, 2.0, -3.0, 1e-3])
    leaf = st.one_of(numbers, st.sampled_from(LEAVES))
    return st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(st.sampled_from([*BINARY]), inner, inner),
            st.tuples(st.sampled_from(["neg", "sin", "cos"]), inner),
            st.tuples(st.just("atan2"), inner, inner),
            st.tuples(st.just("hypot"), inner),
        ),
        max_leaves=25,
    )


def as_node(graph, expression):
    if isinstance(expression, float):
        return graph.number(expression)
    if isinstance(expression, str):
        name, index = expression[0], int(expression[1:] or 0)
        level = {"y": Level.STATE, "p": Level.PARAMETERS, "t": Level.TIME}[name]
        return graph.input(name, index, level)
    name, *arguments = expression
    nodes = [as_node(graph, a) for a in arguments]
    if name in BINARY:
        return BINARY[name](*nodes)
    if name == "neg":
        return -nodes[0]
    if name == "hypot":  # a square root that is always real
        return graph.sqrt(nodes[0] * nodes[0] + 1.0)
    if name == "atan2":  # never at x = ±0, whose sign the graph does not keep
        nodes[1] = graph.sqrt(nodes[1] * nodes[1] + 1.0)
    return graph.apply(name, *nodes)


def directly(expression, leaves):
    if isinstance(expression, float):
        return expression
    if isinstance(expression, str):
        return leaves[expression]
    name, *arguments = expression
    numbers = [directly(a, leaves) for a in arguments]
    if name in BINARY:
        return BINARY[name](*numbers)
    if name == "neg":
        return -numbers[0]
    if name == "hypot":
        return math.sqrt(numbers[0] * numbers[0] + 1.0)
    if name == "atan2":
        numbers[1] = math.sqrt(numbers[1] * numbers[1] + 1.0)
    return getattr(math, name)(*numbers)


@pytest.mark.slow
@given(
    st.lists(expressions(), min_size=1, max_size=4),
    st.lists(st.floats(-9, 9), min_size=5, max_size=5),
)
def test_evaluated_printed_and_direct_values_agree(wanted, numbers):
    leaves = dict(zip(LEAVES, numbers, strict=True))
    try:
        expected = [directly(e, leaves) for e in wanted]
    except (ZeroDivisionError, OverflowError, ValueError):
        assume(False)
    assume(all(math.isfinite(e) for e in expected))
    graph = ScalarGraph()
    try:
        roots = [as_node(graph, e) for e in wanted]
    except (ZeroDivisionError, OverflowError, ValueError):
        assume(False)  # a constant that is not finite
    y, p = [leaves["y0"], leaves["y1"], leaves["y2"]], [leaves["p0"]]
    found = Evaluator(roots)(y=np.array(y), p=np.array(p), t=np.array([leaves["t"]]))

    printed = run_compiled(roots, y=y, p=p, t=leaves["t"])  # the text that kernels are made of

    # moving signs and folding x − x, x·0 and x·1 are exact for finite numbers; bitwise therefore,
    # but NumPy's own sine and cosine may differ from the C library's in the last digit
    assert printed == expected
    if not any(name in repr(wanted) for name in ("sin", "cos", "atan2")):
        assert [float(value) for value in found] == expected


def test_evaluated_functions_are_those_of_numpy(graph, x, z):
    nodes = [graph.sin(x), graph.cos(x), graph.apply("atan2", x, z), graph.sqrt(z)]
    y = np.array([np.linspace(-9, 9, 50), np.linspace(0.1, 3, 50)])
    expected = [np.sin(y[0]), np.cos(y[0]), np.arctan2(y[0], y[1]), np.sqrt(y[1])]
    assert np.array_equal(Evaluator(nodes)(y=y), expected)
