"""All analyses say where the massless link of a clearance would have to push."""

import numpy as np
import pytest
from shared_definitions import worn_engine

import linkages
from linkages.chaos.common_period import common_period
from linkages.chaos.contact_log import (
    PER_PERIOD,
    RESOLVED,
    contact_kept,
    contact_of,
    contact_sentences,
)
from linkages.chaos.maps import chaos_map

# At 300 rpm the load keeps pin and hole together, at 1000 rpm it does not.
ENGINE = worn_engine("""\
name: Slider-crank with a worn crank pin
clearances: {gap: {joint: A, bar: rod, size: 0.1 mm, angle: 180 deg}}
drives: {crank: {angle: 0, speed: 300 rpm}}
simulate: {end: 1, samples: 1001}
""")
SPEED = "drives.crank.speed"
RPM = np.pi / 30
SLOW, FAST = 300 * RPM, 1000 * RPM
PERIODS = 6


@pytest.fixture(scope="module")
def expected():
    """Share of time and least force at both speeds, from a simulation sampled more closely."""
    found = {}
    for speed in (SLOW, FAST):
        solution = linkages.simulate(
            engine(speed), end=(PERIODS - 1) * 2 * np.pi / speed, samples=20_001,
            outputs=["clearance_force"],
        )  # fmt: skip
        (contact,) = contact_of(solution)
        found[speed] = contact.share_lost, contact.smallest
    assert found[SLOW][0] == 0
    assert found[FAST][0] > 0.1
    return found


def engine(speed=SLOW, **changes):
    return linkages.loads(ENGINE, set={SPEED: speed, **changes})


def analysed(name, speed, **given):
    if name == "bifurcation":
        data = linkages.bifurcation(
            engine(), {SPEED: [speed, 1.01 * speed]}, periods=PERIODS, skip=0, **given
        )
        return data.isel(start=0, value=0)
    if name == "chaos_map":
        size = {"clearances.gap.size": [1e-4, 1.01e-4]}
        data = chaos_map(
            engine(), {SPEED: [speed, 1.01 * speed]}, size, periods=PERIODS - 1, **given
        )
        return data.isel(x=0, y=0)
    if name == "lyapunov":
        return linkages.lyapunov(engine(speed), periods=PERIODS - 1)
    section = {"section": "piston.velocity=0", "direction": "down"} if name == "section" else {}
    return linkages.poincare(engine(speed), periods=PERIODS, **section)


@pytest.mark.slow_except("*-fast")
@pytest.mark.parametrize("speed", [SLOW, FAST], ids=["slow", "fast"])
@pytest.mark.parametrize("name", ["poincare", "section", "bifurcation", "lyapunov", "chaos_map"])
def test_contact_is_that_of_a_simulation(name, speed, expected):
    """As far as 640 looks tell: a share of 0.31 of them has a standard deviation of 0.018.

    A section at a dead centre begins there: the crank starts at one. Between two looks the force
    reaches a little less; at 1000 rpm it is a chaotic motion's.
    """
    share, force = expected[speed]
    data = analysed(name, speed)
    found = float(data["contact_lost"].sel(clearance="gap"))
    least = float(data["least_force"].sel(clearance="gap"))
    assert found == pytest.approx(share, abs=0 if speed == SLOW else 0.055)
    assert least == pytest.approx(force, rel=0.02 if speed == SLOW else 0.2)
    period = 2 * np.pi / speed
    closer = np.log2(period / PER_PERIOD / data["contact_lost"].attrs["interval"])
    assert closer == pytest.approx(round(closer), abs=0.03)
    assert closer > -0.03
    if name in ("bifurcation", "chaos_map"):
        assert round(closer) == 0


def test_a_motion_is_the_same_with_and_without_looks(monkeypatch):
    looked = linkages.poincare(engine(), periods=4, skip=1)
    monkeypatch.setattr("linkages.chaos.sections.links", lambda *_: [])
    alone = linkages.poincare(engine(), periods=4, skip=1)
    assert (looked.clearance_angle == alone.clearance_angle).all()
    assert (looked.time == alone.time).all()


def test_what_is_skipped_is_not_looked_at():
    """A start that throws the pin off the hole, and much friction that brings it back."""
    rough = {"clearances.gap.speed": 3000.0,
             "dampers": [{"clearance": "gap", "damping": 1e-4}]}  # fmt: skip
    first = linkages.poincare(engine(**rough), periods=3)
    later = linkages.poincare(engine(**rough), periods=3, skip=5)
    assert float(first.least_force[0]) < float(later.least_force[0])


def test_what_is_said_of_contact():
    lost, kept = (analysed("bifurcation", speed) for speed in (FAST, SLOW))
    (sentence,) = contact_sentences(lost)
    assert "The force in gap has the wrong sign for" in sentence
    assert contact_kept(lost) == ""
    assert contact_sentences(kept) == []
    assert "looked at every 0.00156 s" in contact_kept(kept)
    whole = linkages.bifurcation(engine(), {SPEED: [SLOW, FAST]}, periods=3, skip=0)
    (sentence,) = contact_sentences(whole)
    assert "at 1 of 2 points" in sentence


def test_mechanisms_without_clearances_have_no_contact():
    ideal = engine().ideal().with_component(linkages.JointDamper(index=0, joint="O", damping=0.0))
    pendulum = linkages.load("pendulum")
    assert not ideal.initial
    data = linkages.poincare(pendulum, periods=2, section="rod.speed=0")
    assert "contact_lost" not in data


@pytest.mark.slow_except("poincare")
@pytest.mark.parametrize("name", ["poincare", "lyapunov"])
def test_every_oscillation_of_a_clearance_is_looked_at(name):
    """The journal of the nine-bar swings 222 times in a period, too fast for 128 looks."""
    mechanism = linkages.load("ninebar")
    period = common_period(mechanism)
    if name == "poincare":
        data = linkages.poincare(mechanism, periods=3)
    else:
        data = linkages.lyapunov(mechanism, periods=10, count=1)
    lasting = period * (2 if name == "poincare" else 10)
    (expected,) = contact_of(linkages.simulate(mechanism, end=lasting, samples=101))
    assert data.least_force[0] == pytest.approx(expected.smallest, rel=1e-3)
    assert data.steps_per_look[0] <= RESOLVED
    at = float(data.least_force_time[0])
    end = linkages.simulate(mechanism, end=at, samples=2, outputs=["clearance_force"])
    assert data.least_force[0] == pytest.approx(float(end.data.clearance_force[-1, 0]), rel=1e-6)
    assert contact_kept(data).startswith("journal and bearing stay in contact: least force 26.")


def test_looks_that_miss_oscillations_prove_nothing():
    speed = {"clearances.r1.speed": [0.0, 0.1]}
    data = linkages.bifurcation(linkages.load("ninebar"), speed, periods=3, skip=0)
    assert (data.contact_lost == 0).all()
    assert "so contact may be lost in between" in contact_kept(data)
