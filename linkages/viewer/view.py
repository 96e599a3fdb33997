"""Write the page of a motion."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import TypeAlias

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.opened import Opened
from linkages.reading.output_files import replaced
from linkages.reports import pages as notebook
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution
from linkages.viewer.content import page_content
from linkages.viewer.recorded import dense, wanted

Source: TypeAlias = Solution | Mechanism | Opened


def view(source: Source, path: str | Path | None = None) -> Path:
    """Write one HTML file that shows a motion: no network, no server, nothing beside it.

    Parameters
    ----------
    source
        A solution; a mechanism, which is simulated as its definition says; or results that
        `linkages.open` found.
    path
        Of the file; default: the name of the definition file, ending in ``.html``, in the current
        directory.

    Returns
    -------
    Where the file is.

    Raises
    ------
    ValueError
        If results do not say where joints are.
    """
    text = html(source)
    mechanism = source if isinstance(source, Mechanism) else source.mechanism
    stem = Path(mechanism.source).stem or "mechanism"
    file = Path(f"{stem}.html") if path is None else Path(path)
    with replaced(file) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return file


def html(source: Source) -> str:
    """The text of the file that `view` writes."""
    match source:
        case Solution():
            options, notes = source.options, source.notes
            return page_content(
                source.mechanism, dense(source), options, notes, source.motion.failure
            )
        case Mechanism():
            outputs = wanted(System(source))
            return html(simulate(source, outputs=outputs, throw=False))
        case Opened():
            return page_content(source.mechanism, source.data, source.arguments, source.notes, None)
        case _:
            expected = "a solution, a mechanism or opened results"
            raise TypeError(f"expected {expected}, found {source!r}")


HEIGHT = 760
"""Pixels of the frame."""


def solution_html(solution: Solution) -> str:
    """The page of a motion, in a frame that lets nothing out, and the table of largest values.

    The table alone where there are no two samples of where joints are.
    """
    text = notebook.solution_html(solution)
    if "joint_position" not in solution.data or solution.data.sizes["time"] < 2:
        return text
    name = escape(solution.mechanism.name)
    frame = (
        f'<iframe title="{name}" sandbox="allow-scripts allow-downloads" '
        f'style="width:100%;height:{HEIGHT}px;border:0" srcdoc="{escape(html(solution))}"></iframe>'
    )
    return f"{frame}\n{text}"
