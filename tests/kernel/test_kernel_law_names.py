"""Laws of time in printed kernels, at random: every name is known."""

import ast
import builtins

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from linkage_models import system_of

from linkages.components.laws.law import function_of
from linkages.kernel.numbers.laws import law_values
from linkages.solution.moving.plan import kernel_source
from linkages.spec.formulas import formula
from linkages.spec.grammar import NumberError

LEAVES = st.sampled_from(["t", "0", "1", "2.5", "0*t", "t-t", "-t", "t/t"])
FORMULAS = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.tuples(st.sampled_from("+-*/"), inner, inner).map(lambda p: f"({p[1]}){p[0]}({p[2]})"),
        st.tuples(
            st.sampled_from(["sin", "exp", "log", "sqrt", "tanh", "atan", "abs", "-"]), inner
        ).map(lambda p: f"{p[0]}({p[1]})"),
        st.tuples(st.sampled_from(["min", "max"]), inner, inner).map(
            lambda p: f"{p[0]}({p[1]}, {p[2]})"
        ),
        st.tuples(inner, st.sampled_from([2, 3, 100])).map(lambda p: f"({p[0]})**{p[1]}"),
    ),
    max_leaves=6,
)

LOADED = """
joints: {O: [0, 0]}
bars: {a: {joints: [O, A], length: 1, mass: 1}}
free: {a: {angle: 0.3, speed: 0}}
loads: [{joint: A, force: ['1 + 0*t', 'LAW']}]
"""


def unknown_names(text):
    """Names in the functions of a module that nothing there defines."""
    tree = ast.parse(text)
    known = set(dir(builtins)) | {
        name.asname or name.name
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for name in node.names
    }
    known |= {node.id for part in tree.body for node in _names(part, ast.Store)}
    functions = [part for part in tree.body if isinstance(part, ast.FunctionDef)]
    known |= {function.name for function in functions}
    return {
        node.id
        for function in functions
        for node in _names(ast.Module(function.body, []), ast.Load)
        if node.id not in known
        and node.id not in {argument.arg for argument in function.args.args}
        and node.id not in {stored.id for stored in _names(function, ast.Store)}
    }


def _names(tree, context):
    return [n for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, context)]


def printed(law):
    return kernel_source(system_of(LOADED.replace("LAW", law)).topology).program.text


@pytest.mark.parametrize("law", ["t", "-t", "max(t, t)", "min(-t, -t)", "t/1"])
def test_a_load_that_is_time_itself(law):
    """What depends on the state has no argument t: time comes to it as a value of the clock."""
    assert not unknown_names(printed(law))


@settings(max_examples=60)
@given(FORMULAS)
def test_all_names_of_a_kernel_are_known(law):
    try:
        function = function_of(formula(law), ())
    except NumberError:
        assume(False)
    assume(np.isfinite(law_values(function, np.zeros(1))).all())  # others are refused
    assert not unknown_names(printed(law))


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        ("log(t-t)", -np.inf),
        ("1/(t-t)", np.inf),
        ("exp(exp(exp(exp(exp(t-t)))))", np.inf),
        ("exp(exp(exp(t-t)))**100*exp(exp(exp(t-t)))**100*exp(exp(exp(t-t)))**100", np.inf),
        ("sqrt((t-t) - exp(t-t))", np.nan),
    ],
)
def test_constant_parts_without_a_finite_value_stay_operations(law, expected):
    """As NumPy and the compiled kernel have them: no text of a kernel stands for inf or nan."""
    (found,) = law_values(function_of(formula(law), ("loads", 0)), np.zeros(1))
    np.testing.assert_equal(found, expected)
