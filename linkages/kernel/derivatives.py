"""The Jacobian of the equations of motion: exact derivatives with respect to the state."""

from __future__ import annotations

from collections.abc import Sequence

from linkages.kernel.code.program import Program, write_program
from linkages.kernel.graph.differentiation import derivative
from linkages.kernel.graph.scalars import Scalar, section
from linkages.kernel.model import Model


@section("derivatives of the accelerations")
def jacobian_nodes(model: Model, accelerations: Sequence[Scalar]) -> list[list[Scalar]]:
    """Derivatives of accelerations with respect to the state, shape (n, 2n)."""
    n = model.inputs.coordinates
    state = [model.inputs.coordinate(i) for i in range(n)] + [
        model.inputs.rate(i) for i in range(n)
    ]
    return derivative(accelerations, state)


def write_jacobian(model: Model, accelerations: Sequence[Scalar]) -> Program:
    """Print the kernel of the derivatives of accelerations.

    The program is like that of the accelerations themselves, with a parameter array and a clock
    of its own; its function ``rates(y, p, timed, out)`` writes ``∂a_i/∂y_j`` to ``out[2n·i + j]``,
    followed by margins and their rates.
    """
    entries = [entry for row in jacobian_nodes(model, accelerations) for entry in row]
    return write_program(model, entries)
