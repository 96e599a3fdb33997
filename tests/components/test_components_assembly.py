import pytest
from component_reading import complaints, component

from linkages.components.scene import AssemblyHint

FOUR_BAR = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
assembly:
"""


@pytest.mark.parametrize(
    ("entry", "where"),
    [("left", "left"), ("right", "right"), ("[0.9, 60 cm]", (0.9, 0.6)), ("[0, 0]", (0.0, 0.0))],
)
def test_same_from_yaml_and_python(entry, where):
    hint = component(FOUR_BAR + f"  B: {entry}\n", "assembly", "B")
    assert hint == AssemblyHint(name="B", where=where)


@pytest.mark.parametrize(
    ("where", "position", "side"),
    [("left", None, 1), ("right", None, -1), ((0.9, 0.6), (0.9, 0.6), None)],
)
def test_terms(where, position, side):
    (hint,) = AssemblyHint(name="B", where=where).terms()
    assert (hint.joint, hint.position, hint.side) == ("B", position, side)
    assert hint.path == ("assembly", "B")


def test_unknown_joint():
    assert complaints(FOUR_BAR + "  b: left\n") == [
        "line 7, column 3, assembly.b: unknown joint 'b'; did you mean 'B'?"
    ]


def test_misspelt_side():
    (problem,) = complaints(FOUR_BAR + "  B: lefd\n")
    assert problem.startswith("line 7, column 3, assembly.B: expected 'left' or 'right' or a list")
    assert problem.endswith("found 'lefd'; did you mean 'left'?")
