"""Cycle jumps against closed forms, their errors, limits, stores, and lives."""

import json
import math

import numpy as np
import pytest
from scipy.integrate import quad
from worn_mechanisms import LINK, RADIUS, SIZE, WEIGHT, WIDTH, block, depth, rotor

import linkages
from linkages.tribology.steady_work import WornMotions
from linkages.tribology.worn_joints import BINS, density, worn_joints

FAST = {"skip": 0, "rtol": 1e-9, "longest": 32}
RATE = 1e-13


def bearing(work):
    """Radius of the worn bearing."""
    return math.sqrt((RADIUS + SIZE) ** 2 + RATE * work / (math.pi * WIDTH))


def revolutions_until(size, indentation=0.0):
    """n = ∫ dW/(F 2π (R_b(W) + d)): the bearing alone wears, under a constant force."""
    last = math.pi * WIDTH * ((RADIUS + size) ** 2 - (RADIUS + SIZE) ** 2) / RATE
    found, _ = quad(lambda w: 1 / (WEIGHT * 2 * math.pi * (bearing(w) + indentation)), 0, last)
    return found


def link(**how):
    """A rotor on a massless link, whose motion is a rest."""
    return rotor(LINK, **how)


@pytest.mark.parametrize(
    ("mechanism", "indentation"), [(link(), 0.0), (rotor(), depth(WEIGHT))], ids=["link", "contact"]
)
def test_constant_load_and_speed(mechanism, indentation):
    """The bearing grows from 0.1 mm to 5 mm, and the pin slips farther by a half."""
    size, accuracy = 5e-3, 1e-2
    count = round(revolutions_until(size, indentation))
    how = {"revolutions": count, "accuracy": accuracy, "largest_jump": 50, "confirm": True}
    data = linkages.wear(mechanism, **how, skip=0, rtol=1e-9)
    end = data.isel(jump=-1, clearance=0)
    found, error = float(end["size"]), float(end["error"])
    # half the jumps leave an eighth of an error of third order, and nearly that of long ones
    assert abs(found - size) <= 1.2 * error
    assert error <= accuracy * (size - SIZE)
    assert data["volume"].sel(side="journal")[-1] == 0.0
    work = float(end["volume"].sel(side="bearing")) / RATE
    assert bearing(work) - RADIUS == pytest.approx(found, rel=1e-12)
    expected = WEIGHT * 2 * math.pi * (bearing(work) + indentation)
    # the contact still bounces a little at its new size
    assert abs(float(end["work"]) - expected) <= 3 * float(end["work_error"]) + 1e-9 * expected


def test_a_limit_is_where_the_size_is_reached():
    data = linkages.wear(link(), until="clearances.gap.size = 0.5 mm", accuracy=1e-4, **FAST)
    assert data.attrs["ended"] == "limit"
    assert float(data["size"][-1, 0]) == pytest.approx(0.5e-3, rel=1e-12)
    # the part of the error of the size in the growth is that of the life
    found = float(data["revolutions"][-1])
    assert found == pytest.approx(revolutions_until(0.5e-3), rel=1e-4)
    again = linkages.wear(link(), revolutions=round(found), accuracy=1e-4, **FAST)
    assert again.attrs["ended"] == "revolutions"
    assert float(again["size"][-1, 0]) == pytest.approx(0.5e-3, rel=1e-4)


def test_both_sides_and_a_limit_beside_revolutions():
    """What comes first ends; volumes are as rates."""
    wear = "journal: {wear_rate: 1e-13}, bearing: {wear_rate: 3e-13}"
    data = linkages.wear(
        link(wear=wear), until="clearances.gap.size=9 mm", revolutions=1000, **FAST
    )
    assert data.attrs["ended"] == "revolutions"
    volume = data["volume"][-1, 0]
    assert float(volume[1]) == pytest.approx(3 * float(volume[0]), rel=1e-12)
    # a pin of less radius slips less: both radii follow from volumes of rings
    ring = math.pi * WIDTH
    inner = math.sqrt(RADIUS**2 - float(volume[0]) / ring)
    outer = math.sqrt((RADIUS + SIZE) ** 2 + float(volume[1]) / ring)
    assert float(data["size"][-1, 0]) == pytest.approx(outer - inner, rel=1e-12)


