"""Linear systems, iterations and splines: NumPy and generated code, against NumPy and SciPy."""

import numpy as np
import pytest
from generated_code import run_compiled
from scipy.interpolate import CubicSpline

from linkages.components.contributed.functions import Table
from linkages.kernel.differentiation import (
    MOST_ITERATIONS,
    MOST_TURNED,
    Evaluator,
    Iteration,
    iterate,
    solve_systems,
)
from linkages.kernel.inputs import table_numbers
from linkages.kernel.scalars import Level, ScalarGraph

SIZES = range(1, 8)


def linear(size):
    """Nodes of the solution and the determinant; matrix, then right-hand side, are the inputs."""
    graph = ScalarGraph()
    entries = [graph.input("y", i, Level.STATE) for i in range(size * size + size)]
    matrix = [entries[size * i : size * (i + 1)] for i in range(size)]
    return [*graph.solve(matrix, entries[size * size :]), graph.determinant(matrix)]


def permuted(size, random):
    """A matrix whose leading minors vanish: nothing works without row exchanges."""
    order = np.roll(np.arange(size), 1)
    return np.diag(random.uniform(1, 2, size))[order]


MATRICES = {
    "random": lambda size, random: random.normal(size=(size, size)),
    "permuted": permuted,
    "tiny pivots": lambda size, random: random.normal(size=(size, size)) + 1e9 * np.eye(size)[::-1],
}


@pytest.mark.parametrize("kind", MATRICES)
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("seed", range(3))
def test_linear_systems_against_numpy(kind, size, seed):
    random = np.random.default_rng(seed)
    matrix, right = MATRICES[kind](size, random), random.normal(size=size)
    expected, determinant = np.linalg.solve(matrix, right), np.linalg.det(matrix)
    numbers = [*matrix.ravel(), *right]
    nodes = linear(size)
    for found in (
        solve_systems(numbers),
        Evaluator(nodes)(y=np.array(numbers)),
        run_compiled(nodes, y=numbers),
    ):
        *solution, last = (float(np.squeeze(value)) for value in found)
        # elimination with row exchanges is backward stable
        tolerance = 1e-15 * size**2 * np.linalg.cond(matrix)
        assert solution == pytest.approx(expected, abs=tolerance * np.abs(expected).max())
        # NumPy takes the exponential of a sum of logarithms
        assert last == pytest.approx(determinant, rel=tolerance * max(1, abs(np.log(abs(last)))))


def test_many_systems_at_once():
    random = np.random.default_rng(1)
    matrices, right = random.normal(size=(40, 3, 3)), random.normal(size=3)
    entries = [*(matrices[:, i, j] for i in range(3) for j in range(3)), *right]
    *solution, determinant = solve_systems(entries)
    assert np.stack(solution, axis=-1) == pytest.approx(
        np.linalg.solve(matrices, np.broadcast_to(right[:, None], (40, 3, 1)))[..., 0], rel=1e-12
    )
    assert determinant == pytest.approx(np.linalg.det(matrices), rel=1e-14)


def test_a_singular_system_has_no_solution_and_leaves_the_others_alone():
    entries = [np.array([1.0, 0.0]), 2.0, 3.0, np.array([4.0, 0.0]), 5.0, 6.0]
    x, y, determinant = solve_systems([*entries[:2], 0.0 * entries[0], *entries[3:]])
    assert determinant.tolist() == [4.0, 0.0]
    assert [x[0], y[0]] == [2.0, 1.5]
    assert np.isnan([x[1], y[1]]).all()


# --- Newton's iteration -------------------------------------------------------------------------


def two_circles():
    """Newton's iteration for z0² + z1² = p0 and (z0 − 1)² + z1² = p1, from (y0, y1)."""
    graph = ScalarGraph()
    z = [graph.input("z", i, Level.STATE) for i in range(2)]
    first, second = (graph.input("p", i, Level.PARAMETERS) for i in range(2))
    a, b = z
    gaps = [first - a * a - b * b, second - (a - 1.0) * (a - 1.0) - b * b]
    updates = graph.solve([[2.0 * a, 2.0 * b], [2.0 * a - 2.0, 2.0 * b]], gaps)
    iteration = Iteration(tuple(z), tuple(updates), (1.0, 1.0), block=3)
    start = [graph.input("y", i, Level.STATE) for i in range(2)]
    return iteration, graph.newton(iteration, start)


def intersection(first, second):
    x = (first - second + 1) / 2
    return x, np.sqrt(first - x * x)


@pytest.mark.parametrize("start", [(0.5, 0.9), (0.2, 0.6), (0.5, -0.9)])
def test_numpy_and_printed_code_find_the_same(start):
    _, nodes = two_circles()
    x, y = intersection(0.9, 1.1)
    expected = (x, np.copysign(y, start[1]))
    evaluated = Evaluator(nodes)(y=np.array(start), p=np.array([0.9, 1.1]))
    for found in (evaluated, run_compiled(nodes, y=start, p=[0.9, 1.1])):
        # the last update was below 1e-7 and convergence is quadratic; coefficients around 1
        assert [float(v) for v in found] == pytest.approx(expected, abs=1e-13)


def test_many_starts_at_once():
    iteration, nodes = two_circles()
    radii = np.array([[0.9, 1.0, -4.0, 0.8], [1.1, 0.7, 1.0, 0.9]])
    found = Evaluator(nodes)(y=np.array([[0.5], [0.8]]), p=radii)
    good = [0, 1, 3]
    expected = intersection(*radii[:, good])
    assert np.array(found)[:, good] == pytest.approx(np.array(expected), abs=1e-13)
    assert np.isnan(np.array(found)[:, 2]).all()  # such circles do not intersect
    assert [node.arguments[0] for node in iteration.external if node.operation == "input"] == [
        "p",
        "p",
    ]


