import pytest
from component_reading import complaints, component, mechanism

from linkages.components.contributed.load_measures import Load, Turn, damper_law
from linkages.components.contributed.terms import Parameter
from linkages.components.springs import ClearanceDamper, DamperBetweenBars, JointDamper

BARS = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {joints: [A, B], length: 0.8}
  rocker: {joints: [C, B], length: 0.7}
  arm: {joints: [A, D], length: 0.7}
sliders:
  block: {joint: D, through: O}
  bead: {joint: W, on: rocker}
free: {bead: {position: 0.1}}
clearances: {r1: {joint: B, bar: rocker, size: 1e-4}}
dampers:
"""
DAMPING = Parameter(("dampers", 0, "damping"), 0.1, structural=True)


@pytest.mark.parametrize(
    ("entry", "made"),
    [
        ("{joint: O, damping: 0.1 N*m*s/rad}", JointDamper(index=0, joint="O", damping=0.1)),
        (
            "{joint: A, bars: [arm, rod], damping: 0.1}",
            JointDamper(index=0, joint="A", bars=("arm", "rod"), damping=0.1),
        ),
        (
            "{bars: [ground, rod], damping: 0.1}",
            DamperBetweenBars(index=0, bars=("ground", "rod"), damping=0.1),
        ),
        ("{clearance: r1, damping: 0.1}", ClearanceDamper(index=0, clearance="r1", damping=0.1)),
    ],
)
def test_same_from_yaml_and_python(entry, made):
    assert component(BARS + f"- {entry}\n", "dampers", 0) == made


@pytest.mark.parametrize(
    ("entry", "body", "reference"),
    [
        ("joint: O", "crank", None),
        ("joint: B", "rocker", "rod"),  # the bars that meet at B, not the link of the clearance
        ("joint: D", "arm", None),  # a block on a ground axis does not turn
        ("joint: A, bars: [arm, rod]", "rod", "arm"),
        ("joint: D, bars: [ground, arm]", "arm", None),
        ("bars: [rocker, crank]", "crank", "rocker"),
        ("bars: [ground, rod]", "rod", None),
        ("clearance: r1", "r1", "rocker"),
    ],
)
def test_between_which_bodies(entry, body, reference):
    (load,) = mechanism(BARS + f"- {{{entry}, damping: 0.1}}\n").loads
    assert load == Load(Turn(body, reference), damper_law(DAMPING), ("dampers", 0))


def test_a_block_turns_with_what_carries_it():
    text = BARS.replace("arm: {joints: [A, D]", "arm: {joints: [A, W]").replace(
        "  block: {joint: D, through: O}\n", ""
    )
    (load,) = mechanism(text + "- {joint: W, damping: 0.1}\n").loads
    assert {load.measure.body, load.measure.reference} == {"rocker", "arm"}


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        (
            "{joint: A, damping: 1}",
            "dampers[0]: 3 bodies turn at joint 'A' (crank, rod, arm); expected 'bars' to name "
            "two of them, such as bars: [crank, rod]",
        ),
        (
            "{joint: W, damping: 1}",
            "dampers[0].joint: nothing turns at joint 'W' against rocker; "
            "expected a joint of two bodies",
        ),
        (
            "{joint: A, bars: [crank, rocker], damping: 1}",
            "dampers[0].bars[1]: 'rocker' does not turn at joint 'A'; found crank, rod, arm",
        ),
        (
            "{joint: A, bars: [ground, crank], damping: 1}",
            "dampers[0].bars[0]: 'ground' does not turn at joint 'A'; found crank, rod, arm",
        ),
        ("{joint: E, damping: 1}", "dampers[0].joint: unknown joint 'E'"),
        ("{joint: A, bars: [rod, rod], damping: 1}", "two different bodies, found 'rod' twice"),
        ("{bars: [rod, rot], damping: 1}", "dampers[0].bars[1]: unknown bar 'rot'; did you mean"),
        (
            "{clearance: r2, damping: 1}",
            "dampers[0].clearance: unknown clearance 'r2'; expected one of: r1",
        ),
        ("{clearance: r1, damping: 1 N*s/m}", "not a torsional damping"),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(BARS + f"- {entry}\n")
    assert found in problem
