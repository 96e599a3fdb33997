"""Every command, definition and piece of Python in README.md and docs/ runs as shown."""

import doctest
import importlib
import re
from pathlib import Path

import pytest
from make import examples, schema_tables

ROOT = Path(__file__).resolve().parents[2]


PAGES = [str(page.relative_to(ROOT)) for page in examples.pages()]


@pytest.mark.slow_except("README.md")
@pytest.mark.parametrize("page", PAGES)
def test_page_shows_what_its_examples_do(page, tmp_path):
    _, outputs = examples.run(ROOT / page, tmp_path)
    stale = [
        f"{output.example}\n--- shown\n{output.shown}--- found\n{output.found}"
        for output in outputs
        if not output.agrees
    ]
    assert not stale, "`python docs/make/examples.py` rewrites these:\n" + "\n".join(stale)


@pytest.mark.parametrize(
    ("shown", "found", "agrees"),
    [
        ("value 1.000 m\n", "value   1.001 m\n", True),
        ("value 1.000 m\n", "value 1.1 m\n", False),
        ("value 1 m\n", "value 1 s\n", False),
        ("first\n...\nlast\n", "first\nsecond\nthird\nlast\n", True),
        ("first\n...\nlast\n", "first\nsecond\nend\n", False),
        ("one\n", "one\ntwo\n", False),
        ("closure residual 1e-16 m\n", "closure residual 4e-16 m\n", True),
    ],
)
def test_outputs_agree_up_to_round_off_and_ellipsis(shown, found, agrees):
    assert examples.Output("example", shown, found).agrees is agrees


