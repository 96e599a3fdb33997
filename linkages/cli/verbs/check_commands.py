"""``check``, and all ways to put a mechanism together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from linkages.cli.requests import Request, mechanism_from, require_folder
from linkages.cli.terminal import console, present, print_changes
from linkages.cli.verbs.contribution_rows import drives, loads, relations
from linkages.components.contributed.load_measures import Distance
from linkages.components.contributed.terms import Body
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.assembly_branches import MOST_BRANCHES, SAME, STARTS, Assembly
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.reading.paths import dotted
from linkages.reports.report import Notes, Part, Report, Table, number
from linkages.solution.remarks import assumptions, doubts
from linkages.solution.run_options import options_of
from linkages.solution.stop_messages import joint_of
from linkages.topology.assur_groups import ITERATED, Block
from linkages.topology.decomposition import bodies_at

ACTING = {
    "relations": "Welds and gears",
    "drives": "Drives",
    "loads": "Loads, springs and masses",
}
"""Key of rows → heading of a table."""


MOST_LINES = 200
"""Rows that a table of a mechanism shows; JSON has all of them."""

MOST_NAMES = 40
"""Bodies at a joint that a row lists."""


def run_check(request: Request, kernel: bool, modes: bool, out: Path | None) -> int:
    """Print the report of a file; returns the exit code."""
    mechanism = mechanism_from(request.file, request.assignments, request.tables_from, request.at)
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
        content["modes"] = modes_content(system, out, request.format)
        parts += modes_parts(content["modes"])
    if kernel:
        parts += _kernel_parts(content["kernel"])
    if not request.json:
        print_changes(mechanism.changes, console())
    return present(Report(name=mechanism.name, parts=parts, data=content), request.json)


def _parts(content: dict[str, Any]) -> Iterator[Part]:
    """Bodies, joints, what acts on them, mobility and blocks."""
    joints = [
        [j["joint"], _some(j["bodies"]), *j["position"]] for j in content["joints"][:MOST_LINES]
    ]
    shown = content["bodies"][:MOST_LINES]
    bodies = [{**body, "joints": "–".join(body["joints"])} for body in shown]
    yield Table.of(
        "\nBodies", bodies, "name: body", "kind", "joints", "mass: mass (kg)",
        "inertia: inertia (kg m²)", "coordinate",
    )  # fmt: skip
    yield from _more(content["bodies"], "bodies")
    yield Table("\nJoints at t = 0", ["joint", "bodies", "x (m)", "y (m)"], joints, numbers=2)
    yield from _more(content["joints"], "joints")
    for key, heading in ACTING.items():
        if content[key]:
            rows = content[key][:MOST_LINES]
            yield Table.of(f"\n{heading}", rows, "kind", "on", "value", "path: in the file")
            yield from _more(content[key], key)
    mobility = content["mobility"]
    pairs = [f"{content[f'{kind}_pairs']} {kind}" for kind in ("revolute", "prismatic")]
    loops = f"{content['loops']} independent loop{'' if content['loops'] == 1 else 's'}"
    yield f"\n{' and '.join(pairs)} pairs, {loops}"
    yield (
        f"mobility {mobility['gruebler']} by the Chebychev–Grübler–Kutzbach criterion, "
        f"{mobility['numerical']} by the rank of the closure Jacobian"
    )
    for what in ("driven", "free", "dependent"):
        yield f"{what}: {', '.join(content[what]) or 'none'}"
    if content["redundant"]:
        yield f"redundant joints: {', '.join(content['redundant'])}"
    if content["blocks"]:
        yield Table.of(
            "\nBlocks (Assur groups) in order of solution", content["blocks"][:MOST_LINES],
            "block", "kind", "unknowns: solves for", "apex: at joint", "side: branch",
            "condition: condition number", numbers=1,
        )  # fmt: skip
        yield from _more(content["blocks"], "blocks")


def _some(names: list[str]) -> list[str]:
    more = len(names) - MOST_NAMES
    return names if more <= 0 else [*names[:MOST_NAMES], f"{more} more"]


def _more(rows: list[Any], what: str) -> Iterator[str]:
    if len(rows) > MOST_LINES:
        yield f"{len(rows) - MOST_LINES} more {what}; --json lists all of them"


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
            "numerical": system.mobility,
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
        "notes": _check_notes(system),
    }


def _body(system: System, body: Body) -> dict[str, Any]:
    if body.name in system.mechanism.prescribed:
        coordinate = "driven"
    else:
        coordinate = "free" if body.name in system.mechanism.initial else "dependent"
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


def _check_notes(system: System) -> list[str]:
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
    measures = [load.measure for load in mechanism.loads]
    measures += [actuation.measure for actuation in mechanism.actuations.values()]
    along = [measure for measure in measures if isinstance(measure, Distance)]
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


Content = dict[str, Any]

MOST_ROWS = 64
"""Modes that a table shows; JSON has all of them."""

DIFFERENT = 1e-9
"""Of the mechanism's size: joints closer than this are at one place."""