def test_half_the_jumps_confirm():
    data = linkages.wear(link(), revolutions=10**6, largest_jump=10, confirm=True, **FAST)
    (difference,) = data.attrs["difference"]
    assert 0.0 < difference <= float(data["error"][-1, 0])


def test_a_link_that_pushes_is_said():
    """A rotor that stands on its pin: to round-off it stays there for a revolution."""
    how = {**FAST, "longest": 1}
    data = linkages.wear(rotor("angle: 90 deg", speed=20000.0), revolutions=1, **how)
    assert "100% of the work is done while it pushes" in data.attrs["notes"]
    assert "massless" not in linkages.wear(link(), revolutions=1, **FAST).attrs["notes"]


def test_a_block_wears_its_guide_along_its_way():
    data = linkages.wear(block(), revolutions=10**5, **FAST)
    end = data.isel(jump=-1, clearance=0)
    first, second = end["volume"].to_numpy()
    assert second == pytest.approx(3 * first, rel=1e-12)
    grown = first / (2 * 0.04 * 0.02) + second / (2 * (0.04 + 0.1) * 0.02)
    assert float(end["size"]) == pytest.approx(SIZE + grown, rel=1e-6)
    assert not end["depth"].any()


def test_depth_is_where_the_contact_is():
    """The pin of the ground is worn below, the turning bearing all around; volumes are theirs."""
    wear = "journal: {wear_rate: 1e-13}, bearing: {wear_rate: 1e-13}"
    data = linkages.wear(link(wear=wear), revolutions=1000, **FAST)
    end = data.isel(jump=-1, clearance=0)
    width = 2 * math.pi / BINS
    for side, radius in (("journal", RADIUS), ("bearing", RADIUS + SIZE)):
        depths = end["depth"].sel(side=side)
        volume = float(depths.sum()) * width * radius * WIDTH
        assert volume == pytest.approx(float(end["volume"].sel(side=side)), rel=1e-9)
    pin, hole = (end["depth"].sel(side=side).to_numpy() for side in ("journal", "bearing"))
    # n points from the centre of the bearing, which hangs, to that of the pin
    assert np.argmax(pin) in (BINS // 4 - 1, BINS // 4)
    assert np.count_nonzero(pin > 0.01 * pin.max()) <= 2
    assert hole == pytest.approx(np.full(BINS, hole.mean()), rel=1e-6)
    assert "times as deep as all around" in data.attrs["notes"]


def test_density_of_a_contact_that_moves():
    assert density(np.linspace(0, 2 * np.pi, 2001), np.ones(2000)) == pytest.approx(
        np.full(BINS, 1 / (2 * np.pi)), rel=1e-9
    )


@pytest.mark.parametrize("place", [1.0, 0.0, 2 * np.pi - 0.1])
def test_density_of_a_wide_contact(place):
    """Hertz's half ellipse has the variance a²/4, across 0° as well."""
    found = density(np.full(3, place), np.ones(2), np.full(3, 0.3))
    angle = (np.arange(BINS) + 0.5) * 2 * np.pi / BINS
    apart = np.angle(np.exp(1j * (angle - place)))
    width = 2 * np.pi / BINS
    assert found.sum() * width == pytest.approx(1.0, rel=1e-12)
    # bins of one degree add a twelfth of their square
    variance = float((found * apart**2).sum() * width) - width**2 / 12
    assert variance == pytest.approx(0.3**2 / 4, rel=1e-3)


def test_sizes_keep_the_digits_of_small_volumes():
    (joint,) = worn_joints(link(wear="journal: {wear_rate: 1}, bearing: {wear_rate: 1}"), {})
    depths = joint.depths(1e-20)
    assert depths == pytest.approx(1e-20 / (2 * np.pi * np.array([RADIUS, RADIUS + SIZE]) * WIDTH))


def test_a_journal_that_is_worn_through():
    data = link(wear="journal: {wear_rate: 1e-6}")
    with pytest.raises(linkages.ComputationError, match="worn through"):
        linkages.wear(data, revolutions=10**9, largest_jump=1e9, accuracy=0.9, **FAST)


def test_a_store_goes_on(tmp_path, monkeypatch):
    def ended(_fraction):
        raise KeyboardInterrupt

    how = {"revolutions": 10**6, **FAST}
    whole = linkages.wear(link(), **how)
    with pytest.raises(linkages.Interrupted) as stop:
        linkages.wear(link(), store=tmp_path / "s", watch=ended, **how)
    kept = stop.value.kept["wear"]
    assert kept.attrs["ended"] == "interrupt"
    assert kept.sizes["jump"] == 2
    counted = []
    settled = WornMotions.settled
    monkeypatch.setattr(WornMotions, "settled", lambda *args: counted.append(1) or settled(*args))
    again = linkages.wear(link(), store=tmp_path / "s", **how)
    assert whole.identical(again)
    first = len(counted)
    assert first == 1 + 3 * (whole.sizes["jump"] - 1) - 4
    linkages.wear(link(), store=tmp_path / "s", **how)
    assert len(counted) == first
    with pytest.raises(linkages.InputError, match="holds another sweep"):
        linkages.wear(link(), store=tmp_path / "s", revolutions=10, **FAST)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "a number of revolutions, or a limit"),
        ({"until": "clearances.gap.size"}, "expected a size of a clearance that wears"),
        ({"until": "clearances.gab.size=1 mm"}, "there are clearances.gap.size"),
        ({"until": "clearances.gap.size=1 N"}, "N is a force"),
        ({"until": "clearances.gap.size=0.1 mm"}, "expected a larger limit"),
        ({"revolutions": 0}, "revolutions must be"),
        ({"revolutions": 5, "accuracy": 0.0}, "accuracy must be"),
    ],
)
def test_faulty_options(given, message):
    with pytest.raises(ValueError, match=message):
        linkages.wear(link(), **given)


