"""Reads components from definition texts, for the tests of this folder."""

import pytest

from linkages.components.contributed.component import Component
from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.reading.document import parse
from linkages.reading.paths import KeyPath


def mechanism(text: str) -> Mechanism:
    return from_document(parse(text, "m.yaml"))


def component(text: str, *path: str | int) -> Component:
    """The component at a path of a definition."""
    found: dict[KeyPath, Component] = {c.path: c for c in mechanism(text).components}
    return found[path]


def complaints(text: str) -> list[str]:
    """All problems of a definition, as messages show them."""
    with pytest.raises(InputError) as caught:
        mechanism(text)
    assert caught.value.source == "m.yaml"
    return [str(problem) for problem in caught.value.problems]
