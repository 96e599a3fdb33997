from component_reading import complaints, component, mechanism

from linkages.components.scene import UniformGravity

CRANK = "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 0.3}}\n"
DOWN = UniformGravity(acceleration=(0.0, -9.81))


def test_same_from_yaml_and_python():
    assert component(CRANK + "gravity: [0, -9.81]\n", "gravity") == DOWN
    assert component(CRANK + "gravity: [0, -981 cm/s^2]\n", "gravity") == DOWN


def test_a_zero_component_is_structure():
    (term,) = DOWN.terms()
    assert (term.x.value, term.y.value) == (0.0, -9.81)
    assert (term.x.absent, term.y.absent) == (True, False)
    assert term.y.path == ("gravity", 1)


def test_none_by_default():
    gravity = mechanism(CRANK).gravity
    assert gravity.x.absent
    assert gravity.y.absent


def test_wrong_value():
    (problem,) = complaints(CRANK + "gravity: 9.81\n")
    assert problem.startswith("line 3, column 1, gravity: expected a list of two numbers")
