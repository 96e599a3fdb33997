from component_reading import assert_frozen_and_keyword_only, complaints, component, mechanism

from linkages.components.load import SliderForce

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


def test_frozen_and_keyword_only():
    assert_frozen_and_keyword_only(PRESS)


def test_terms():
    (term,) = PRESS.terms()
    assert (term.body, term.force.value, term.path) == ("piston", -100, ("loads", 0))
    assert term.force.path == ("loads", 0, "force")
    assert SliderForce(index=0, slider="piston", force=0).terms()[0].force.absent


def test_several_loads_on_one_slider():
    entries = "  - {slider: piston, force: 1}\n  - {slider: piston, force: 2}\n"
    forces = mechanism(SLIDER_CRANK + entries).forces
    assert [(f.path, f.force.value) for f in forces] == [(("loads", 0), 1), (("loads", 1), 2)]


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
