"""Functions that kernels write out, against mpmath; limits are what was found, and a tenth more."""

import math

import mpmath
import numpy as np
import pytest
from kernel_lanes import run_routines

from linkages.kernel.code.statements import Entry, Routine, build_block
from linkages.kernel.scalars import Level, ScalarGraph, reachable
from linkages.operations import ELEMENTARY

GRAPH = ScalarGraph()
INPUTS = [GRAPH.input("y", k, Level.STATE) for k in range(2)]
RANDOM = np.random.default_rng(1)
SMALL = RANDOM.choice([-1, 1], 300) * 10.0 ** RANDOM.uniform(-300, 0, 300)
NEAR_ONE = 1 - 10.0 ** RANDOM.uniform(-16, 0, 300)
SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, np.inf, -np.inf, np.nan, 5e-324, 1.1, -746, 709])


def uniform(first, last):
    return RANDOM.uniform(first, last, 600)


# name: largest error in units in the last place, and where
FUNCTIONS = {
    "exp": (0.9, uniform(-1, 1), uniform(-745, 709), SMALL),
    "log": (0.8, uniform(0, 2), 10.0 ** uniform(-320, 308), uniform(0.7, 1.5), NEAR_ONE[:200]),
    "tanh": (1.4, uniform(-1, 1), uniform(-20, 20), uniform(0.6, 0.7), SMALL),
    "sinh": (2.7, uniform(-1, 1), uniform(-700, 700), SMALL),
    "cosh": (1.1, uniform(-1, 1), uniform(-700, 700)),
    "tan": (1.9, uniform(-1.6, 1.6), uniform(-1e6, 1e6)),
    "asin": (2.1, uniform(-1, 1), SMALL, NEAR_ONE),
    "acos": (2.0, uniform(-1, 1), NEAR_ONE),
    "atan": (0.7, uniform(-3, 3), uniform(-1e3, 1e3), 10.0 ** uniform(0, 300), SMALL),
}


def values(name, *operands):
    node = GRAPH.apply(name, *INPUTS[: len(operands)])
    stores, places = {Entry("out", 0): node}, {n.index: Entry(*n.arguments) for n in INPUTS}
    block = build_block(reachable([node]), places, [node], stores=stores)
    routine = Routine("values", "", {"y": 2, "out": 1}, block)
    return run_routines([routine], {"y": np.array(operands)}, 1).arrays["out"][0]


def units_off(name, *operands):
    """Largest error in units in the last place."""
    with mpmath.workprec(250):
        exact = [
            getattr(mpmath, name)(*map(mpmath.mpf, row)) for row in np.array(operands).T.tolist()
        ]
        found = map(mpmath.mpf, values(name, *operands).tolist())
        units = np.spacing(np.abs([float(true) for true in exact]))
        return max(
            float(abs(f - true) / unit) for f, true, unit in zip(found, exact, units, strict=True)
        )


@pytest.mark.slow_except("exp", "tan")
@pytest.mark.parametrize("name", FUNCTIONS)
def test_errors(name):
    limit, *where = FUNCTIONS[name]
    assert max(units_off(name, x) for x in where) < limit


def test_errors_of_angles_of_points():
    far, near = 10.0 ** uniform(-300, 300), 10.0 ** uniform(-300, 300)
    points = [(uniform(-1, 1), uniform(-1, 1)), (far, -near), (near, far), (SMALL, SMALL[::-1])]
    assert max(units_off("atan2", *point) for point in points) < 1.1


@pytest.mark.parametrize("name", FUNCTIONS)
def test_special_values_are_those_of_the_library(name):
    with np.errstate(all="ignore"):
        expected = getattr(np, str(ELEMENTARY[name].numpy))(SPECIAL)
    # elsewhere the library errs as well, as `test_errors` says of these functions
    assert_alike(values(name, SPECIAL), expected, 5e-16)


def test_special_points():
    y, x = (grid.ravel() for grid in np.meshgrid(SPECIAL[:7], SPECIAL[:7]))
    assert_alike(values("atan2", y, x), np.arctan2(y, x), 0.0)


def assert_alike(found, expected, tolerance):
    np.testing.assert_allclose(found, expected, rtol=tolerance, atol=0)
    finite = ~np.isnan(expected)
    assert (np.signbit(found) == np.signbit(expected))[finite].all()
    assert math.isnan(found[6])
