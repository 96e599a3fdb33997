"""Mechanisms as programs in C, JavaScript and Python."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.exports.texts import fixed_text
from linkages.exports.writers.exported_model import Exported, exported
from linkages.exports.writers.routines import (
    Constant,
    CRoutines,
    JavaScriptRoutines,
    constants,
    python_routines,
)
from linkages.kernel.code.languages import Python, c_function, call, javascript_function
from linkages.kernel.code.languages import python_function as function_of
from linkages.kernel.code.statements import Routine
from linkages.kernel.differentiation import system_size
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.operations import ELEMENTARY
from linkages.options.run import RunOptions, SimulationOptions

Floats = NDArray[np.float64]

STEPS = 1000
"""Of the method with equal steps, by default, within the simulated time."""


def c_files(system: System, stem: str, options: SimulationOptions) -> dict[str, str]:
    """A header and a program with ``main``."""
    result, prefix = exported(system, run=options), c_name(stem)
    main = {
        "END": repr(float(options.end)),
        "SAMPLES": repr(float(options.samples)),
        "STEP": repr(abs(float(options.end)) / STEPS),
    }
    parts = [
        _title(result),
        f'#include "{stem}.h"\n',
        c_program(result),
        filled(fixed_text("main.c"), main),
    ]
    files = {f"{stem}.h": c_header(result), f"{stem}.c": "\n".join(parts)}
    return {name: named_in_c(text, prefix) for name, text in files.items()}


def _title(found: Exported) -> str:
    name = _safe_c(found.system.mechanism.name)
    return f"/* {name}: equations of motion, written by linkages. */\n"


def c_header(found: Exported) -> str:
    """Declarations of what others may call."""
    return _title(found) + filled(fixed_text("model.h"), _sizes(found))


def c_program(found: Exported) -> str:
    """What follows the declarations: tables, equations and integrators."""
    body = "\n".join(_static(c_function(_renamed(routine))) for routine in found.routines)
    parts = [
        "#include <math.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n",
        _constants(found),
        _tables(found),
        _needed(fixed_text("functions.c"), body),
        body,
        _message(found.statuses),
        CRoutines().routines(),
        fixed_text("model.c"),
    ]
    return "\n".join(parts)


def c_name(stem: str) -> str:
    """A stem as the beginning of names in C."""
    prefix = re.sub(r"[^A-Za-z0-9]+", "_", stem).strip("_")
    return prefix if prefix and not prefix[0].isdigit() else f"linkage_{prefix}"


def named_in_c(text: str, prefix: str) -> str:
    """A text whose names begin with a prefix."""
    return text.replace("linkage_", f"{prefix}_").replace("LINKAGE_", f"{prefix.upper()}_")


def _renamed(routine: Routine) -> Routine:
    """``clock`` is a function of the standard library."""
    return replace(routine, name="clock_") if routine.name == "clock" else routine


def _static(function: str) -> str:
    return re.sub(r"^int ", "static int ", function, count=1, flags=re.MULTILINE)


def filled(text: str, values: Mapping[str, object]) -> str:
    """A text with values in its places."""
    for name, value in values.items():
        text = text.replace(f"@{name}@", str(value))
    return text


def _needed(functions: str, body: str) -> str:
    """Those functions that are called."""
    _, *parts = re.split(r"/\*: (\w+\() \*/\n", functions)
    return "".join(text for call, text in zip(parts[::2], parts[1::2], strict=True) if call in body)


def _sizes(found: Exported) -> dict[str, int]:
    return {
        "NUMBERS": len(found.feed.numbers),
        "PARAMETERS": len(found.p),
        "STATE": len(found.state),
        "QUANTITIES": len(found.quantities),
    }


def _constants(found: Exported) -> str:
    """What routines look up: whole numbers, others, and tables."""
    whole, others = list[str](), list[str]()
    for name, value in constants(found).items():
        match value:
            case int():
                whole.append(f"  {name} = {value},\n")
            case float():
                others.append(f"static const double {name} = {value!r};\n")
            case tuple():
                others.append(c_array(f"static const int {name}", value) + "\n")
            case _ if name != "OWN_NUMBERS":  # a table of the header
                others.append(_matrix(name, value))
    return f"enum {{\n{''.join(whole)}}};\n{''.join(others)}"


def _tables(found: Exported) -> str:
    numbers, quantities = found.feed.numbers, found.quantities
    coordinates = found.system.layout.coordinates
    state = [*coordinates, *(f"{name} rate" for name in coordinates)]
    return "\n".join([
        c_texts("linkage_paths", [number.path for number in numbers]),
        c_array("const double linkage_numbers", [number.value for number in numbers]),
        c_texts("linkage_names", [_column(quantity.name) for quantity in quantities]),
        c_texts("linkage_units", [quantity.unit for quantity in quantities]),
        c_texts("linkage_coordinates", state),
        "",
    ])  # fmt: skip


def c_texts(name: str, texts: Sequence[str]) -> str:
    """The definition of an array of texts."""
    return c_array(f"const char *const {name}", [_literal(text) for text in texts] or ["NULL"])


def c_array(declared: str, values: Iterable[object]) -> str:
    """The definition of an array, which has at least one entry."""
    rows = [f"  {value},\n" for value in values] or ["  0,\n"]
    return f"{declared}[] = {{\n{''.join(rows)}}};"


def _matrix(name: str, table: Floats) -> str:
    """A table of numbers with one or two axes."""
    if not table.size:
        return f"static const double {name}[] = {{0}};\n"
    shape = "".join(f"[{size}]" for size in table.shape)
    rows = [", ".join(map(repr, row.tolist())) for row in np.atleast_2d(table)]
    inner = ",\n  ".join(f"{{{row}}}" if table.ndim == 2 else row for row in rows)
    return f"static const double {name}{shape} = {{\n  {inner}}};\n"


def _message(statuses: Mapping[int, str]) -> str:
    cases = "".join(
        f"    case {status}: return {_literal(text)};\n" for status, text in statuses.items()
    )
    head = "const char *linkage_message(int status) {\n  switch (status) {\n"
    return f'{head}    case 0: return "all is well";\n{cases}    default: return "";\n  }}\n}}\n'


def _column(name: str) -> str:
    """A name as the heading of a column of comma-separated values."""
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',"\n') else name


def _literal(text: str) -> str:
    """A text as C writes it, in UTF-8."""
    plain = {byte: chr(byte) for byte in range(32, 127) if chr(byte) not in '"\\?'}
    return '"' + "".join(plain.get(byte, f"\\{byte:03o}") for byte in text.encode()) + '"'


def _safe_c(text: str) -> str:
    return text.replace("*/", "* /").replace("\n", " ")


_FUNCTIONS = sorted(
    {row.name for row in ELEMENTARY.values() if row.operator is None and row.c is None} | {"abs"}
)


def javascript_module(
    system: System,
    options: RunOptions | None = None,
    variables: Sequence[str] | None = None,
) -> str:
    """The text of a module that exports ``model``: its numbers, equations, outputs and motion."""
    result = exported(system, variables, options)
    tables = {
        name: value.tolist() if isinstance(value, np.ndarray) else value
        for name, value in constants(result).items()
    }
    parts = [
        f"/* {_safe_script(system.mechanism.name)}: equations of motion, written by linkages. */",
        f"const {{ {', '.join(_FUNCTIONS)} }} = Math;\n",
        fixed_text("functions.js"),
        *map(javascript_function, result.routines),
        *(f"const {name} = {json.dumps(value)};" for name, value in tables.items()),
        f"\nconst described = {_json(_described(result))};\n",
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


def _safe_script(text: str) -> str:
    return text.replace("*/", "* /").replace("<", "‹")


_ARRAYS = "array, asarray, errstate, float64, zeros"


def python_module(system: System, options: SimulationOptions) -> str:
    """The text of a module with equations, outputs, and a program that prints a motion."""
    result = exported(system, run=options)
    named = {
        row.numpy: row.name
        for row in ELEMENTARY.values()
        if isinstance(row.numpy, str) and row.operator is None
    }
    functions = [own if own == name else f"{own} as {name}" for own, name in sorted(named.items())]
    title = f"{system.mechanism.name}: equations of motion, written by linkages."
    return "\n".join([
        f'"""{_safe_python(title)}\n\n{_DOC}"""\n',
        "from math import ceil, isfinite",
        "",
        f"from numpy import {_ARRAYS}",
        "from numpy import (",
        *(f"    {name}," for name in functions),
        ")",
        "",
        *_numbers(result),
        f"END, SAMPLES = {float(options.end)!r}, {int(options.samples)}",
        "\n",
        fixed_text("functions.txt"),
        *(function_of(routine, _Numbers) for routine in result.routines),
        "\n",
        python_routines(),
        "\n",
        fixed_text("model.txt"),
    ])  # fmt: skip


_DOC = """Needs NumPy. Numbers are in SI, angles in radians; a state has COORDINATES in their order,
then their rates. For example:

    p, y = start(**{next(iter(NUMBERS)): 0.1})
    times = linspace(0.0, 1.0, 101)
    show = lambda t, state: print(t, dict(zip(NAMES, outputs(t, state, p))))
    integrate(times, p, y, visit=show)
