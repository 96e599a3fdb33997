"""Runs printed statements as Python, for the tests of this folder."""

import math
from collections.abc import Sequence

from linkages.kernel.printing import Statements, write_functions
from linkages.kernel.scalars import FUNCTIONS, Scalar, reachable


def run_printed(roots: Sequence[Scalar], **inputs: Sequence[float]) -> list[float]:
    """Values of nodes by the text that kernels are made of, without a compiler.

    Where an iteration gives up, the number of its status is raised as a `LookupError`.
    """
    nodes = reachable(roots)
    known = {
        n.index: "t" if n.arguments[0] == "t" else "{}[{}]".format(*n.arguments)
        for n in nodes
        if n.operation == "input"
    }
    code = Statements([n for n in nodes if n.operands], roots, known)
    body = [*code.lines, f"return 0, [{', '.join(code.text(root) for root in roots)}]"]
    text = write_functions(nodes) + "\n\ndef values(y, p, t):\n"
    text += "\n".join(f"    {line}" for line in body)
    scope = {name: getattr(math, name) for name in (*FUNCTIONS, "atan2")}
    scope |= {"njit": lambda **_: lambda function: function, "_inline": {}}
    exec(text, scope)
    found = scope["values"](inputs.get("y"), inputs.get("p"), inputs.get("t"))
    if isinstance(found, int):
        raise LookupError(found)
    return found[1]
