"""Mechanisms as modules of JavaScript, without imports."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from linkages.exports.kernels.exported import Exported, exported
from linkages.exports.kernels.method import constants
from linkages.exports.kernels.routines import JavaScriptRoutines
from linkages.exports.kernels.texts import fixed_text
from linkages.kernel.code.braces import javascript_function
from linkages.kernel.system import System
from linkages.operations import ELEMENTARY
from linkages.options.run import RunOptions

_FUNCTIONS = sorted(
    {row.name for row in ELEMENTARY.values() if row.operator is None and row.c is None} | {"abs"}
)


def javascript_module(
    system: System,
    options: RunOptions | None = None,
    variables: Sequence[str] | None = None,
) -> str:
    """The text of a module that exports ``model``: its numbers, equations, outputs and motion.

    Parameters
    ----------
    system
        The mechanism.
    options
        Whether motions pass change points; as the definition says if not given.
    variables
        Outputs, as `exported` takes them.
    """
    found = exported(system, variables, options)
    tables = {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in constants(found).items()
    }
    parts = [
        f"/* {_safe(system.mechanism.name)}: equations of motion, written by linkages. */",
        f"const {{ {', '.join(_FUNCTIONS)} }} = Math;\n",
        fixed_text("functions.js"),
        *map(javascript_function, found.routines),
        *(f"const {name} = {json.dumps(value)};" for name, value in tables.items()),
        f"\nconst described = {_json(_described(found))};\n",
        JavaScriptRoutines().routines(),
        fixed_text("model.js"),
    ]
    return "\n".join(parts)


def _described(found: Exported) -> dict[str, Any]:
    layout, turns = found.system.layout, found.system.mechanism.bodies
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
        "paths": [".".join(map(str, path)) for path in found.parameters],
        "series": [
            {"name": q.name, "variable": q.variable, "unit": q.unit, "label": q.label}
            for q in found.quantities
        ],
        "statuses": found.statuses,
        "modes": found.modes,
    }


def _json(value: Any) -> str:
    """JSON that may stand in a page as well."""
    return json.dumps(value, indent=1).replace("<", "\\u003c")


def _safe(text: str) -> str:
    return text.replace("*/", "* /").replace("<", "‹")
