"""Runs statements as machine code, for the tests of this folder."""

import ctypes
from collections.abc import Sequence

import numpy as np

from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.statements import Entry, Routine, build_block
from linkages.kernel.code.writer import write_assembly
from linkages.kernel.scalars import Scalar, reachable


def input_places(nodes):
    """Where the inputs among nodes stand: an entry of the array of their name."""
    return {n.index: Entry(*n.arguments) for n in nodes if n.operation == "input"}


def run_compiled(roots: Sequence[Scalar], **inputs: Sequence[float]) -> list[float]:
    """Values of nodes by machine code, made as that of kernels is.

    Where an iteration gives up, the number of its status is raised as a `LookupError`.
    """
    nodes = reachable(roots)
    stores = {Entry("out", k): root for k, root in enumerate(roots)}
    block = build_block(nodes, input_places(nodes), roots, stores=stores)
    arrays = {"y": len(inputs.get("y", ())), "p": len(inputs.get("p", ())), "out": len(roots)}
    code = MachineCode(write_assembly([Routine("values", "", {"t": 0, **arrays}, block)]))
    pointers = [ctypes.c_void_p] * len(arrays)
    function = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, *pointers)(code.address("values"))
    given = [np.array(inputs.get(name, [0.0]), dtype=float) for name in ("y", "p")]
    found = np.zeros(len(roots))
    status = function(inputs.get("t", 0.0), *(a.ctypes.data for a in (*given, found)))
    if status:
        raise LookupError(status)
    return found.tolist()
