"""Equations of iterated blocks for derivatives of their unknowns: exact, or by least squares."""

import numpy as np
import pytest
from kernel_motion import difference

from linkages.kernel.differentiation import Evaluator
from linkages.kernel.dyads import LinearSystem
from linkages.kernel.scalars import Level, ScalarGraph, Vector

SHAPES = [(2, 1), (4, 2), (6, 3), (1, 1), (3, 2), (2, 2), (5, 3)]
"""Unknowns and loops; as many equations as unknowns, or more."""
SHAPE = pytest.mark.parametrize(("unknowns", "loops"), SHAPES)


class Case:
    """A system with random numbers, and the same as a matrix."""

    def __init__(self, unknowns, loops):
        random = np.random.default_rng(10 * unknowns + loops)
        self.matrix, self.rate = random.normal(size=(2, 2 * loops, unknowns))
        self.right = random.normal(size=2 * loops)
        graph = ScalarGraph()
        index = iter(range(10_000))

        def vector():
            return Vector(*(graph.input("y", next(index), Level.STATE) for _ in "xy"))

        self.columns = [[vector() for _ in range(loops)] for _ in range(unknowns)]
        self.rates = [[vector() for _ in range(loops)] for _ in range(unknowns)]
        self.gaps = [vector() for _ in range(loops)]
        self.system = LinearSystem(self.columns)

    def evaluate(self, nodes):
        numbers = np.concatenate([self.matrix.T.ravel(), self.rate.T.ravel(), self.right])
        return np.array([float(v) for v in Evaluator(nodes)(y=numbers)])

    def determinant(self, shift):
        """That of the matrix, or of its normal equations: a polynomial."""
        moved = self.matrix + shift * self.rate
        square = moved if self.system.square else moved.T @ moved
        return np.linalg.det(square)

    @property
    def volume(self):
        """That the columns span, with a sign where there are enough of them; and its rate."""
        found, rate = self.determinant(0.0), difference(self.determinant, 1e-2)
        return (found, rate) if self.system.square else (found**0.5, 0.5 * rate / found**0.5)


@SHAPE
def test_solutions_are_those_of_least_squares(unknowns, loops):
    case = Case(unknowns, loops)
    assert case.system.square == (unknowns == 2 * loops)
    expected, *_ = np.linalg.lstsq(case.matrix, case.right, rcond=None)
    found = case.evaluate(case.system.solve(case.gaps))
    # normal equations square the condition number
    assert found == pytest.approx(expected, rel=1e-15 * np.linalg.cond(case.matrix) ** 2 * 10)


@SHAPE
def test_determinants_and_their_rates(unknowns, loops):
    case = Case(unknowns, loops)
    value, rate, bound = case.evaluate(
        [
            case.system.determinant,
            case.system.determinant_rate(case.rates),
            case.system.largest_determinant,
        ]
    )
    volume, volume_rate = case.volume
    assert value == pytest.approx(volume, rel=1e-12)
    assert rate == pytest.approx(volume_rate, rel=1e-9)  # differences of polynomials
    assert abs(value) <= bound * (1 + 1e-14)  # Hadamard


@pytest.mark.parametrize(("unknowns", "loops"), [(2, 1), (2, 2)])
def test_the_bound_is_reached_at_right_angles(unknowns, loops):
    case = Case(unknowns, loops)
    case.matrix, _ = np.linalg.qr(case.matrix)
    value, bound = case.evaluate([case.system.determinant, case.system.largest_determinant])
    assert abs(value) == pytest.approx(bound, rel=1e-14)