def test_what_does_not_wear():
    with pytest.raises(linkages.InputError, match="nothing wears"):
        linkages.wear(linkages.load("idling-engine"), revolutions=10)
    with pytest.raises(linkages.InputError, match="wear counts revolutions"):
        linkages.wear(rotor(speed=0.0), revolutions=10)
    floating = rotor().with_values({"gravity": [0, 0], "clearances.gap.offset": [0, 0]})
    with pytest.raises(linkages.ComputationError, match="the limit is never reached"):
        linkages.wear(floating, until="clearances.gap.size=1 mm", **FAST)
    assert float(linkages.wear(floating, revolutions=10**6, **FAST)["size"][-1, 0]) == SIZE


LIMIT = "clearances.gap.size = 0.3 mm"


def test_life_of_uncertain_wear_rates():
    """Lognormal: 95 of 100 rates are within the factor of 5 that nothing else is said of."""
    lives = linkages.wear_life(link(), LIMIT, accuracy=1e-3, **FAST)
    nominal = float(lives["nominal"])
    assert nominal == pytest.approx(revolutions_until(0.3e-3), rel=1e-3)
    spread = math.exp(1.2815515655446004 * math.log(5) / 1.959963984540054)
    expected = np.array([nominal / spread, nominal, nominal * spread])
    assert lives["life_quantile"].to_numpy() == pytest.approx(expected, rel=1e-9)
    assert lives["relative_quantile"].to_numpy() == pytest.approx(1.0)
    assert not lives.sizes["parameter"]


