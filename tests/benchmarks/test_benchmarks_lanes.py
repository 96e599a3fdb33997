"""The benchmark of lanes evaluates what it says."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.benchmark.problem import derivative
from linkages.kernel.system import System
from linkages.solution.plan import build_flow, kernel_source

sys.path.insert(0, str(Path(__file__).parent))

import lanes


@pytest.mark.parametrize("count", [1, 8])
def test_what_is_repeated_is_an_evaluation(count):
    """Against the kernel that solvers call, to the last bit."""
    of = System(linkages.load("ninebar"))
    measure = lanes.evaluation(of, kernel_source(of.topology).program, count)
    assert measure(2) > 0
    (_, arrays) = measure.__defaults__[0]
    rate = derivative(build_flow(of))(0.0, of.state)
    assert (arrays["out"][0] == rate[1]).all()
    assert np.isfinite(arrays["out"]).all()
