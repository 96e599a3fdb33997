"""Mechanisms as modules of JavaScript, without imports."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from linkages.exports.kernels.exported import Exported, exported
from linkages.exports.kernels.method import dop853_tables
from linkages.exports.kernels.texts import fixed_text
from linkages.kernel.code.braces import javascript_function
from linkages.kernel.system import System
from linkages.operations import ELEMENTARY

_FUNCTIONS = sorted(
    {row.name for row in ELEMENTARY.values() if row.operator is None and row.c is None} | {"abs"}
)


def javascript_module(system: System, variables: Sequence[str] | None = None) -> str:
    """The text of a module that exports ``model``: numbers, states, rates and outputs.

    Parameters
    ----------
    system
        The mechanism.
    variables
        Outputs, as `exported` takes them.
    """
    found = exported(system, variables)
    parts = [
        f"/* {_safe(system.mechanism.name)}: equations of motion, written by linkages. */",
        f"const {{ {', '.join(_FUNCTIONS)} }} = Math;\n",
        fixed_text("functions.js"),
        *map(javascript_function, found.routines),
        f"const described = {_json(_described(found))};\n",
        fixed_text("model.js"),
    ]
    return "\n".join(parts)


def javascript_integrator() -> str:
    """The text of a module that exports ``integrate``, an adaptive method with dense output."""
    tables = dop853_tables().items()
    rows = ",\n".join(f"  {name}: {json.dumps(values.tolist())}" for name, values in tables)
    return f"const DOP853 = {{\n{rows},\n}};\n\n{fixed_text('integrate.js')}"


def _described(found: Exported) -> dict[str, Any]:
    layout, turns = found.system.layout, found.system.mechanism.bodies
    program = found.program
    return {
        "name": found.system.mechanism.name,
        "coordinates": [*layout.coordinates],
        "turning": [name in turns and turns[name].rotates for name in layout.coordinates],
        "free": len(layout.free),
        "internal": len(layout.internal),
        "carried": len(layout.carried),
        "numbers": [
            {"path": n.path, "value": n.value, "unit": n.unit, "written": n.written, "size": n.size}
            for n in found.feed.numbers
        ],
        "parameters": found.p.tolist(),
        "paths": [".".join(map(str, path)) for path in found.parameters],
        "state": found.state.tolist(),
        "series": [
            {"name": q.name, "variable": q.variable, "unit": q.unit, "label": q.label}
            for q in found.quantities
        ],
        "statuses": found.statuses,
        "modes": found.modes,
        "switching": None
        if found.switching is None
        else {
            "active": found.switching.active,
            "owners": found.switching.owners,
            "jumps": found.switching.jumps,
            "sticks": found.switching.sticks,
            "shakes": found.switching.shakes,
            "held": len(found.p) - found.program.held,
        },
        "turned": found.turned,
        "marginScale": found.margin_scale.tolist(),
        "blocks": found.blocks,
        "timed": program.timed,
        "become": program.routines[-1].arguments["out"],
        "written": found.written,
    }


def _json(value: Any) -> str:
    """JSON that may stand in a page as well."""
    return json.dumps(value, indent=1).replace("<", "\\u003c")


def _safe(text: str) -> str:
    return text.replace("*/", "* /").replace("<", "‹")
