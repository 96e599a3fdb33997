"""The common period of drives and loads, from their laws."""

import math

import pytest

import linkages
from linkages.chaos.common_period import NoPeriodError, common_period, incommensurate_periods

TWO_CRANKS = """\
joints: {{O: [0, 0], D: [1, 0]}}
bars:
  one: {{joints: [O, A], length: 0.1}}
  two: {{joints: [D, B], length: 0.1}}
drives:
  one: {one}
  two: {two}
{more}
"""


def period(one: str, two: str = "{angle: 0, speed: 0}", more: str = "") -> float:
    text = TWO_CRANKS.format(one=one, two=two, more=more)
    return common_period(linkages.loads(text))


@pytest.mark.parametrize(
    ("one", "two", "expected"),
    [
        ("{angle: 0, speed: pi}", "{angle: 1, speed: -pi}", 2.0),
        ("{angle: 0, speed: 2*pi}", "{angle: 0, speed: 3*pi}", 2.0),
        ("{angle: 0, speed: pi}", '{law: "0.2*sin(4*pi*t)"}', 2.0),
        ("{angle: 0, speed: 4*pi}", '{law: "0.2*sin(pi*t)*cos(2*pi*t) + 0.1"}', 2.0),
        ('{law: "2*pi*t + 0.1*sin(2*pi*t/3)"}', "{angle: 0, speed: 0}", 3.0),
        (
            "{law: {table: {times: [0, 0.5, 1.2, 1.5], values: [0, 1, 0.5, 0], periodic: true}}}",
            "{angle: 0, speed: 4*pi}",
            1.5,
        ),
    ],
)
def test_common_period(one, two, expected):
    assert period(one, two) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("one", "two", "words"),
    [
        ("{angle: 0, speed: 0}", "{angle: 0, speed: 0}", "nothing depends on time"),
        ("{angle: 0, speed: 1}", f"{{angle: 0, speed: {math.sqrt(2)!r}}}", "no common multiple"),
        ('{law: "t**2"}', "{angle: 0, speed: 1}", "does not repeat"),
        (
            "{law: {rise: cycloidal, from: 0, to: 1, begin: 0, duration: 1}}",
            "{angle: 0, speed: 1}",
            "does not repeat",
        ),
    ],
)
def test_no_common_period(one, two, words):
    with pytest.raises(NoPeriodError, match=words):
        period(one, two)


def test_loads_count():
    load = 'loads: [{bar: one, torque: "3*cos(pi*t)"}]'
    assert period("{angle: 0, speed: 2*pi}", more=load) == pytest.approx(2.0, rel=1e-12)


TRAIN = """\
joints: {O: [0, 0], D: [1, 0], E: [0, 1], F: [0, 2]}
bars:
  crank: {joints: [O, A], length: 0.1}
  slow: {joints: [D, B], length: 0.1}
  third: {joints: [E, C], length: 0.1}
  other: {joints: [F, G], length: 0.1}
drives: {crank: {angle: 0, speed: 180 rpm}, other: {angle: 0, speed: SPEED}}
"""


@pytest.mark.parametrize(
    ("gears", "speed", "expected"),
    [
        ("{bars: [crank, slow], ratio: -1/3}", "0", 1.0),
        ("{bars: [crank, slow], ratio: 3}", "0", 1 / 3),
        (
            "{bars: [crank, slow], ratio: -1/3}, {bars: [slow, third], ratio: 1/2}",
            "0",
            2.0,
        ),
        # epicyclic: (1 + 2/3) · 3 turns in a second
        ("{bars: [other, slow], ratio: -2/3, carrier: crank}", "0", 1.0),
        # the carrier's share and that of the wheel cancel: 2·90 rpm - 180 rpm
        ("{bars: [other, slow], ratio: 2, carrier: crank}", "90 rpm", 2 / 3),
        # what follows a free body alone turns with it
        ("{bars: [third, slow], ratio: 1/7}", "0", 1 / 3),
    ],
)
def test_gears_make_whole_turns(gears, speed, expected):
    text = TRAIN.replace("SPEED", speed) + f"gears: [{gears}]\n"
    assert common_period(linkages.loads(text)) == pytest.approx(expected, rel=1e-12)


