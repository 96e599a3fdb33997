"""Work and distance of slip, worn volumes, and the keys of wear, against closed forms."""

import math

import numpy as np
import pytest
from worn_mechanisms import (
    LINK,
    RADIUS,
    SIZE,
    SPEED,
    WEIGHT,
    WIDTH,
    block,
    depth,
    resting,
    rotor,
)

import linkages

WORN = ["clearance_sliding_work", "clearance_sliding_distance", "wear_volume"]


def end_of(mechanism, end=0.5, outputs=WORN, **how):
    data = linkages.simulate(mechanism, end=end, samples=11, outputs=outputs, **how).data
    return data.isel(time=-1)


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5])
def test_a_rotor_under_its_weight(friction):
    """F = m g cos(atan μ) slips with (R + c + d) ω."""
    force = WEIGHT * math.cos(math.atan(friction))
    speed = (RADIUS + SIZE + depth(force)) * SPEED
    found = end_of(rotor(resting(friction)), outputs=[*WORN, "clearance_pressure_velocity"])
    found = found.sel(clearance="gap")
    # it starts where it rests, to round-off of 1e-4 m over indentations of 1e-6 m
    assert float(found.clearance_sliding_work) == pytest.approx(force * speed * 0.5, rel=1e-9)
    assert float(found.clearance_sliding_distance) == pytest.approx(speed * 0.5, rel=1e-9)
    pressure = force / (2 * RADIUS * WIDTH)
    assert float(found.clearance_pressure_velocity) == pytest.approx(pressure * speed, rel=1e-9)
    volume = 1e-13 * force * speed * 0.5
    assert found.wear_volume.values == pytest.approx([0.0, volume], rel=1e-9)


def test_a_massless_link_under_its_weight():
    """The same without an indentation."""
    found = end_of(rotor(LINK)).sel(clearance="gap")
    speed = (RADIUS + SIZE) * SPEED
    assert float(found.clearance_sliding_work) == pytest.approx(WEIGHT * speed * 0.5, rel=1e-10)
    assert float(found.clearance_sliding_distance) == pytest.approx(speed * 0.5, rel=1e-10)


@pytest.mark.parametrize("carries", ["hole", "pin"])
def test_the_pin_may_be_on_either_body(carries):
    """A pin that turns slips with R ω, a bearing with (R + c) ω."""
    law = f"{LINK}, carries: {carries}"
    found = end_of(rotor(law)).sel(clearance="gap")
    radius = RADIUS + SIZE * (carries == "hole")
    assert float(found.clearance_sliding_distance) == pytest.approx(radius * SPEED * 0.5, rel=1e-9)


def test_a_block_on_its_guide():
    """Corners share the weight; all of them together slip as far as the block, in four strokes."""
    found = end_of(block(), end=2 * math.pi / 20)
    work = WEIGHT * 4 * 0.05
    # corners are lifted and pressed by the inertia of the block about its middle, steps see |v|
    # without the corner at its turns: 1e-6
    total = found.clearance_sliding_work.sum("clearance")
    assert float(total) == pytest.approx(work, rel=1e-5)
    volumes = found.wear_volume.sum("clearance").to_numpy()
    assert volumes == pytest.approx(np.array([1e-14, 3e-14]) * float(total), rel=1e-12)


ENGINE = {
    "clearances.gap.pin_radius": "12 mm",
    "clearances.gap.width": "25 mm",
    "clearances.gap.friction": 0.1,
    "clearances.gap.wear": {"journal": {"wear_rate": "1e-6 mm^3/(N m)"}},
}


def test_archard_and_coulomb_dissipate_alike():
    """V = (k/H) E/μ where friction is μ F, through impacts and sticking."""
    mechanism = linkages.load(
        "idling-engine", set=ENGINE | {"clearances.gap.friction_law": "coulomb"}
    )
    names = ["clearance_friction_dissipation", "wear_volume"]
    found = end_of(mechanism, 0.2, names).sel(clearance="gap")
    volume = 1e-15 * float(found.clearance_friction_dissipation) / 0.1
    assert volume > 0.0
    assert found.wear_volume.values == pytest.approx([volume, 0.0], rel=1e-9)


