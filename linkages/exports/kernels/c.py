"""Mechanisms as C99 that needs nothing but the standard library."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from linkages.exports.kernels.exported import Exported, exported
from linkages.exports.kernels.method import constants
from linkages.exports.kernels.routines import CRoutines
from linkages.exports.kernels.texts import fixed_text
from linkages.kernel.code.braces import c_function
from linkages.kernel.code.statements import Routine
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions

Floats = NDArray[np.float64]

STEPS = 1000
"""Of the method with equal steps, by default, within the simulated time."""


def c_files(system: System, stem: str, options: SimulationOptions) -> dict[str, str]:
    """A header and a program with ``main``.

    Parameters
    ----------
    system
        The mechanism.
    stem
        What files and, in letters of C, functions are called.
    options
        Of the motion that is printed where nothing else is said: `end` and `samples` are taken.
    """
    found = exported(system, run=options)
    prefix = re.sub(r"[^A-Za-z0-9]+", "_", stem).strip("_")
    prefix = prefix if prefix and not prefix[0].isdigit() else f"linkage_{prefix}"
    title = f"/* {_safe(system.mechanism.name)}: equations of motion, written by linkages. */\n"
    header = title + _filled(fixed_text("model.h"), _sizes(found))
    routines = [_static(c_function(_renamed(routine))) for routine in found.routines]
    body = "\n".join(routines)
    main = {
        "END": repr(float(options.end)),
        "SAMPLES": repr(float(options.samples)),
        "STEP": repr(abs(float(options.end)) / STEPS),
    }
    parts = [
        title,
        f'#include "{stem}.h"\n',
        "#include <math.h>\n#include <stdio.h>\n#include <stdlib.h>\n#include <string.h>\n",
        _constants(found),
        _tables(found),
        _needed(fixed_text("functions.c"), body),
        body,
        _message(found.statuses),
        CRoutines().routines(),
        fixed_text("model.c"),
        _filled(fixed_text("main.c"), main),
    ]
    text = "\n".join(parts)
    return {f"{stem}.h": _named(header, prefix), f"{stem}.c": _named(text, prefix)}


def _named(text: str, prefix: str) -> str:
    return text.replace("linkage_", f"{prefix}_").replace("LINKAGE_", f"{prefix.upper()}_")


def _renamed(routine: Routine) -> Routine:
    """``clock`` is a function of the standard library."""
    return replace(routine, name="clock_") if routine.name == "clock" else routine


def _static(function: str) -> str:
    return re.sub(r"^int ", "static int ", function, count=1, flags=re.MULTILINE)


def _filled(text: str, values: Mapping[str, object]) -> str:
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
                others.append(_array(f"static const int {name}", value) + "\n")
            case _ if name != "OWN_NUMBERS":  # a table of the header
                others.append(_matrix(name, value))
    return f"enum {{\n{''.join(whole)}}};\n{''.join(others)}"


def _tables(found: Exported) -> str:
    numbers, quantities = found.feed.numbers, found.quantities
    coordinates = found.system.layout.coordinates
    state = [*coordinates, *(f"{name} rate" for name in coordinates)]
    return "\n".join([
        _texts("linkage_paths", [number.path for number in numbers]),
        _array("const double linkage_numbers", [number.value for number in numbers]),
        _texts("linkage_names", [_column(quantity.name) for quantity in quantities]),
        _texts("linkage_units", [quantity.unit for quantity in quantities]),
        _texts("linkage_coordinates", state),
        "",
    ])  # fmt: skip


def _texts(name: str, texts: Sequence[str]) -> str:
    return _array(f"const char *const {name}", [_literal(text) for text in texts] or ["NULL"])


def _array(declared: str, values: Iterable[object]) -> str:
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


def _safe(text: str) -> str:
    return text.replace("*/", "* /").replace("\n", " ")
