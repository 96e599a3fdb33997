"""Where results come from: the definition as it was computed, options, version."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism

DEFINITION = "definition"


def origin_of(mechanism: Mechanism, options: Mapping[str, Any]) -> dict[str, str]:
    """Attributes from which results can be computed again.

    Parameters
    ----------
    mechanism
        What was computed.
    options
        How, as keyword arguments of what computed it. Whatever is no number, text or list of these
        is written as text.

    Returns
    -------
    ``version``; ``options`` and, of these, the ``arguments`` that were given, as JSON; and
    ``definition``, YAML text in which all values are put in, those that were changed in Python as
    well.
    """
    said = {name: value for name, value in options.items() if value is not None}
    return {
        "version": f"linkages {version('linkages')}",
        "options": json.dumps(options, default=str, ensure_ascii=False),
        "arguments": json.dumps(said, default=str, ensure_ascii=False),
        DEFINITION: mechanism.to_yaml(),
    }
