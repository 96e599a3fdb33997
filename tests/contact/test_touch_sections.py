"""Sections at touch-downs: times and rates against reference results, the rest against geometry."""

import numpy as np
import pytest
from contact_references import Reference
from test_reference_motions import mechanism_of

import linkages
from linkages.plots.chaos.chaos_figures import impact_map_figure

NAME, PERIOD = "4-slider-crank-5000rpm", 0.012
SIZE = 0.5e-3


@pytest.fixture(scope="module")
def section():
    touched = [event for event in Reference(NAME).events if event["kind"] == "touch"]
    return linkages.poincare(
        mechanism_of(NAME), section="gap.touch", periods=len(touched), end=PERIOD, rtol=1e-12
    )


def test_touches_are_those_of_the_reference(section):
    """The motion forgets 2.3 digits within the revolution; 1e-9 s is what remains of 1e-12."""
    touched = [event for event in Reference(NAME).events if event["kind"] == "touch"]
    times = np.array([float(event["t"]) for event in touched])
    assert section["time"].to_numpy() == pytest.approx(times, abs=1e-9, rel=0)
    rates = np.array([float(event["indentation_rate"]) for event in touched])
    # a rate changes by itself within 50 µs
    assert section["touch_rate"][:, 0].to_numpy() == pytest.approx(rates, abs=1e-4 * rates.max())


def test_phase_direction_and_rate_follow_from_states(section):
    """Offset and its rate are the free coordinates; the touch is where the offset is the size."""
    x, y = section["offset_position"].sel(offset=["gap.x", "gap.y"]).to_numpy().T
    u, v = section["offset_rate"].sel(offset=["gap.x", "gap.y"]).to_numpy().T
    assert np.hypot(x, y) == pytest.approx(SIZE, rel=1e-9)  # located to round-off of 0.1 m
    direction = section["touch_direction"][:, 0].to_numpy()
    assert np.cos(direction) == pytest.approx(x / SIZE, abs=1e-9)
    assert np.sin(direction) == pytest.approx(y / SIZE, abs=1e-9)
    rate = (x * u + y * v) / SIZE
    assert section["touch_rate"][:, 0].to_numpy() == pytest.approx(rate, rel=1e-9)
    assert (rate > 0).all()
    phase = section["touch_phase"][:, 0].to_numpy()
    assert phase == pytest.approx(section["time"].to_numpy() / PERIOD, abs=1e-12)
    assert list(section["touch"].to_numpy()) == ["gap"]


def test_pins_leave_where_the_section_is_crossed_downwards():
    left = [event for event in Reference(NAME).events if event["kind"] == "leave"][:5]
    found = linkages.poincare(
        mechanism_of(NAME), section="gap.touch", direction="down", periods=5, end=PERIOD, rtol=1e-11
    )
    times = [float(event["t"]) for event in left]
    assert found["time"].to_numpy() == pytest.approx(times, abs=1e-9)
    assert (found["touch_rate"] < 0).all()


def test_impacts_of_a_rigid_pin():
    """23 of them, until it stays on the wall; each takes no time."""
    reference = Reference("7-rigid-pin-in-hole")
    impacts = [float(event["t"]) for event in reference.events if "impact" in event["kind"]]
    found = linkages.poincare(
        linkages.loads(reference.definition), section="gap.touch", periods=60, end=0.1, rtol=1e-11
    )
    assert found["time"].to_numpy() == pytest.approx(impacts, abs=1e-9)
    assert "touch_phase" not in found  # nothing is driven
    assert "23 of 60 points" in found.attrs["warning"]


def test_events_may_be_touches():
    solution = linkages.simulate(
        mechanism_of(NAME), end=2e-3, samples=2,
        events={"gap.touch": "up", "gap.indentation=0": "up"},
    )  # fmt: skip
    named, crossed = (solution.events[name] for name in ("gap.touch", "gap.indentation=0"))
    assert len(named.time) > 3
    assert named.time.to_numpy().tolist() == crossed.time.to_numpy().tolist()


def test_a_diagram_has_the_touches_of_each_value():
    vary = {"clearances.gap.size": [4e-4, 5e-4]}
    options = {"section": "gap.touch", "periods": 6, "skip": 2, "rtol": 1e-9}
    diagram = linkages.bifurcation(mechanism_of(NAME), vary, **options)
    for index, size in enumerate(vary["clearances.gap.size"]):
        one = mechanism_of(NAME).with_values({"clearances.gap.size": size})
        section = linkages.poincare(one, **options)
        for name in ("touch_phase", "touch_direction", "touch_rate"):
            found = diagram[name][0, index]
            assert found.to_numpy().tolist() == section[name].to_numpy().tolist()


