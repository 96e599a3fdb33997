"""Laws of time as nodes: values and derivatives against SymPy and SciPy."""

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st
from kernel_motion import difference
from linkage_models import system_of, values
from scipy.interpolate import CubicSpline, PchipInterpolator

from linkages.components.contributed.functions import Number, Operation, Table, Time, constant
from linkages.components.contributed.terms import Parameter
from linkages.kernel.differentiation import Evaluator
from linkages.kernel.inputs import Inputs, law_of, law_values, numbers_in, table_numbers, value_of
from linkages.kernel.scalars import Level, ScalarGraph

TIMES = np.array([0.05, 0.4, 1.3, 2.2])


def driven(law):
    return system_of(
        f"joints: {{O: [0, 0]}}\nbars: {{rod: {{joints: [O, P], length: 1}}}}\n"
        f"drives: {{rod: {{law: {law}}}}}\n"
    )


def motion_values(law, times=TIMES):
    """Value, rate and acceleration of the law of a drive, shape (3, times)."""
    of = driven(law)
    names = ("bar_angle", "bar_speed", "bar_acceleration")
    return np.array([values(of, name, times)[0] for name in names])


FORMULAS = [
    "0.3 + 2*t",
    "1.5",
    "-t**3 + t**2/4",
    "sin(3*t)*cos(t)",
    "tan(0.3*t)",
    "exp(-t)*(1 - t)",
    "log(1 + t)",
    "sqrt(1 + t**2)",
    "tanh(2*t - 1)",
    "1/(1 + t**4)",
    "3*(t - 1)**5 - 2*t",
    "exp(-t)*sin(4*t)/(2 + cos(t))",
]


@pytest.mark.parametrize("text", FORMULAS)
def test_formulas_against_symbolic_derivatives(text):
    t = sympy.Symbol("t")
    symbolic = sympy.sympify(text, locals={"t": t})
    exact = [
        [float(symbolic.diff(t, order).subs(t, time).evalf(30)) for time in TIMES]
        for order in range(3)
    ]
    found = motion_values(f"'{text}'")
    # a dozen operations; polynomials of degree 5 lose two digits where terms cancel
    assert found == pytest.approx(np.array(exact), rel=1e-13, abs=1e-13)


def test_the_arctangent_of_a_law():
    """Named laws may use it; formulas do not."""
    graph = ScalarGraph()
    inputs = Inputs(graph, 0)
    law = law_of(Operation("atan", (Operation("mul", (constant(2.0), Time())),)), inputs)
    found = np.array(Evaluator([law.value, law.rate, law.acceleration])(t=TIMES[None], p=[]))
    rate = 2 / (1 + 4 * TIMES**2)
    assert found == pytest.approx(np.array([np.arctan(2 * TIMES), rate, -4 * TIMES * rate**2]))


@pytest.mark.parametrize("exponent", [*range(2, 12), -1, -3])
def test_whole_powers(exponent):
    graph = ScalarGraph()
    inputs = Inputs(graph, 0)
    law = law_of(Operation("power", (Time(), constant(float(exponent)))), inputs)
    nodes = [law.value, law.rate, law.acceleration]
    found = [np.broadcast_to(v, TIMES.shape) for v in Evaluator(nodes)(t=TIMES[None], p=[])]
    exact = [
        TIMES**exponent,
        exponent * TIMES ** (exponent - 1.0),
        exponent * (exponent - 1) * TIMES ** (exponent - 2.0),
    ]
    assert np.array(found) == pytest.approx(
        np.array(exact), rel=1e-13
    )  # as many roundings as factors
    assert sum(node.operation == "mul" for node in graph.nodes) < 40


def test_harmonic_law():
    of = motion_values("{harmonic: {amplitude: 0.4, frequency: 0.5, phase: 0.2, mean: 0.1}}")
    w = np.pi
    s, c = np.sin(w * TIMES + 0.2), np.cos(w * TIMES + 0.2)
    assert of == pytest.approx(np.array([0.1 + 0.4 * s, 0.4 * w * c, -0.4 * w * w * s]), abs=1e-14)


