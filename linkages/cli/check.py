"""``check``: what a mechanism is made of, how it moves and how it is solved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape

from linkages.cli.loading import mechanism_from
from linkages.cli.terminal import console, number, print_json, table
from linkages.components.terms import Body
from linkages.kernel.system import System
from linkages.reading.paths import dotted
from linkages.solution.assumptions import assumptions
from linkages.topology.blocks import Block
from linkages.topology.graph import bodies_at
from linkages.topology.jacobian import numerical_mobility


def run_check(file: str, assignments: Sequence[str], json: bool, kernel: bool) -> int:
    """Print the report of a file; returns the exit code."""
    system = System(mechanism_from(file, assignments))
    content = _content(system)
    if kernel:
        content["kernel"] = _kernel(system)
    if json:
        print_json(content)
    else:
        _print(content, console())
    return 0


def _content(system: System) -> dict[str, Any]:
    topology, mechanism = system.topology, system.mechanism
    places = system.places()
    return {
        "mechanism": mechanism.name,
        "bodies": [_body(system, body) for body in mechanism.bodies.values()],
        "joints": [
            {"joint": joint, "bodies": list(bodies), "position": [float(v) for v in places[joint]]}
            for joint, bodies in bodies_at(mechanism).items()
        ],
        "revolute_pairs": sum(len(b) - 1 for b in bodies_at(mechanism).values()),
        "prismatic_pairs": sum(not body.rotates for body in mechanism.bodies.values()),
        "loops": topology.loops,
        "mobility": {
            "gruebler": topology.mobility,
            "numerical": _numerical(system),
        },
        "driven": list(topology.driven),
        "free": list(topology.free),
        "dependent": list(topology.dependent),
        "blocks": [
            _block(system, block, condition)
            for block, condition in zip(topology.solved_blocks, system.conditions, strict=True)
        ],
        "notes": _notes(system),
    }


def _numerical(system: System) -> int:
    return numerical_mobility(system.jacobian)


def _body(system: System, body: Body) -> dict[str, Any]:
    topology = system.topology
    if body.name in topology.driven:
        coordinate = "driven"
    else:
        coordinate = "free" if body.name in topology.free else "dependent"
    return {
        "name": body.name,
        "kind": body.kind,
        "joints": list(body.points),
        "mass": body.mass.value,
        "inertia": body.inertia.value,
        "coordinate": coordinate,
    }


def _block(system: System, block: Block, condition: float) -> dict[str, Any]:
    return {
        "block": block.index,
        "kind": f"{block.kind} dyad, closed form",
        "unknowns": list(block.unknowns),
        "apex": block.loops[0].apex,
        "side": _side(system, block),
        "condition": condition,
    }


def _side(system: System, block: Block) -> str | None:
    sign = system.sides.get(block.index)
    if sign is None:
        return None
    words = ("left", "right") if block.kind == "RRR" else ("forward", "backward")
    return words[sign < 0]


def _notes(system: System) -> list[str]:
    notes = assumptions(system)
    ends = system.topology.free_ends
    notes += [f"joint {joint} is a free end: only one body has it" for joint in ends]
    return notes


def _kernel(system: System) -> dict[str, Any]:
    if not system.topology.free:
        return {"note": "nothing is free to move: no kernel is compiled, nothing is integrated"}
    from linkages.kernel.counting import report_kernel
    from linkages.solution.integration import kernel_source

    source = kernel_source(system)
    report = report_kernel(source.model, source.program)
    return {"operations": report.counts, "left_out": [dotted(path) for path in report.left_out]}


def _print(content: dict[str, Any], screen: Console) -> None:
    screen.print(f"[bold]{escape(content['mechanism'])}[/bold]")
    mobility = content["mobility"]
    rows = [
        [
            b["name"],
            b["kind"],
            "–".join(b["joints"]),
            number(b["mass"]),
            number(b["inertia"]),
            b["coordinate"],
        ]
        for b in content["bodies"]
    ]
    heads = ["body", "kind", "joints", "mass (kg)", "inertia (kg m²)", "coordinate"]
    screen.print(table("\nBodies", heads, rows))
    joints = [
        [j["joint"], ", ".join(j["bodies"]), *(number(v) for v in j["position"])]
        for j in content["joints"]
    ]
    screen.print(
        table("\nJoints at t = 0", ["joint", "bodies", "x (m)", "y (m)"], joints, numbers=2)
    )
    screen.print(
        f"\n{content['revolute_pairs']} revolute and {content['prismatic_pairs']} prismatic pairs, "
        f"{content['loops']} independent loops\n"
        f"mobility {mobility['gruebler']} by Grübler's formula, {mobility['numerical']} by the "
        "rank of the closure Jacobian"
    )
    for what in ("driven", "free", "dependent"):
        screen.print(f"{what}: {', '.join(content[what]) or 'none'}", markup=False)
    blocks = [
        [
            str(b["block"]),
            b["kind"],
            ", ".join(b["unknowns"]),
            b["apex"],
            b["side"] or "",
            number(b["condition"]),
        ]
        for b in content["blocks"]
    ]
    heads = ["block", "kind", "solves for", "at joint", "side", "condition number"]
    if blocks:
        screen.print(table("\nBlocks in their order of solution", heads, blocks, numbers=1))
    for note in content["notes"]:
        screen.print(f"note: {note}", markup=False)
    if "kernel" in content:
        _print_kernel(content["kernel"], screen)


def _print_kernel(kernel: dict[str, Any], screen: Console) -> None:
    if "note" in kernel:
        screen.print(f"\nkernel: {kernel['note']}")
        return
    counts = kernel["operations"]
    kinds = list(next(iter(counts.values())))
    rows = [[part, *(str(count[kind]) for kind in kinds)] for part, count in counts.items()]
    screen.print(table("\nOperations of the kernel", ["part", *kinds], rows, numbers=len(kinds)))
    left_out = ", ".join(kernel["left_out"]) or "nothing"
    screen.print(f"left out because the motion does not depend on it: {left_out}", markup=False)
