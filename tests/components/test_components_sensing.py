"""Quantities that laws of loads name: what they are, which there are, what follows from them."""

import numpy as np
import pytest
from component_reading import complaints, mechanism

import linkages
from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.evidence import conservative
from linkages.components.contributed.functions import Measured, Number, Operation, Table, V, X
from linkages.components.contributed.load_measures import (
    Coordinate,
    Distance,
    Slide,
    Turn,
    named,
    written,
)
from linkages.components.contributed.state_laws import leaves
from linkages.kernel.inputs import wound_angles

ENGINE = """
joints: {O: [0, 0], G: [0.1, 0.3]}
bars:
  crank: {joints: [O, A], length: 50 mm, mass: 1}
  rod: {joints: [A, B], length: 150 mm, mass: 0.5}
  left arm: {joints: [G, H], length: 0.1, mass: 1}
sliders: {piston: {joint: B, through: O, mass: 0.3}}
clearances: {gap: {joint: A, bar: rod, size: 0.1 mm}}
assembly: {B: [0.2, 0]}
"""
FREE = "free: {crank: {angle: 10 deg, speed: 30}, left arm: {angle: 0, speed: 1}}\n"
DRIVEN = "drives: {crank: {angle: 10 deg, speed: 30}}\nfree: {left arm: {angle: 0, speed: 1}}\n"


def loaded(force, body="slider: piston", key="force", moved=FREE):
    law = force if force.startswith("{") else repr(force)
    return mechanism(f"{ENGINE}{moved}loads: [{{{body}, {key}: {law}}}]")


def law(force, **where):
    return loaded(force, **where).loads[0].law


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("crank.angle", Measured(0, Turn("crank", None))),
        ("gap.speed", Measured(1, Turn("gap", None))),
        ("'left arm'.angle", Measured(0, Turn("left arm", None))),
        ("angle(ground, rod)", Measured(0, Turn("rod", None))),
        ("rate(angle(crank, rod))", Measured(1, Turn("rod", "crank"))),
        ("distance(A, B)", Measured(0, Distance("A", "B"))),
        ("B.x", Measured(0, Coordinate("B", 0))),
        ("B.vy", Measured(1, Coordinate("B", 1))),
        # what the load itself acts along
        ("piston.position", X),
        ("piston.velocity", V),
        ("piston.speed", V),  # as drives and free coordinates call it
        ("rate(piston.position)", V),
    ],
)
def test_quantities_are_measures(text, found):
    assert law(text) == found


def test_the_speed_of_a_slider_is_along_its_axis():
    assert law("piston.speed", body="bar: crank", key="torque") == Measured(1, Slide("piston"))


def test_a_distance_has_no_order():
    found = mechanism(f"{ENGINE}{FREE}loads: [{{between: [O, B], force: '-3*distance(B, O)'}}]")
    assert list(leaves(found.loads[0].law))[1] == X


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            "pistn.velocity",
            "unknown slider 'pistn'; did you mean 'piston'? (character 1 of ",
        ),
        ("2*crnk.angle", "unknown body 'crnk'; did you mean 'crank'? (character 3 of "),
        ("C.x", "unknown joint 'C'; expected one of: A, B, G, H, O (character 1 of 'C.x')"),
        (
            "distance(A, b)",
            "unknown joint 'b'; did you mean 'B'? (character 1 of",
        ),
        ("distance(A, A)", "distance(A, A) is that of 'A' with itself; expected two"),
        ("angle(rod, ground)", "unknown body 'ground'"),
        ("piston.angle", "slider 'piston' has no 'angle'; expected 'position' or 'velocity'"),
        ("crank.velocity", "bar 'crank' has no 'velocity'; expected 'angle' or 'speed'"),
        ("gap.position", "clearance 'gap' has no 'position'; expected 'angle' or 'speed'"),
        (
            "20 N*s/m*crank.speed",
            "expected a force (N), found '20 N*s/m*crank.speed': it is ",
        ),
        ("3 N + 2*B.x", "a force (N) and a length (m) do not go together in '3 N + 2*B.x'"),
        ("A.reaction", "'A.reaction' follows from accelerations, which follow from the loads"),
    ],
)
def test_what_is_wrong_is_said_once_with_its_place(text, reason):
    (problem,) = complaints(f"{ENGINE}{FREE}loads:\n- slider: piston\n  force: {text!r}\n")
    assert reason in problem
    assert problem.startswith("line 13, column 3, loads[0].force: ")


def test_a_clearance_with_contact_has_no_angle():
    contact = "size: 0.1 mm, contact: hertz, stiffness: 2e9 N/m^1.5}"
    text = f"{ENGINE.replace('size: 0.1 mm}', contact)}{DRIVEN}"
    (problem,) = complaints(text + "loads: [{slider: piston, force: '3*gap.angle'}]")
    assert "clearance 'gap' has 'contact': what moves in it has two coordinates, and no" in problem


def test_formulas_of_torques_and_dampers_are_checked_as_well():
    found = complaints(
        f"{ENGINE}{FREE}loads: [{{bar: crank, torque: '3 N*t/(1 s)'}}]\n"
        "dampers: [{clearance: gap, damping: '0.1 N*s*gap.sped'}, {joint: O, damping: '1 N*t'}]\n"
        "springs: [{between: [G, H], stiffness: '3 N*G.x', length: 0.1}]\n"
    )
    assert [problem.split("found")[0].rpartition("expected ")[2] for problem in found] == [
        "a torque (N*m), ",
        "a torsional damping >= 0 (N·m·s/rad, or with a unit), a formula of t, crank.angle and the "
        "like, or a law (harmonic, rise or table), ",
        "a torsional damping (N*m*s/rad), ",
        "a stiffness (N/m), ",
    ]