@pytest.mark.parametrize("periodic", [False, True])
def test_tables(periodic):
    times, numbers = [0.0, 0.7, 1.0, 2.0], [0.0, 0.5, 0.2, 0.0]
    found = motion_values(
        f"{{table: {{times: {times}, values: {numbers}, periodic: {str(periodic).lower()}}}}}"
    )
    exact = CubicSpline(times, numbers, bc_type="periodic" if periodic else "natural")
    where = TIMES % 2.0 if periodic else np.minimum(TIMES, 2.0)
    inside = periodic | (TIMES <= 2.0)
    outside = np.where(inside, 0.0, TIMES - 2.0)
    expected = [exact(where) + outside * exact(where, 1), exact(where, 1), exact(where, 2)]
    expected[2] = np.where(inside, expected[2], 0.0)
    assert found == pytest.approx(np.array(expected), abs=1e-13)


def test_numbers_of_a_table_stand_together():
    """Knots, then four coefficients for each interval: in the order in which kernels read them."""
    table = Table((), (0.0, 1.0, 3.0), (2.0, 0.0, 5.0))
    numbers = table_numbers(table)
    assert numbers[:3] == [0.0, 1.0, 3.0]
    assert len(numbers) == 3 + 4 * 2
    exact = CubicSpline(table.places, table.values, bc_type="natural")
    assert numbers[3:7] == exact.c[:, 0].tolist()
    assert numbers[7:] == exact.c[:, 1].tolist()


KNOTS, LEVELS = (0.25, 0.7, 1.0, 2.0), (1.0, 3.0, 2.5, 1.0)
WHERE = np.array([-4.0, 0.1, 0.25, 0.3, 0.7, 0.95, 1.0, 1.6, 1.99, 2.0, 2.4, 3.7])


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("held", [False, True])
def test_linear_tables(periodic, held):
    """Against NumPy's straight lines; beyond the ends the slope stays, or the value."""
    found = law_values(Table((), KNOTS, LEVELS, periodic, "linear", held), WHERE)
    if periodic:
        expected = np.interp(KNOTS[0] + np.mod(WHERE - KNOTS[0], 1.75), KNOTS, LEVELS)
    else:
        expected = np.interp(WHERE, KNOTS, LEVELS)
        if not held:
            first, last = 2.0 / 0.45, -1.5
            expected = expected + first * np.minimum(WHERE - KNOTS[0], 0)
            expected = expected + last * np.maximum(WHERE - KNOTS[-1], 0)
    # numbers of order 10; the remainder of a division loses a digit
    assert found == pytest.approx(expected, abs=1e-13)


def nodes_of(function):
    """The nodes of a function of time, and its numbers."""
    given = dict(numbers_in(function))
    return law_of(function, Inputs(ScalarGraph(), 0, given)), np.array(list(given.values()))


@pytest.mark.parametrize("held", [False, True])
def test_monotone_tables_are_those_of_scipy(held):
    table = Table((), KNOTS, LEVELS, False, "pchip", held)
    law, numbers = nodes_of(table)
    found = Evaluator([law.value, law.rate, law.acceleration])(t=WHERE[None], p=numbers)
    exact = PchipInterpolator(KNOTS, LEVELS)
    inner, steady = np.clip(WHERE, KNOTS[0], KNOTS[-1]), np.zeros(len(WHERE))
    outside = inner != WHERE
    slope = np.where(outside & held, steady, exact(inner, 1))
    slope[KNOTS[-1] == WHERE] *= not held  # there the constant part begins
    bend = np.where(outside | (held & (KNOTS[-1] == WHERE)), steady, exact(inner, 2))
    assert found[0] == pytest.approx(exact(inner) + slope * (WHERE - inner), abs=1e-13)
    assert found[1] == pytest.approx(slope, abs=1e-13)
    assert found[2] == pytest.approx(bend, abs=1e-12)


