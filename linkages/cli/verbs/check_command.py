"""``check``: components, mobility and solution of a mechanism."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from linkages.cli.requests import Request, mechanism_from, require_folder
from linkages.cli.terminal import console, present, print_changes
from linkages.cli.verbs.contribution_rows import drives, loads, relations
from linkages.components.contributed.load_measures import Distance
from linkages.components.contributed.terms import Body
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.reading.paths import dotted
from linkages.reports.report import Notes, Part, Report, Table
from linkages.solution.remarks import assumptions, doubts
from linkages.solution.run_options import options_of
from linkages.solution.stop_messages import joint_of
from linkages.topology.assur_groups import ITERATED, Block
from linkages.topology.graph import bodies_at
from linkages.topology.topology import numerical_mobility

BODIES = {
    "name": "body", "kind": "kind", "joints": "joints", "mass": "mass (kg)",
    "inertia": "inertia (kg m²)", "coordinate": "coordinate",
}  # fmt: skip
ACTING = {
    "relations": "Welds and gears",
    "drives": "Drives",
    "loads": "Loads, springs and masses",
}
ROWS = {"kind": "kind", "on": "on", "value": "value", "path": "in the file"}
BLOCKS = {
    "block": "block", "kind": "kind", "unknowns": "solves for", "apex": "at joint",
    "side": "branch", "condition": "condition number",
}  # fmt: skip
"""Key → heading of tables."""


def run(request: Request, kernel: bool, modes: bool, out: Path | None) -> int:
    """Print the report of a file; returns the exit code."""
    mechanism = mechanism_from(request.file, request.assignments, request.tables_from)
    if out is not None:
        require_folder(out)
    options_of(SimulationOptions, mechanism, {})
    system = System(mechanism)
    content = check_content(system)
    parts = [*_parts(content), Notes(content["notes"])]
    if mechanism.changes:
        content["changes"] = list(mechanism.changes)
    if kernel:
        content["kernel"] = _kernel(system)
    if modes or out is not None:
        from linkages.cli.verbs.modes_command import modes_content, modes_parts

        content["modes"] = modes_content(system, out, request.format)
        parts += modes_parts(content["modes"])
    if kernel:
        parts += _kernel_parts(content["kernel"])
    if not request.json:
        print_changes(mechanism.changes, console())
    return present(Report(name=mechanism.name, parts=parts, data=content), request.json)


def _parts(content: dict[str, Any]) -> Iterator[Part]:
    """Bodies, joints, what acts on them, mobility and blocks."""
    joints = [[j["joint"], j["bodies"], *j["position"]] for j in content["joints"]]
    bodies = [{**body, "joints": "–".join(body["joints"])} for body in content["bodies"]]
    yield Table("\nBodies", BODIES, bodies)
    yield Table("\nJoints at t = 0", ["joint", "bodies", "x (m)", "y (m)"], joints, numbers=2)
    for key, heading in ACTING.items():
        if content[key]:
            yield Table(f"\n{heading}", ROWS, content[key])
    mobility = content["mobility"]
    pairs = [f"{content[f'{kind}_pairs']} {kind}" for kind in ("revolute", "prismatic")]
    yield f"\n{' and '.join(pairs)} pairs, {content['loops']} independent loops"
    yield (
        f"mobility {mobility['gruebler']} by the Chebychev–Grübler–Kutzbach criterion, "
        f"{mobility['numerical']} by the rank of the closure Jacobian"
    )
    for what in ("driven", "free", "dependent"):
        yield f"{what}: {', '.join(content[what]) or 'none'}"
    if content["redundant"]:
        yield f"redundant joints: {', '.join(content['redundant'])}"
    if content["blocks"]:
        heading = "\nBlocks (Assur groups) in order of solution"
        yield Table(heading, BLOCKS, content["blocks"], numbers=1)


def _kernel_parts(kernel: dict[str, Any]) -> Iterator[Part]:
    if "note" in kernel:
        yield f"\nkernel: {kernel['note']}"
        return
    counts = kernel["operations"]
    kinds = list(next(iter(counts.values())))
    rows = [[part, *(count[kind] for kind in kinds)] for part, count in counts.items()]
    yield Table("\nOperations of the kernel", ["part", *kinds], rows, numbers=len(kinds))
    left_out = ", ".join(kernel["left_out"]) or "nothing"
    yield f"left out because the motion does not depend on it: {left_out}"


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
            "numerical": numerical_mobility(system.jacobian),
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
