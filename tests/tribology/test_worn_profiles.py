"""Bearings that wear out of round: depths against closed forms, and cycle jumps with them."""

import json
import math

import numpy as np
import pytest
from worn_mechanisms import RADIUS, SIZE, WEIGHT, WIDTH, block, depth, rotor

import linkages
from linkages.components.contributed.bearing_profiles import support_of
from linkages.tribology.worn_bearings import (
    ANGLES,
    BINS,
    harmonics,
    hull,
    jackson,
    volume_of,
    worn_depth,
)

ROUND = np.full(BINS, SIZE)
FAST = {"skip": 0, "rtol": 1e-9, "longest": 32}
PROFILE = {"feedback": "profile", **FAST}


def taken_off(volume, layer, thinner=0.0, before=ROUND):
    return worn_depth(before, layer, thinner, ROUND, volume, RADIUS, WIDTH)


def layer_at(*places):
    result = np.zeros(BINS)
    result[list(places)] = 1.0
    return result


def test_a_journal_takes_off_what_stands_in_its_way():
    """The hull of a circle of centres and one place: where e cos φ > c it is e cos φ deep."""
    found = taken_off(1e-9, layer_at(90))
    assert volume_of(found, ROUND, RADIUS, WIDTH) == pytest.approx(1e-9, rel=1e-12)
    expected = np.maximum(SIZE, found[90] * np.cos(ANGLES - ANGLES[90]))
    assert found == pytest.approx(expected, rel=1e-14)


def test_wear_all_around_keeps_a_bearing_round():
    """The volume of a ring; what the journal has lost does not matter."""
    wide = math.sqrt((RADIUS + SIZE) ** 2 + 1e-9 / (math.pi * WIDTH)) - RADIUS
    for thinner in (0.0, 2e-5):
        assert taken_off(1e-9, np.ones(BINS), thinner) == pytest.approx(
            np.full(BINS, wide), rel=1e-13
        )
    assert taken_off(0.0, np.ones(BINS)) is ROUND


def test_sets_of_centres_stay_convex():
    """Random layers one after the other; the corners of the polygon of all angles have it."""
    random = np.random.default_rng(5)
    support = ROUND
    for _ in range(20):
        layer = np.where(random.random(BINS) < 0.05, random.random(BINS), 0.0) * 2e-5
        wider = hull(support, layer)
        assert (wider >= support).all()
        assert (wider >= support + layer - 1e-18).all()
        step = 2 * math.pi / BINS
        edges = np.roll(wider, 1) - 2 * wider * math.cos(step) + np.roll(wider, -1)
        assert (edges >= -1e-18).all()
        support = wider
    corners = np.array([
        np.linalg.solve(
            [[math.cos(a), math.sin(a)] for a in (ANGLES[k - 1], ANGLES[k])], support[[k - 1, k]]
        )
        for k in range(BINS)
    ])  # fmt: skip
    units = np.array([np.cos(ANGLES), np.sin(ANGLES)])
    assert (corners @ units).max(axis=0) == pytest.approx(support, rel=1e-11)


@pytest.mark.parametrize("count", [2, 7, 8, 16, 64])
def test_harmonics_keep_the_mean_and_the_curvature(count):
    """Jackson's kernel is positive: p + p″ is, down to the corner of a pocket."""
    angle = np.linspace(0, 2 * np.pi, 2001)
    kernel = 1 + 2 * np.cos(np.multiply.outer(angle, np.arange(1, count + 1))) @ jackson(count)[1:]
    assert kernel.min() > -1e-12
    support = taken_off(1e-8, layer_at(40, 200))
    mean, cos, sin = harmonics(support, count)
    assert mean == pytest.approx(support.mean(), rel=1e-14)
    smooth, _, bent = support_of(mean, cos, sin, angle)
    # of the integrals of a pocket over 360 angles
    assert (smooth + bent).min() > -1e-3 * SIZE
    wanted = support_of(SIZE, np.array([3e-5, 0.0]), np.array([0.0, 1e-5]), ANGLES)[0]
    mean, cos, sin = harmonics(wanted, count)
    assert cos[:2] == pytest.approx([3e-5 * jackson(count)[1], 0.0], abs=1e-18)
    assert sin[:2] == pytest.approx([0.0, 1e-5 * jackson(count)[2]], abs=1e-18)


PIN = """
name: Rotor with a worn bearing
gravity: [0, {gravity}]
joints: {{O: [0, 0]}}
bars: {{rotor: {{joints: [O, P], length: 0.1, mass: 2, center: {center}, inertia: 1e-3}}}}
drives: {{rotor: {{angle: 0, speed: 200}}}}
clearances:
  gap: {{joint: O, bar: rotor, size: 0.1 mm, pin_radius: 10 mm, width: 20 mm, carries: pin,
        contact: hunt-crossley-constant, stiffness: {stiffness}, dissipation: 1,
        offset: [{x!r}, {y!r}], rate: [0, {rate!r}], wear: {{bearing: {{wear_rate: 1e-13}}{more}}}}}
"""


def standing(more=""):
    """A pin that turns under its weight in a bearing of the ground."""
    y = -(SIZE + depth(WEIGHT))
    about = {"gravity": -9.81, "center": 0, "stiffness": 1e9, "more": more}
    return linkages.loads(PIN.format(x=0.0, y=y, rate=0.0, **about))


def whirling():
    """One that its unbalance presses outwards, all around the bearing."""
    reach = SIZE + (2 * 0.01 * 200**2 / 1e10) ** (2 / 3)
    about = {"gravity": 0, "center": 0.01, "stiffness": 1e10, "more": ""}
    return linkages.loads(PIN.format(x=reach, y=0.0, rate=200 * reach, **about))