@settings(max_examples=60)
@given(
    st.lists(st.tuples(st.floats(0.01, 1), st.floats(-1e3, 1e3)), min_size=3, max_size=8),
    st.booleans(),
    st.floats(-20, 20),
)
def test_monotone_tables_stay_within_neighbouring_values(points, periodic, time):
    """At any time, the seam of a periodic one and the times outside included."""
    times = tuple(np.cumsum([step for step, _ in points]).tolist())
    values = tuple(value for _, value in points)
    values = (*values[:-1], values[0]) if periodic else values
    table = Table((), times, values, periodic, "pchip", held=True)
    inside = times[0] + (time - times[0]) % (times[-1] - times[0]) if periodic else time
    later = int(np.clip(np.searchsorted(times, inside), 1, len(times) - 1))
    beside = values[later - 1], values[later]
    if not periodic:
        beside = values[:1] if time < times[0] else values[-1:] if time > times[-1] else beside
    (found,) = law_values(table, np.array([time]))
    slack = 1e-12 * max(map(abs, values))  # a few roundings
    # at a knot round-off of the remainder may fall into the other interval
    if min(abs(inside - knot) for knot in times) > 1e-9:
        assert min(beside) - slack <= found <= max(beside) + slack


def test_a_periodic_monotone_table_has_no_corner_at_its_seam():
    """The same points with the seam elsewhere are the same function."""
    times, values = (0.0, 0.4, 1.0, 1.7, 2.0), (0.0, 1.0, 2.0, 0.5, 0.0)
    moved = (0.4, 1.0, 1.7, 2.0, 2.4), (1.0, 2.0, 0.5, 0.0, 1.0)
    one, other = (Table((), *points, True, "pchip") for points in ((times, values), moved))
    where = np.linspace(-3.0, 5.0, 401)
    assert law_values(one, where) == pytest.approx(law_values(other, where), abs=1e-13)
    law, numbers = nodes_of(one)
    (slopes,) = Evaluator([law.rate])(t=np.array([[2.0 - 1e-9, 2.0 + 1e-9]]), p=numbers)
    # the second derivative, below 20, moves it by less than 4e-8
    assert slopes[0] == pytest.approx(slopes[1], abs=1e-7)


RISE = "{rise: PROFILE, to: 1.2, begin: 0.5, duration: 0.8}"


@pytest.mark.parametrize("profile", ["cycloidal", "polynomial", "modified-sine"])
def test_a_rise_begins_and_ends_at_rest(profile):
    """Rates are derivatives of values also where the branches of the law meet."""
    law = RISE.replace("PROFILE", profile)
    found = motion_values(law, np.array([0.0, 0.5, 1.3, 2.0]))
    assert found == pytest.approx(np.array([[0, 0, 1.2, 1.2], [0] * 4, [0] * 4]), abs=1e-12)
    of = driven(law)
    for time in (0.56, 0.9, 1.25):
        for name, other in (("bar_angle", "bar_speed"), ("bar_speed", "bar_acceleration")):
            slope = difference(lambda h, n=name, t=time: values(of, n, t + h)[0, 0], 5e-3)
            assert values(of, other, time)[0, 0] == pytest.approx(slope, abs=1e-8)


def test_numbers_of_formulas_are_structure_and_those_of_drives_are_not():
    path = ("drives", "rod", "speed")
    inputs = Inputs(ScalarGraph(), 0, [path])
    fixed = value_of(Number(Parameter((), 2.5)), inputs)
    assert fixed.constant == 2.5
    given = value_of(Number(Parameter(path, 2.5)), inputs)
    assert given.level == Level.PARAMETERS
    assert given.arguments == ("p", 0)


def test_a_law_that_is_none():
    with pytest.raises(ValueError, match="no elementary operation 'sine'"):
        value_of(Operation("sine", (Time(),)), Inputs(ScalarGraph(), 0))
