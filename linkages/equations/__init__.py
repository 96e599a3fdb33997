"""Closure, energies and Lagrange's equations of a mechanism as SymPy expressions.

They share no formula with the kernel, so that each can check the other. SymPy is loaded when an
equation is asked for, not before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkages.equations.derivation import SymbolicEquations
    from linkages.topology.topology import Topology

__all__ = ["FORMATS", "derive", "render"]

FORMATS = ("text", "latex", "python")


def derive(topology: Topology) -> SymbolicEquations:
    """Derive the equations of an analysed mechanism; see `linkages.equations.derivation`."""
    from linkages.equations import derivation

    return derivation.derive(topology)


def render(equations: SymbolicEquations, format: str = "text") -> str:  # noqa: A002
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
    from linkages.equations.python_module import write_python
    from linkages.equations.rendering import sections, write_latex, write_text

    match format:
        case "text":
            return write_text(equations.title, sections(equations), equations.symbols)
        case "latex":
            return write_latex(equations.title, sections(equations), equations.symbols)
        case "python":
            return write_python(equations)
    raise ValueError(f"unknown format {format!r}; expected one of: {', '.join(FORMATS)}")
