"""Gaps that almost close: the least of them, and its time."""

import numpy as np
import pytest

import linkages

SWINGING = """
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, mass: 0.5, inertia: 1e-3}}
clearances:
  gap: {slider: block, size: 1 mm, length: 100 mm, height: 50 mm, contact: restitution,
        restitution: 0.5, offset: HIGH mm}
free: {block: {position: 0, speed: 0}}
gravity: [0, GRAVITY]
"""


def thrown(rate, gravity, **options):
    """A block thrown at the upper wall from the middle of its guide."""
    text = SWINGING.replace("HIGH", "0").replace("GRAVITY", f"{-gravity!r}")
    text = text.replace("offset: 0 mm", f"rate: {rate!r}")
    return linkages.simulate(linkages.loads(text), outputs="all", **options)


@pytest.mark.slow_except("*False")
@pytest.mark.parametrize(("share", "nearly"), [(0.999, True), (0.9, False), (1.001, False)])
def test_a_block_that_turns_before_the_wall(share, nearly):
    """It rises to v²/2g, here a share of the play of 1 mm, at t = v/g."""
    rate = np.sqrt(2 * 9.81 * share * 1e-3)
    notes = thrown(float(rate), 9.81, end=1.5 * rate / 9.81, samples=8).notes
    said = [note for note in notes if "nearly touches" in note]
    assert bool(said) == nearly
    if nearly:
        # a parabola is a cubic, to the digits that are written
        assert f"at t = {rate / 9.81:.6g} s" in said[0]
        assert "closes to 1e-06 m" in said[0]
        assert len(said) == 2  # both upper corners
    if share > 1:
        assert any("1 touch" in note for note in notes)


THROWN = """
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, mass: 0.5}}
free: {block: {position: 0, speed: 2}}
loads: [{slider: block, force: -5 N}]
stops: [{slider: block, upper: PLACE, restitution: 0.5}]
"""
SPUN = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1, mass: 0.5, center: 0, inertia: 0.5}}
free: {arm: {angle: 0, speed: 2}}
loads: [{bar: arm, torque: -5}]
stops: [{bars: [ground, arm], upper: PLACE, restitution: 0.5}]
"""


@pytest.mark.parametrize(("text", "unit"), [(THROWN, "m"), (SPUN, "rad")], ids=["slides", "turns"])
@pytest.mark.parametrize(("beyond", "nearly"), [(1e-4, True), (0.01, False), (-1e-4, False)])
def test_a_body_that_turns_before_its_stop(text, unit, beyond, nearly):
    """v²/2a = 0.2 of the way at t = 0.2 s, which no sample is at; the stop stands behind it."""
    mechanism = linkages.loads(text.replace("PLACE", f"{0.2 + beyond!r} {unit}"))
    notes = linkages.simulate(mechanism, end=0.45, samples=8).notes
    said = [note for note in notes if "nearly touches" in note]
    assert bool(said) == nearly
    if nearly:
        # a parabola is a cubic, to the digits that are written
        assert said[0].startswith("stops[0].upper nearly touches at t = 0.2 s: ")
        assert f"closes to 0.0001 {unit}," in said[0]
    assert any("1 touch" in note for note in notes) == (beyond < 0)
