"""Pages and notebook views that need no other file."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from io import BytesIO, StringIO
from string import Template
from typing import Any

from matplotlib.figure import Figure

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.system import System
from linkages.plots.mechanism import drawing
from linkages.plots.style import style
from linkages.solution.solution import Solution
from linkages.topology.topology import Topology

STYLE = """<style>
table.linkages th, table.linkages td { text-align: left; padding: 0.1em 1.2em 0.1em 0; }
table.linkages.numbers .n { text-align: right; font-variant-numeric: tabular-nums; }
</style>"""
"""Of tables: pages around them have their own rules, or none."""


def notebook_table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: bool = False
) -> str:
    """A table, whose cells but the first of a row may be numbers, set to the right."""

    def row(tag: str, cells: Sequence[str]) -> str:
        marked = [
            f"<{tag}{' class=n' if place else ''}>{escape(cell)}</{tag}>"
            for place, cell in enumerate(cells)
        ]
        return f"<tr>{''.join(marked)}</tr>"

    body = "\n".join([row("th", heads), *(row("td", cells) for cells in rows)])
    kind = "linkages numbers" if numbers else "linkages"
    return f'<table class="{kind}">\n{body}\n</table>'


def mechanism_html(mechanism: Mechanism) -> str:
    """A drawing at t = 0, mobility and coordinates, and how many components there are of each kind.

    Of one that cannot be assembled, what is wrong with it.
    """
    counts: dict[str, list[str]] = {}
    for component in mechanism.components:
        counts.setdefault(component.section, []).append(str(component.path[-1]))
    rows = [[section, str(len(names)), ", ".join(names)] for section, names in counts.items()]
    parts = [STYLE, f"<h4>{escape(mechanism.name)}</h4>"]
    try:
        system = System(mechanism)
    except InputError as error:
        parts.append(f"<pre>{escape(str(error))}</pre>")
    else:
        parts += [_svg(drawing.start_figure(system)), _mobility(system.topology)]
    return "\n".join([*parts, notebook_table(["section", "entries", "names"], rows)])


def topology_html(topology: Topology) -> str:
    """Mobility and coordinates, and the blocks in the order in which they are solved."""
    rows = [
        [str(place), block.title, ", ".join(block.unknowns)]
        for place, block in enumerate(topology.solved_blocks, start=1)
    ]
    name = escape(topology.mechanism.name)
    parts = [STYLE, f"<h4>{name}: topology</h4>", _mobility(topology)]
    return "\n".join(
        [*parts, notebook_table(["", "block", "coordinates"], rows)] if rows else parts
    )


def _mobility(topology: Topology) -> str:
    moved = [
        f"{word} {', '.join(names)}"
        for word, names in (("driven", topology.driven), ("free", topology.free))
        if names
    ]
    return (
        f"<p>mobility {topology.mobility}: {escape('; '.join(moved))}; "
        f"{len(topology.dependent)} dependent coordinates in "
        f"{len(topology.solved_blocks)} blocks</p>"
    )


def solution_html(solution: Solution) -> str:
    """How it was computed, the largest value of each output, and notes."""
    data, motion = solution.data, solution.motion
    largest: dict[str, dict[str, Any]] = {}
    for row in solution.maxima:
        before = largest.setdefault(row["variable"], row)
        if abs(row["value"]) > abs(before["value"]):
            largest[row["variable"]] = row
    rows = [
        [f"{row['long_name']} {row['element']}", *(f"{row[key]:.6g}" for key in ("value", "time")),
         row["units"]]
        for row in largest.values()
    ]  # fmt: skip
    how = (
        f"{motion.method}, rtol {solution.settings.run.rtol:g}"
        if motion.method
        else "no integration"
    )
    parts = [
        STYLE,
        f"<h4>{escape(solution.mechanism.name)}</h4>",
        f"<p>{escape(solution.summary)}; {escape(how)}</p>",
        notebook_table(["largest absolute value", "", "at t (s)", "unit"], rows, numbers=True),
        f"<p>outputs: {', '.join(escape(str(name)) for name in data.data_vars)}</p>",
    ]
    notes = [*solution.notes, *motion.notes] if motion.failure is None else [*solution.notes]
    failed = [] if motion.failure is None else [f"stopped {motion.failure}"]
    listed = "".join(f"<li>{escape(note)}</li>" for note in dict.fromkeys([*failed, *notes]))
    return "\n".join([*parts, f"<ul>{listed}</ul>" if listed else ""])


def _svg(figure: Figure) -> str:
    stream = StringIO()
    with style():
        figure.savefig(stream, format="svg", metadata={"Creator": None, "Date": None})
    text = stream.getvalue()
    return text[text.index("<svg") :]


_PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>$title</title>
<style>
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
.texts td.n, .texts th.n { text-align: left; }
figure { margin: 1.2rem 0; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .9rem; }
pre { font-size: .8rem; background: #f6f6f6; padding: .6rem; overflow-x: auto; }
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


def page(title: str, source: str, changes: Sequence[str], body: Iterable[str]) -> str:
    """A page as HTML.

    Parameters
    ----------
    title, source
        What it is of, and the name of the file that defines it.
    changes
        In what that differs from its file.
    body
        Parts as HTML; empty ones are left out.
    """
    from importlib.metadata import version

    differs = [f'<p class="changed">{escape(spaced(text))}</p>' for text in changes]
    return _PAGE.substitute(
        title=escape(title),
        source=escape(source),
        body="\n".join([*differs, *(part for part in body if part)]),
        version=version("linkages"),
    )


def spaced(change: str) -> str:
    """An assignment as people read it."""
    return change.replace("=", " = ", 1)


def section(heading: str, *parts: str) -> str:
    """A heading with what stands under it; nothing if that is empty."""
    text = "\n".join(part for part in parts if part)
    return f"<h2>{escape(heading)}</h2>\n{text}" if text else ""


def paragraph(text: str) -> str:
    """A text of its own."""
    return f"<p>{escape(text)}</p>" if text else ""


def items(texts: Iterable[str]) -> str:
    """A list of texts; nothing if there are none."""
    found = "\n".join(f"<li>{escape(text)}</li>" for text in texts)
    return f"<ul>\n{found}\n</ul>" if found else ""


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], *, texts: bool = False) -> str:
    """A table; all cells but the first of a row are numbers, unless they are texts."""
    found = notebook_table(heads, rows)
    return f'<div class="texts">{found}</div>' if texts else found


def definition(text: str) -> str:
    """The text of a definition, folded."""
    return f"<details><summary>Definition</summary><pre>{escape(text)}</pre></details>"


def picture(figure: Figure) -> bytes:
    """A figure as PNG."""
    stream = BytesIO()
    with style():
        figure.savefig(stream, format="png", metadata={"Software": None})
    return stream.getvalue()


def figure_with(figure: Figure, text: str) -> str:
    """A figure over its caption."""
    source, caption = b64encode(picture(figure)).decode("ascii"), escape(text)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{source}">'
        f"<figcaption>{caption}</figcaption></figure>"
    )
