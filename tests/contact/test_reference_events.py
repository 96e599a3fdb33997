"""Touches and leaves at the times of the reference results, and tangents through them."""

import numpy as np
import pytest
from contact_references import Reference
from test_reference_motions import ENDS, mechanism_of

import linkages

CROSSED = "gap.indentation=0"


def crossings(name, end, rtol=1e-12):
    found = linkages.simulate(
        mechanism_of(name), end=end, samples=2, rtol=rtol, events={CROSSED: "both"},
        outputs=["clearance_offset", "clearance_indentation_rate"],
    ).events[CROSSED]  # fmt: skip
    expected = [event for event in Reference(name).events if float(event["t"]) < end]
    assert len(found.time) == len(expected)
    return found, expected


def check_events(name, end, seconds):
    found, expected = crossings(name, end)
    times = np.array([float(event["t"]) for event in expected])
    assert found.time.to_numpy() == pytest.approx(times, abs=seconds, rel=0)
    rates = np.array([float(event["indentation_rate"]) for event in expected])
    # Between touch and leave a rate changes by itself within a duration of some 50 µs to 1 ms.
    size = np.abs(rates).max()
    assert (
        np.abs(found.clearance_indentation_rate[:, 0] - rates).max()
        < max(1e-8, 1e5 * seconds) * size
    )


def test_a_whole_revolution():
    """56 events; the motion forgets 2.3 digits meanwhile, and 1e-9 s is what remains."""
    check_events("4-slider-crank-5000rpm", 0.012, 1e-9)


@pytest.mark.parametrize("name", [name for name in ENDS if name[0] != "4"])
def test_events_are_located_to_round_off(name):
    """As accurately as the motion itself: 1e-10 of the time between two events."""
    check_events(name, min(ENDS[name], 0.03), 1e-11 if name[0] != "6" else 1e-10)


def test_location_does_not_depend_on_the_tolerance_of_steps():
    """At 1e-7 the first touch is as exact as at 1e-12: free flight is smooth."""
    found, expected = crossings("4-slider-crank-5000rpm", 0.00025, rtol=1e-9)
    assert float(found.time[0]) == pytest.approx(float(expected[0]["t"]), rel=1e-10)


@pytest.mark.parametrize("name", ["2-pin-in-hole", "4-slider-crank-5000rpm"])
def test_jacobian_through_touches(name):
    """With the jump of the first rate's tangent; with that rate held, they are 12 % off.

    Differences of the reference are good to 1e-6 or 1e-7 of the largest entry of a block.
    """
    mechanism, reference = mechanism_of(name), Reference(name)
    rhs = linkages.compile(mechanism)
    names = ("gap.x.position", "gap.y.position", "gap.x.velocity", "gap.y.velocity")
    rows = [rhs.names.index(entry) for entry in names]
    count = len(rhs.names)
    start = np.zeros(count)
    entry = mechanism.definition.content["clearances"]["gap"]
    start[rows] = [float(v) for v in (*entry["offset"], *entry["rate"])]
    end, expected = reference.jacobian()
    found = rhs.flow(tangents=count, rtol=1e-12).advance(start, 0.0, end, np.eye(count))
    tangents = np.asarray(found.tangents)[np.ix_(rows, rows)]
    for i in (slice(0, 2), slice(2, 4)):
        for j in (slice(0, 2), slice(2, 4)):
            size = np.abs(expected[i, j]).max()
            assert np.abs(tangents[i, j] - expected[i, j]).max() < 1e-6 * size
