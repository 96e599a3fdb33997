import numpy as np
import pytest

import linkages
from linkages.errors import InputError
from linkages.reading.document import parse
from linkages.reading.overrides import apply, parse_assignment

TEXT = """\
gravity: [0, -9.81]
bars:
  crank: {joints: [A, B], length: 0.3}
loads:
  - {bar: crank, torque: 5}
  - {bar: crank, torque: 6}
drives:
"""


@pytest.fixture
def document():
    return parse(TEXT, "m.yaml")


class Array:
    """Stands for a numpy array or scalar, which reading does not import."""

    def __init__(self, value):
        self.value = value

    def tolist(self):
        return self.value


@pytest.mark.parametrize(
    ("path", "value", "where", "expected"),
    [
        ("bars.crank.length", 0.25, ("bars", "crank", "length"), 0.25),
        ("bars.crank.length", "12 cm", ("bars", "crank", "length"), "12 cm"),
        ("bars.crank.mass", "1e-3", ("bars", "crank", "mass"), "1e-3"),
        ("loads[1].torque", 7, ("loads", 1, "torque"), 7),
        ("loads.1.torque", "-pi", ("loads", 1, "torque"), "-pi"),
        ("gravity", "[0,-9.81]", ("gravity",), ["0", "-9.81"]),
        ("gravity", (0, -1.62), ("gravity",), [0, -1.62]),
        ("gravity", Array([0.0, 1.0]), ("gravity",), [0.0, 1.0]),
        ("gravity[1]", Array(2.5), ("gravity", 1), 2.5),
        ("drives.crank.speed", "30 rpm", ("drives", "crank", "speed"), "30 rpm"),
        ("clearances.r1", "{joint: B, size: 1e-4}", ("clearances", "r1", "size"), "1e-4"),
        ("drives", "", ("drives",), None),
    ],
)
def test_value_at_path(document, path, value, where, expected):
    assert apply(document, {path: value}).value(where) == expected


def test_the_given_document_is_not_changed(document):
    changed = apply(document, {"bars.crank.length": 1, "loads[0].torque": 1})
    assert document == parse(TEXT, "m.yaml")
    assert changed.content["loads"][1] is document.content["loads"][1]


def test_problems_of_set_values_name_the_assignment_and_no_line(document):
    changed = apply(document, {"bars.crank.length": "-12 cm", "springz.s.size": 1.5})
    assert changed.locate(("bars", "crank", "length")) is None
    assert str(changed.problem(("bars", "crank", "length"), "wrong")) == (
        "bars.crank.length: wrong (from set bars.crank.length=-12 cm)"
    )
    # Created on the way to the value, so it has no line either.
    assert str(changed.problem(("springz",), "unknown")) == (
        "springz: unknown (from set springz.s.size=1.5)"
    )
    assert str(changed.problem(("bars", "crank", "joints"), "wrong")) == (
        "line 3, column 11, bars.crank.joints: wrong"
    )


def test_replaced_values_lose_the_places_of_what_was_inside(document):
    changed = apply(document, {"bars.crank": "{joints: [A, C]}"})
    assert changed.locate(("bars", "crank", "joints", 1)) is None
    assert changed.locate(("bars",)) == (2, 1)
    again = apply(changed, {"bars.crank.joints[0]": "D"})
    assert again.content["bars"]["crank"]["joints"] == ["D", "C"]


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        ("loads[2].torque", 1, "index 2 is out of range: loads has 2 entries (from set loads[2]"),
        ("loads.first.torque", 1, "loads is a list; expected an index, found 'first'"),
        ("loads[99999999999].x", 1, "expected a path such as"),
        ("loads.99999999999.x", 1, "index 99999999999 is out of range"),
        ("bars[0]", 1, "bars is a mapping; [0] needs a list"),
        ("drives[0]", 1, "drives is nothing; [0] needs a list"),
        ("bars.crank.length.unit", 1, "bars.crank.length is '0.3'; 'unit' needs a mapping"),
        ("", 1, "expected a path such as"),
        ("a..b", 1, "expected a path such as"),
        ("[0]", 1, "expected a path such as"),
        ("loads[-1]", 1, "expected a path such as"),
        ("gravity", "[0, ", "not valid YAML"),
        ("gravity", "!!python/name:os.system x", "is not allowed"),
        ("gravity", "1\nbars: 2", "expected a value on one line"),
        ("gravity", "\x00", "is not text"),
        ("gravity", object(), "found a value of type object"),
    ],
)
def test_assignments_that_cannot_be_made(document, path, value, expected):
    with pytest.raises(InputError) as caught:
        apply(document, {path: value})
    (problem,) = caught.value.problems
    assert expected in problem.message
    assert "(from set " in problem.message
    assert problem.line is None
    assert "\n" not in str(problem)


