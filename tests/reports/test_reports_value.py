"""One report is the same on a terminal and on a page; each leaves out what it cannot show."""

import re

import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.cli.terminal import console, print_report
from linkages.reports.pages import page
from linkages.reports.report import (
    Column,
    Definition,
    Items,
    Notes,
    Picture,
    Report,
    Section,
    Table,
    Unbroken,
)

ROWS = [
    {"path": "a.b", "value": 1 / 3, "share": 0.25, "among": ["x", "y"], "active": True},
    {"path": "c", "value": None, "share": np.float64(1), "among": (), "active": False},
]
TABLE = Table.of(
    "\nNumbers", ROWS, "path: number", Column("value", "value", "mm"),
    Column("share", "share", form=".1%"), "among", "active: at bound", numbers=2,
)  # fmt: skip
REPORT = Report(
    name="Press [1]",
    summary="two <numbers>",
    parts=[
        "A paragraph.",
        Unbroken("a/path"),
        TABLE,
        Items(["first"]),
        Picture(Figure(), "A caption."),
        Section("More", ["Only on pages.", ""]),
        Section("Empty", [""]),
        Definition("name: x"),
        Notes(["be careful"]),
    ],
)


def test_cells_are_texts_of_values_in_the_format_of_their_column():
    assert TABLE.headings == ["number", "value (mm)", "share", "among", "at bound"]
    assert TABLE.cells == [
        ["a.b", "0.333333", "25.0%", "x, y", "yes"],
        ["c", "", "100.0%", "", ""],
    ]


def test_a_terminal_shows_texts_and_tables_in_their_order(capsys):
    print_report(REPORT, console())
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert lines == [
        "Press [1]: two <numbers>", "A paragraph.", "a/path", "", "Numbers",
        "number value (mm) share among at bound", "a.b 0.333333 25.0% x, y yes", "c 100.0%",
        "- first", "note: be careful",
    ]  # fmt: skip


def test_a_page_has_all_parts_but_empty_ones_and_sets_numbers_to_the_right():
    text = page(REPORT, linkages.load("pendulum"))
    assert re.findall("<h2>(.*)</h2>", text) == ["Numbers", "More", "Notes"]
    assert re.findall("<th( class=n)?>", text) == ["", "", "", " class=n", " class=n"]
    for part in ("<p>A paragraph.</p>", "<li>first</li>", "<figcaption>A caption.</figcaption>",
                 "<p>Only on pages.</p>", "<pre>name: x</pre>", "two &lt;numbers&gt;"):  # fmt: skip
        assert part in text
