import numpy as np
import pytest
from kernel_motion import places_at
from linkage_models import refusal, system, system_of

from linkages.errors import InputError

FOUR_BAR = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
drives: {crank: {angle: 1, speed: 1}}
"""
SLIDER_CRANK = """joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {joints: [A, B], length: 0.8}
sliders: {piston: {joint: B, through: O, angle: 0}}
drives: {crank: {angle: 1, speed: 1}}
"""


def side_of(places, joint, first, second):
    """+1 where a joint lies on the left of the line from one joint to another."""
    (ax, ay), (bx, by) = places[second] - places[first], places[joint] - places[first]
    return np.sign(ax * by - ay * bx)


@pytest.mark.parametrize(("word", "side"), [("left", 1), ("right", -1)])
@pytest.mark.parametrize("swapped", [False, True])
def test_sides_are_seen_along_the_bars_of_the_file(word, side, swapped):
    """Coupler first: from A to C; rocker first: from C to A."""
    lines = FOUR_BAR.splitlines(keepends=True)
    if swapped:
        lines[3:5] = lines[3:5][::-1]
    of = system_of("".join(lines) + f"assembly: {{B: {word}}}")
    assert of.assembly.sides == {0: side}
    assert of.assembly.assumed == ()
    ends = ("C", "A") if swapped else ("A", "C")
    assert side_of(of.places(), "B", *ends) == side


@pytest.mark.parametrize(("where", "side"), [("[0.9, 0.6]", 1), ("[0.6, -0.5]", -1), ("[9, 9]", 1)])
def test_the_nearest_place_is_taken(where, side):
    of = system_of(FOUR_BAR + f"assembly: {{B: {where}}}")
    assert of.assembly.sides == {0: side}


def test_a_side_holds_in_motion():
    """The sign of a dyad is the same at all times: positions are continuous."""
    of = system_of(FOUR_BAR + "assembly: {B: right}")
    sides = [side_of(places_at(of, t), "B", "A", "C") for t in np.linspace(0, 7, 50)]
    assert set(sides) == {-1}


def test_missing_hint_names_both_places():
    message = refusal(FOUR_BAR)
    assert message == (
        "line 1, column 1, assembly: joint B can be in two places; expected 'B: left' (at [0.9442, "
        "0.6978]) or 'B: right' (at [0.568, -0.5508])"
    )
    for word, place in (("left", [0.9442, 0.6978]), ("right", [0.568, -0.5508])):
        found = system_of(FOUR_BAR + f"assembly: {{B: {word}}}").places()["B"]
        assert found == pytest.approx(place, abs=5e-5)  # printed with four digits


@pytest.mark.parametrize("bar", ["coupler", "rocker"])
def test_a_hint_can_be_given_where_the_clearance_is(bar):
    """The displaced end of a bar has no name in the file: messages must not ask for it."""
    text = FOUR_BAR + f"clearances: {{r1: {{joint: B, bar: {bar}, size: 1 mm}}}}\n"
    message = refusal(text)
    assert "'B: left'" in message
    assert "B.r1" not in message
    for word, side in (("left", 1), ("right", -1)):
        of = system_of(text + f"assembly: {{B: {word}}}")
        assert of.assembly.sides == {0: side}
        assert side_of(of.places(), "B", "A", "C") == side


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        ("A", "joint A has one possible place only; expected no side"),
        ("O", "joint O has one possible place only; expected no side"),
    ],
)
def test_a_side_of_the_wrong_joint(joint, message):
    text = FOUR_BAR + f"assembly:\n  B: left\n  {joint}: right\n"
    assert refusal(text) == f"line 9, column 3, assembly.{joint}: {message}"


def test_a_side_of_a_point_beside_the_meeting_joint():
    text = FOUR_BAR.replace(
        "{joints: [A, B], length: 0.9}", "{points: {A: [0, 0], B: [0.9, 0], E: [0.4, 0.3]}}"
    )
    assert refusal(text + "assembly:\n  E: left\n") == (
        "line 8, column 3, assembly.E: left and right belong to joint B, where the two links meet"
    )
    # but where it is tells the side as well
    places = [system_of(text + f"assembly: {{B: {w}}}").places()["E"] for w in ("left", "right")]
    for place, side in zip(places, (1, -1), strict=True):
        hint = f"assembly: {{E: [{place[0]}, {place[1]}]}}"
        assert system_of(text + hint).assembly.sides == {0: side}


def test_a_side_of_a_sliders_joint():
    assert refusal(SLIDER_CRANK + "assembly:\n  B: left\n") == (
        "line 8, column 3, assembly.B: joint B moves along an axis; expected its approximate "
        "position, such as [0.5, 0]"
    )


def test_a_slider_lies_forward_unless_told_otherwise():
    of = system_of(SLIDER_CRANK)
    assert (of.assembly.sides, of.assembly.assumed) == ({0: 1}, (0,))
    places = of.places()
    assert places["B"][0] > places["A"][0]
    told = system_of(SLIDER_CRANK + "assembly: {B: [-1, 0]}")
    assert (told.assembly.sides, told.assembly.assumed) == ({0: -1}, ())
    assert told.places()["B"][0] < places["A"][0]
    turned = system_of(SLIDER_CRANK.replace("angle: 0}", "angle: 180 deg}"))
    assert turned.places()["B"][0] < places["A"][0]


def test_a_hint_as_near_to_one_place_as_to_the_other():
    message = "lies as near to one possible place as to the other; expected nearer to one"
    # both places of B mirror each other on the line from A to C
    a = np.array([0.3 * np.cos(1), 0.3 * np.sin(1)])
    middle = 0.5 * (a + np.array([1, 0]))
    text = FOUR_BAR + f"assembly:\n  B: [{middle[0]}, {middle[1]}]\n"
    assert refusal(text) == f"line 8, column 3, assembly.B: {message}"
    crank = 0.3 * np.cos(1)
    assert refusal(SLIDER_CRANK + f"assembly:\n  B: [{crank}, 0.4]\n") == (
        f"line 8, column 3, assembly.B: {message}"
    )


def test_hints_of_joints_that_are_known_anyway_do_no_harm():
    of = system_of(FOUR_BAR + "assembly: {B: left, A: [0.1, 0.2], O: [0, 0]}")
    assert of.assembly.sides == {0: 1}


@pytest.mark.parametrize(
    ("coupler", "rocker", "between"),
    [(0.2, 0.1, "0.1 m and 0.3 m"), (3.0, 0.5, "2.5 m and 3.5 m")],
)
def test_links_that_cannot_meet(coupler, rocker, between):
    text = FOUR_BAR.replace("length: 0.9", f"length: {coupler}")
    text = text.replace("length: 0.7", f"length: {rocker}")
    distance = abs(0.3 * np.exp(1j) - 1)
    assert refusal(text + "assembly: {B: left}") == (
        "line 4, column 3, bars.coupler: cannot be assembled: coupler and rocker "
        f"({coupler:g} m and {rocker:g} m) cannot meet at B: their other ends A and C are "
        f"{distance:.6g} m apart at t = 0; expected between {between}"
    )


def test_a_point_without_a_name_is_said_in_words():
    """A driven cylinder: the barrel's length is given, and its lever is too far away."""
    text = """joints: {O: [0, 0], D: [2, 0]}
bars: {lever: {joints: [O, A], length: 0.5}, barrel: {joints: [D, E], length: 0.2}}
sliders: {rod: {joint: A, on: barrel}}
drives: {rod: {position: 0.3, speed: 0}}
"""
    message = refusal(text)
    assert "lever and barrel (0.5 m and 0.3 m) cannot meet at the axis of rod: " in message
    assert ".axis" not in message


def test_a_rod_that_cannot_reach_the_axis():
    text = SLIDER_CRANK.replace("length: 0.8", "length: 0.2")
    assert refusal(text) == (
        "line 4, column 3, bars.rod: cannot be assembled: rod (0.2 m) cannot reach the axis of "
        "piston: A is 0.252441 m away from it at t = 0; expected at most 0.2 m"
    )
    assert 0.3 * np.sin(1) == pytest.approx(0.252441, abs=5e-7)


def test_the_second_block_is_judged_with_the_side_of_the_first():
    of = system("ninebar")
    assert of.assembly.sides == {0: 1, 1: -1, 2: 1}
    places = of.places()
    assert side_of(places, "B", "A", "C.r1") == 1
    assert side_of(places, "E", "O", "B") == -1
    assert places["F"][0] > places["E"][0]


def test_two_sliders_have_one_place():
    of = system("trammel")
    assert len(of.modes()) == 1
    assert of.assembly.assumed == ()
    assert ("side", 0) not in of.model.inputs.parameters


def test_every_wrong_side_in_one_report():
    with pytest.raises(InputError) as caught:
        system_of(FOUR_BAR + "assembly: {A: left, O: left, C: right, B: left}")
    assert len(caught.value.problems) == 3
