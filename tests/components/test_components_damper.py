import pytest
from component_reading import complaints, component

from linkages.components.contributed.load_measures import Distance, Load, Slide, damper_law
from linkages.components.contributed.terms import Parameter
from linkages.components.springs import GuideDamper, LineDamper

SLIDER_CRANK = """joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3}, rod: {joints: [A, B], length: 0.8}}
sliders: {piston: {joint: B, through: O}}
dampers:
"""
DAMPING = Parameter(("dampers", 0, "damping"), 2000.0, structural=True)


@pytest.mark.parametrize(
    ("entry", "made", "term"),
    [
        (
            "{between: [O, B], damping: 2 N*s/mm}",
            LineDamper(index=0, between=("O", "B"), damping=2000),
            Load(Distance("O", "B"), damper_law(DAMPING), ("dampers", 0)),
        ),
        (
            "{slider: piston, damping: 2000}",
            GuideDamper(index=0, slider="piston", damping=2000),
            Load(Slide("piston"), damper_law(DAMPING), ("dampers", 0)),
        ),
    ],
)
def test_same_from_yaml_and_python(entry, made, term):
    assert component(SLIDER_CRANK + f"- {entry}\n", "dampers", 0) == made
    assert made.terms() == (term,)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{between: [O, E], damping: 1}", "dampers[0].between[1]: unknown joint 'E'"),
        ("{between: [O, O], damping: 1}", "expected two different joints, found 'O' twice"),
        ("{slider: rod, damping: 1}", "unknown slider 'rod'; expected one of: piston"),
        ("{slider: piston, damping: -1}", "expected a damping >= 0"),
        ("{slider: piston, damping: 1 N*m*s}", "N*m*s is not a unit of damping"),
        ("{damping: 1}", "missing key 'between'"),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(SLIDER_CRANK + f"- {entry}\n")
    assert found in problem
