"""Verdicts on undriven motions with impacts: their section is taken at touches."""

import numpy as np
import pytest

import linkages

BILLIARD = """\
name: Billiard
gravity: [0, GRAVITY]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 0.1, mass: 1, inertia: 0.01, center: 0}}
clearances:
  gap: {joint: O, bar: rod, size: 10 mm, contact: restitution, restitution: 1,
        offset: [2 mm, 0], rate: [0.05, 0.02], least_rate: 1e-6}
free: {rod: {angle: 0}}
simulate: {end: 1}
"""


@pytest.mark.slow_except("-0.5*")
@pytest.mark.parametrize(("gravity", "expected"), [(0, "quasi-periodic"), (-0.5, "chaotic")])
def test_a_body_that_flies_in_its_bearing(gravity, expected):
    """G. D. Birkhoff (1927): chords of a circle turn by one angle at every touch.

    With gravity an independent map with tangents has the exponent 3.573 over 60,000 touches.
    """
    report = linkages.verdict(linkages.loads(BILLIARD.replace("GRAVITY", str(gravity))))
    assert report.verdict == expected, report.reasons
    assert report.section.attrs["section"] == "gap.touch"
    assert set(report.rotation) == {"rod"}
    if gravity:
        value, error = (float(report.exponents[name][0]) for name in ("exponent", "error"))
        assert abs(value - 3.573) < 3 * error
    else:
        # across the chord of a start at 2 mm in the direction of (5, 2)
        distance = 2e-3 * 2 / np.hypot(5, 2)
        chord = 2 * np.sqrt(1e-4 - distance**2)
        assert report.run["period"] == pytest.approx(chord / np.hypot(0.05, 0.02), rel=1e-6)


SLIDER = """\
name: Elastic stops
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, angle: ANGLE, mass: 1}}
stops: [{slider: m, STOPS, restitution: 1}]
free: {m: {position: 0.5, speed: 1}}
simulate: {end: 1}
"""


@pytest.mark.slow_except("one floor")
@pytest.mark.parametrize(
    ("angle", "stops", "period"),
    [
        ("0 deg", "lower: -1, upper: 1", 4.0),
        ("90 deg", "lower: 0", 2 * np.sqrt(2 * (9.81 * 0.5 + 0.5)) / 9.81),
    ],
    ids=["two walls", "one floor"],
)
def test_elastic_impacts_repeat(angle, stops, period):
    text = SLIDER.replace("ANGLE", angle).replace("STOPS", stops)
    report = linkages.verdict(linkages.loads(text), periods=200)
    assert (report.verdict, report.period) == ("periodic", 1), report.reasons
    assert report.section.attrs["section"] == "stops[0].lower.touch"
    assert report.run["period"] == pytest.approx(period, rel=1e-9)


@pytest.mark.parametrize("rtol", [1e-7, 1e-9])
def test_bounces_that_end_come_to_rest(rtol):
    """Impacts accumulate, so that they are no section of the motion."""
    text = SLIDER.replace("ANGLE", "90 deg").replace("STOPS", "lower: 0")
    falling = linkages.loads(text.replace("restitution: 1", "restitution: 0.7"))
    report = linkages.verdict(falling, periods=200, rtol=rtol)
    assert report.verdict == report.tighter["verdict"] == "at rest", report.reasons
    assert report.section.attrs["section"] == "m.velocity=0"
