"""Where constraints and coordinates do not match, the most likely cause comes first."""

import pytest
from linkage_files import mechanism, refusal

from linkages.kernel.system import System

FOUR_BAR = """joints: {O: [0, 0], D: [0.4, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  rod: {joints: [A, C], length: 0.35, mass: 1}
  lever: {joints: [D, C], length: 0.2, mass: 1}
assembly: {C: left}
"""
ONE = "drives: {crank: {angle: 1, speed: 1}}\n"
TWO = "drives:\n  lever: {angle: 1, speed: 1}\n  crank: {angle: 1, speed: 1}\n"


def test_a_joint_named_once_before_any_sentence_about_mobility():
    (problem,) = refusal(FOUR_BAR.replace("[D, C]", "[D, c]") + ONE, System)
    named = "bars.lever.joints: joint 'c' is on one body only, lever; did you mean 'C'?"
    assert named in problem
    assert problem.index(named) < problem.index("Otherwise: mobility is 3")


def test_of_two_names_the_one_with_unusual_capitals_is_the_odd_one():
    (problem,) = refusal(FOUR_BAR.replace("[A, C]", "[A, c]") + ONE, System)
    assert "bars.rod.joints: joint 'c' is on one body only, rod; did you mean 'C'?" in problem
    lower = (
        FOUR_BAR.replace("[A, C]", "[a, C]").replace("[D, C]", "[D, c]").replace("[O, A]", "[O, a]")
    )
    (problem,) = refusal(lower.replace("O", "o").replace("D", "d") + ONE, System)
    assert "bars.rod.joints: joint 'C' is on one body only, rod; did you mean 'c'?" in problem


@pytest.mark.parametrize("drives", [TWO, TWO + "free: {rod: {angle: 0, speed: 0}}\n"])
def test_a_joint_named_once_where_coordinates_are_in_the_way_of_each_other(drives):
    """As many coordinates as the mobility by count, or fewer: but at the wrong places."""
    (problem,) = refusal(FOUR_BAR.replace("[D, C]", "[D, c]") + drives, System)
    assert "joint 'c' is on one body only, lever; did you mean 'C'? Otherwise: " in problem


def test_a_joint_that_something_uses_may_be_on_one_body():
    text = FOUR_BAR.replace("[D, C]", "[D, C1]") + "masses: {C1: 2}\n"
    (problem,) = refusal(text + ONE, System)
    assert "joint 'C' is on one body only, rod; did you mean 'C1'?" in problem
    (problem,) = refusal(text.replace("C1: 2", "C1: 2, C: 1") + ONE, System)
    assert problem.split(": ")[1].startswith("mobility is 3, but 1 coordinate is driven (crank)")


def test_names_that_are_not_near_are_no_cause():
    (problem,) = refusal(FOUR_BAR.replace("[D, C]", "[D, X]") + ONE, System)
    assert "mobility is 3, but 1 coordinate is driven (crank) and 0 free" in problem
    assert problem.endswith("that a single body has: C (of rod), X (of lever)?")


def test_too_many_drives_before_any_sentence_about_assembly():
    (problem,) = refusal(FOUR_BAR + TWO, System)
    first = "mobility is 1, but 2 coordinates are driven (lever, crank) and 0 free; remove 1 of"
    assert problem.startswith(f"line 9, column 3, drives.crank: {first} them. Otherwise: cannot")


def test_a_moving_joint_under_joints():
    (problem,) = refusal(FOUR_BAR.replace("{O:", "{A: [0.05, 0.08], O:") + ONE, System)
    assert problem.startswith(
        "line 3, column 3, bars.crank: crank cannot move: its joints O and A are fixed to the "
        "ground; expected under 'joints' only those that do not move. Otherwise: "
    )


SLOT = """joints: {P: [0, 0.1], O: [0, 0]}
bars:
  crank: {joints: [P, A], length: 0.05, mass: 1}
  arm: {joints: [A, B], length: 0.3, mass: 1}
  twin: {joints: [A, B], length: 0.3, mass: 1}
sliders: {block: {joint: O, on: arm, mass: 1}}
drives: {crank: {angle: 1, speed: 1}}
"""


def test_what_is_missing_is_said_by_names_of_the_file():
    """Two bodies share two joints, and one of them carries a slider."""
    (problem,) = refusal(SLOT, System)
    assert (
        "group of 2 loops with 1 redundant equation at the axis of block can be assembled"
        in problem
    )
    # the two places of B, on the line through A = (0.027, 0.142) and O, 0.3 m from A
    assert "'B: [x, y]' (B would be at [-0.02903, -0.1526], [0.08306, 0.4368])" in problem


def test_a_slotted_arm_made_of_two_plates_moves_like_one():
    """The same positions as without the second plate, whose mass the first one gets."""
    hint = "assembly: {B: [-0.03, -0.15]}\n"
    twins = System(mechanism(SLOT + hint))
    lines = [line for line in SLOT.splitlines() if "twin" not in line]
    single = "\n".join(lines).replace("length: 0.3, mass: 1", "length: 0.3, mass: 2")
    one = System(mechanism(single + "\n" + hint))
    assert twins.topology.redundant == ("block.axis",)
    for joint, place in one.places().items():
        assert twins.places()[joint] == pytest.approx(place, abs=1e-15)  # of 0.3 m
    efforts = [
        system.evaluate([system.model.required_force(system.model.accelerations,
                                                     system.model.partial("crank"))])[0, 0]
        for system in (twins, one)
    ]  # fmt: skip
    assert efforts[0] == pytest.approx(efforts[1], rel=1e-12)


def test_two_identical_plates_on_a_slider():
    """Three equations too many; one plate turns by its drive, the other with it."""
    plate = "{points: {A: [0, 0], P: [1, 0], Q: [0, 1]}, mass: 1, center: [0, 0], inertia: 1}"
    text = (
        f"joints: {{O: [0, 0]}}\nbars:\n  p: {plate}\n  twin: {plate}\n"
        "sliders: {s: {joint: A, through: O, mass: 1}}\n"
        "drives: {p: {angle: 0.5, speed: 1}}\nfree: {s: {position: 2, speed: 1}}\n"
    )
    system = System(mechanism(text))
    (angle,) = system.evaluate([system.model.positions.angle("twin")])[:, 0]
    assert angle == pytest.approx(0.5, abs=1e-14)
    assert system.places()["A"] == pytest.approx([2.0, 0.0], abs=1e-15)


def test_a_slider_that_only_repeating_bars_carry():
    """Crank and rod share both joints: as many equations as unknowns, but none for the piston."""
    text = (
        "joints: {O: [0, 0]}\nbars:\n  crank: {joints: [B, A], length: 0.04}\n"
        "  rod: {joints: [A, B], length: 0.14}\nsliders: {piston: {joint: B, through: O}}\n"
    )
    (problem,) = refusal(text + ONE, System)
    assert problem.endswith("sliders.piston: nothing determines the coordinate of 'piston'")
