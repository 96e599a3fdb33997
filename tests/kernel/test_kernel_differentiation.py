"""Rules of differentiation against complex steps, differences and closed forms."""

import cmath

import numpy as np
import pytest
from kernel_motion import difference
from scipy.interpolate import CubicSpline

from linkages.components.contributed.functions import Table
from linkages.kernel.differentiation import Evaluator, Iteration, derivative
from linkages.kernel.inputs import table_numbers
from linkages.kernel.scalars import Level
from linkages.operations import ELEMENTARY

X, Z = 0.7, 1.3
TINY = 1e-30
"""A complex step has no cancellation: Im f(x + ih)/h is exact to h²."""


def evaluated(nodes, *numbers):
    return [float(v) for v in Evaluator(nodes)(y=np.array(numbers))]


SMOOTH = [name for name, row in ELEMENTARY.items() if row.formula and row.arity == 1]


@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("point", [0.2, 0.7, 1.4])
def test_functions_by_complex_steps(graph, inputs, name, point):
    x, z = inputs
    ((dx, dz),) = derivative([graph.apply(name, x * z)], [x, z])
    f = getattr(cmath, name)
    point = point / 3 if name in ("asin", "acos") else point  # within their domain
    found = evaluated([dx, dz], point, Z)
    exact = [
        f((point + 1j * TINY) * Z).imag / TINY,
        f(point * (Z + 1j * TINY)).imag / TINY,
    ]
    assert found == pytest.approx(exact, rel=2e-15)  # a few roundings


@pytest.mark.parametrize("name", SMOOTH)
def test_second_derivatives_of_functions(graph, inputs, name):
    x = inputs[0]
    ((first,),) = derivative([graph.apply(name, x)], [x])
    ((second,),) = derivative([first], [x])
    (found,) = evaluated([second], X, 0.0)
    f = getattr(cmath, name)
    # a complex step of a difference quotient: Re f(x + ih) = f − h² f''/2, to h⁴
    h = 1e-3
    quarters = [2 * (f(X).real - f(X + 1j * s).real) / s**2 for s in (h, h / 2)]
    assert found == pytest.approx((4 * quarters[1] - quarters[0]) / 3, abs=2e-8)  # 1e-16/h²


def test_floor_is_flat(graph, inputs):
    x = inputs[0]
    assert derivative([graph.apply("floor", x * 3.0)], [x]) == [[graph.zero]]
    ((found,),) = derivative([graph.apply("floor", x) * x], [x])
    assert evaluated([found], 2.5, 0.0) == [2.0]


@pytest.mark.parametrize(("condition", "expected"), [(1.0, [3.0, 0.0]), (-1.0, [0.0, 2 * Z])])
def test_select_differentiates_what_it_takes(graph, inputs, condition, expected):
    x, z = inputs
    chosen = graph.select(graph.input("p", 0, Level.PARAMETERS), 3.0 * x, z * z)
    (row,) = derivative([chosen], [x, z])
    found = Evaluator(row)(y=np.array([X, Z]), p=np.array([condition]))
    assert [float(v) for v in found] == pytest.approx(expected, rel=1e-15)


def test_the_condition_of_a_select_does_not_count(graph, inputs):
    """A jump has no derivative; on both sides of it the branches have theirs."""
    x, z = inputs
    ((dx, dz),) = derivative([graph.select(x, x * z, x + z)], [x, z])
    assert evaluated([dx, dz], X, Z) == [Z, X]
    assert evaluated([dx, dz], -X, Z) == [1.0, 1.0]


@pytest.mark.parametrize("size", [1, 2, 3, 5])
def test_linear_systems(graph, size):
    """x' = A⁻¹(b' − A'x), against differences of numpy.linalg.solve."""
    random = np.random.default_rng(size)
    x = graph.input("y", 0, Level.STATE)
    constant, slope = random.normal(size=(2, size * size + size))
    constant[: size * size] += 4 * np.eye(size).ravel()  # well conditioned
    entries = [graph.sin(x * float(a)) + float(b) for a, b in zip(slope, constant, strict=True)]
    matrix = [entries[size * i : size * (i + 1)] for i in range(size)]
    solution = graph.solve(matrix, entries[size * size :])
    found = evaluated([row[0] for row in derivative(solution, [x])], X)

    def exact(shift):
        numbers = np.sin((X + shift) * slope) + constant
        return np.linalg.solve(numbers[:-size].reshape(size, size), numbers[-size:])

    assert found == pytest.approx(difference(exact, 3e-3), rel=1e-10, abs=1e-10)  # eighth order


def test_second_derivatives_of_linear_systems(graph, inputs):
    """The 1×1 system z/x by its closed form."""
    x, z = inputs
    (quotient,) = graph.solve([[x]], [z])
    (row,) = derivative([quotient], inputs)
    (dxx, dxz), (dzx, dzz) = derivative(row, inputs)
    found = evaluated([dxx, dxz, dzx, dzz], X, Z)
    assert found == pytest.approx([2 * Z / X**3, -1 / X**2, -1 / X**2, 0.0], rel=1e-14)


def test_a_determinant_has_no_rule(graph, inputs):
    """Nothing needs it; it must not be zero silently."""
    x, z = inputs
    with pytest.raises(IndexError):
        derivative([graph.determinant([[x, z], [z, x]])], inputs)


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("point", [0.05, 0.5, 2.0])
def test_splines(graph, periodic, point):
    times, numbers = (0.0, 0.3, 1.0, 2.5), (1.0, -0.5, 0.7, 1.0)
    time = graph.input("t", 0, Level.TIME)
    value = graph.spline(time * time, 0, 3, periodic)[0]
    ((first,),) = derivative([value], [time])
    ((second,),) = derivative([first], [time])
    p = np.array(table_numbers(Table((), times, numbers, periodic)))
    found = [float(v[0]) for v in Evaluator([first, second])(t=np.array([[point**0.5]]), p=p)]
    exact = CubicSpline(times, numbers, bc_type="periodic" if periodic else "natural")
    t = point**0.5
    chained = [2 * t * exact(point, 1), 2 * exact(point, 1) + 4 * t * t * exact(point, 2)]
    assert found == pytest.approx(chained, rel=1e-12)


def test_the_third_derivative_of_a_spline_has_no_rule(graph):
    time = graph.input("t", 0, Level.TIME)
    with pytest.raises(IndexError):
        derivative([graph.spline(time, 0, 3, False)[2]], [time])


def test_an_iteration_and_the_step_behind_it(graph, inputs):
    """z = √x by Newton's iteration from y1; only the step behind it has the derivative."""
    x, start = inputs
    z = graph.input("z", 0, Level.STATE)
    iteration = Iteration((z,), ((x - z * z) / (2.0 * z),), (1.0,), 0)
    (found,) = graph.newton(iteration, [start])
    assert derivative([found], inputs) == [[graph.zero, graph.zero]]
    solved = found + (x - found * found) / (2.0 * found)
    (row,) = derivative([solved], inputs)
    value, dx, dstart = evaluated([solved, *row], X, 0.9)
    assert value == pytest.approx(X**0.5, rel=1e-15)
    assert dx == pytest.approx(0.5 / X**0.5, rel=1e-15)
    assert dstart == 0.0


def test_an_operation_without_a_rule(graph, inputs):
    unknown = graph._operation("bessel", inputs[0])
    with pytest.raises(ValueError, match="no rule for the derivative of 'bessel'"):
        derivative([unknown], inputs)