@pytest.mark.parametrize("more", ["", ", journal: {wear_rate: 1e-14}"], ids=["bearing", "both"])
def test_a_constant_load_wears_a_pocket(more):
    """It is below, as deep as its volume says, and the journal sits in the middle of it."""
    data = linkages.wear(standing(more), revolutions=10**5, **PROFILE)
    profile, end = data["profile"].isel(clearance=0), data.isel(jump=-1, clearance=0)
    first, last = (profile.isel(jump=k).to_numpy() for k in (0, -1))
    assert first == pytest.approx(ROUND)
    journal, bearing = end["volume"].to_numpy()
    thinner = RADIUS - math.sqrt(RADIUS**2 - journal / (math.pi * WIDTH))
    assert volume_of(last - thinner, ROUND, RADIUS, WIDTH) == pytest.approx(bearing, rel=1e-9)
    assert ANGLES[np.argmax(last)] == pytest.approx(1.5 * np.pi, abs=0.02)
    assert last.min() == pytest.approx(SIZE + thinner, rel=1e-9)
    assert last.max() > 1.3 * SIZE
    assert "fits into" in data.attrs["notes"]
    worn = standing(more).with_values(json.loads(data.attrs["worn"]))
    again = linkages.loads(worn.to_yaml())
    (clearance,) = again.opening
    mean, cos, sin = harmonics(last, 8)
    assert clearance.size == pytest.approx(mean, rel=1e-12)
    assert clearance.profile.cos == pytest.approx(cos, abs=1e-15)
    assert clearance.profile.sin == pytest.approx(sin, abs=1e-15)
    assert linkages.simulate(again, end=0.01).data.clearance_indentation.size
    # a load that does not turn works m g 2π (R + ...) in each revolution
    assert float(end["work"]) == pytest.approx(WEIGHT * 2 * math.pi * RADIUS, rel=1e-3)
    uniform = linkages.wear(standing(more), revolutions=10**5, **FAST)
    assert float(uniform["size"][-1, 0]) == pytest.approx(float(end["size"]), rel=1e-3)


def test_a_load_that_turns_wears_all_around():
    """As uniform feedback: the mean clearance, to what one of 8000 samples of the load is."""
    data = linkages.wear(whirling(), revolutions=1000, **PROFILE)
    uniform = linkages.wear(whirling(), revolutions=1000, **FAST)
    last = data["profile"][-1, 0].to_numpy()
    grown = float(uniform["size"][-1, 0]) - SIZE
    assert last.mean() - SIZE == pytest.approx(grown, rel=1e-3)
    assert np.ptp(last) < 1e-2 * grown
    assert "fits into" not in data.attrs["notes"]


@pytest.mark.slow
def test_half_the_jumps_a_limit_and_a_store(tmp_path):
    how = {"until": "clearances.gap.size = 0.11 mm", **PROFILE}
    data = linkages.wear(standing(), confirm=True, **how)
    assert float(data["size"][-1, 0]) == pytest.approx(1.1e-4, rel=1e-12)
    grown = float(np.ptp(data["profile"][-1, 0].to_numpy()))
    (difference,) = data.attrs["difference"]
    assert difference < 0.02 * grown
    assert difference <= float(data["error"][-1, 0])
    volume = volume_of(data["profile"][-1, 0].to_numpy(), ROUND, RADIUS, WIDTH)
    assert volume == pytest.approx(float(data["volume"][-1, 0, 1]), rel=1e-9)

    def ended(_fraction):
        raise KeyboardInterrupt

    with pytest.raises(linkages.Interrupted):
        linkages.wear(standing(), store=tmp_path / "s", watch=ended, **how)
    again = linkages.wear(standing(), store=tmp_path / "s", **how)
    assert np.array_equal(again["profile"], data["profile"])
    with pytest.raises(linkages.InputError, match="holds another sweep"):
        linkages.wear(standing(), store=tmp_path / "s", **how | {"harmonics": 12})


def test_a_life_with_profiles():
    how = {"draws": 2, "accuracy": 0.1, **PROFILE}
    lives = linkages.wear_life(standing(), "clearances.gap.size = 0.102 mm", **how)
    how |= {"feedback": "uniform"}
    plain = linkages.wear_life(standing(), "clearances.gap.size = 0.102 mm", **how)
    assert float(lives["nominal"]) == pytest.approx(float(plain["nominal"]), rel=1e-3)


@pytest.mark.parametrize(
    ("mechanism", "options", "message"),
    [
        (rotor("angle: -90 deg"), {}, "clearances.gap.wear: this has no profile"),
        (block(), {}, "clearances.play.wear: this has no profile"),
        (rotor("contact: restitution, restitution: 0.5"), {}, "this has no profile"),
        (
            standing().with_values({"clearances.gap.profile": {"cos": [0.0] * 9}}), {},
            "expected fewer harmonics, found 9, with 8 of wear",
        ),
        (standing(), {"feedback": "round"}, "feedback must be 'uniform' or 'profile'"),
        (standing(), {"harmonics": 1}, "harmonics must be"),
    ],
)  # fmt: skip
def test_what_has_no_profile(mechanism, options, message):
    with pytest.raises((ValueError, linkages.InputError), match=message):
        linkages.wear(mechanism, revolutions=10, **PROFILE | options)


def test_notes_of_uniform_feedback_stay():
    notes = json.loads(linkages.wear(standing(), revolutions=1000, **FAST).attrs["notes"])
    assert any("the size is that of uniform wear" in note for note in notes)