@pytest.mark.parametrize("friction", [{"friction_law": "tanh", "slip": 1e-3}, {"friction": 0}])
def test_work_is_the_integral_of_its_power(friction):
    """An independent quadrature of F |v|, which finds the corners that steps do not end at."""
    values = ENGINE | {f"clearances.gap.{key}": value for key, value in friction.items()}
    mechanism = linkages.load("idling-engine", set=values)
    solution = linkages.simulate(mechanism, end=0.2, samples=501, outputs=WORN)
    mean = linkages.measure(solution, "mean(abs(gap.slip)*gap.force)")
    assert mean == pytest.approx(linkages.measure(solution, "mean(gap.sliding_power)"), rel=1e-12)
    work = float(solution.data.clearance_sliding_work[-1, 0])
    assert work == pytest.approx(mean * 0.2, rel=1e-5)


def test_the_link_of_the_nine_bar_by_quadrature():
    """Its tension follows from accelerations."""
    link = {"pin_radius": "10 mm", "width": "20 mm", "wear": {"bearing": {"wear_rate": 1e-15}}}
    values = {f"clearances.r1.{key}": value for key, value in link.items()}
    mechanism = linkages.load("ninebar", set=values)
    solution = linkages.simulate(mechanism, end=0.3, samples=2001, outputs=WORN)
    work = float(solution.data.clearance_sliding_work[-1, 0])
    power = linkages.measure(solution, "mean(abs(r1.force)*abs(r1.sliding_power)/abs(r1.force))")
    assert work == pytest.approx(power * 0.3, rel=1e-6)


def test_wear_changes_no_motion():
    values = ENGINE | {"clearances.gap.friction_law": "coulomb"}
    worn = linkages.load("idling-engine", set=values)
    plain = linkages.load("idling-engine", set=values).with_values(
        {
            "clearances.gap": {
                **worn.definition.content["clearances"]["gap"],
                "wear": None,
                "width": None,
            }
        }
    )
    states = [
        linkages.simulate(m, end=0.1, samples=11, outputs=["clearance_offset"]).data
        for m in (worn, plain)
    ]
    assert np.array_equal(*(each.clearance_offset for each in states))


def test_mechanisms_without_wear_have_none_of_its_outputs():
    with pytest.raises(ValueError, match="has no wear_volume"):
        linkages.simulate(linkages.load("idling-engine"), outputs=["wear_volume"])


@pytest.mark.parametrize(
    ("given", "rate"),
    [
        ("wear_rate: 2e-16", 2e-16),
        ("wear_rate: 2e-7 mm³/(N m)", 2e-16),
        ("coefficient: 1e-6, hardness: 2 GPa", 5e-16),
        ("pair: brass-on-tool-steel, hardness: 1.2 GPa", 5e-13),
    ],
)
def test_wear_rates(given, rate):
    mechanism = rotor(wear=f"journal: {{{given}}}")
    (own,) = mechanism.worn
    assert own.wear.rates == pytest.approx((rate, 0.0))
    assert linkages.loads(mechanism.to_yaml()) == mechanism


@pytest.mark.parametrize(
    ("wear", "message"),
    [
        ("uncertainty: 3", "gap.wear: nothing wears; expected 'journal' or 'bearing'"),
        ("bearing: {}", "expected one of 'wear_rate', 'coefficient' and 'pair', found none"),
        ("bearing: {coefficient: 1e-3}", "wear.bearing: missing key 'hardness'"),
        ("bearing: {wear_rate: 1, coefficient: 1}", "found 'wear_rate' and 'coefficient'"),
        ("bearing: {wear_rate: 1, hardness: 1}", "expected no hardness beside it"),
        ("bearing: {wear_rate: 1 mm}", "not a wear rate"),
        ("bearing: {pair: brass, hardness: 1}", "expected a pair of materials"),
        ("bearing: {wear_rate: 1}, uncertainty: 0.5", "expected a factor of at least 1"),
        ("block: {wear_rate: 1}", "unknown key 'block'"),
    ],
)
def test_faulty_wear(wear, message):
    with pytest.raises(linkages.InputError, match=r"clearances\.gap\.wear") as error:
        rotor(wear=wear)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (
            "contact: lubricated, viscosity: 0.1",
            "lubricated keeps the sides apart; expected a law with a stiffness, or restitution",
        ),
    ],
)
def test_contacts_that_do_not_wear(law, message):
    with pytest.raises(linkages.InputError, match=message):
        rotor(law)


@pytest.mark.parametrize("key", ["pin_radius", "width"])
def test_missing_lengths(key):
    mechanism = rotor()
    gap = {k: v for k, v in mechanism.definition.content["clearances"]["gap"].items() if k != key}
    with pytest.raises(linkages.InputError, match=f"missing key '{key}': wear is spread over it"):
        mechanism.with_values({"clearances.gap": gap})
