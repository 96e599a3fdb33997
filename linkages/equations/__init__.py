"""Closure, energies and Lagrange's equations of a mechanism as SymPy expressions.

They share no formula with the kernel, so that each can check the other. SymPy is loaded when an
equation is asked for, not before.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from linkages.equations.derivation import Equations
    from linkages.topology.topology import Topology

__all__ = ["derive", "render"]


def derive(topology: Topology) -> Equations:
    """Derive the equations of an analysed mechanism; see `linkages.equations.derivation`."""
    from linkages.equations import derivation

    return derivation.derive(topology)


def render(equations: Equations, format: str = "text") -> str:  # noqa: A002
    """Print equations as ``"text"``, ``"latex"`` or ``"python"``."""
    from linkages.equations import printing

    return printing.render(equations, format)