def test_life_over_tolerances(tmp_path):
    """Life is as 1/m: of normal masses its quantiles follow."""
    mechanism = link(mass="2 ± 10 %", wear="bearing: {wear_rate: 1e-13}, uncertainty: 1")
    how = {"draws": 20, "accuracy": 0.1, "largest_jump": 10, **FAST}
    lives = linkages.wear_life(mechanism, LIMIT, store=tmp_path / "s", **how)
    assert lives["exponent"].to_numpy() == pytest.approx([-1.0], abs=1e-3)
    zone = mechanism.tolerances["bars.rotor.mass"]
    low, high = lives["ends"].to_numpy()[0]
    part = zone.deviation / 2
    assert (low, high) == pytest.approx((1 / (1 - part), 1 / (1 + part)), rel=1e-3)
    expected = 1 / (1 + part * np.array([1.2816, 0.0, -1.2816]))
    # standard errors of quantiles of 20 draws are 0.4 deviations at most
    assert lives["relative_quantile"].to_numpy() == pytest.approx(expected, abs=1.2 * part)
    other = linkages.wear_life(mechanism, LIMIT, cores=1, **{**how, "draws": 5})
    assert np.array_equal(other["relative"], lives["relative"][:5])


def test_copies_that_never_wear_out():
    """Half of the masses are so small that the limit is not reached in time: P90 is infinite."""
    count = round(revolutions_until(0.3e-3))
    mechanism = link(mass="2 ± 10 %", wear="bearing: {wear_rate: 1e-13}, uncertainty: 1")
    lives = linkages.wear_life(
        mechanism, LIMIT, draws=8, revolutions=count + 10, accuracy=1e-3, **FAST
    )
    assert np.isinf(lives["relative"]).any()
    assert np.isinf(lives["life_quantile"].sel(percent=90))
    assert "the limit is not reached" in lives["reason"].values
    with pytest.raises(linkages.ComputationError, match="nominal mechanism: the limit is not"):
        linkages.wear_life(mechanism, LIMIT, draws=2, revolutions=10, **FAST)


ENGINE = {
    "clearances.gap.pin_radius": "12 mm",
    "clearances.gap.width": "25 mm",
    "clearances.gap.friction": 0.1,
    "clearances.gap.friction_law": "coulomb",
    "clearances.gap.wear": {"bearing": {"wear_rate": 1e-15}, "journal": {"wear_rate": 1e-16}},
}


@pytest.mark.slow
def test_means_of_a_chaotic_engine_are_within_their_errors():
    """Knocking in every turn: means from two starts differ by their standard errors."""
    engine = linkages.load("idling-engine", set=ENGINE)
    both = [
        WornMotions(m, linkages_options(m)).settled(np.zeros(1), np.zeros((1, 0)), None, 0.01)
        for m in (engine, engine.with_values({"clearances.gap.offset": [1e-5, 2e-5]}))
    ]
    apart = abs(both[0].work[0] - both[1].work[0])
    # 4 standard errors of a difference: one case out of 10 000
    assert apart <= 4 * math.hypot(*(float(each.error[0]) for each in both))
    assert all(each.error[0] <= 0.01 * each.work[0] for each in both)


def linkages_options(mechanism):
    from linkages.options.analysis_options import WearOptions
    from linkages.solution.run_options import options_of

    return options_of(WearOptions, mechanism, {"rtol": 1e-8})


@pytest.mark.slow
def test_an_engine_that_knocks_grows_as_its_error_says():
    """Against a run with a third of the jumps' length and of the means' errors."""
    engine = linkages.load("idling-engine", set=ENGINE)
    coarse = linkages.wear(engine, revolutions=10**7, rtol=1e-8)
    fine = linkages.wear(engine, revolutions=10**7, rtol=1e-8, accuracy=3e-3, largest_jump=0.08)
    both = [float(d["size"][-1, 0]) for d in (coarse, fine)]
    errors = [float(d["error"][-1, 0]) for d in (coarse, fine)]
    assert abs(both[0] - both[1]) <= sum(errors)
    assert errors[0] <= 0.02 * (both[0] - 1e-4)
    assert json.dumps(coarse.attrs["notes"])
