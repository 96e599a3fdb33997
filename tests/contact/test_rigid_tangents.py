"""Tangents through rigid impacts, closing and opening, and what is left of exponents."""

import numpy as np
import pytest
from shared_definitions import loaded_engine
from tangent_differences import check

import linkages

PIN = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {pin: {joints: [O, P], length: 0.1, mass: 0.25, inertia: 1e-4, center: 0.01}}
clearances: {gap: {joint: O, bar: pin, size: 1 mm, contact: restitution, restitution: 0.4,
              least_rate: 20 mm/s, rate: [0.1, 0.3]}}
free: {pin: {angle: 0.5, speed: 2}}
"""
ENGINE = loaded_engine("""\
clearances: {gap: {joint: A, bar: rod, size: 0.1 mm, contact: restitution, restitution: 0.3,
                   least_rate: 10 mm/s}}
drives: {crank: {angle: 0, speed: 1000 rpm}}
""")
BOUNCED, CLOSED, OPENED, AGAIN = 0.0012, 0.03, 0.0538, 0.06


@pytest.mark.parametrize("end", [0.02, 0.1], ids=["impacts", "closed and swinging"])
def test_a_free_pin(end):
    check(PIN, end, 1e-3)


@pytest.mark.slow_except("0.03")
@pytest.mark.parametrize("end", [BOUNCED, CLOSED, OPENED, AGAIN])
def test_an_engine_that_closes_and_opens(end):
    check(ENGINE, end, 1e-4)


def test_the_engine_does_what_these_times_say():
    changes = linkages.simulate(linkages.loads(ENGINE), end=AGAIN).motion.changes["gap: touch"]
    rises = [list(changes.rises[changes.time < end]) for end in (BOUNCED, CLOSED, OPENED, AGAIN)]
    assert rises[0] == [True]
    assert rises[1] == [True] * 3
    assert rises[2] == [True] * 3 + [False]
    assert rises[3] == [True] * 3 + [False] + [True] * 3


def test_a_contact_that_closes_takes_two_directions_away():
    """Of four exponents two are left, as those of the massless link; the others are −∞."""
    slow = linkages.loads(ENGINE.replace("1000 rpm", "600 rpm"))
    found = linkages.lyapunov(slow, periods=16, skip=2)
    two = linkages.lyapunov(slow, periods=16, skip=2, count=2)
    assert found.attrs["lost"] == 2
    assert two.attrs["lost"] == 0
    # the area of neighbours on the wall, whatever directions they begin in: errors of 64 intervals
    sums = [data.history.sum("index").to_numpy() for data in (found, two)]
    np.testing.assert_allclose(*sums, atol=1e-6 * abs(two.history).max())
