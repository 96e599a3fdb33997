import math

import pytest
from linkage_files import FOLDER, FOUR_BAR, linkage, mechanism, refusal

from linkages.kernel.system import System
from linkages.topology.assur_groups import Step
from linkages.topology.topology import build_topology


def test_coordinates_by_what_determines_them():
    topology = build_topology(linkage("ninebar"))
    assert topology.driven == ("crank1", "crank4")
    assert topology.free == ("r1",)
    assert topology.dependent == ("link2", "link3", "rocker6", "link7", "link8", "slider9")


def test_joints_are_listed_from_the_ground_on():
    joints = build_topology(linkage("ninebar")).joints
    assert joints == ("O", "D", "A", "B", "C.r1", "C", "E", "F")


def test_free_ends():
    assert build_topology(linkage("trammel")).free_ends == ("P",)
    assert build_topology(linkage("doublependulum")).free_ends == ("Q",)
    assert build_topology(linkage("ninebar")).free_ends == ()


def test_path_from_the_ground():
    topology = build_topology(linkage("ninebar"))
    assert topology.path("O") == ([], "O")
    assert topology.path("A") == ([Step("crank1", "O", "A")], "O")
    assert topology.path("C.r1") == ([Step("crank4", "D", "C"), Step("r1", "C", "C.r1")], "D")
    piston = build_topology(linkage("slidercrank"))
    assert [step.body for step in piston.path("B")[0]] in (["crank", "rod"], ["piston"])


def test_steps_and_loops_run_both_ways():
    (block,) = build_topology(linkage("fourbar")).solved_blocks
    (loop,) = block.loops
    assert loop.reversed.reversed == loop
    assert (loop.reversed.start, loop.reversed.end) == (loop.end, loop.start)
    assert [s.body for s in loop.reversed.steps] == [s.body for s in loop.steps][::-1]
    assert block.label == "RRR dyad at joint B"


@pytest.mark.parametrize("swap", [False, True])
def test_a_loop_starts_with_the_first_unknown_bar_of_the_file(swap):
    lines = FOUR_BAR.splitlines()
    if swap:
        lines[3:5] = lines[3:5][::-1]
    text = "\n".join(lines) + "\ndrives: {crank: {angle: 1, speed: 1}}\n"
    (block,) = build_topology(mechanism(text)).solved_blocks
    bodies = [step.body for step in block.loops[0].steps]
    assert bodies == (["rocker", "coupler"] if swap else ["coupler", "rocker"])


# --- mobility -----------------------------------------------------------------------------------


def test_missing_drive():
    assert refusal(FOUR_BAR) == [
        "line 1, column 1: mobility is 1, but 0 coordinates are driven and 0 free; expected as "
        "many as the mobility: add a drive, or name a bar under 'free' with its initial angle"
    ]


def test_a_mistyped_joint_is_named():
    """A rocker that hangs in the air leaves two links loose."""
    (message,) = refusal(FOUR_BAR.replace("[C, B]", "[C, X]"))
    assert "mobility is 3" in message
    assert "is one of the joints mistyped that a single body has: B (of coupler), X (of" in message


INDEPENDENT = "expected the drives and free coordinates to be independent of each other"
TWO = "\n  crank: {angle: 1, speed: 1}\n  rocker: {angle: ANGLE, speed: 1}\n"


def angle_of_the_rocker():
    """Where it is when the crank stands at 1 rad."""
    crank = "drives: {crank: {angle: 1, speed: 1}}\nassembly: {B: left}\n"
    x, y = System(mechanism(FOUR_BAR + crank)).places()["B"]
    return math.atan2(y, x - 1.0)


@pytest.mark.parametrize("section", ["drives", "free"])
def test_two_known_bars_for_one_degree_of_freedom(section):
    """Drives or free coordinates at angles that do not fit."""
    (problem,) = refusal(FOUR_BAR + section + ":" + TWO.replace("ANGLE", "1"), System)
    given = "2 coordinates are driven (crank, rocker) and 0 free"
    if section == "free":
        given = "0 coordinates are driven and 2 free (crank, rocker)"
    assert f"rocker: mobility is 1, but {given}; remove 1 of them. Otherwise: cannot" in problem
    assert (
        "the constraints at B contradict each other: expected dimensions that fit, or fewer"
        in problem
    )


@pytest.mark.parametrize("section", ["drives", "free"])
@pytest.mark.parametrize("speed", [1, 0])
def test_two_known_bars_that_fit_in_one_position(section, speed):
    """They would be in the way of each other, even at rest."""
    two = TWO.replace("ANGLE", repr(angle_of_the_rocker())).replace("speed: 1", f"speed: {speed}")
    (problem,) = refusal(FOUR_BAR + section + ":" + two, System)
    assert "more constraints than coordinates at B: they would not let crank move" in problem
    assert INDEPENDENT in problem


def test_a_drive_of_every_bar():
    drives = TWO.replace("ANGLE", "1") + "  coupler: {angle: 0, speed: 0}\n"
    (problem,) = refusal(FOUR_BAR + "drives:" + drives, System)
    assert "cannot be assembled: nothing is left to be moved" in problem
    assert "more constraints than coordinates at" in problem


@pytest.mark.parametrize("speed", [0, 1])
def test_a_structure_that_cannot_move(speed):
    text = FOUR_BAR.replace("crank: {joints: [O, A]", "crank: {joints: [O, C]")
    text = text.replace("coupler: {joints: [A,", "coupler: {joints: [O,")
    drive = f"drives: {{crank: {{angle: 0, speed: {speed}}}}}\nassembly: {{B: left}}\n"
    (problem,) = refusal(text + drive, System)
    cause = "crank cannot move: its joints O and C are fixed to the ground; expected under 'joints'"
    assert problem.startswith(f"line 3, column 3, bars.crank: {cause}")
    assert "cannot be assembled: nothing is left" in problem
    assert "crank meets C; more constraints than coordinates at C" in problem
    # and where its length fits, its drive still has nothing to move
    (problem,) = refusal(text.replace("0.3}", "1}") + drive, System)
    assert "more constraints than coordinates at C: they would not let crank move" in problem


