"""`new` and `schema`: files to start from, and what editors know of them."""

import json
from typing import get_args

import jsonschema
import pytest

import linkages
from linkages.cli.verb import Template
from linkages.components.mechanisms.registry import FILE_NAME, SECTIONS, definition_schema
from linkages.reading.document import parse, shipped

TEMPLATES = get_args(Template)
SHORT = ("--set", "simulate.end=0.01", "--set", "simulate.samples=11")


@pytest.mark.parametrize(
    "template",
    [pytest.param(t, marks=pytest.mark.slow if t == "nine-bar" else ()) for t in TEMPLATES],
)
def test_template_runs_as_it_stands(cli, template):
    result = cli("new", "mine", "--template", template)
    assert (result.code, result.err) == (0, "")
    assert result.files == {"mine.yaml", FILE_NAME}
    assert "python -m linkages simulate mine.yaml" in result.out
    done = cli("simulate", "mine.yaml", "--no-figures", *SHORT)
    assert (done.code, done.err) == (0, "")


@pytest.mark.parametrize(
    ("template", "name"),
    [("slider-crank", "slider-crank"), ("four-bar", "four-bar"), ("nine-bar", "ninebar")],
)
def test_template_is_the_mechanism_of_the_library(cli, template, name):
    assert cli("new", "mine", "--template", template).code == 0
    assert linkages.load("mine.yaml").components == linkages.load(name).components


@pytest.mark.slow_except("nine-bar")
@pytest.mark.parametrize("template", TEMPLATES)
def test_what_templates_comment_out_is_right(cli, tmp_path, template):
    """Sections that begin a commented line, with the entries that follow it."""
    cli("new", "mine", "--template", template)
    text = (tmp_path / "mine.yaml").read_text(encoding="utf-8")
    starts = ("#  ", *(f"# {key}:" for key in SECTIONS))
    lines = (line[2:] if line.startswith(starts) else line for line in text.splitlines())
    content = parse("\n".join(lines), "mine.yaml").content
    jsonschema.validate(content, definition_schema())
    if template == "empty":
        assert set(content) == {"name", *SECTIONS}


def test_nine_bar_has_its_clearance(cli):
    cli("new", "mine", "--template", "nine-bar")
    content = json.loads(cli("list", "mine.yaml", "--no-figures", "--json").out)
    assert (content["driven"], content["free"]) == (["crank1", "crank4"], ["r1"])


@pytest.mark.slow_except("engine-*", "deep*")
@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("engine", "engine.yaml"),
        ("engine.yaml", "engine.yaml"),
        ("engine.yml", "engine.yml"),
        ("press-1.5", "press-1.5.yaml"),
        ("deep/er/engine", "deep/er/engine.yaml"),
        ("mit Spiel", "mit Spiel.yaml"),
    ],
)
def test_names_and_paths(cli, tmp_path, name, file):
    result = cli("new", name, "--json")
    content = json.loads(result.out)
    assert content["template"] == "slider-crank"
    assert [tmp_path / path for path in content["files"]] == [
        tmp_path / file, (tmp_path / file).parent / FILE_NAME,
    ]  # fmt: skip
    assert linkages.load(file).name == "Slider-crank"
    assert f'simulate "{file}"' in cli("new", name, "--force").out or " " not in name


def test_nothing_is_replaced_unless_forced(cli, tmp_path):
    (tmp_path / "mine.yaml").write_text("my work")
    cli.refused("new", "mine", says="mine.yaml exists; --force replaces it", files={"mine.yaml"})
    assert (tmp_path / "mine.yaml").read_text() == "my work"
    assert cli("new", "mine", "--force").code == 0
    assert linkages.load("mine.yaml").name == "Slider-crank"


def test_schema_of_somebody_else_is_kept_and_an_old_one_brought_up_to_date(cli, tmp_path):
    (tmp_path / FILE_NAME).write_text('{"title": "of somebody else"}')
    result = cli("new", "mine")
    assert (result.code, result.files) == (2, {FILE_NAME})
    old = {"title": definition_schema()["title"], "old": True}
    (tmp_path / FILE_NAME).write_text(json.dumps(old))
    assert cli("new", "mine").code == 0
    assert json.loads((tmp_path / FILE_NAME).read_text(encoding="utf-8")) == definition_schema()


@pytest.mark.parametrize("name", ["", "folder/", "two\nlines"])
def test_what_is_no_name(cli, name):
    cli.refused("new", name, says="expected the name of a file", files=set())


def test_folder_of_that_name(cli, tmp_path):
    (tmp_path / "mine.yaml").mkdir()
    assert cli("new", "mine", "--force").code == 2


def test_schema_is_printed(cli):
    result = cli("schema")
    assert (result.code, result.err, result.files) == (0, "", frozenset())
    assert json.loads(result.out) == definition_schema()


# list NAME


def test_list_of_one_says_what_it_is(cli, tmp_path):
    result = cli("list", "ninebar")
    assert (result.code, result.err) == (0, "")
    for expected in (
        "Nine-bar press mechanism",
        'Source: "Nonlinear dynamic behavior',
        "mobility 3; driven: crank1, crank4; free: r1",
        str(shipped()["ninebar"]),
    ):
        assert expected in result.out
    assert "yaml-language-server" not in result.out
    picture = tmp_path / "results/ninebar/drawing.png"
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_list_of_one_as_json_to_another_folder(cli):
    result = cli("list", "four-bar.yaml", "--json", "--out", "here")
    content = json.loads(result.out)
    assert content["components"]["bars"] == ["crank", "coupler", "rocker"]
    assert content["description"][0].startswith("Four-bar linkage, driven at constant speed")
    assert (content["mobility"], content["driven"]) == (1, ["crank"])
    assert content["files"] == ["here/drawing.png"]
    assert result.files == {"here", "here/drawing.png"}


def test_list_of_one_without_figure(cli):
    assert not cli("list", "andrews", "--no-figures").files


def test_list_of_one_that_there_is_not(cli):
    cli.refused("list", "nine-bar", says="did you mean 'ninebar'?", files=set())
