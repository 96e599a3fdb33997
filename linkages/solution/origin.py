"""Where results come from: the definition as it was computed, options, version."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from importlib.metadata import version
from typing import Any

from linkages.components.mechanism import Mechanism
from linkages.reading.writing import as_yaml

DEFINITION = "definition"


def origin_of(mechanism: Mechanism, options: Mapping[str, Any]) -> dict[str, str]:
    """Attributes from which results can be computed again.

    Parameters
    ----------
    mechanism
        What was computed.
    options
        How, beyond what its `simulate` section says; None says nothing. Whatever is no number,
        text or list of these is written as text.

    Returns
    -------
    ``version``; ``options`` as JSON; and ``definition``, YAML text in which all values are put in,
    unless the mechanism was built or changed in Python.
    """
    said = {name: value for name, value in options.items() if value is not None}
    how = {**asdict(mechanism.simulation), **said}
    found = {
        "version": f"linkages {version('linkages')}",
        "options": json.dumps(how, default=str, ensure_ascii=False),
    }
    document = mechanism.document
    if document is not None and _defines(document, mechanism):
        content = {"name": mechanism.name} | document.content  # else the file's name is its name
        found[DEFINITION] = as_yaml(replace(document, content=content))
    return found


def _defines(document: Any, mechanism: Mechanism) -> bool:
    """Whether a document still says what a mechanism is; components may have been changed since."""
    from linkages.components.definition import from_document

    return from_document(document).components == mechanism.components
