"""and, or, not and chains of comparisons in formulas, against Python itself."""

import itertools

import numpy as np
import pytest

import linkages
from linkages.components.contributed.functions import Measured, Number, Operation, Time
from linkages.components.laws import translated
from linkages.spec.formulas import formula
from linkages.spec.grammar import NumberError

CONDITIONS = [
    "t > 1 and crank.angle < 2",
    "t > 1 or crank.angle < 2",
    "not t > 1",
    "not (t > 1 and crank.angle < 2)",
    "not t > 1 and crank.angle < 2",
    "t > 1 and crank.angle < 2 or t < 0.5",
    "t > 1 and (crank.angle < 2 or t < 0.5)",
    "0.5 < t <= 1.5",
    "0.5 < t < 1.5 < crank.angle",
    "(t + 1) > 2 and ((crank.angle) < 2)",
    "not not t > 1",
]


def value(function, t, angle):
    match function:
        case Number(parameter):
            return parameter.value
        case Time():
            return t
        case Measured():
            return angle
        case Operation("where", (difference, first, second)):
            return value(first if value(difference, t, angle) >= 0 else second, t, angle)
        case Operation("add", (a, b)):
            return value(a, t, angle) + value(b, t, angle)
        case Operation("sub", (a, b)):
            return value(a, t, angle) - value(b, t, angle)
    raise AssertionError(function)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_as_in_python(condition):
    function = translated(formula(f"where({condition}, 3, 4)"), ("loads", 0, "force"))
    plain = condition.replace("crank.angle", "angle")
    for t, angle in itertools.product((0.2, 0.7, 1.2, 1.7), (1.0, 1.7, 2.5)):
        expected = 3 if eval(plain, {"t": t, "angle": angle}) else 4
        assert value(function, t, angle) == expected, (t, angle)


def test_numbers_behind_several_conditions_count_once():
    function = translated(formula("where(t > 1 and t < 2 and t < 3, 7, 8)"), ("a",))

    def numbers(found):
        match found:
            case Number(parameter):
                yield parameter.path, parameter.value
            case Operation(_, arguments):
                for argument in arguments:
                    yield from numbers(argument)

    found = dict(numbers(function))
    assert sorted(found.values()) == [1, 2, 3, 7, 8]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("t > 1 and t < 2", "a comparison stands in 'where(…)' only"),
        ("3 and 4", "a comparison stands in 'where(…)' only"),
        ("where(3 and t > 1, 1, 2)", "'and' expects comparisons, such as t > 1 s and t < 2 s"),
        ("where(not 3, 1, 2)", "'not' expects comparisons, such as not t < 1 s"),
        ("where(t > 1, t < 1, 2)", "a comparison stands first"),
        ("1 + (t > 1)", "a comparison stands first"),
        ("where(t > 1 and, 1, 2)", "expected a number before ','"),
    ],
)
def test_misplaced(text, found):
    with pytest.raises(NumberError) as refused:
        formula(text)
    assert found in str(refused.value)


def test_bodies_may_be_called_like_words():
    function = formula("where(or.angle > 1 and and.angle < 2, not.speed, 4)")
    assert [node.names for node in function.nodes() if hasattr(node, "names")] == [
        ("or",), ("and",), ("not",)
    ]  # fmt: skip


def test_each_comparison_is_located():
    """A force within a window of position: two kinks, one for each end, both to round-off."""
    text = """
joints: {O: [0, 0], P: [-1, 0]}
bars: {dummy: {joints: [P, Q], length: 0.1}}
sliders: {block: {joint: B, through: O, angle: 0, mass: 2}}
drives: {dummy: {angle: 0, speed: 0}}
free: {block: {position: 0, speed: 1}}
loads:
  - {slider: block, force: "where(20 cm < block.position <= 50 cm, 3 N, 0 N)"}
"""
    solution = linkages.simulate(linkages.loads(text), end=1.0, samples=11, rtol=1e-9)
    # coasts 0.2 s, then 1.5 m/s² over 0.3 m
    speed = np.sqrt(1 + 2 * 1.5 * 0.3)
    ends = [0.2, 0.2 + (speed - 1) / 1.5]
    times = sorted(t for changed in solution.motion.changes.values() for t in changed.time)
    assert times == pytest.approx(ends, abs=1e-12)
    end = 0.5 + speed * (1 - ends[1])
    assert solution.data.slider_position.item(-1) == pytest.approx(end, abs=1e-12)