def modes_content(
    system: System,
    out: Path | None,
    format: str = "png",  # noqa: A002
) -> Content:
    """All modes with their positions; draws them if a folder is given."""
    result = system.modes()
    places = [_places(system, assembly) for assembly in result]
    differing = _differing(system.topology.joints, places)
    rows = [
        {
            "mode": index + 1,
            "selected": _same(system, assembly),
            "blocks": [_choice(system, assembly, b) for b in system.topology.solved_blocks],
            "positions": {joint: [float(v) for v in place[joint]] for joint in differing},
        }
        for index, (assembly, place) in enumerate(zip(result, places, strict=True))
    ]
    content: Content = {
        "count": len(rows),
        "complete": len(rows) < MOST_BRANCHES and not system.topology.iterated,
        "modes": rows,
        "notes": _modes_notes(system, rows),
        "files": [],
    }
    if out is not None:
        content["files"] = [str(_draw(system, rows, places, out / f"modes.{format}"))]
    return content


def _places(system: System, assembly: Assembly) -> dict[str, np.ndarray]:
    result = system.in_mode(assembly)
    return {joint: result[joint] for joint in system.topology.joints}


def _differing(joints: tuple[str, ...], places: list[dict[str, np.ndarray]]) -> list[str]:
    """Joints that are not at the same place in all modes."""
    if not places:
        return []
    array = np.array([[place[joint] for joint in joints] for place in places])
    size = float(np.ptp(array.reshape(-1, 2), axis=0).max())
    spread = np.ptp(array, axis=0).max(axis=1)
    return [joint for joint, apart in zip(joints, spread, strict=True) if apart > DIFFERENT * size]


def _same(system: System, assembly: Assembly) -> bool:
    """Whether a mode is the one that the definition selects."""
    own = system.assembly
    if own.sides != assembly.sides or own.values.keys() != assembly.values.keys():
        return False
    for name, value in assembly.values.items():
        apart = value - own.values[name]
        if system.mechanism.bodies[name].rotates:
            apart = math.remainder(apart, 2 * math.pi)
        if abs(apart) > SAME * max(1.0, abs(value)):
            return False
    return True


def _choice(system: System, assembly: Assembly, block: Block) -> Content:
    from linkages.solution.stop_messages import joint_of

    values = {n: assembly.values[n] for n in block.unknowns if n in assembly.values}
    return {
        "block": block.index,
        "apex": joint_of(system.model, block),
        "side": assembly.side_of(block),
        "values": values or None,
    }


def _modes_notes(system: System, rows: list[Content]) -> list[str]:
    notes = []
    if len(rows) >= MOST_BRANCHES:
        notes.append(
            f"only the first {MOST_BRANCHES} assembly modes are listed; there may be more"
            + ("" if any(r["selected"] for r in rows) else ", the selected one among them")
        )
    blocks = [b for b in system.topology.solved_blocks if b.kind == ITERATED]
    if blocks:
        listed = ", ".join(str(block.index) for block in blocks)
        notes.append(
            f"modes of iterated groups (block {listed}) were found by search from {STARTS} random "
            "positions: that there are no others is likely, not certain"
        )
    return notes


def _draw(
    system: System, rows: list[Content], places: list[dict[str, np.ndarray]], path: Path
) -> Path:
    from linkages.plots.figures import write_figure
    from linkages.plots.mechanism.branches import Mode, figure

    drawn = [
        Mode(
            row["mode"],
            {joint: (float(x), float(y)) for joint, (x, y) in place.items()},
            ", ".join(text for choice in row["blocks"] if (text := _short(system, choice))),
            row["selected"],
        )
        for row, place in zip(rows, places, strict=True)
    ]
    return write_figure(figure(system.mechanism, drawn), path)


def _short(system: System, choice: Content) -> str:
    """The side of a block; of an iterated one, the angles or places that tell modes apart."""
    if choice["side"]:
        return f"{choice['apex']} {choice['side']}"
    bodies, parts = system.mechanism.bodies, []
    for name, value in (choice["values"] or {}).items():
        turned = math.degrees(math.remainder(value, 2.0 * math.pi))
        parts.append(f"{name} " + (f"{turned:.0f}°" if bodies[name].rotates else number(value)))
    return ", ".join(parts).replace("-", "−")


def _cell(choice: Content) -> str:
    if choice["values"] is None:
        return choice["side"] or "one way"
    return ", ".join(f"{name} {number(v)}" for name, v in choice["values"].items())


def modes_parts(content: Content) -> list[Part]:
    """The table of all modes, and what must be said about it."""
    rows: list[Content] = content["modes"]
    parts: list[Part] = []
    if rows:
        heads = ["mode", ""]
        heads += [f"block {b['block']} at {b['apex']}" for b in rows[0]["blocks"]]
        heads += [f"{joint} (m)" for joint in rows[0]["positions"]]
        shown = [row for row in rows if row["mode"] <= MOST_ROWS or row["selected"]]
        cells = [
            [
                row["mode"],
                "selected" if row["selected"] else "",
                *map(_cell, row["blocks"]),
                *row["positions"].values(),
            ]
            for row in shown
        ]
        parts.append(Table("\nAssembly modes at the start", heads, cells))
        if len(shown) < len(rows):
            parts.append(f"{len(rows) - len(shown)} more modes; --json lists all of them")
    return [*parts, Notes(content["notes"]), *(f"drawn in {path}" for path in content["files"])]
