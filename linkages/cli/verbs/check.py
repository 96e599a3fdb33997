"""``check``: what a mechanism is made of, how it moves and how it is solved."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from linkages.cli.loading import mechanism_from, require_folder
from linkages.cli.requests import Request
from linkages.cli.terminal import console, print_json
from linkages.cli.verbs.check_report import print_report
from linkages.cli.verbs.contributions import drives, loads, relations
from linkages.components.contributed.measures import Distance
from linkages.components.contributed.terms import Body
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.reading.paths import dotted
from linkages.solution.options import options_of
from linkages.solution.remarks.assumptions import assumptions
from linkages.solution.remarks.doubts import doubts
from linkages.solution.remarks.stops import joint_of
from linkages.topology.blocks import ITERATED, Block
from linkages.topology.graph import bodies_at
from linkages.topology.jacobian import numerical_mobility


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
        from linkages.cli.verbs.modes import modes_content

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
    from linkages.kernel.code.counting import report_kernel
    from linkages.solution.moving.plan import kernel_source

    source = kernel_source(system.topology)
    report = report_kernel(source.model, source.program)
    return {"operations": report.counts, "left_out": [dotted(path) for path in report.left_out]}