def test_every_output_stands_on_its_page():
    from linkages.kernel.outputs import VARIABLES

    text = (ROOT / "docs" / "outputs.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in text.splitlines() if line.startswith("| `")]
    found = {}
    for _, names, mark, units, *_ in (row for row in rows if len(row) == 6):
        listed = re.findall(r"`(\w+)`", names)
        given = [unit.strip() for unit in units.split(",")]
        found |= {
            name: (given[-1] if len(given) == 1 else given[place], bool(mark.strip()))
            for place, name in enumerate(listed)
        }
    assert found == {name: (entry.units, entry.default) for name, entry in VARIABLES.items()}


def test_every_figure_stands_on_the_page_of_outputs():
    from linkages.plots.figures import FIGURES, OF_ALL, WITHOUT_SLIDERS

    text = (ROOT / "docs" / "outputs.md").read_text(encoding="utf-8")
    polar = [name for name in FIGURES if name.endswith("_polar")]
    named = [*OF_ALL, *WITHOUT_SLIDERS, *polar]
    assert [name for name in named if f"`{name}.png`" not in text] == []


@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "components").glob("*.md")), ids=str)
def test_component_page_is_in_the_list(page):
    index = (page.parent / "index.md").read_text(encoding="utf-8")
    title = page.read_text(encoding="utf-8").splitlines()[0].removeprefix("# ")
    assert page.stem == "index" or f"- [{title}]({page.name})" in index.splitlines()
    contents = re.search(r"<!-- toctree\n(.*?)\n-->", index, re.DOTALL)[1].splitlines()
    assert page.stem == "index" or page.stem in contents or {":glob:", "*"} <= set(contents)


def test_every_page_on_a_component_has_a_picture():
    static = ROOT / "docs" / "_static"
    for page in sorted((ROOT / "docs" / "components").glob("*.md")):
        if page.stem == "index":
            continue
        pictures = re.findall(r"!\[.*?\]\(../_static/(.*?)\)", page.read_text(encoding="utf-8"))
        own = static / f"component-{page.stem}.svg"
        assert own.name in pictures if own.is_file() else pictures, f"{page.name} has no picture"
    sizes = {file.name: file.stat().st_size for file in static.glob("component-*.svg")}
    assert {name: size for name, size in sizes.items() if size > 25_000} == {}


# without the pages that are other files of the repository
@pytest.mark.parametrize(
    "page", [page for page in PAGES if page not in ("docs/contributing.md", "docs/index.md")]
)
def test_page_reads_where_directives_are_unknown(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    assert not re.search(r"^(```|:::)\{|^: |^\([\w-]+\)=$", text, re.MULTILINE)
    opened = re.findall(r"^<!-- (table: [\w-]+|end of table) -->$", text, re.MULTILINE)
    assert all(mark.startswith("table") for mark in opened[::2])
    assert opened[1::2] == ["end of table"] * len(opened[::2])
    shown = re.findall(r"!\[(.*?)\]\((.*?)\)", text)
    assert all(words for words, _ in shown), "a picture has no text for those who do not see it"
    missing = [path for _, path in shown if not ((ROOT / page).parent / path).is_file()]
    assert missing == []


INTERFACE = sorted((ROOT / "docs" / "api").glob("*.rst"))


@pytest.mark.parametrize("page", INTERFACE, ids=lambda page: page.stem)
def test_examples_of_the_interface_run_as_shown(page):
    found = doctest.testfile(str(page), module_relative=False)
    assert found.attempted >= 2
    assert found.failed == 0


def test_every_public_name_stands_in_the_reference():
    import linkages
    from linkages.components.mechanisms.registry import components

    text = "\n".join(page.read_text(encoding="utf-8") for page in INTERFACE)
    assert "\n.. all components of the package: conf.py puts them here\n" in text
    listed = re.findall(r"^\.\. auto\w+:: linkages\.(\w+)$", text, re.MULTILINE)
    assert len(listed) == len(set(listed))
    assert set(linkages.__all__) == set(listed) | (set(components()) & set(linkages.__all__))


DOCTESTED = (
    "linkages.components.mechanisms.definition",
    "linkages.components.mechanisms.mechanism",
    "linkages.opened",
    "linkages.solution.rhs",
)


@pytest.mark.parametrize("name", DOCTESTED)
def test_examples_in_docstrings_run_as_shown(name):
    failed, tried = doctest.testmod(importlib.import_module(name))
    assert tried > 0
    assert failed == 0


def test_every_key_stands_on_a_page_of_the_format():
    import dataclasses

    from linkages.components.mechanisms.registry import SECTIONS

    pages = [ROOT / "docs" / "definition-file.md", *(ROOT / "docs" / "components").glob("*.md")]
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    samples = ({}, {"points": {}}, {"position": 0})
    models = {(s, s.choose(raw)) for s in SECTIONS.values() for raw in samples}
    missing = [
        f"{model.__name__}.{field.name}"
        for section, model in models
        for field in dataclasses.fields(model)
        if field.name not in ("name", "index", section.field) and f"`{field.name}`" not in text
    ]
    assert missing == []


def test_every_key_of_the_schema_stands_in_the_tables_made_at_build():
    from linkages.components.mechanisms.registry import SECTIONS, definition_schema

    text = schema_tables.tables()
    assert re.findall("^## (.*)$", text, re.M) == [*SECTIONS, "law", "Index of keys"]
    for name, model in definition_schema()["definitions"].items():
        table = text.split(f"**{name}.**")[1].split("\n\n")[1]
        rows = [line for line in table.splitlines() if line.startswith("| `")]
        assert [row.split("`")[1] for row in rows] == list(model["properties"])
        required = [row.split("`")[1] for row in rows if "| required |" in row]
        assert required == model.get("required", [])
    assert "<!-- tables of keys -->" in (ROOT / "docs" / "schema.md").read_text(encoding="utf-8")


def test_no_two_files_of_the_package_have_the_same_name():
    """As docs/architecture.md promises: a name leads to one file."""
    names = [path.name for path in (ROOT / "linkages").rglob("*.py") if path.stem != "__init__"]
    assert sorted(names) == sorted(set(names))


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/architecture.md"])
def test_files_to_start_from_exist(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    named = re.findall(r"`([\w./-]+/[\w.-]+|test_\w+\.py)`", text)
    folders = [ROOT, ROOT / "linkages", ROOT / "tests" / "solvers"]
    generated = {"docs/_build"}
    missing = [n for n in named if not any((f / n).exists() for f in folders)]
    assert len(named) > 20
    assert set(missing) <= generated


def test_contributing_is_one_text():
    text = (ROOT / "docs" / "contributing.md").read_text(encoding="utf-8")
    assert "{include} ../CONTRIBUTING.md" in text
    assert len(text.splitlines()) < 6
