"""The shipped slider-crank with contact: it is that of the reference results, and meets them."""

import numpy as np
import pytest
from contact_references import Reference
from library_runs import place, results, whole_run

import linkages

REFERENCE = Reference("4-slider-crank-5000rpm")
SIZE, PERIOD, FIRST_EVENTS = 0.5e-3, 0.012, 4e-3


def test_numbers_are_those_of_the_reference():
    """Lengths, masses and inertias of both, in SI."""
    mine, theirs = linkages.load("slider-crank-contact"), linkages.loads(REFERENCE.definition)
    assert mine.bodies.keys() == theirs.bodies.keys()
    for name, body in mine.bodies.items():
        other = theirs.bodies[name]
        for local, same in zip(body.points.values(), other.points.values(), strict=True):
            assert [v.value for v in local] == [v.value for v in same]
    (contact,), (known,) = mine.contacts, theirs.contacts
    assert contact.size.value == known.size.value == SIZE
    assert contact.normal.numbers[0].value == known.normal.numbers[0].value


@pytest.mark.slow
def test_states_of_the_first_revolution():
    early = REFERENCE.times <= FIRST_EVENTS
    data = results(
        "slider-crank-contact", times=[0.0, *REFERENCE.times[early]], rtol=1e-12,
        outputs=["clearance_offset", "clearance_offset_rate"],
    ).isel(time=slice(1, None))  # fmt: skip
    for name, expected in (
        ("clearance_offset", REFERENCE.offset[early]),
        ("clearance_offset_rate", REFERENCE.rate[early]),
    ):
        off = np.abs(data[name][:, 0].to_numpy() - expected).max()
        assert off < 1e-8 * np.abs(expected).max()


def test_every_touch_and_leave_of_the_first_revolution():
    """56 events to 1e-9 s, which is what remains of 1e-12 behind a revolution."""
    solution = linkages.simulate(
        linkages.load("slider-crank-contact"), end=PERIOD, samples=2, rtol=1e-12,
        events={"gap.touch": "both"},
    )  # fmt: skip
    times = [float(event["t"]) for event in REFERENCE.events]
    assert len(times) == 56
    assert solution.events["gap.touch"].time.to_numpy() == pytest.approx(times, abs=1e-9, rel=0)


def test_the_pin_stays_in_its_hole_and_flies_for_a_part_of_the_time():
    """Its place follows from the joints alone: the offset is the way from the pin to the hole."""
    data = whole_run("slider-crank-contact").data
    apart = place(data, "B.gap") - place(data, "B")
    assert np.abs(apart.T - data.clearance_offset[:, 0].to_numpy()).max() < 1e-15
    offset = np.hypot(*apart)
    depth = float(data.clearance_indentation.max())
    assert offset.max() == pytest.approx(SIZE + depth, abs=1e-15)
    assert 0.1 * SIZE < depth < 0.2 * SIZE  # of which a note warns
    flying = float((data.clearance_state == 0).mean())
    assert 0.05 < flying < 0.5
    assert (data.clearance_force.to_numpy()[data.clearance_state.to_numpy() == 0] == 0).all()
