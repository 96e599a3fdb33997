"""``check --modes``: all ways to put a mechanism together where it starts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from linkages.kernel.assembly_branches import MOST_MODES, SAME, STARTS, Assembly
from linkages.kernel.system import System
from linkages.reports.report import Notes, Part, Table, number
from linkages.topology.assur_groups import ITERATED, Block

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
    found = system.modes()
    places = [_places(system, assembly) for assembly in found]
    differing = _differing(system.topology.joints, places)
    rows = [
        {
            "mode": index + 1,
            "selected": _same(system, assembly),
            "blocks": [_choice(system, assembly, b) for b in system.topology.solved_blocks],
            "positions": {joint: [float(v) for v in place[joint]] for joint in differing},
        }
        for index, (assembly, place) in enumerate(zip(found, places, strict=True))
    ]
    content: Content = {
        "count": len(rows),
        "complete": len(rows) < MOST_MODES and not system.topology.iterated,
        "modes": rows,
        "notes": _notes(system, rows),
        "files": [],
    }
    if out is not None:
        content["files"] = [str(_draw(system, rows, places, out / f"modes.{format}"))]
    return content


def _places(system: System, assembly: Assembly) -> dict[str, np.ndarray]:
    found = system.in_mode(assembly)
    return {joint: found[joint] for joint in system.topology.joints}


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


def _notes(system: System, rows: list[Content]) -> list[str]:
    notes = []
    if len(rows) >= MOST_MODES:
        notes.append(
            f"only the first {MOST_MODES} assembly modes are listed; there may be more"
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
