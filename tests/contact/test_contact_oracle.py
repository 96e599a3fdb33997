"""The independent formulation itself: against reference results, and against energy and links."""

from functools import cache

import numpy as np
import pytest
from absolute_contact import LOST, RUBBED, WORK, AbsoluteContact
from absolute_legs import motion
from contact_references import MOTIONS, Reference, off

# Two digits more than the promise of the program under test, so that it can judge it.
LIMIT = 1e-9
RTOL = 1e-12
# The motion forgets 2.3 digits a revolution of 12 ms in file 4, 1 digit in 10 ms in file 6.
QUICK = {
    "2-pin-in-hole": 0.0115,
    "3-pendulum-with-friction": 0.01,
    "4-slider-crank-5000rpm": 0.002,
    "5-engine-crank-pin": 0.004,
    "6-free-crank-energy": 0.01,
}
LONG = {
    "2-pin-in-hole": 0.08,
    "3-pendulum-with-friction": 0.03,
    "4-slider-crank-5000rpm": 0.004,
    "5-engine-crank-pin": 0.03,
    "6-free-crank-energy": 0.02,
}


@cache
def followed(name, end):
    model = AbsoluteContact(Reference(name).definition)
    times = [time for time in Reference(name).times if time <= end]
    return model, motion(model, times, rtol=RTOL)


def check_against_reference(name, end, limit):
    reference, (model, found) = Reference(name), followed(name, end)
    count = len(found.states)
    offset, rate = (
        np.array([part[0] for part in parts])
        for parts in zip(*map(model.offsets, found.states), strict=True)
    )
    assert off(offset, reference.offset[:count]).max() < limit
    assert off(rate, reference.rate[:count]).max() < limit
    states = [modes[0].state for modes in found.modes]
    assert states == [state["gap.state"] for state in reference.states[:count]]
    expected = [event for event in reference.events if float(event["t"]) < end]
    assert [event.kind for event in found.events] == [event["kind"] for event in expected]
    rates = np.array([float(event["indentation_rate"]) for event in expected])
    assert np.abs([event.rate for event in found.events] - rates).max() < 1e-8 * np.abs(rates).max()
    times = [event.time - float(e["t"]) for event, e in zip(found.events, expected, strict=True)]
    assert np.abs(times).max() < 1e-11
    balance = reference.column("dissipated.normal", "dissipated.friction", "work.drives_and_loads")
    scale = np.abs(reference.column("energy")).max()
    done = found.states[:, 2 * model.size :][:, [LOST, RUBBED, WORK]]
    assert np.abs(done - balance[:count]).max() < 10 * limit * scale
    forces = [
        model.force(0, model.wall(y, 0), modes[0])
        for y, modes in zip(found.states, found.modes, strict=True)
    ]
    known = reference.column("gap.force")
    # A force is stiffness times what is right to `limit` of the clearance, some 1e8 N/m · 1e-4 m.
    assert np.abs(forces - known[:count, 0]).max() < 100 * limit * np.abs(known).max()


@pytest.mark.slow_except("2-*", "5-*")
@pytest.mark.parametrize("name", QUICK)
def test_reference_results(name):
    check_against_reference(name, QUICK[name], LIMIT)


@pytest.mark.slow
@pytest.mark.parametrize("name", LONG)
def test_reference_results_over_more_events(name):
    check_against_reference(name, LONG[name], 4 * LIMIT)


@pytest.mark.parametrize("name", QUICK)
def test_slip_and_energy(name):
    """Slip where the definition says the radius; energy less work and plus losses is constant."""
    reference, (model, found) = Reference(name), followed(name, QUICK[name])
    energy = np.array([model.energy(y) for y in found.states])
    kept = energy + found.states[:, 2 * model.size :] @ [1, 1, -1]
    start = model.energy(model.start())
    assert np.abs(kept - start).max() < 1e-9 * np.abs(energy).max()
    if model.gaps[0].pin_radius or name == "2-pin-in-hole":
        slip = [[model.wall(y, 0).slip] for y in found.states]
        assert off(np.array(slip), reference.column("gap.slip")[: len(slip)]).max() < LIMIT


def test_references_agree_with_themselves():
    """Indentations and their rates follow from offsets; digits of both methods are stated."""
    for name in MOTIONS:
        reference = Reference(name)
        rho = np.hypot(*reference.offset.T)
        size = rho - reference.column("gap.indentation")[:, 0]
        assert np.ptp(size) < 1e-17
        speed = np.sum(reference.offset * reference.rate, axis=1) / rho
        assert speed == pytest.approx(reference.column("gap.indentation_rate")[:, 0], abs=1e-12)
        free = np.array([state["gap.state"] == "free" for state in reference.states])
        assert (reference.column("gap.indentation")[free] < 0).all()
        assert (reference.column("gap.force")[free] == 0).all()
