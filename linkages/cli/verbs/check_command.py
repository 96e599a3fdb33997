"""``check``: components, mobility and solution of a mechanism."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import Request, mechanism_from, require_folder
from linkages.cli.terminal import console, print_changes, print_json, print_notes, table
from linkages.cli.verbs.contribution_rows import drives, loads, relations
from linkages.components.contributed.load_measures import Distance
from linkages.components.contributed.terms import Body
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.reading.paths import dotted
from linkages.solution.remarks import assumptions, doubts
from linkages.solution.run_options import options_of
from linkages.solution.stop_messages import joint_of
from linkages.topology.assur_groups import ITERATED, Block
from linkages.topology.graph import bodies_at
from linkages.topology.topology import numerical_mobility


def print_report(content: dict[str, Any], screen: Console) -> None:
    """Print everything that `check` found."""
    print_changes(content.get("changes", ()), screen)
    screen.print(f"[bold]{escape(content['mechanism'])}[/bold]")
    _print_bodies(content, screen)
    _print_contributions(content, screen)
    _print_mobility(content, screen)
    _print_blocks(content, screen)
    print_notes(content["notes"], screen)
    if "modes" in content:
        from linkages.cli.verbs.modes_command import print_modes

        print_modes(content["modes"], screen)
    if "kernel" in content:
        _print_kernel(content["kernel"], screen)


def _print_bodies(content: dict[str, Any], screen: Console) -> None:
    rows = [
        [b["name"], b["kind"], "–".join(b["joints"]), b["mass"], b["inertia"], b["coordinate"]]
        for b in content["bodies"]
    ]
    heads = ["body", "kind", "joints", "mass (kg)", "inertia (kg m²)", "coordinate"]
    screen.print(table("\nBodies", heads, rows))
    joints = [[j["joint"], ", ".join(j["bodies"]), *j["position"]] for j in content["joints"]]
    heads = ["joint", "bodies", "x (m)", "y (m)"]
    screen.print(table("\nJoints at t = 0", heads, joints, numbers=2))


def _print_contributions(content: dict[str, Any], screen: Console) -> None:
    """Welds and gears; drives; loads, springs, dampers and masses at joints."""
    headings = {
        "relations": "Welds and gears",
        "drives": "Drives",
        "loads": "Loads, springs and masses",
    }
    for key, heading in headings.items():
        rows = [[r["kind"], r["on"], r["value"], r["path"]] for r in content[key]]
        if rows:
            screen.print(table(f"\n{heading}", ["kind", "on", "value", "in the file"], rows))


def _print_mobility(content: dict[str, Any], screen: Console) -> None:
    mobility = content["mobility"]
    screen.print(
        f"\n{content['revolute_pairs']} revolute and {content['prismatic_pairs']} prismatic pairs, "
        f"{content['loops']} independent loops\n"
        f"mobility {mobility['gruebler']} by the Chebychev–Grübler–Kutzbach criterion, "
        f"{mobility['numerical']} by the rank of the closure Jacobian"
    )
    for what in ("driven", "free", "dependent"):
        screen.print(f"{what}: {', '.join(content[what]) or 'none'}", markup=False)
    if content["redundant"]:
        screen.print(f"redundant joints: {', '.join(content['redundant'])}", markup=False)


def _print_blocks(content: dict[str, Any], screen: Console) -> None:
    keys = ("block", "kind", "unknowns", "apex", "side", "condition")
    rows = [[", ".join(b[k]) if k == "unknowns" else b[k] for k in keys] for b in content["blocks"]]
    heads = ["block", "kind", "solves for", "at joint", "branch", "condition number"]
    if rows:
        screen.print(table("\nBlocks (Assur groups) in order of solution", heads, rows, numbers=1))


def _print_kernel(kernel: dict[str, Any], screen: Console) -> None:
    if "note" in kernel:
        screen.print(f"\nkernel: {kernel['note']}")
        return
    counts = kernel["operations"]
    kinds = list(next(iter(counts.values())))
    rows = [[part, *(count[kind] for kind in kinds)] for part, count in counts.items()]
    screen.print(table("\nOperations of the kernel", ["part", *kinds], rows, numbers=len(kinds)))
    left_out = ", ".join(kernel["left_out"]) or "nothing"
    screen.print(f"left out because the motion does not depend on it: {left_out}", markup=False)


def run(request: Request, kernel: bool, modes: bool, out: Path | None) -> int:
    """Print the report of a file; returns the exit code."""
    mechanism = mechanism_from(request.file, request.assignments, request.tables_from)
    if out is not None:
        require_folder(out)
    options_of(SimulationOptions, mechanism, {})
    system = System(mechanism)
    content = check_content(system)
    if mechanism.changes:
        content["changes"] = list(mechanism.changes)
    if kernel:
        content["kernel"] = _kernel(system)
    if modes or out is not None:
        from linkages.cli.verbs.modes_command import modes_content

        content["modes"] = modes_content(system, out, request.format)
    if request.json:
        print_json(content)
    else:
        print_report(content, console())
    return 0


def check_content(system: System) -> dict[str, Any]:
    """What the report says, as plain data for JSON."""
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
        "redundant": list(topology.redundant),
        "relations": relations(mechanism),
        "drives": drives(mechanism),
        "loads": loads(mechanism),
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
        "kind": f"{block.title}, {'iterated' if block.kind == ITERATED else 'closed form'}",
        "unknowns": list(block.unknowns),
        "apex": joint_of(system.model, block),
        "side": system.assembly.side_of(block),
        "condition": condition,
    }


def _notes(system: System) -> list[str]:
    notes = [*assumptions(system), *doubts(system.mechanism)]
    if system.topology.redundant:
        notes.append(
            f"constraints at {system.topology.redundant_places} are redundant: they repeat what "
            "others hold, and joint reactions are not determined by rigid bodies alone"
        )
    held = _held(system.mechanism)
    ends = [joint for joint in system.topology.free_ends if joint not in held]
    notes += [f"joint {joint} is a free end: only one body has it" for joint in ends]
    return notes


def _held(mechanism: Mechanism) -> set[str]:
    """Joints that a spring or damper pulls at, or that the axis of a slider goes through."""
    along = [load.measure for load in mechanism.loads if isinstance(load.measure, Distance)]
    held = {joint for distance in along for joint in (distance.first, distance.second)}
    for guide in (body.guide for body in mechanism.bodies.values() if body.guide is not None):
        places = mechanism.ground if guide.body is None else mechanism.bodies[guide.body].points
        held |= {joint for joint, place in places.items() if place == guide.origin}
    return held


def _kernel(system: System) -> dict[str, Any]:
    if not system.topology.free:
        return {"note": "nothing is free to move: no kernel is compiled, nothing is integrated"}
    from linkages.kernel.code.program import report_kernel
    from linkages.solution.plan import kernel_source

    source = kernel_source(system.topology)
    report = report_kernel(source.model, source.program)
    return {"operations": report.counts, "left_out": [dotted(path) for path in report.left_out]}
