import itertools

import pytest

from linkages.kernel.code.languages import Python
from linkages.kernel.code.statements import Entry, build_block
from linkages.kernel.scalars import Level, reachable, section

# such that every wrong association shows in the last digits
VALUES = [0.1, 0.7, 1e-3, 1e16, -3.3, 0.3]
NAMES = "abcdef"


@pytest.fixture
def leaves(graph):
    return [graph.input("y", i, Level.STATE) for i in range(6)]


def printed(root, *others):
    nodes = reachable([root, *others])
    known = {n.index: NAMES[n.arguments[1]] for n in nodes if n.operation == "input"}
    return Python(build_block(nodes, known)).text(root)


def lines(roots, known, checks=None):
    return Python(build_block(reachable(roots), known, roots, checks)).lines()


def test_no_more_parentheses_than_needed(graph, leaves):
    a, b, c, d, *_ = leaves
    cases = {
        "a + b * c": a + b * c,
        "c * (a + b)": (a + b) * c,  # factors in the order of the graph
        "a - (b - c)": a - (b - c),
        "a - b - c": (a - b) - c,
        "c + (a + b)": (a + b) + c,
        "a / (b * c)": a / (b * c),
        "a / b / c": (a / b) / c,
        "a * b / c": (a * b) / c,
        "-(a * b)": -(a * b),
        "-(a + b)": -(a + b),
        "-a": -a,
        "sqrt(a + b)": graph.sqrt(a + b),
        "sin(a) * cos(b)": graph.sin(a) * graph.cos(b),
        "atan2(a, b)": graph.apply("atan2", a, b),
        "2.0 - a": 2.0 - a,
        "sqrt(-a)": graph.sqrt(-a),
    }
    for text, node in cases.items():
        assert printed(node) == text
    assert printed(a / (b / (c / d))) == "a / (b / (c / d))"


def test_sums_keep_their_association(leaves):
    """Floating-point addition does not associate: a + (b + c) is not a + b + c.

    Commuting is harmless; the graph orders the operands of sums and products.
    """
    a, b, c, *_ = leaves
    left, right = (a + b) + c, a + (b + c)
    numbers = dict(zip(NAMES, [1e16, -1e16, 1.0, 0, 0, 0], strict=True))
    assert eval(printed(left), dict(numbers)) == 1.0
    assert eval(printed(right), dict(numbers)) == 0.0


OPERATIONS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}


@pytest.mark.slow_except("*-0", "[-+]/[*]-?")
@pytest.mark.parametrize("shape", range(5))
@pytest.mark.parametrize("signs", [*itertools.product(OPERATIONS, repeat=3)], ids="".join)
def test_bitwise_what_the_graph_says(shape, signs, leaves):
    """All five ways to bracket four operands, with all combinations of operators."""

    def value(a, b, c, d):
        f, g, h = (OPERATIONS[s] for s in signs)
        return (
            lambda: h(g(f(a, b), c), d),
            lambda: h(f(a, g(b, c)), d),
            lambda: g(f(a, b), h(c, d)),
            lambda: f(a, h(g(b, c), d)),
            lambda: f(a, g(b, h(c, d))),
        )[shape]()

    for numbers in itertools.permutations(VALUES, 4):
        text = printed(value(*leaves[:4]))
        found = eval(text, dict(zip(NAMES, [*numbers, 0, 0], strict=True)))
        assert found == value(*numbers), text


@pytest.mark.parametrize("constant", [-2.5, -0.1, 1e-300, 1e300, 0.1, 12345678.9])
def test_constants_keep_all_digits(constant, graph, leaves):
    a, b, *_ = leaves
    for build in (
        lambda x, y, k: x - k * y,
        lambda x, y, k: (k - x) * y,
        lambda x, y, k: k / (x * k) + y,
        lambda x, y, k: x - (k + y),
    ):
        text = printed(build(a, b, graph.number(constant)))
        scope = {"a": 0.7, "b": 0.3}
        assert eval(text, scope) == build(0.7, 0.3, constant), text


def test_what_is_used_twice_gets_a_variable(graph, leaves):
    a, b, *_ = leaves
    shared = graph.sqrt(a * b)
    root = shared * shared + shared
    found = lines([root], {a.index: "a", b.index: "b"})
    (name,) = [line.split(" = ")[0] for line in found if "sqrt" in line]
    assert found == [
        f"{name} = sqrt(a * b)",
        f"v{root.index} = {name} + {name} * {name}",
    ]


def test_labels_name_variables_and_never_twice(graph, leaves):
    a, b, *_ = leaves
    with section("first part"):
        first, second = graph.sin(a), graph.cos(b)
    first.label = second.label = "angle"
    with section("second part"):
        root = first * second
    root.label = "product"
    assert lines([first, second, root], {a.index: "a", b.index: "b"}) == [
        "",
        "# first part",
        "angle = sin(a)",
        f"angle_{second.index} = cos(b)",
        "",
        "# second part",
        f"product = angle * angle_{second.index}",
    ]


def test_checks_follow_their_value(graph, leaves):
    a, b, *_ = leaves
    radicand = a - b
    root = graph.sqrt(radicand)
    found = lines([root], {a.index: "a", b.index: "b"}, {radicand.index: 1})
    assert [line for line in found if line and not line.startswith("#")] == [
        f"v{radicand.index} = a - b",
        f"if not v{radicand.index} >= 0.0:",
        "    return 1",
        f"v{root.index} = sqrt(v{radicand.index})",
    ]


def test_known_values_are_not_computed_again(graph, leaves):
    a, *_ = leaves
    inner = graph.sin(a)
    root = inner * inner
    found = lines([root], {a.index: Entry("y", 0), inner.index: Entry("timed", 0)})
    assert found[-1] == f"v{root.index} = timed[0] * timed[0]"
    assert not any("sin" in line for line in found)
