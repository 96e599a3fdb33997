"""Variants of a mechanism that a search goes through: assembly branches and senses of rotation."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.assembly_branches import Assembly
from linkages.kernel.system import System
from linkages.reading.wording import suggestion
from linkages.solution.stop_messages import joint_of

CHOICES = ("file", "all")
"""Of the variants that a search goes through."""

SIDES = ("left", "right")
"""Of a dyad of two links, which hold for all lengths; other branches are given by positions."""

_NUMBER = re.compile(r"-?\s*[\d.]+(e[+-]?\d+)?\s*[^\W\d]*(/[^\W\d]+)?", re.IGNORECASE)
"""A number with or without a unit, whose sign is that of the whole."""


@dataclass(frozen=True)
class Variant:
    """An assembly branch with a sense of the drives, as values of the definition."""

    name: str = ""
    values: dict[str, object] = field(default_factory=dict)


def variants_of(mechanism: Mechanism, branches: str, varied: Collection[str] = ()) -> list[Variant]:
    """Variants to search: that of the file alone, or all of them.

    All are the product of the assembly branches at the initial position and of both senses of
    all drives at constant speed together, unless such a speed is `varied`. Raises ValueError for
    an unknown choice.
    """
    if branches not in CHOICES:
        near = suggestion(branches, CHOICES) or f"; expected {' or '.join(map(repr, CHOICES))}"
        raise ValueError(f"unknown branches {branches!r}{near}")
    if branches == "file":
        return [Variant()]
    system = System(mechanism)
    assembled = [_branch(system, assembly) for assembly in system.modes()]
    return [
        Variant(", ".join(filter(None, (branch.name, sense.name))), branch.values | sense.values)
        for branch in assembled
        for sense in _senses(mechanism, varied)
    ]


def _branch(system: System, assembly: Assembly) -> Variant:
    """A branch by the sides of its dyads, or by positions of joints."""
    words, places = [], system.in_mode(assembly)
    values: dict[str, object] = {}
    for block in system.topology.solved_blocks:
        joint, side = joint_of(system.model, block), assembly.side_of(block)
        if side is None and not any(name in assembly.values for name in block.unknowns):
            continue  # there is one way only
        position = [float(value) for value in places[joint]]
        words.append(f"{joint} {side or '({:.3g}, {:.3g}) m'.format(*position)}")
        values[f"assembly.{joint}"] = side if side in SIDES else position
    return Variant(", ".join(words), values)


def _senses(mechanism: Mechanism, varied: Collection[str]) -> Iterator[Variant]:
    """The drives as they turn, and all of them reversed."""
    speeds = dict(_speeds(mechanism))
    names = " and ".join(path.split(".")[1] for path in speeds)
    reversible = speeds and not {*speeds} & {*varied}
    yield Variant(f"{names} as in the file" if reversible else "")
    if reversible:
        yield Variant(f"{names} reversed", {path: _negated(text) for path, text in speeds.items()})


def _speeds(mechanism: Mechanism) -> Iterator[tuple[str, object]]:
    """Paths of constant speeds of drives, and what the definition has there."""
    drives = mechanism.definition.content.get("drives", {})
    for name, entry in drives.items():
        if "speed" in entry:
            yield f"drives.{name}.speed", entry["speed"]


def _negated(value: object) -> object:
    """A speed with the other sign, as it is written."""
    if not isinstance(value, str):
        return -value  # type: ignore[operator]
    text = value.strip()
    if _NUMBER.fullmatch(text):
        return text[1:].lstrip() if text.startswith("-") else f"-{text}"
    return f"-1*({text})"