def test_welded_bodies_turn_alike():
    weld = "welds: {A: {bars: [crank, end], angle: 1}}\n"
    text = TRAIN.replace("SPEED", "0").replace(
        "drives:", "  end: {joints: [A, H], length: 0.1}\ndrives:"
    )
    gear = "gears: [{bars: [end, slow], ratio: 2/3}]\n"
    assert common_period(linkages.loads(text + weld)) == pytest.approx(1 / 3)
    assert common_period(linkages.loads(text + weld + gear)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("torque", "expected"),
    [
        # constants are folded
        ("{harmonic: {amplitude: 1, frequency: 1 Hz}}", 1.0),
        ("{harmonic: {amplitude: 1, frequency: 4 Hz, mean: 2, phase: 1}}", 0.25),
        ("{harmonic: {amplitude: 1, angular_frequency: 2}}", math.pi),
        ('"cos(pi*(1 + 3)*t/2)"', 1.0),
        ('"cos(t*sqrt(4)*pi)"', 1.0),
        ('"cos(2*pi*t/cos(0)) + exp(1)"', 1.0),
        ('"cos(2**3*pi*t/(3 - 7))"', 1.0),
        # powers, products and sums of functions
        ('"sin(t)**2"', math.pi),
        ('"abs(sin(t))"', math.pi),
        ('"sin(3*t)*sin(t)"', math.pi),
        ('"tan(t/4)"', 4 * math.pi),
        ('"9*(2*cos(t/3)**2 - 1)"', 3 * math.pi),
        ('"exp(-50*sin(t/2)**2)"', 2 * math.pi),
        ('"sin(t)**2*cos(t)**2"', math.pi / 2),
        ('"cos(22*t) + cos(44*t)*cos(t)**2 - cos(44*t)*cos(2*t)/2"', math.pi / 11),
        # these are not to be reduced
        ('"sin(t)**2 + 1e-9*sin(t)"', 2 * math.pi),
        ('"sin(t)"', 2 * math.pi),
        ('"cos(t) + cos(2*t)"', 2 * math.pi),
        ('"sin(t)**2 + cos(t)**2"', 2 * math.pi),
    ],
)
def test_laws_repeat_after_their_least_period(torque, expected):
    load = f"loads: [{{bar: one, torque: {torque}}}]"
    found = period("{angle: 0, speed: 0}", more=load)
    assert found == pytest.approx(expected, rel=1e-12)


def test_least_period_of_a_law_that_turns_on_and_on():
    """Two turns each second, and what goes with them four times."""
    law = '{law: "4*pi*t + 0.1*sin(4*pi*t)**2"}'
    assert period(law) == pytest.approx(0.5, rel=1e-12)


def test_least_period_of_a_table():
    values = "times: [0, 0.5, 1, 1.5, 2, 2.5, 3], values: [0, 1, 3, 0, 1, 3, 0], periodic: true"
    assert period(f"{{law: {{table: {{{values}}}}}}}") == pytest.approx(1.5, rel=1e-12)


@pytest.mark.parametrize(
    ("one", "two", "expected"),
    [
        ("{angle: 0, speed: pi}", "{angle: 1, speed: -pi}", [2.0]),
        (
            "{angle: 0, speed: pi}",
            f"{{angle: 0, speed: {2**0.5 * math.pi!r}}}",
            [2.0, math.sqrt(2)],
        ),
        (
            "{angle: 0, speed: pi}",
            '{law: "0.1*sin(2*pi*t/3)+0.1*cos(2*pi*t/sqrt(2))+0.1*sin(2*pi*t*sqrt(2))"}',
            [6.0, math.sqrt(2)],
        ),
    ],
)
def test_groups_without_a_common_period(one, two, expected):
    text = TWO_CRANKS.format(one=one, two=two, more="")
    found = incommensurate_periods(linkages.loads(text))
    assert found == pytest.approx(expected, rel=1e-12)
