"""How much a kernel computes, and what it leaves out."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from linkages.components.contributed.functions import Function, Number, Table
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import Path
from linkages.kernel.code.program import Program
from linkages.kernel.graph.scalars import Level, Scalar, reachable
from linkages.kernel.graph.several import SEVERAL
from linkages.kernel.model import Model
from linkages.operations import ELEMENTARY, KINDS

PARTS = {
    "once per run": Level.PARAMETERS,
    "once per distinct time": Level.TIME,
    "once per state": Level.STATE,
}


@dataclass(frozen=True)
class KernelReport:
    """Operation counts of a kernel.

    Parameters
    ----------
    counts
        Part (see `PARTS`) → kind of operation (see `linkages.operations.KINDS`) → number.
    left_out
        Numbers of the definition file that the motion does not depend on.
    """

    counts: dict[str, dict[str, int]]
    left_out: tuple[Path, ...]


def report_kernel(model: Model, program: Program) -> KernelReport:
    """Count the operations of a program, and find the inertia and loads that it does not need."""
    counts = {part: _count(program.groups[level]) for part, level in PARTS.items()}
    return KernelReport(counts, _left_out(model, program))


def _count(nodes: list[Scalar]) -> dict[str, int]:
    names = Counter(node.operation for node in nodes)
    found = dict.fromkeys(KINDS, 0)
    for name, number in names.items():
        row = ELEMENTARY.get(name) or SEVERAL.get(name)
        if row is not None:  # picking one of several results is no operation
            found[row.kind] += number
    return found


def _left_out(model: Model, program: Program) -> tuple[Path, ...]:
    nodes = reachable(node for level in program.groups.values() for node in level)
    used = {n.arguments for n in nodes if n.operation == "input"}
    numbered = {path: ("p", index) for index, path in enumerate(model.inputs.parameters)}
    given = [
        (*body.path, key)
        for body in model.mechanism.bodies.values()
        for key, value in (("mass", body.mass), ("inertia", body.inertia))
        if not value.absent
    ]
    given += [term.mass.path for term in model.mechanism.point_masses if not term.mass.absent]
    found = (leaf for load in model.mechanism.loads for leaf in leaves(load.force))
    given += dict.fromkeys(path for leaf in found if (path := _number(leaf)))
    return tuple(path for path in given if numbered.get(path) not in used)


def _number(leaf: Function) -> Path:
    """Path of a number of the definition file, the first one of a table; empty for others."""
    match leaf:
        case Number(parameter):
            return parameter.path
        case Table(path):
            return (*path, "spline", 0)
    return ()
