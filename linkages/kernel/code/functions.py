"""Functions that processors have no instruction for, by their names in `linkages.operations`.

Others come from the C library, which differs from one machine to the next, and takes one state at a
time. No function of formulas is among them.
"""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.code import arcs, exponentials

FUNCTIONS: dict[str, Callable[..., str]] = {
    "exp": exponentials.exponential,
    "log": exponentials.logarithm,
    "sinh": exponentials.hyperbolic_sine,
    "cosh": exponentials.hyperbolic_cosine,
    "tanh": exponentials.hyperbolic_tangent,
    "asin": arcs.arc_sine,
    "acos": arcs.arc_cosine,
    "atan": arcs.arc_tangent,
    "atan2": arcs.arc_of,
}
"""Each writes what becomes of its operands, and returns the name of that."""
