"""What loads say of themselves follows from the form of their laws alone."""

import pytest
from component_reading import mechanism

from linkages.chaos.evidence import conservative

MOVABLE = """
joints: {O: [0, 0], C: [1, 0]}
bars: {a: {joints: [O, A], length: 1, mass: 1}, b: {joints: [A, B], length: 1, mass: 1}}
free: {a: {angle: 1, speed: 0}, b: {angle: 2, speed: 0}}
"""


def loaded(text):
    return mechanism(MOVABLE + text)


# a mechanism dissipates if any damper of it does, and not only if all of them do
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", True),
        ("dampers: [{joint: A, damping: 0.1}]", False),
        ("dampers: [{joint: A, damping: 0}]", True),
        ("dampers: [{joint: A, damping: 0}, {between: [C, B], damping: 2}]", False),
        ("dampers: [{joint: A, damping: 0.1}, {between: [C, B], damping: 0}]", False),
        ("dampers: [{joint: A, damping: 0}, {between: [C, B], damping: 0}]", True),
        ("springs: [{bar: a, stiffness: 3}, {between: [C, B], stiffness: 2, length: 1}]", True),
        ("springs: [{bar: a, stiffness: 3}, {bar: b, stiffness: 3, damping: 0.1}]", False),
        # a given load may do work, but shrinks no set of states
        ("loads: [{bar: a, torque: 'sin(t)'}, {joint: B, force: [1, 't']}]", True),
        ("loads: [{bar: a, torque: 3}]\ndampers: [{bars: [a, b], damping: 0.1}]", False),
    ],
)
def test_what_dissipates(text, expected):
    assert conservative(loaded(text)) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("springs: [{bar: a, stiffness: 3}]", ("a",)),
        ("springs: [{between_bars: [a, b], stiffness: 3}]", ("b", "a")),
        ("dampers: [{bars: [a, b], damping: 3}]", ()),
        ("springs: [{between: [C, B], stiffness: 3, length: 0}]", ()),
        ("loads: [{bar: a, torque: 3}]", ()),
    ],
)
def test_whose_whole_turns_count(text, expected):
    (load,) = loaded(text).loads
    assert load.turned == expected


def test_laws_and_units():
    found = loaded("loads: [{joint: B, force: [1, 't']}, {bar: a, torque: 't'}]").loads
    assert [(len(load.laws), load.unit) for load in found] == [(1, "N"), (1, "N"), (1, "N m")]
