"""Cosine and sine of compiled kernels, against mpmath."""

import math

import mpmath
import numpy as np
import pytest
from generated_code import run_compiled

from linkages.kernel.code.elementary_functions import LARGEST
from linkages.kernel.scalars import Level, ScalarGraph

GRAPH = ScalarGraph()
ANGLE = GRAPH.input("y", 0, Level.STATE)
BOTH = [GRAPH.cos(ANGLE), GRAPH.sin(ANGLE)]


def cosine_and_sine(angle):
    return run_compiled(BOTH, y=[angle])


def units_off(angle):
    """Errors in units in the last place."""
    with mpmath.workprec(400):
        exact = [function(mpmath.mpf(angle)) for function in (mpmath.cos, mpmath.sin)]
        pairs = zip(cosine_and_sine(angle), exact, strict=True)
        return [float(abs(found - true) / np.spacing(abs(float(true)))) for found, true in pairs]


RANDOM = np.random.default_rng(4)
MULTIPLES = RANDOM.integers(-(10**9), 10**9, 100) * (math.pi / 2)
ANGLES = {
    "within a turn": RANDOM.uniform(-4, 4, 150),
    "many turns": RANDOM.uniform(-1e6, 1e6, 150),
    "the largest": RANDOM.uniform(-LARGEST, LARGEST, 150),
    "beside multiples of a quarter turn": np.concatenate(
        [np.nextafter(MULTIPLES, np.inf), MULTIPLES, np.nextafter(MULTIPLES, -np.inf)]
    ),
    "small": 10.0 ** RANDOM.uniform(-300, -3, 100),
    "at the ends of the polynomials": np.linspace(0.78539, 0.78541, 100),
}


@pytest.mark.slow_except("within*", "the largest")
@pytest.mark.parametrize("angles", ANGLES.values(), ids=ANGLES)
def test_errors_stay_below_one_unit_in_the_last_place(angles):
    assert max(max(units_off(angle)) for angle in angles.tolist()) < 0.8


def test_signs_and_numbers_without_a_place_on_the_circle():
    assert cosine_and_sine(0.0) == [1.0, 0.0]
    assert math.copysign(1.0, cosine_and_sine(-0.0)[1]) == -1.0
    for angle in (math.inf, -math.inf, math.nan, 1.01 * LARGEST):
        assert np.isnan(cosine_and_sine(angle)).all()


def test_symmetry_to_the_last_bit():
    for angle in ANGLES["many turns"].tolist():
        cosine, sine = cosine_and_sine(angle)
        assert cosine_and_sine(-angle) == [cosine, -sine]
