import pytest
from component_reading import complaints, mechanism

from linkages.components.mechanisms.definition import load
from linkages.components.rigid_bodies import Bar
from linkages.errors import InputError

TEXT = """name: A crank
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 30 cm}
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "crank.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


@pytest.mark.parametrize("kind", [str, lambda path: path], ids=["text", "path"])
def test_load_a_file(file, kind):
    found = load(kind(file))
    assert (found.name, found.source) == ("A crank", str(file))
    assert found.components == mechanism(TEXT).components


def test_set_a_value(file):
    found = load(file, set={"bars.crank.length": 0.4, "bars.crank.mass": "200 g"})
    assert Bar(name="crank", joints=("O", "A"), length=0.4, mass=0.2) in found.components
    assert Bar(name="crank", joints=("O", "A"), length=0.3) in load(file).components


def test_a_wrong_value_from_outside_names_its_origin(file):
    with pytest.raises(InputError) as caught:
        load(file, set={"bars.crank.length": -1})
    (problem,) = caught.value.problems
    assert problem.line is None
    assert "expected a length > 0" in problem.message
    assert "bars.crank.length" in problem.message


def test_no_such_file(tmp_path):
    with pytest.raises(InputError) as caught:
        load(tmp_path / "missing.yaml")
    assert "missing.yaml" in str(caught.value)
    assert caught.value.exit_code == 2


def test_unknown_sections():
    assert complaints(TEXT + "slider: {}\n") == [
        "line 5, column 1, slider: unknown key 'slider'; did you mean 'sliders'?"
    ]
    (problem,) = complaints(TEXT + "colour: red\n")
    assert problem.startswith("line 5, column 1, colour: unknown key 'colour'; expected one of: ")


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("drives: [crank]", "drives: expected a mapping such as crank: {angle: 0, speed: 60 rpm}"),
        ("sliders: piston", "sliders: expected a mapping such as piston: {joint: B, through: O}"),
        ("loads: {slider: piston, force: 1}", "loads: expected a list such as [{slider: piston"),
    ],
)
def test_sections_of_the_wrong_form(section, message):
    (problem,) = complaints(TEXT + section + "\n")
    assert problem.startswith(f"line 5, column 1, {message}")


def test_entries_of_the_wrong_form():
    (problem,) = complaints(TEXT + "drives:\n  crank: 60 rpm\n")
    assert problem.startswith("line 6, column 3, drives.crank: expected a mapping such as {angle:")


@pytest.mark.parametrize("section", ["joints", "sliders", "drives", "free", "assembly", "loads"])
def test_an_empty_section_is_nothing(section):
    text = TEXT if section != "joints" else TEXT.replace("joints: {O: [0, 0]}\n", "")
    assert mechanism(text + f"{section}:\n").bodies


@pytest.mark.parametrize("name", ["[a, b]", '"two\\nlines"', '"a\\tb"', "{a: b}"])
def test_name_is_one_line(name):
    (problem,) = complaints(TEXT.replace("A crank", name))
    assert problem == "line 1, column 1, name: expected one line of text"


@pytest.mark.parametrize("key", ["a.b", "-a", "a b ", '"a\\nb"', "é" * 65, "\"__import__('os')\""])
def test_names_that_need_quoting_are_refused(key):
    found = complaints(
        TEXT.replace("crank:", f"{key}:")
        if not key.endswith(" ")
        else TEXT.replace("crank:", f'"{key}":')
    )
    assert any("a name (letters, digits, _" in problem for problem in found)


def test_names_of_other_alphabets():
    assert [*mechanism(TEXT.replace("crank:", "Kurbel-Ä 2:")).bodies] == ["Kurbel-Ä 2"]
