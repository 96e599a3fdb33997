"""Runs printed statements as Python, for the tests of this folder."""

import math
from collections.abc import Sequence

from linkages.kernel.code.printing import Python, definitions
from linkages.kernel.code.statements import Entry, build_block
from linkages.kernel.graph.scalars import Scalar, reachable
from linkages.operations import ELEMENTARY


def input_places(nodes):
    """Where the inputs among nodes stand: an entry of the array of their name."""
    return {n.index: Entry(*n.arguments) for n in nodes if n.operation == "input"}


def run_printed(roots: Sequence[Scalar], **inputs: Sequence[float]) -> list[float]:
    """Values of nodes by the text that kernels are made of, without a compiler.

    Where an iteration gives up, the number of its status is raised as a `LookupError`.
    """
    nodes, called = reachable(roots), set()
    code = Python(build_block(nodes, input_places(nodes), roots), called)
    body = [*code.lines(), f"return 0, [{', '.join(code.text(root) for root in roots)}]"]
    text = definitions(called) + "\n\ndef values(y, p, t):\n"
    text += "\n".join(f"    {line}" for line in body)
    scope = {name: getattr(math, name) for name in called & ELEMENTARY.keys()}
    scope |= {"njit": lambda **_: lambda function: function, "_inline": {}}
    exec(text, scope)
    found = scope["values"](inputs.get("y"), inputs.get("p"), inputs.get("t"))
    if isinstance(found, int):
        raise LookupError(found)
    return found[1]
