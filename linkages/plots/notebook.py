"""Mechanisms and solutions as notebooks show them."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from io import StringIO
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


def table(heads: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: bool = False) -> str:
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
    return "\n".join([*parts, table(["section", "entries", "names"], rows)])


def topology_html(topology: Topology) -> str:
    """Mobility and coordinates, and the blocks in the order in which they are solved."""
    rows = [
        [str(place), block.title, ", ".join(block.unknowns)]
        for place, block in enumerate(topology.solved_blocks, start=1)
    ]
    name = escape(topology.mechanism.name)
    parts = [STYLE, f"<h4>{name}: topology</h4>", _mobility(topology)]
    return "\n".join([*parts, table(["", "block", "coordinates"], rows)] if rows else parts)


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
        table(["largest absolute value", "", "at t (s)", "unit"], rows, numbers=True),
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
