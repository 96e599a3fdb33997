"""Where results come from: the definition as it was computed, options, versions."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.options.asked import stored

DEFINITION = "definition"


def origin_of(mechanism: Mechanism, options: Mapping[str, Any]) -> dict[str, str]:
    """Attributes from which results can be computed again.

    Parameters
    ----------
    mechanism
        What was computed.
    options
        How, as keyword arguments of what computed it; those that say where it ran are left out.
        Whatever is no number, text or list of these is written as text; of paths, their names.

    Returns
    -------
    ``version`` and ``libraries``; ``options`` and, of these, the ``arguments`` that were given, as
    JSON; ``definition``, YAML text in which all values are put in, those that were changed in
    Python as well; and ``changes``, the assignments that made it out of its file, as JSON.
    """
    how = stored(options)
    said = {name: value for name, value in how.items() if value is not None}
    return {
        "version": f"linkages {version('linkages')}",
        "libraries": ", ".join(
            [f"Python {platform.python_version()}", *(f"{n} {version(n)}" for n in _LIBRARIES)]
        ),
        "options": json.dumps(how, default=_text, ensure_ascii=False),
        "arguments": json.dumps(said, default=_text, ensure_ascii=False),
        "changes": json.dumps(mechanism.changes, ensure_ascii=False),
        DEFINITION: mechanism.to_yaml(),
    }


_LIBRARIES = ("numpy", "scipy", "llvmlite")
"""Those that numbers may depend on."""


def _text(value: object) -> str:
    return value.name if isinstance(value, Path) else str(value)
