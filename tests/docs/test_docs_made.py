"""What scripts make for the pages: each output is in one table, and stands on a page."""

import json
import re
import runpy
import sys

import pytest
from make import registry
from PIL import Image

MAKERS = registry.discovered()
OUTPUTS = [name for maker in MAKERS for name in maker.outputs]
SHOWN = registry.shown()
NEITHER = {"pages.css"}
"""Files of docs/_static that a person writes, beside fonts."""


def test_every_file_is_an_output():
    static = registry.STATIC
    files = {f.relative_to(static).as_posix() for f in static.rglob("*") if f.is_file()}
    found = {name for name in files - NEITHER if not name.startswith("fonts/")}
    kept = {maker.numbers for maker in MAKERS} - {None}
    assert found == {n for n in {*OUTPUTS, *kept} if "." in n and not n.startswith("../")}


def test_every_output_is_made_once_and_shown():
    assert len(OUTPUTS) == len(set(OUTPUTS))
    drawn = [name for name in OUTPUTS if not name.endswith(".json")]
    assert [name for name in drawn if name not in SHOWN] == []


def test_everything_shown_is_an_output():
    assert {*SHOWN} <= {*OUTPUTS, "figures"}


def test_the_page_lists_all_outputs_with_their_scripts_and_pages():
    """`python docs/make NAME` writes the page anew."""
    page = registry.LIST.read_text(encoding="utf-8")
    table = page.partition("<!-- table: figures -->\n\n")[2].partition("\n<!-- end of table -->")[0]
    assert table == registry.rows(MAKERS, registry.known())
    lines = table.splitlines()[2:]
    assert len(lines) == len(MAKERS)
    for line in lines:
        script, seconds = re.fullmatch(r"\| .*? \| `(\S+)` \| \[.* \| (\S+) \|", line).groups()
        assert (registry.SCRIPTS / script).is_file()
        assert seconds == "–" or float(seconds) >= 0


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["contact-laws.svg"], {"contact-laws.svg"}),
        (["docs/_static/contact-laws.svg"], {"contact-laws.svg"}),
        (["docs/make/wear.py"], {"wear-cost"}),
        (["docs/components/cam.md"], {"cam-jump.png", "component-cam.svg"}),
        (
            ["gallery/four-bar*"],
            {f"gallery/four-bar{ending}" for ending in (".webp", ".svg", "-drawing.svg")},
        ),
        (["wear.py"], {"wear-cost"}),
        (["tolerances.md"], {"tolerances.png"}),
        (["chains.json"], {"chains.json"}),
        (["free_chains.*"], {"free_chains.json", "free_chains.svg", "free-chains"}),
    ],
)
def test_outputs_scripts_pages_and_patterns_are_names(names, expected):
    chosen = registry.selected(names, MAKERS)
    assert {name for maker in chosen for name in maker.outputs} == expected


def test_pages_and_scripts_do_not_measure():
    chosen = registry.selected(["benchmark.md", "chains"], MAKERS)
    assert not any(name.endswith(".json") for maker in chosen for name in maker.outputs)
    assert {"chains.svg", "bench-ninebar"} <= {name for maker in chosen for name in maker.outputs}


def test_numbers_are_measured_before_they_are_drawn():
    order = [maker.outputs for maker in registry.selected(["chains*", "verdicts.md"], MAKERS)]
    assert order[0] == ("chains.json",)
    assert order[-1][0] == "verdicts-shares"
    assert order.index(("chains.svg", "chains")) > order.index(("verdicts-maps",))


def test_names_of_nothing_are_refused():
    with pytest.raises(ValueError, match=r"nought\.png: no output, script or page"):
        registry.selected(["nought.png", "wear.py"], MAKERS)


def test_each_kind_of_output_is_kept(tmp_path, monkeypatch):
    page = tmp_path / "page.md"
    marks = "<!-- table: some -->\n\n{}<!-- end of table -->\nrest\n"
    page.write_text(marks.format("old\n\n"), encoding="utf-8")
    monkeypatch.setattr(registry, "STATIC", tmp_path)
    monkeypatch.setattr(registry, "pages", lambda: [page])
    registry.keep("some", registry.table(("a", "b"), [("x", 1)]))
    text = marks.format("| a | b |\n|---|--:|\n| x | 1 |\n\n")
    assert page.read_text(encoding="utf-8") == text
    registry.keep("numbers.json", {"rows": [{"n": 1 / 3}, {"n": 2}], "more": [0.1]})
    text = (tmp_path / "numbers.json").read_text(encoding="utf-8")
    assert '\n  {"n": 0.3333},\n  {"n": 2}\n' in text
    assert json.loads(text).keys() == {"machine", "date", "rows", "more"}
    registry.keep("picture.png", Image.new("RGB", (3, 2), "red"))
    with Image.open(tmp_path / "picture.png") as image:
        assert image.size == (3, 2)
    with pytest.raises(ValueError, match="no page has a place for the table 'other'"):
        registry.keep("other", "text")
    for name, made in (("absent.png", tmp_path / "absent.png"), ("none.png", None)):
        with pytest.raises(TypeError, match=name):
            registry.keep(name, made)


def test_films_are_small():
    assert (
        max((registry.STATIC / f"ninebar.{kind}").stat().st_size for kind in ("gif", "webp")) < 1e6
    )


def test_the_program_lists_outputs_and_refuses_names(monkeypatch, capsys):
    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["docs/make", *arguments])
        monkeypatch.setattr(sys, "path", [*sys.path])
        runpy.run_path(str(registry.SCRIPTS), run_name="__main__")

    run("--list", "wear.py")
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 3
    assert lines[2].startswith("| `wear-cost` | `wear.py` | [wear](wear.md) |")
    with pytest.raises(SystemExit):
        run("nought")
    assert "nought: no output, script or page of the table" in capsys.readouterr().err
