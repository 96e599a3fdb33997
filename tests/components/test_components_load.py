from component_reading import complaints, component, mechanism
from law_values import value

from linkages.components.contributed.functions import Number
from linkages.components.contributed.load_measures import Coordinate, Load, Slide
from linkages.components.contributed.terms import Parameter
from linkages.components.external_loads import JointForce, SliderForce

SLIDER_CRANK = """joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {joints: [A, B], length: 0.8}
sliders:
  piston: {joint: B, through: O}
loads:
"""
PRESS = SliderForce(index=0, slider="piston", force=-100.0)


def test_same_from_yaml_and_python():
    text = SLIDER_CRANK + "  - {slider: piston, force: -0.1 kN}\n"
    assert component(text, "loads", 0) == PRESS


def test_terms():
    (term,) = PRESS.terms()
    force = Parameter(("loads", 0, "force"), -100.0, structural=True)
    assert term == Load(Slide("piston"), Number(force), ("loads", 0), applied=True)
    assert SliderForce(index=0, slider="piston", force=0).terms()[0].absent


def test_several_loads_on_one_slider():
    entries = "  - {slider: piston, force: 1}\n  - {slider: piston, force: 2}\n"
    loads = mechanism(SLIDER_CRANK + entries).loads
    assert [(f.path, f.law.parameter.value) for f in loads] == [
        (("loads", 0), 1),
        (("loads", 1), 2),
    ]


def test_unknown_slider_in_the_second_entry():
    entries = "  - {slider: piston, force: 1}\n  - {slider: pisten, force: 2}\n"
    assert complaints(SLIDER_CRANK + entries) == [
        "line 9, column 6, loads[1].slider: unknown slider 'pisten'; did you mean 'piston'?"
    ]


def test_bars_take_no_axial_force():
    assert complaints(SLIDER_CRANK + "  - {slider: rod, force: 1}\n") == [
        "line 8, column 6, loads[0].slider: unknown slider 'rod'; expected one of: piston"
    ]


def test_index_is_no_key():
    (problem,) = complaints(SLIDER_CRANK + "  - {slider: piston, force: 1, index: 4}\n")
    assert "unknown key 'index'" in problem


def test_force_that_follows_a_law():
    text = (
        SLIDER_CRANK + "  - {slider: piston, force: {rise: polynomial, to: 2 kN, duration: 3 s}}\n"
    )
    (term,) = component(text, "loads", 0).terms()
    assert [value(term.law, t) for t in (-1, 0, 1.5, 3, 4)] == [0, 0, 1000, 2000, 2000]


PUSH = JointForce(index=0, joint="A", force=(1.0, "-2*t"))


def test_force_at_a_joint():
    made = component(SLIDER_CRANK + "  - {joint: A, force: [1 N, -2*t]}\n", "loads", 0)
    assert made == PUSH
    along_x, along_y = made.terms()
    assert (along_x.measure, along_y.measure) == (Coordinate("A", 0), Coordinate("A", 1))
    assert along_x.path == along_y.path == ("loads", 0)
    assert [value(load.law, 3.0) for load in (along_x, along_y)] == [1.0, -6.0]
    assert along_x.law.parameter == Parameter(("loads", 0, "force", 0), 1.0, structural=True)


def test_joints_of_forces_must_move():
    assert complaints(SLIDER_CRANK + "  - {joint: O, force: [1, 0]}\n") == [
        "line 8, column 6, loads[0].joint: joint 'O' is fixed to the ground; expected another"
    ]
    assert complaints(SLIDER_CRANK + "  - {joint: E, force: [1, 0]}\n") == [
        "line 8, column 6, loads[0].joint: unknown joint 'E'; expected one of: A, B, O"
    ]


def test_force_at_a_joint_has_two_components():
    (problem,) = complaints(SLIDER_CRANK + "  - {joint: A, force: 3 N}\n")
    assert problem.startswith(
        "line 8, column 16, loads[0].force: expected a list of two numbers (newtons, or with units)"
    )
    (problem,) = complaints(SLIDER_CRANK + "  - {joint: A, force: [3 N, 2 mm]}\n")
    assert problem.startswith("line 8, column 29, loads[0].force[1]: expected a force")