"""


class _Numbers(Python):
    """Python on numbers of NumPy, whose divisions by zero are infinite."""

    def operation(self, node: Scalar) -> tuple[str, int]:
        """Python's own numbers refuse to be divided by zero."""
        text, strength = super().operation(node)
        plain = node.operation == "div" and all(o.constant is not None for o in node.operands)
        return text.replace(" / ", " / float64(") + ")" if plain else text, strength

    def solved(self, node: Scalar) -> str:
        """One function for all sizes."""
        entries = ", ".join(self.text(operand) for operand in node.operands)
        return call("solve", [str(system_size(node)), f"[{entries}]"])


def _numbers(found: Exported) -> Sequence[str]:
    return [
        _mapping("NUMBERS", {number.path: number.value for number in found.feed.numbers}),
        _list("COORDINATES", found.system.layout.coordinates),
        _list("NAMES", [quantity.name for quantity in found.quantities]),
        _list("UNITS", [quantity.unit for quantity in found.quantities]),
        _mapping("STATUSES", found.statuses),
        *(_constant(name, value) for name, value in constants(found).items()),
    ]


def _constant(name: str, value: Constant) -> str:
    if isinstance(value, int | float):
        return f"{name} = {value!r}"
    return _list(name, value.tolist() if isinstance(value, np.ndarray) else value)


def _list(name: str, values: Sequence[Any]) -> str:
    return f"{name} = [\n" + "".join(f"    {value!r},\n" for value in values) + "]"


def _mapping(name: str, values: Mapping[Any, Any]) -> str:
    rows = (f"    {key!r}: {value!r},\n" for key, value in values.items())
    return f"{name} = {{\n{''.join(rows)}}}"


def _safe_python(text: str) -> str:
    return text.replace("\\", "/").replace('"""', "'''")
