from component_reading import complaints, component, mechanism

from linkages.components.contributed.terms import Parameter, PointMass
from linkages.components.rigid_bodies import JointMass

CRANK = "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, P], length: 0.3}}\nmasses:\n"
BOB = JointMass(name="P", mass=2.0)


def test_same_from_yaml_and_python():
    assert component(CRANK + "  P: 2000 g\n", "masses", "P") == BOB


def test_terms():
    mass = Parameter(("masses", "P"), 2.0, structural=True)
    assert mechanism(CRANK + "  P: 2\n").point_masses == (PointMass("P", mass, ("masses", "P")),)


def test_wrong_entries():
    assert complaints(CRANK + "  Q: 2\n  O: 3\n") == [
        "line 4, column 3, masses.Q: unknown joint 'Q'; expected one of: O, P",
        "line 5, column 3, masses.O: joint 'O' is fixed to the ground; expected another",
    ]
    (problem,) = complaints(CRANK + "  P: -2\n")
    assert problem.startswith("line 4, column 3, masses.P: expected a mass >= 0")
