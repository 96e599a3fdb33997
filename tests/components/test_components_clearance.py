import math

from component_reading import complaints, component, mechanism

from linkages.components.contributed.terms import ZERO
from linkages.components.joint_clearances import Clearance

FOUR_BAR = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
clearances:
"""
BARE = Clearance(name="r1", joint="B", bar="rocker", size=1.5e-4)


def test_same_from_yaml_and_python():
    text = FOUR_BAR + "  r1: {joint: B, bar: rocker, size: 0.15 mm}\n"
    # a unit may cost one rounding: 0.15·10⁻³ against the literal 1.5e-4
    made = component(text, "clearances", "r1")
    assert made in (BARE, Clearance(name="r1", joint="B", bar="rocker", size=0.15 * 1e-3))
    text = FOUR_BAR + "  r1: {joint: B, bar: rocker, size: 1.5e-4, angle: 90 deg, speed: -2}\n"
    full = Clearance(name="r1", joint="B", bar="rocker", size=1.5e-4, angle=math.pi / 2, speed=-2.0)
    assert component(text, "clearances", "r1") == full


def test_starts_at_rest_along_x():
    assert (BARE.angle, BARE.speed) == (0.0, 0.0)


def test_terms():
    displacement, initial = Clearance(
        name="r1", joint="B", bar="rocker", size=1e-3, angle=0.4, speed=-2
    ).terms()
    assert (displacement.joint, displacement.body) == ("B", "rocker")
    assert displacement.renamed == "B.r1"
    link = displacement.links[0]
    assert (link.name, link.kind, link.rotates) == ("r1", "clearance", True)
    assert [*link.points] == ["B", "B.r1"]
    assert link.points["B"] == (ZERO, ZERO)
    assert [p.value for p in link.points["B.r1"]] == [1e-3, 0.0]
    assert link.mass.absent
    assert link.inertia.absent
    assert (initial.body, initial.position, initial.speed) == ("r1", 0.4, -2)


def test_the_end_of_its_bar_is_displaced():
    bodies = mechanism(FOUR_BAR + "  r1: {joint: B, bar: rocker, size: 1e-3}\n").bodies
    assert [*bodies["rocker"].points] == ["C", "B.r1"]
    assert [*bodies["coupler"].points] == ["A", "B"]
    assert [*bodies["r1"].points] == ["B", "B.r1"]


def test_several_bars_may_have_clearance_at_one_joint():
    text = FOUR_BAR + (
        "  r1: {joint: B, bar: rocker, size: 1e-3}\n  r2: {joint: B, bar: coupler, size: 1e-3}\n"
    )
    bodies = mechanism(text).bodies
    assert [*bodies["coupler"].points] == ["A", "B.r2"]
    assert [*bodies["rocker"].points] == ["C", "B.r1"]


def test_size_is_not_zero():
    (problem,) = complaints(FOUR_BAR + "  r1: {joint: B, bar: rocker, size: 0}\n")
    assert problem.startswith("line 7, column 31, clearances.r1.size: expected a length > 0")
