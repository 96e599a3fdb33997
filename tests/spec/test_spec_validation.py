from typing import Literal

import pytest
from pydantic import ConfigDict, model_validator
from pydantic.dataclasses import dataclass

from linkages.reading.document import parse
from linkages.reading.overrides import apply
from linkages.spec.quantities import Inertia, Length, Mass, Name, Point, PositiveLength
from linkages.spec.validation import annotation_at, validated

FORBID = ConfigDict(extra="forbid")


@dataclass(frozen=True, kw_only=True, config=FORBID)
class Marker:
    shape: Literal["circle", "square"]


@dataclass(frozen=True, kw_only=True, config=FORBID)
class Bar:
    name: Name
    joints: tuple[Name, Name]
    length: PositiveLength
    mass: Mass = 0.0
    inertia: Inertia | None = None
    center: Length | Point | None = None
    side: Literal["left", "right"] | Point = "left"
    points: dict[Name, Point] | None = None
    chain: tuple[Name, ...] = ()
    marker: Marker | None = None
    fixed: bool = False

    @model_validator(mode="after")
    def differ(self):
        if self.joints[0] == self.joints[1]:
            raise ValueError("expected two different joints")
        return self


GOOD = "joints: [A, B], length: 30 cm"


def validate(body, name="crank", overrides=None):
    document = parse(f"bars:\n  {name}: {body}\n", "m.yaml")
    if overrides:
        document = apply(document, overrides)
    problems = []
    key = next(iter(document.content["bars"]))
    raw = document.content["bars"][key]
    bar = validated(Bar, raw, document, ("bars", key), problems, name=key)
    assert (bar is None) == bool(problems)
    return bar, [str(problem) for problem in problems]


def test_instance_in_si():
    bar, _ = validate(f"{{{GOOD}, center: [10 cm, 0], side: right, points: {{P: [0, 1]}}}}")
    assert bar == Bar(
        name="crank", joints=("A", "B"), length=0.3, center=(0.1, 0.0), side="right",
        points={"P": (0.0, 1.0)},
    )  # fmt: skip


LENGTH = "expected a length (metres, or with a unit)"
POSITIVE = "expected a length > 0 (metres, or with a unit)"
POINT = "a list of two numbers (metres, or with units), such as [0.3, 0.4]"
NAMES = "expected a list of two names, such as [A, B]"
ENTRY = "expected a mapping such as {joints: [A, B], length: 0.3}"
NOT_NUMBER = "found 'x': expected a number before 'x'"
KEYS = "joints, length, mass, inertia, center, side, points, chain, marker, fixed"


@pytest.mark.parametrize(
    ("body", "column", "inside", "message"),
    [
        ("{joints: [A, B]}", 3, "", f"missing key 'length': {POSITIVE}"),
        ("{length: 1}", 3, "", f"missing key 'joints': {NAMES}"),
        ("{joints: [A, B], length: -12 cm}", 27, ".length", f"{POSITIVE}, found '-12 cm'"),
        ("{joints: [A], length: 1}", 11, ".joints", f"{NAMES}, found a list of 1"),
        ("{joints: [], length: 1}", 11, ".joints", f"{NAMES}, found an empty list"),
        ("{joints: [A, B, C], length: 1}", 11, ".joints", f"{NAMES}, found a list of 3"),
        ("{joints: A, length: 1}", 11, ".joints", f"{NAMES}, found 'A'"),
        ("{joints: [A, A], length: 1}", 3, "", "expected two different joints"),
        ("0.3", 3, "", f"{ENTRY}, found '0.3'"),
        ("", 3, "", f"{ENTRY}, found nothing"),
    ],
)
def test_problem_with_the_entry(body, column, inside, message):
    assert validate(body)[1] == [f"line 2, column {column}, bars.crank{inside}: {message}"]


@pytest.mark.parametrize(
    ("extra", "column", "inside", "message"),
    [
        ("mas: 1", 42, "mas", "unknown key 'mas'; did you mean 'mass'?"),
        ("name: x", 42, "name", f"unknown key 'name'; expected one of: {KEYS}"),
        (
            "side: lft", 42, "side",
            f"expected 'left' or 'right' or {POINT}, found 'lft'; did you mean 'left'?",
        ),
        (
            "side: [0, 3 kg]", 52, "side[1]",
            f"{LENGTH}, found '3 kg': kg is a mass, not a length",
        ),
        (
            "center: 3 kg", 42, "center",
            f"{LENGTH} or {POINT}, found '3 kg': kg is a mass, not a length",
        ),
        (
            "inertia: x", 42, "inertia",
            f"expected an inertia >= 0 (kg·m², or with a unit), {NOT_NUMBER}",
        ),
        ("points: {P: [0, x]}", 58, "points.P[1]", f"{LENGTH}, {NOT_NUMBER}"),
        ("points: [P]", 42, "points", "expected a mapping, found a list of 1"),
        ("chain: A", 42, "chain", "expected a list of names, such as [A, B], found 'A'"),
        (
            "marker: big", 42, "marker",
            "expected a mapping such as {shape: circle}, found 'big'",
        ),
        (
            "marker: {shape: cirle}", 51, "marker.shape",
            "expected 'circle' or 'square', found 'cirle'; did you mean 'circle'?",
        ),
        ("marker: {}", 42, "marker", "missing key 'shape': expected 'circle' or 'square'"),
        (
            "marker: {shape: circle, colour: x}", 66, "marker.colour",
            "unknown key 'colour'; expected shape",
        ),
        ("fixed: maybe", 42, "fixed", "expected true or false, found 'maybe'"),
    ],
)  # fmt: skip
def test_problem_with_a_key(extra, column, inside, message):
    expected = f"line 2, column {column}, bars.crank.{inside}: {message}"
    assert validate(f"{{{GOOD}, {extra}}}")[1] == [expected]


def test_all_problems_at_once():
    _, problems = validate("{joints: [A, 'x.y'], lenght: 1, name: x}")
    assert len(problems) == 4


def test_problem_of_the_name_is_the_entrys():
    _, (problem,) = validate(f"{{{GOOD}}}", name="a.b")
    assert problem.startswith("line 2, column 3, bars.'a.b': expected a name (letters")


def test_problem_of_a_set_value_names_the_assignment():
    _, problems = validate(
        f"{{{GOOD}}}", overrides={"bars.crank.length": "-1", "bars.crank.mas": 2}
    )
    assert problems == [
        "bars.crank.length: expected a length > 0 (metres, or with a unit), found '-1'"
        " (from set bars.crank.length=-1)",
        "bars.crank.mas: unknown key 'mas'; did you mean 'mass'? (from set bars.crank.mas=2)",
    ]


def test_value_that_is_wrapped_for_validation_keeps_its_path():
    document = parse("gravity: [0, x]\n", "m.yaml")
    problems = []
    wrapped = {"shape": document.content["gravity"]}
    assert validated(Marker, wrapped, document, ("gravity",), problems) is None
    assert problems[0].path == "gravity"


def test_a_path_beyond_a_list_of_so_many_leads_nowhere():
    assert annotation_at(tuple[int, str], (1,)) is str
    assert annotation_at(tuple[int, str], (2,)) is None
    assert annotation_at(tuple[str, ...], (2,)) is str
