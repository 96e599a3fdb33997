import math

import pytest
from component_reading import complaints, component

from linkages.components.scene import FreeAngle, FreePosition

SLIDER_CRANK = """joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {joints: [A, B], length: 0.8}
sliders:
  piston: {joint: B, through: O}
free:
"""


@pytest.mark.parametrize(
    ("entry", "made"),
    [
        ("crank: {angle: 90 deg}", FreeAngle(name="crank", angle=math.pi / 2)),
        ("crank: {angle: 0.1, speed: -2}", FreeAngle(name="crank", angle=0.1, speed=-2)),
        ("piston: {position: 80 cm}", FreePosition(name="piston", position=0.8)),
        (
            "piston: {position: 0.8, speed: 1 cm/s}",
            FreePosition(name="piston", position=0.8, speed=0.01),
        ),
    ],
)
def test_same_from_yaml_and_python(entry, made):
    found = component(SLIDER_CRANK + f"  {entry}\n", "free", made.name)
    assert found == made
    assert type(found) is type(made)


@pytest.mark.parametrize("made", [FreeAngle(name="b", angle=1), FreePosition(name="s", position=1)])
def test_terms_at_rest_by_default(made):
    (term,) = made.terms()
    assert (term.body, term.position, term.speed) == (made.name, 1.0, 0.0)
    assert term.path == ("free", made.name)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("crank: {position: 0.3}", "free.crank: unknown slider 'crank'; expected one of: piston"),
        ("piston: {angle: 1}", "free.piston: unknown bar 'piston'; expected one of: crank, rod"),
        ("crenk: {angle: 1}", "free.crenk: unknown bar 'crenk'; did you mean 'crank'?"),
    ],
)
def test_angles_are_of_bars_and_positions_of_sliders(entry, message):
    assert complaints(SLIDER_CRANK + f"  {entry}\n") == [f"line 8, column 3, {message}"]


def test_state_is_needed():
    (problem,) = complaints(SLIDER_CRANK + "  crank: {speed: 1}\n")
    assert problem.startswith("line 8, column 3, free.crank: missing key 'angle'")