def test_maps_of_touches_are_drawn_over_the_phase(section):
    (rates, directions) = impact_map_figure(section).axes
    assert rates.get_xlim() == (0.0, 1.0)
    (dots,) = rates.lines
    assert dots.get_ydata() == pytest.approx(section["touch_rate"][:, 0].to_numpy())
    (dots,) = directions.lines
    degrees = np.degrees(section["touch_direction"][:, 0].to_numpy())
    assert dots.get_ydata() == pytest.approx(degrees)
    (directed,) = impact_map_figure(section.drop_vars("touch_phase")).axes
    assert "direction" in directed.get_xlabel()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("gab.touch", "'gab' is no clearance that opens .*; did you mean 'gap'"),
        ("crank.touch", "'crank' is no clearance that opens .*; expected gap"),
        ("gap.tough=0", "gap has no 'tough'"),
    ],
)
def test_what_cannot_touch(text, words):
    with pytest.raises(ValueError, match=words):
        linkages.poincare(mechanism_of(NAME), section=text, periods=2)


def test_a_massless_link_touches_always():
    with pytest.raises(ValueError, match="'r1' is no clearance that opens"):
        linkages.poincare(linkages.load("ninebar"), section="r1.touch", periods=2)


BALL = """\
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {ball: {joint: P, through: O, angle: 90 deg, mass: 0.3}}
stops: [{slider: ball, lower: 0, restitution: 0.7}]
free: {ball: {position: 1, speed: 0}}
simulate: {end: 2}
"""


def test_touches_of_a_stop():
    """Each impact leaves 0.7 of the rate, until that is below the usual 1 mm/s; then it rests."""
    ball = linkages.loads(BALL)
    found = linkages.poincare(ball, section="stops[0].lower.touch", periods=60, end=100)
    first = np.sqrt(2 * 9.81)
    rates = first * 0.7 ** np.arange(24)
    flights = np.concatenate([[first / 9.81], 2 * rates[1:] / 9.81])
    # errors of a tolerance of 1e-10 m/s remain as they are while rates shrink
    assert found["touch_rate"][:, 0].to_numpy() == pytest.approx(rates, abs=1e-9)
    assert found["time"].to_numpy() == pytest.approx(np.cumsum(flights), abs=1e-10)
    assert list(found["touch"].to_numpy()) == ["stops[0].lower"]
    assert "24 of 60 points" in found.attrs["warning"]
    events = linkages.simulate(ball, events={"stops[0].touch": "up"}).events["stops[0].touch"]
    times = found["time"].to_numpy()
    assert events.time.to_numpy() == pytest.approx(times[times < 2], abs=1e-12)


def test_touches_of_a_stop_over_a_parameter():
    vary = {"stops[0].restitution": [0.5, 1.0]}
    options = {"section": "stops[0].lower.touch", "periods": 5, "end": 20.0, "skip": 0}
    diagram = linkages.bifurcation(linkages.loads(BALL), vary, **options)
    rates = diagram["touch_rate"].to_numpy().reshape(2, 5)
    first = np.sqrt(2 * 9.81)
    assert rates[0] == pytest.approx(first * 0.5 ** np.arange(5), rel=1e-9)
    assert rates[1] == pytest.approx(np.full(5, first), rel=1e-9)


@pytest.mark.parametrize(
    ("section", "direction", "words"),
    [
        ("stops[0].lower.touch", "down", "expected direction 'up'"),
        ("stops[0].touch", "up", r"of 2; expected stops\[0\].lower or stops\[0\].upper"),
        ("stops[0].uper.touch", "up", r"did you mean 'stops\[0\].upper'"),
    ],
)
def test_what_is_no_touch_of_a_stop(section, direction, words):
    two = linkages.loads(BALL.replace("lower: 0", "lower: 0, upper: 3"))
    with pytest.raises(ValueError, match=words):
        linkages.poincare(two, section=section, direction=direction, periods=2)


def test_a_pin_that_rests_on_its_wall_does_not_touch_it_again():
    text = """\
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 0.5, mass: 2}}
clearances:
  gap: {joint: O, bar: rod, size: 1 mm, contact: restitution, restitution: 0.5}
free: {rod: {angle: -90 deg}}
dampers: [{bars: [ground, rod], damping: 0.5}]
simulate: {end: 1}
"""
    found = linkages.poincare(linkages.loads(text), section="gap.touch", periods=100, end=20)
    assert len(found.time) < 30
    assert (found["touch_rate"] > 1e-4).all()