def test_unreachable_bodies_are_all_named():
    text = FOUR_BAR + "  lost: {joints: [X, Y], length: 1}\n  adrift: {joints: [Y, Z], length: 1}\n"
    message = "not connected to the ground by any chain of joints"
    assert refusal(text + "drives: {crank: {angle: 0, speed: 1}}\n") == [
        f"line 6, column 3, bars.lost: {message}",
        f"line 7, column 3, bars.adrift: {message}",
    ]


def test_no_ground_at_all():
    found = refusal("bars:\n  a: {joints: [X, Y], length: 1}\n  b: {joints: [Y, Z], length: 1}\n")
    assert len(found) == 2


def test_under_and_over_constrained_parts():
    text = FOUR_BAR + "  tail: {joints: [B, T], length: 0.2}\n"
    drives = "drives:\n  crank: {angle: 1, speed: 1}\n  rocker: {angle: 1, speed: 1}\n"
    found = refusal(text + drives)
    assert found[1] == "line 6, column 3, bars.tail: nothing determines the coordinate of 'tail'"
    assert found[0] == (
        "line 1, column 1: more constraints than coordinates at A, B; expected the drives and "
        "free coordinates to be independent of each other"
    )


TRIANGLE = """joints: {O: [0, 0], C: [1, 0]}
bars:
  left: {joints: [O, T], length: 1}
  right: {joints: [C, T], length: 1}
  hanging: {joints: [T, P], length: 1}
"""


def test_driving_a_bar_that_cannot_move():
    """A triangle on the ground stands still: its drive and a missing one elsewhere cancel."""
    found = refusal(TRIANGLE + "drives: {left: {angle: 1, speed: 0}}\n")
    assert "line 5, column 3, bars.hanging: nothing determines the coordinate of 'hanging'" in found


def test_a_triangle_on_the_ground_carries_a_pendulum():
    """A dyad that time does not move is a block like any other."""
    topology = build_topology(mechanism(TRIANGLE + "free: {hanging: {angle: 1}}\n"))
    assert [set(b.unknowns) for b in topology.solved_blocks] == [{"left", "right"}]


# --- Assur groups of class III ------------------------------------------------------------------

TRIAD = """joints: {O: [0, 0], C: [1, 0], D: [0.5, 1]}
bars:
  crank: {joints: [O, A], length: 0.1}
  plate: {points: {P: [0, 0], Q: [0.3, 0], R: [0.15, 0.2]}}
  a: {joints: [A, P], length: 0.4}
  b: {joints: [C, Q], length: 0.4}
  c: {joints: [D, R], length: 0.4}
drives: {crank: {angle: 0, speed: 1}}
"""


def groups(topology):
    return [(b.kind, {*b.unknowns}, len(b.loops)) for b in topology.solved_blocks]


def test_a_plate_on_three_links_is_no_dyad():
    """It is one group of two loops, solved by iteration from coordinates that are carried along."""
    topology = build_topology(mechanism(TRIAD))
    assert groups(topology) == [("N", {"plate", "a", "b", "c"}, 2)]
    (block,) = topology.solved_blocks
    assert (block.title, block.surplus) == ("group of 2 loops", 0)
    assert {*topology.carried} == {*topology.iterated} == {"plate", "a", "b", "c"}
    assert topology.coordinates == topology.carried
    assert topology.redundant == ()


def test_whether_a_group_is_a_dyad_depends_on_the_drive():
    """Stephenson III: dyads from the crank, a triad from the other end."""
    text = (FOLDER / "stephenson.yaml").read_text()
    dyads = build_topology(mechanism(text))
    assert [kind for kind, *_ in groups(dyads)] == ["RRR", "RRR"]
    assert dyads.carried == ()
    triad = build_topology(mechanism(text.replace("  crank: {angle", "  arm: {angle")))
    assert groups(triad) == [("N", {"crank", "coupler", "rocker", "tie"}, 2)]


def test_a_triad_before_a_dyad():
    extra = "  tie: {joints: [P, X], length: 1}\n  arm: {joints: [C, X], length: 1}\ndrives:"
    topology = build_topology(mechanism(TRIAD.replace("drives:", extra)))
    expected = [("N", {"plate", "a", "b", "c"}, 2), ("RRR", {"tie", "arm"}, 1)]
    assert groups(topology) == expected
    assert {*topology.carried} == {"plate", "a", "b", "c"}


# --- where the drive is -------------------------------------------------------------------------


@pytest.mark.parametrize("driven", ["crank", "coupler", "rocker"])
def test_the_drive_may_sit_on_any_bar(driven):
    topology = build_topology(mechanism(FOUR_BAR + f"drives: {{{driven}: {{angle: 1, speed: 1}}}}"))
    (block,) = topology.solved_blocks
    assert set(block.unknowns) == {"crank", "coupler", "rocker"} - {driven}
    assert block.kind == "RRR"


def test_a_free_slider():
    text = """joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3}, rod: {joints: [A, B], length: 0.8}}
sliders: {piston: {joint: B, through: O}}
free: {piston: {position: 0.9}}
"""
    topology = build_topology(mechanism(text))
    assert [(b.kind, set(b.unknowns)) for b in topology.solved_blocks] == [
        ("RRR", {"crank", "rod"})
    ]