def test_no_solution_ends_with_the_number_of_the_block():
    """Status 1 + block, after a bounded number of iterations."""
    _, nodes = two_circles()
    with pytest.raises(LookupError) as caught:
        run_compiled(nodes, y=[0.5, 0.8], p=[-4.0, 1.0])
    assert caught.value.args == (4,)


@pytest.mark.parametrize("start", [(0.5, 0.3), (0.5, 2.4)])
def test_what_lies_too_far_from_the_start_is_another_mode(start):
    """The correction exceeds `MOST_TURNED`: found, but not trusted."""
    iteration, nodes = two_circles()
    x, y = intersection(0.9, 1.1)
    assert abs(y - start[1]) > MOST_TURNED
    assert np.isnan(Evaluator(nodes)(y=np.array(start), p=np.array([0.9, 1.1]))).all()
    with pytest.raises(LookupError):
        run_compiled(nodes, y=start, p=[0.9, 1.1])
    outside = dict(
        zip((n.index for n in iteration.external), _external(iteration, [0.9, 1.1]), strict=True)
    )
    found = iterate(iteration, start, outside, most_turned=np.inf)
    assert [float(v) for v in found] == pytest.approx([x, y], abs=1e-13)


def _external(iteration, radii):
    values = Evaluator(iteration.external)(p=np.array(radii))
    return [float(value) for value in values]


def test_an_iteration_that_runs_away_does_not_warn():
    """Infinities and what they leave behind are told by nan alone."""
    graph = ScalarGraph()
    z = graph.input("z", 0, Level.STATE)
    (step,) = graph.solve([[z * z]], [z * z * z * z])
    iteration = Iteration((z,), (step,), (1.0,), 0)
    for start in (1e3, 0.0, np.nan):
        (found,) = iterate(iteration, [np.array([start])], {}, most_turned=np.inf)
        assert np.isnan(found).all()


def test_scales_say_what_is_close():
    """In millimetres the same correction counts as far; in kilometres as near."""
    iteration, _ = two_circles()
    outside = {
        n.index: v
        for n, v in zip(iteration.external, _external(iteration, [0.9, 1.1]), strict=True)
    }
    start = (0.5, 0.8)
    for scale, reached in ((1e-3, False), (1.0, True)):
        scaled = Iteration(iteration.iterates, iteration.updates, (scale, scale), 0)
        found = iterate(scaled, start, outside)
        assert np.isfinite(found).all() == reached


def test_the_iteration_is_bounded():
    """z ← z + 1 + sin(z)/2 never comes to rest."""
    graph = ScalarGraph()
    z = graph.input("z", 0, Level.STATE)
    iteration = Iteration((z,), (1.0 + 0.5 * graph.sin(z),), (1.0,), 0)
    (node,) = graph.newton(iteration, [graph.input("y", 0, Level.STATE)])
    assert np.isnan(Evaluator([node])(y=np.array([0.0]))[0])
    with pytest.raises(LookupError):
        run_compiled([node], y=[0.0])
    assert MOST_ITERATIONS < 100


# --- splines ------------------------------------------------------------------------------------

TIMES = (0.0, 0.3, 1.0, 1.1, 2.5)
VALUES = (1.0, -0.5, 0.7, 0.2, 1.0)
WHERE = np.array([-3.0, -0.4, 0.0, 0.1, 0.3, 0.999, 1.05, 1.1, 2.0, 2.5, 2.6, 9.3])


def spline(periodic):
    """Nodes of a spline, and its numbers behind another parameter."""
    graph = ScalarGraph()
    time = graph.input("t", 0, Level.TIME)
    numbers = table_numbers(Table((), TIMES, VALUES, periodic))
    return graph.spline(time, 1, len(TIMES) - 1, periodic), np.array([np.nan, *numbers])


def expected_spline(periodic):
    """Value and derivatives by SciPy; outside a natural spline goes on in straight lines."""
    if periodic:
        exact = CubicSpline(TIMES, VALUES, bc_type="periodic", extrapolate="periodic")
        return np.array([exact(WHERE, order) for order in range(3)])
    exact = CubicSpline(TIMES, VALUES, bc_type="natural")
    inner = np.clip(WHERE, TIMES[0], TIMES[-1])
    value, slope, curvature = (exact(inner, order) for order in range(3))
    inside = inner == WHERE
    return np.array([value + slope * (WHERE - inner), slope, np.where(inside, curvature, 0.0)])


@pytest.mark.parametrize("periodic", [False, True])
def test_splines_against_scipy(periodic):
    nodes, numbers = spline(periodic)
    expected = expected_spline(periodic)
    evaluated = np.array(Evaluator(nodes)(t=WHERE[None], p=numbers))
    printed = np.array([run_compiled(nodes, t=time, p=numbers) for time in WHERE.tolist()]).T
    # coefficients up to 20; the remainder of a division by the period loses a digit
    assert evaluated == pytest.approx(expected, abs=1e-13)
    assert printed == pytest.approx(expected, abs=1e-13)


def test_the_numbers_of_a_spline_may_differ_from_sample_to_sample():
    """Parameters come with an axis of samples where assembly modes change along a motion."""
    nodes, numbers = spline(periodic=False)
    plain = np.array(Evaluator(nodes)(t=WHERE[None], p=numbers))
    repeated = np.repeat(numbers[:, None], len(WHERE), axis=1)
    assert np.array_equal(np.array(Evaluator(nodes)(t=WHERE[None], p=repeated)), plain)