@pytest.mark.parametrize(
    "law_text",
    ["0.1*crank.angle", "{table: {over: crank.angle, at: [0, 1, 2], values: [0, 1, 2]}}"],
)
def test_drives_are_functions_of_time(law_text):
    text = f"{ENGINE}drives: {{left arm: {{law: {law_text}}}}}\nfree: {{crank: {{angle: 0}}}}\n"
    assert any(
        "a drive prescribes a motion as a function of time alone" in p for p in complaints(text)
    )


ROUND = "{table: {over: crank.angle, values: [0, 1, 0], periodic: true, at: [0, 1, %s]}}"


@pytest.mark.parametrize(
    ("text", "turns"),
    [
        ("crank.angle", ["crank"]),
        ("sin(crank.angle)", []),
        ("cos(3*crank.angle - 20*pi/180)", []),
        ("cos(0.5*crank.angle)", ["crank"]),
        ("cos(crank.angle)*rod.angle", ["rod"]),
        ("sin(crank.angle - 2*t) + tan(angle(crank, rod))", []),
        ("crank.speed + distance(A, B)", []),
        ("where(sin(crank.angle) > 0, 1, 2)", []),
        (ROUND % "360 deg", []),
        (ROUND % "120 deg", []),
        (ROUND % "720 deg", ["crank"]),
        ("{table: {over: crank.angle, at: [0, 1, 360 deg], values: [0, 1, 0]}}", ["crank"]),
    ],
)
def test_whole_turns_count_unless_all_repeats(text, turns):
    assert [turn.body for turn in loaded(text).loads[0].wound] == turns


def test_an_angle_between_two_bodies_starts_within_half_a_turn():
    """As the angle of a torsional spring; that of one body is what it is in outputs."""
    moved = FREE.replace("10 deg", "-700 deg")
    found = loaded("angle(crank, rod) - rod.angle", moved=moved)
    system = linkages.kernel.system.System(found)
    assert list(wound_angles(found)) == [1]  # of what one load senses, the first
    value = system.evaluate([system.model.loads[0].acting])[0, 0]
    rod, crank = system.evaluate([system.model.positions.angle(n) for n in ("rod", "crank")])[:, 0]
    assert crank == pytest.approx(np.radians(-700))
    assert abs(value + rod) < np.pi
    assert (value - (rod - crank) + rod) / (2 * np.pi) == pytest.approx(-2)


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("crank.angle + B.x + t", True),
        ("crank.speed", False),
        ("where(B.vx > 0, 1, 2)", False),
        ("rate(distance(A, B))", False),
    ],
)
def test_a_rate_of_whatever_it_is_of_may_shrink_volumes(text, kept):
    assert conservative(loaded(text)) == kept


def test_common_period():
    """From drives, and from the parts of laws that depend on time."""
    turn = 2 * np.pi / 30
    assert common_period(loaded("sin(rod.angle)", moved=DRIVEN)) == pytest.approx(turn)
    both = loaded("sin(rod.angle)*cos(15*t)", moved=DRIVEN)
    assert common_period(both) == pytest.approx(2 * turn)
    mixed = loaded("sin(rod.angle - 15*t)", moved=DRIVEN)
    assert common_period(mixed) == pytest.approx(2 * turn)
    four_stroke = loaded(ROUND % "720 deg", moved=DRIVEN)
    assert common_period(four_stroke) == pytest.approx(2 * turn)
    assert common_period(loaded("cos(0.2*crank.angle)", moved=DRIVEN)) == pytest.approx(5 * turn)
    with pytest.raises(NoPeriodError, match="the law of a load does not repeat"):
        common_period(loaded("0.1*crank.angle", moved=DRIVEN))
    wheels = "bars:\n  wheel: {joints: [G, W], length: 0.1, mass: 1}\n"
    driven = (
        f"{ENGINE.replace('bars:' + chr(10), wheels)}gears: [{{bars: [crank, wheel], ratio: 3}}]"
    )
    geared = mechanism(f"{driven}\n{DRIVEN}loads: [{{slider: piston, force: wheel.angle}}]")
    with pytest.raises(NoPeriodError, match="feels whole turns of 'wheel', which turns on and on"):
        common_period(geared)
    with pytest.raises(NoPeriodError, match="nothing depends on time"):
        common_period(loaded("crank.angle"))


def test_words():
    found = loaded(
        "-3*piston.velocity*(2 - distance(A, B))**2 + where(t >= 3, B.x, rod.speed)"
    ).loads[0]
    assert named(found.law) == ["v", "distance(A, B)", "B.x", "rod.speed", "t"]
    assert named(found.law, found.measure)[-1] == "t"
    assert "piston.velocity" in named(found.law, found.measure)
    first, second = found.law.arguments
    assert written(first, found.measure) == "(-3) * piston.velocity * (2 - distance(A, B))**2"
    assert written(second, found.measure) == "where(t - 3 >= 0)"
    assert len(written(Operation("add", (first, first)), found.measure)) == 60


def test_a_table_knows_what_it_is_over_and_its_corners():
    text = "{table: {over: 2*crank.angle, at: [0, 1, 3, 4], values: [0, 5, 2, 0], periodic: true, "
    found = law(text + "interpolation: linear}}")
    assert isinstance(found, Table)
    assert found.over == Operation(
        "mul", (Number(found.over.arguments[0].parameter), Measured(0, Turn("crank", None)))
    )
    corners = found.corners
    assert corners.places == (0, 1, 3, 3.5, 4)  # three lines: one more, of both signs in turn
    assert found.corners.over == found.over
    assert law(text + "interpolation: pchip}}").corners is None
