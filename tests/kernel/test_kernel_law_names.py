"""Laws of time in compiled kernels, at random."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from linkage_models import system_of

from linkages.components.laws import function_of
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.inputs import law_values
from linkages.solution.plan import kernel_source
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


def assembled(law):
    """Machine code of a kernel; there is none if a value is used that nothing has given."""
    program = kernel_source(system_of(LOADED.replace("LAW", law)).topology).program
    return MachineCode(program.assembly)


@pytest.mark.parametrize("law", ["t", "-t", "max(t, t)", "min(-t, -t)", "t/1"])
def test_a_load_that_is_time_itself(law):
    """What depends on the state has no argument t: time comes to it as a value of the clock."""
    assert assembled(law).address("rates")


@pytest.mark.slow
@settings(max_examples=60)
@given(FORMULAS)
def test_any_law_of_time_compiles(law):
    try:
        function = function_of(formula(law), ())
    except NumberError:
        assume(False)
    assume(np.isfinite(law_values(function, np.zeros(1))).all())  # others are refused
    assert assembled(law).address("rates")


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
