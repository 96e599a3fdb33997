"""Laws of drives that are not defined at all times: nothing beyond is computed, and why is said."""

import numpy as np
import pytest
from solution_mechanisms import SLIDER_CRANK, mechanism

import linkages
from linkages import IncompleteError, InputError

BAR = "joints: {O: [0, 0]}\nbars: {a: {joints: [O, A], length: 1, mass: 1}}\n"


@pytest.mark.parametrize("law", ["log(t)", "1/t", "sqrt(t)"])
def test_at_the_start(law):
    with pytest.raises(InputError, match=r"line 3, column 10, drives\.a: expected a law with fini"):
        linkages.simulate(mechanism(BAR, f"drives: {{a: {{law: '{law}'}}}}"), end=1.0)


def test_on_the_way():
    found = mechanism(BAR, "drives: {a: {law: 'sqrt(1-t)'}}")
    with pytest.raises(
        IncompleteError, match=r"at t = 1 s: the law of drive a has no fin"
    ) as caught:
        linkages.simulate(found, end=2.0, samples=21, outputs="all")
    data = caught.value.solution.data
    assert caught.value.time == 1.0
    assert data.sizes["time"] == 10
    assert all(np.isfinite(values).all() for values in data.data_vars.values())


def test_with_something_free():
    law = "drives: {crank: {law: 'sqrt(1-t)'}}"
    clearance = "clearances: {gap: {joint: A, bar: rod, size: 1e-3, angle: 180 deg}}"
    text = SLIDER_CRANK.replace("drives: {crank: {angle: 0.3, speed: 50}}\n", "")
    with pytest.raises(IncompleteError) as caught:
        linkages.simulate(mechanism(text, law, clearance), end=2.0, samples=21)
    assert 0.99 < caught.value.time <= 1.0
    assert caught.value.solution.data.sizes["time"] == 10
