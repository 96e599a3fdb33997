import math

import pytest
from component_reading import complaints, component

from linkages.components.contributed.load_measures import Load, Turn, spring_law
from linkages.components.contributed.terms import Parameter
from linkages.components.springs import BarSpring, SpringBetweenBars

BARS = """joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3}, rod: {joints: [A, B], length: 0.8}}
springs:
"""


@pytest.mark.parametrize(
    ("where", "made", "body", "reference"),
    [
        ("bar: rod", BarSpring(index=0, bar="rod", stiffness=5, angle=math.pi), "rod", None),
        (
            "between_bars: [crank, rod]",
            SpringBetweenBars(index=0, between_bars=("crank", "rod"), stiffness=5, angle=math.pi),
            "rod",
            "crank",
        ),
        (
            "between_bars: [ground, rod]",
            SpringBetweenBars(index=0, between_bars=("ground", "rod"), stiffness=5, angle=math.pi),
            "rod",
            None,
        ),
    ],
)
def test_same_from_yaml_and_python(where, made, body, reference):
    entry = f"{{{where}, stiffness: 5 N*m/rad, angle: 180 deg}}"
    assert component(BARS + f"- {entry}\n", "springs", 0) == made
    stiffness, angle, damping = (
        Parameter(("springs", 0, key), number, structural=True)
        for key, number in (("stiffness", 5.0), ("angle", math.pi), ("damping", 0.0))
    )
    law = spring_law(stiffness, angle, damping)
    assert made.terms() == (Load(Turn(body, reference), law, ("springs", 0)),)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{bar: rot, stiffness: 1}", "springs[0].bar: unknown bar 'rot'; did you mean 'rod'?"),
        (
            "{between_bars: [crank, ground], stiffness: 1}",
            "springs[0].between_bars[1]: expected a bar or plate; the ground can stand first only",
        ),
        (
            "{between_bars: [rod, rod], stiffness: 1}",
            "springs[0].between_bars: expected two different bodies, found 'rod' twice",
        ),
        ("{bar: rod, stiffness: 1, damping: -1}", "expected a torsional damping >= 0"),
        ("{bar: rod, stiffness: 1 N/m}", "not a torsional stiffness"),
        ("{bar: rod}", "springs[0]: missing key 'stiffness'"),
    ],
)
def test_wrong_entries(entry, found):
    assert found in complaints(BARS + f"- {entry}\n")[0]


@pytest.mark.parametrize("section", ["springs", "maxwell"])
def test_key_of_other_sections(section):
    found = complaints(BARS.replace("springs", section) + "- {bars: [crank, rod]}\n")
    assert any("unknown key 'bars'" in line and "'between_bars'" in line for line in found)
