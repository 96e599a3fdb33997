"""Pages and notebook views that need no other file."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from io import BytesIO
from string import Template
from typing import Any, assert_never

from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.system import System
from linkages.plots.mechanism import drawing
from linkages.plots.style import style
from linkages.reports.report import (
    Definition,
    Items,
    Notes,
    Part,
    Picture,
    Report,
    Section,
    Table,
)
from linkages.solution.solution import Solution
from linkages.topology.topology import Topology

STYLE = """<style>
table.linkages th, table.linkages td { text-align: left; padding: 0.1em 1.2em 0.1em 0; }
table.linkages .n { text-align: right; font-variant-numeric: tabular-nums; }
</style>"""
"""Of tables in notebooks: pages around them have their own rules, or none."""


def html(part: Part) -> str:
    """A part as HTML, with all its texts escaped; nothing if it is empty."""
    match part:
        case Table():
            below = replace(part, heading="")
            return html(Section(part.heading.strip(), [below])) if part.heading else _grid(part)
        case Items(texts):
            result = "\n".join(f"<li>{escape(text)}</li>" for text in texts)
            return f"<ul>\n{result}\n</ul>" if result else ""
        case Notes(texts):
            return html(Section("Notes", [Items(texts)]))
        case Picture(figure, text):
            source = b64encode(_saved(figure, "png", ("Software",))).decode("ascii")
            caption = escape(text)
            return (
                f'<figure><img alt="{caption}" src="data:image/png;base64,{source}">'
                f"<figcaption>{caption}</figcaption></figure>"
            )
        case Definition(text):
            return f"<details><summary>Definition</summary><pre>{escape(text)}</pre></details>"
        case Section(heading, parts):
            result = "\n".join(text for own in parts if (text := html(own)))
            return f"<h2>{escape(heading)}</h2>\n{result}" if result else ""
        case Markup():
            return part
        case str():
            return f"<p>{escape(part)}</p>" if part else ""
    assert_never(part)


SHOWN_ROWS = 40
"""Longer tables of pages are folded."""


class Markup(str):
    """A text that is HTML already."""


def _grid(table: Table) -> str:
    """A table without its heading, with numbers set to the right."""

    def row(tag: str, cells: Sequence[str]) -> str:
        left = len(cells) - table.numbers
        marked = [
            f"<{tag}{' class=n' if place >= left else ''}>{escape(cell)}</{tag}>"
            for place, cell in enumerate(cells)
        ]
        return f"<tr>{''.join(marked)}</tr>"

    body = "\n".join([row("th", table.headings), *(row("td", cells) for cells in table.cells)])
    grid = f'<table class="linkages">\n{body}\n</table>'
    count = len(table.rows)
    folded = f"<details><summary>{count} rows</summary>\n{grid}\n</details>"
    return grid if count <= SHOWN_ROWS else folded


def notebook(report: Report) -> str:
    """What notebooks show: a heading, and the parts."""
    title = f"{report.name}: {report.summary}" if report.summary else report.name
    return "\n".join([STYLE, f"<h4>{escape(title)}</h4>", *filter(None, map(html, report.parts))])


def mechanism_html(mechanism: Mechanism) -> str:
    """A drawing at t = 0, mobility, coordinates and components, or why it does not assemble."""
    counts: dict[str, list[str]] = {}
    for component in mechanism.components:
        counts.setdefault(component.section, []).append(str(component.path[-1]))
    rows = [[section, len(names), ", ".join(names)] for section, names in counts.items()]
    try:
        system = System(mechanism)
    except InputError as error:
        parts: list[Part] = [Markup(f"<pre>{escape(str(error))}</pre>")]
    else:
        parts = [
            Markup(_svg(drawing.start_figure(system))),
            f"{moved_by(system.topology)}; {in_blocks(system.topology)}",
        ]
    table = Table("", ["section", "entries", "names"], rows)
    return notebook(Report(name=mechanism.name, parts=[*parts, table]))


def topology_html(topology: Topology) -> str:
    """Mobility and coordinates, and the blocks in the order in which they are solved."""
    rows = [
        [place, block.title, ", ".join(block.unknowns)]
        for place, block in enumerate(topology.solved_blocks, start=1)
    ]
    parts: list[Part] = [f"{moved_by(topology)}; {in_blocks(topology)}"]
    if rows:
        parts.append(Table("", ["", "block", "coordinates"], rows))
    return notebook(Report(name=topology.mechanism.name, summary="topology", parts=parts))


def moved_by(topology: Topology) -> str:
    """The mobility, and what is driven and free."""
    moved = [
        f"{word} {', '.join(names)}"
        for word, names in (("driven", topology.driven), ("free", topology.free))
        if names
    ]
    return f"mobility {topology.mobility}" + f": {'; '.join(moved)}" * bool(moved)


def in_blocks(topology: Topology) -> str:
    """Numbers of dependent coordinates and of blocks."""
    counts = (
        (len(topology.dependent), "dependent coordinate"),
        (len(topology.solved_blocks), "block"),
    )
    return " in ".join(f"{count} {word}{'' if count == 1 else 's'}" for count, word in counts)


def computed_by(solution: Solution) -> list[str]:
    """What was computed and how, and what stopped it."""
    motion = solution.motion
    how = "drives determine the motion, nothing integrated"
    if motion.method:
        how = f"{motion.method}, rtol {solution.settings.run.rtol:g}"
    stopped = [] if motion.failure is None else [f"stopped {motion.failure}"]
    return [f"{solution.summary}; {how}", *stopped]


def solution_html(solution: Solution) -> str:
    """How it was computed, the largest value of each output, and notes."""
    data, motion, (how, *stopped) = solution.data, solution.motion, computed_by(solution)
    largest: dict[str, dict[str, Any]] = {}
    for row in solution.maxima:
        before = largest.setdefault(row["variable"], row)
        if abs(row["value"]) > abs(before["value"]):
            largest[row["variable"]] = row
    rows = [
        [f"{row['long_name']} {row['element']}", row["value"], row["time"], row["units"]]
        for row in largest.values()
    ]
    notes = [*solution.notes, *motion.notes] if motion.failure is None else [*solution.notes]
    parts: list[Part] = [
        how,
        Table("", ["largest absolute value", "", "at t (s)", "unit"], rows, numbers=3),
        f"outputs: {', '.join(map(str, data.data_vars))}",
        Items(list(dict.fromkeys([*stopped, *notes]))),
    ]
    return notebook(Report(name=solution.mechanism.name, parts=parts))


def _svg(figure: Figure) -> str:
    text = _saved(figure, "svg", ("Creator", "Date")).decode()
    return text[text.index("<svg") :]


def _saved(figure: Figure, form: str, left_out: Sequence[str]) -> bytes:
    """A figure in a format, without some of the metadata."""
    stream, metadata = BytesIO(), dict.fromkeys(left_out)
    with style():
        figure.savefig(stream, format=form, metadata=metadata)
    return stream.getvalue()


_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>$title</title>
<style>
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff;
       max-width: 54rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin: 0 0 .2rem; }
h2 { font-size: 1.1rem; margin: 2rem 0 .4rem; border-bottom: 1px solid #ddd; }
.source { color: #666; margin: 0 0 1rem; overflow-wrap: anywhere; }
.label { display: inline-block; color: #fff; border-radius: .3rem;
         font-size: 1.2rem; font-weight: 600; padding: .15rem .7rem; }
.changed { color: #b3420a; font-weight: 600; margin: .2rem 0; }
table { border-collapse: collapse; margin: .4rem 0; }
th, td { text-align: left; vertical-align: top; padding: .15rem 1.2rem .15rem 0;
         border-bottom: 1px solid #eee; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
figure { margin: 1.2rem 0; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .9rem; }
pre { font-size: .8rem; background: #f6f6f6; padding: .6rem; overflow-x: auto; }
table { display: block; overflow-x: auto; }
@media (prefers-color-scheme: dark) {
  body { color: #d8d8d8; background: #14181d; }
  h2, th, td { border-color: #333a42; }
  .source, figcaption { color: #a5adb5; }
  .changed { color: #ffb27d; }
  pre { background: #1d232a; }
  figure img { filter: invert(0.92) hue-rotate(180deg); }
}
@media print { body { max-width: none; margin: 0; font-size: 10pt; }
               figure, tr { break-inside: avoid; } pre { white-space: pre-wrap; } }
</style>
</head>
<body>
<h1>$title</h1>
<p class="source">$source</p>
$body
<p class="source">linkages $version</p>
</body>
</html>
""")


def page(report: Report, mechanism: Mechanism) -> str:
    """A page as HTML, with the definition file and changes; the summary is a coloured label."""
    from importlib.metadata import version

    body = [f'<p class="changed">{escape(spaced(text))}</p>' for text in mechanism.changes]
    if report.summary:
        look = f'class="label" style="background: {report.colours[1]}"'
        body.append(f"<p><span {look}>{escape(report.summary)}</span></p>")
    return _PAGE.substitute(
        title=escape(report.name),
        source=escape(mechanism.file_name),
        body="\n".join([*body, *filter(None, map(html, report.parts))]),
        version=version("linkages"),
    )


def spaced(change: str) -> str:
    """An assignment as people read it."""
    return change.replace("=", " = ", 1)
