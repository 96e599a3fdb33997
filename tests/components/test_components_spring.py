import pytest
from component_reading import complaints, component

from linkages.components.contributed.load_measures import Distance, Load, spring_law
from linkages.components.contributed.terms import Parameter
from linkages.components.springs import JointSpring

BARS = """joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3}, rod: {joints: [A, B], length: 0.8}}
springs:
"""
FULL = JointSpring(index=0, between=("O", "B"), stiffness=4530, length=0.08, damping=2)


def test_same_from_yaml_and_python():
    entry = "{between: [O, B], stiffness: 4.53 N/mm, length: 8 cm, damping: 2}"
    assert component(BARS + f"- {entry}\n", "springs", 0) == FULL


def test_terms():
    stiffness, length, damping = (
        Parameter(("springs", 0, key), number, structural=True)
        for key, number in (("stiffness", 4530.0), ("length", 0.08), ("damping", 2.0))
    )
    law = spring_law(stiffness, length, damping)
    assert FULL.terms() == (Load(Distance("O", "B"), law, ("springs", 0)),)
    (bare,) = JointSpring(index=1, between=("O", "B"), stiffness=1, length=0).terms()
    assert not bare.dissipates
    assert bare.path == ("springs", 1)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        (
            "{between: [O, E], stiffness: 1, length: 1}",
            "springs[0].between[1]: unknown joint 'E'; expected one of: A, B, O",
        ),
        (
            "{between: [O, O], stiffness: 1, length: 1}",
            "springs[0].between: expected two different joints, found 'O' twice",
        ),
        ("{between: [O, B], stiffness: -1, length: 1}", "expected a stiffness >= 0"),
        ("{between: [O, B], stiffness: 1}", "springs[0]: missing key 'length'"),
        ("{stiffness: 1, length: 1}", "springs[0]: missing key 'between'"),
        ("{between: [O, B], stiffness: 1 N*m/rad, length: 1}", "not a stiffness"),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(BARS + f"- {entry}\n")
    assert found in problem
