"""Solving for the accelerations of the free coordinates."""

import numpy as np
import pytest
from linkage_models import system, values

from linkages.kernel.differentiation import Evaluator, solve_symmetric
from linkages.kernel.scalars import Level, ScalarGraph


def lower_triangle(graph, count):
    index = iter(range(count * count))
    return [
        [graph.input("m", next(index), Level.STATE) for _ in range(i + 1)] for i in range(count)
    ]


@pytest.mark.parametrize("count", range(1, 7))
@pytest.mark.parametrize("seed", range(5))
def test_symmetric_systems_against_numpy(count, seed):
    random = np.random.default_rng(seed)
    factor = random.normal(size=(count, count))
    matrix = factor @ factor.T + 0.1 * np.eye(count)
    right = random.normal(size=count)
    graph = ScalarGraph()
    rows = lower_triangle(graph, count)
    nodes = solve_symmetric(rows, [graph.input("r", i, Level.STATE) for i in range(count)])
    entries = [matrix[i, j] for i in range(count) for j in range(i + 1)]
    found = [float(v) for v in Evaluator(nodes)(m=np.array(entries), r=right)]
    expected = np.linalg.solve(matrix, right)
    # both are backward stable: the error is a few roundings times the condition number
    tolerance = 1e-15 * count * np.linalg.cond(matrix) * np.abs(expected).max()
    assert found == pytest.approx(expected, abs=tolerance)


def test_uncoupled_coordinates_cost_nothing():
    graph = ScalarGraph()
    a, b = (graph.input("m", i, Level.STATE) for i in range(2))
    r, s = (graph.input("r", i, Level.STATE) for i in range(2))
    before = len(graph.nodes)
    x, y = solve_symmetric([[a], [graph.zero, b]], [r, s])
    assert len(graph.nodes) == before + 4  # two quotients 1/pivot, two products
    assert [n.operation for n in (x, y)] == ["mul", "mul"]


def test_no_free_coordinate_no_equation():
    assert solve_symmetric([], []) == []
    assert system("fourbar").model.free_accelerations == []


@pytest.mark.parametrize("name", ["pendulum", "doublependulum", "clearance", "ninebar"])
def test_nothing_has_to_push_free_coordinates(name):
    """Newton's equations hold along every free direction: the force required there is zero."""
    of = system(name)
    accelerations = of.evaluate(of.model.free_accelerations)
    for partial in of.model.partials:
        required = of.model.required_force(of.model.accelerations, partial)
        without = of.model.required_force(of.model.bias, partial)
        (found,) = of.evaluate([required], acceleration=accelerations)[:, 0]
        (scale,) = of.evaluate([without])[:, 0]
        assert abs(found) <= 1e-13 * max(1.0, abs(scale))  # sums of a hundred terms


@pytest.mark.parametrize(
    "name", ["fourbar", "slidercrank", "fivebar", "trammel", "watt", "stephenson"]
)
def test_drive_power_is_the_rate_of_energy(name):
    """All that is driven: power of drives and loads = d(T + V)/dt, by differences of energies."""
    of = system(name)
    h = 1e-4 / np.abs(of.evaluate([*of.model.known_rates.values()])).max()

    def energy(t):
        return values(of, "kinetic_energy", t)[0, 0] + values(of, "potential_energy", t)[0, 0]

    rate = (energy(-2 * h) - 8 * energy(-h) + 8 * energy(h) - energy(2 * h)) / (12 * h)
    power = values(of, "drive_power")[0, 0] + values(of, "load_power")[0, 0]
    (own,) = of.evaluate([of.model.power])[:, 0]
    scale = abs(energy(0.0)) + abs(power) + 1
    # rounding of energies over h: 1e-16/1e-4 per rad/s; truncation 1e-16
    assert power == pytest.approx(rate, abs=1e-10 * scale * 1e-4 / h)
    assert own == pytest.approx(power, rel=1e-12)