def test_one_value_of_a_misspelt_entry(document):
    with pytest.raises(InputError) as caught:
        apply(document, {"bars.cank.length": 1})
    (problem,) = caught.value.problems
    assert problem.message == (
        "unknown name 'cank'; did you mean 'crank'? (from set bars.cank.length=1)"
    )


def test_a_new_entry_may_have_a_similar_name(document):
    changed = apply(document, {"bars.crank2.length": 1, "bars.crank2.joints": "[B, C]"})
    assert changed.content["bars"]["crank2"] == {"length": 1, "joints": ["B", "C"]}
    changed = apply(document, {"bars.crank2": "{length: 1}"})
    assert changed.content["bars"]["crank2"] == {"length": "1"}


def test_all_faulty_assignments_at_once(document):
    with pytest.raises(InputError) as caught:
        apply(document, {"loads[7]": 1, "gravity.x": 2, "bars.crank.length": 1})
    assert len(caught.value.problems) == 2


def test_endless_value(document):
    endless = []
    endless.append(endless)
    with pytest.raises(InputError, match="nested more than"):
        apply(document, {"gravity": endless})


def test_parse_assignment():
    assert parse_assignment("a.b[0] = x=1") == ("a.b[0]", "x=1")
    assert parse_assignment("a=") == ("a", "")


@pytest.mark.parametrize("text", ["", "=1", "a", "a..b=1", "a[x]=1"])
def test_text_that_is_no_assignment(text):
    with pytest.raises(InputError, match="expected path=value") as caught:
        parse_assignment(text)
    assert caught.value.source == "--set"


def test_quantities_of_pint_carry_their_unit():
    import pint

    unit = pint.UnitRegistry()
    values = {
        "bars.crank.length": 40 * unit.mm,
        "bars.rocker.inertia": unit.Quantity(300.0, "kg mm^2"),
        "drives.crank.speed": np.float64(90) * unit.rpm,
        "joints.O4": unit.Quantity([10.0, -2.5], "cm"),
        "bars.rocker.mass": unit.Quantity(2, "lb"),
        "simulate.samples": unit.Quantity(11, ""),
    }
    mechanism = linkages.load("four-bar", set=values)
    assert mechanism.bodies["crank"].points["A"][0].value == 0.04
    assert mechanism.bodies["rocker"].inertia.value == pytest.approx(3e-4, rel=1e-15)
    assert [x.value for x in mechanism.ground["O4"]] == [0.1, -0.025]
    assert mechanism.bodies["rocker"].mass.value == pytest.approx(0.90718474, rel=1e-15)
    assert mechanism.simulation.samples == 11
    speeds = [c.speed for c in mechanism.components if isinstance(c, linkages.Drive)]
    assert speeds == [pytest.approx(3 * np.pi, rel=1e-15)]
    with pytest.raises(InputError, match="kilogram is a mass, not a length"):
        linkages.load("four-bar", set={"bars.crank.length": 1 * unit.kg})
