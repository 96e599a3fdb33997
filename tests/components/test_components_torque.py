import pytest
from component_reading import complaints, component
from law_values import value

from linkages.components.contributed.functions import Number
from linkages.components.contributed.load_measures import Load, Turn
from linkages.components.contributed.terms import Parameter
from linkages.components.external_loads import BarTorque, TorqueBetweenBars

BARS = """joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  rod: {points: {A: [0, 0], B: [1, 0]}}
loads:
"""


@pytest.mark.parametrize(
    ("entry", "made", "body", "reference"),
    [
        ("{bar: rod, torque: 3 N*m}", BarTorque(index=0, bar="rod", torque=3), "rod", None),
        (
            "{bars: [crank, rod], torque: 3}",
            TorqueBetweenBars(index=0, bars=("crank", "rod"), torque=3),
            "rod",
            "crank",
        ),
        (
            "{bars: [ground, rod], torque: 3}",
            TorqueBetweenBars(index=0, bars=("ground", "rod"), torque=3),
            "rod",
            None,
        ),
    ],
)
def test_same_from_yaml_and_python(entry, made, body, reference):
    assert component(BARS + f"- {entry}\n", "loads", 0) == made
    torque = Number(Parameter(("loads", 0, "torque"), 3.0, structural=True))
    assert made.terms() == (Load(Turn(body, reference), torque, ("loads", 0), applied=True),)


def test_torque_that_follows_a_law():
    (term,) = component(BARS + '- {bar: rod, torque: "max(0, 2 - t)"}\n', "loads", 0).terms()
    assert [value(term.law, t) for t in (0, 1.5, 3)] == [2, 0.5, 0]


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{bar: rot, torque: 3}", "loads[0].bar: unknown bar 'rot'; did you mean 'rod'?"),
        (
            "{bars: [crank, rot], torque: 3}",
            "loads[0].bars[1]: unknown bar 'rot'; did you mean 'rod'?",
        ),
        (
            "{bars: [rod, rod], torque: 3}",
            "loads[0].bars: expected two different bodies, found 'rod' twice",
        ),
        (
            "{bars: [rod, ground], torque: 3}",
            "loads[0].bars[1]: expected a bar or plate; the ground can stand first only",
        ),
        ("{bar: rod, torque: 3 N}", "found '3 N': N is a force, not a torque"),
        (
            "{bar: rod, torque: {run-up: {speed: 1, duration: 1}}}",
            "or a law (harmonic, rise or table), found a mapping of other keys",
        ),
    ],
)
def test_wrong_entries(entry, found):
    problems = complaints(BARS + f"- {entry}\n")
    assert any(found in problem for problem in problems)
    assert problems[0].startswith("line 6, column ")
