"""Solutions as notebooks show them: the page in a frame, below it what was computed."""

from __future__ import annotations

from html import escape

from linkages.plots import notebook
from linkages.solution.solution import Solution
from linkages.viewer.view import html

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
