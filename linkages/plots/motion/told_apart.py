"""What tells motions apart: the values in which their definitions differ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.units import unit_at
from linkages.plots.paths import path_words
from linkages.reading.document import Document
from linkages.reading.paths import dotted
from linkages.reading.wording import shown
from linkages.spec.arithmetic import leading_number
from linkages.spec.grammar import NumberError

MOST = 3
"""Differences that a legend can say."""


def told_apart(mechanisms: Sequence[Mechanism | None], names: Sequence[str] = ()) -> list[str]:
    """A name for each of some motions, no two alike.

    Parameters
    ----------
    mechanisms
        What moves, if that is known.
    names
        What they are called besides, such as their files.

    Returns
    -------
    The values in which the definitions differ, if these are few; else names of files or mechanisms.
    Those that are still alike are numbered.
    """
    found = [""] * len(mechanisms)
    known = [mechanism.definition for mechanism in mechanisms if mechanism]
    if len(known) == len(found):
        found = _differences(known)
    if len({*found}) < len(found):
        own = [m.name if m else "" for m in mechanisms]
        others = list(names) or own
        found = [", ".join(filter(None, pair)) for pair in zip(others, found, strict=True)]
    if len({*found}) < len(found) or not all(found):
        found = [f"{name or 'run'} ({k})" for k, name in enumerate(found, start=1)]
    return found


def _differences(definitions: Sequence[Document]) -> list[str]:
    """What each definition has where not all agree; empty texts where they differ in too much."""
    flat = [dict(_leaves(definition.content)) for definition in definitions]
    paths = dict.fromkeys(path for one in flat for path in one)
    differing = [p for p in paths if len({shown(one.get(p)) for one in flat}) > 1]
    differing = [p for p in differing if p not in (("name",), ("description",))]
    if not 0 < len(differing) <= MOST:
        return [""] * len(flat)
    return [
        ", ".join(
            f"{path_words(path)} = {_text(value, unit_at(definition, path))}"
            for path, value in ((dotted(steps), one.get(steps)) for steps in differing)
        )
        for one, definition in zip(flat, definitions, strict=True)
    ]


def _text(value: object, si: str) -> str:
    """A value with its unit: the one that it is written with, else that of SI."""
    if value is None:
        return "none"
    try:
        number, unit = leading_number(str(value))
    except NumberError:
        return str(value)
    return f"{number:.6g} {unit or si}".rstrip()


def _leaves(content: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[Any, Any]]:
    if isinstance(content, dict):
        for key, value in content.items():
            yield from _leaves(value, (*path, str(key)))
    elif isinstance(content, list | tuple):
        for place, value in enumerate(content):
            yield from _leaves(value, (*path, place))
    else:
        yield path, content
