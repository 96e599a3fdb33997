"""Coefficients are what they claim to be."""

import dataclasses

import numpy as np
import pytest

from linkages.solvers import METHODS
from linkages.solvers.tableau import Tableau, density, rooted_trees, stage_weights

DENSE_ORDER = {"rk4": 3, "tsit5": 4, "dop853": 7, "vern9": 8}


def test_number_of_rooted_trees():
    # Hairer, Nørsett & Wanner, table II.2.1.
    assert [len(rooted_trees(nodes)) for nodes in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]


def test_density_of_a_tree_that_branches():
    # The tree [[•, •]] has subtrees of 4, 3, 1 and 1 nodes.
    assert density((((), ()),)) == 12


@pytest.mark.parametrize("name", sorted(DENSE_ORDER))
def test_dense_output_has_its_order(name):
    tableau = METHODS[name].tableau
    known = {}
    for theta in (0.3, 0.8):
        weights = tableau.dense @ theta ** np.arange(1, tableau.dense.shape[1] + 1)
        for nodes in range(1, DENSE_ORDER[name] + 1):
            for tree in rooted_trees(nodes):
                found = weights @ stage_weights(tree, tableau.extended_A, known)
                # Coefficients of dense output go up to 5e2 (dop853) and 1e4 (vern9) and cancel.
                allowed = max(1e-13, 1e-15 * np.abs(tableau.dense).max())
                assert found == pytest.approx(theta**nodes / density(tree), abs=allowed)


def test_dense_output_of_dop853_is_scipys():
    from scipy.integrate import DOP853

    def derivative(t, y):
        return np.array([y[1], -np.sin(y[0]) + np.cos(t)])

    solver = DOP853(derivative, 0.0, np.array([1.0, 0.0]), 10.0, first_step=0.3, rtol=1e-3)
    solver.step()
    theirs = solver.dense_output()
    tableau = METHODS["dop853"].tableau
    for theta in (0.1, 0.5, 0.9):
        weights = tableau.dense @ theta ** np.arange(1, 8)
        ours = solver.y_old + solver.h_previous * (solver.K_extended.T @ weights)
        assert ours == pytest.approx(theirs(theta * solver.t), abs=1e-14)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"b": np.array([0.2, 0.3, 0.3, 0.2])}, "order is not 4"),
        ({"c": np.array([0.0, 0.4, 0.5, 1.0])}, "row sums"),
        ({"A": np.eye(4)}, "needs itself or a later one"),
        ({"A": np.zeros((3, 3))}, "shapes"),
        ({"order": 5}, "order is not 5"),
        ({"error": np.ones((1, 5))}, "do not add up to 0"),
        ({"dense": np.ones((5, 1))}, "dense output"),
    ],
)
def test_wrong_coefficients_are_refused(change, message):
    right = METHODS["rk4"].tableau
    fields = {field.name: getattr(right, field.name) for field in dataclasses.fields(right)}
    with pytest.raises(ValueError, match=message):
        Tableau(**(fields | change))
