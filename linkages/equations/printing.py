"""Equations in one of three forms."""

from __future__ import annotations

from linkages.equations.derivation import Equations
from linkages.equations.latex import write_latex
from linkages.equations.python import write_python
from linkages.equations.sheet import sections
from linkages.equations.text import write_text

FORMATS = ("text", "latex", "python")


def render(equations: Equations, format: str = "text") -> str:  # noqa: A002
    """Print equations.

    Parameters
    ----------
    equations
        Of one mechanism.
    format
        ``"text"`` for reading, ``"latex"`` for amsmath, ``"python"`` for a module that needs
        nothing but NumPy.

    Raises
    ------
    ValueError
        For any other format.
    """
    match format:
        case "text":
            return write_text(equations.title, sections(equations), equations.symbols)
        case "latex":
            return write_latex(equations.title, sections(equations), equations.symbols)
        case "python":
            return write_python(equations)
    raise ValueError(f"unknown format {format!r}; expected one of: {', '.join(FORMATS)}")
