from component_reading import complaints, component

from linkages.components.rigid_bodies import GroundJoint

BARS = "bars: {crank: {joints: [O, A], length: 1}}\n"
PIN = GroundJoint(name="O", position=(1.1, 0.0))


def test_same_from_yaml_and_python():
    assert component(BARS + "joints: {O: [110 cm, 0]}\n", "joints", "O") == PIN


def test_terms():
    (pin,) = PIN.terms()
    assert pin.joint == "O"
    assert [p.value for p in pin.position] == [1.1, 0.0]
    assert [p.path for p in pin.position] == [("joints", "O", 0), ("joints", "O", 1)]
    assert [p.absent for p in pin.position] == [False, True]


def test_position_is_two_lengths():
    (problem,) = complaints(BARS + "joints:\n  O: [1, 2, 3]\n")
    assert problem.startswith("line 3, column 3, joints.O: expected a list of two numbers (metres")
    (problem,) = complaints(BARS + "joints:\n  O: [30,5 mm, 0]\n")
    assert problem.endswith(
        "found a list of 3; decimals are written with a point, as in 0.5, not 0,5"
    )
    (problem,) = complaints(BARS + "joints:\n  O: [1 kg, 2]\n")
    assert "line 3" in problem
    assert "'1 kg'" in problem
