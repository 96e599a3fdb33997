"""A definition with other numbers, as text: the file that it was read from, comments and all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import yaml

from linkages.components.mechanisms.definition import loads
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError
from linkages.kernel.system import System
from linkages.reading.decoding import decode
from linkages.reading.locate import find
from linkages.reading.paths import Path, split


def kept(mechanism: Mechanism) -> list[str]:
    """Sentences on what a search does not vary beside numbers: assembly and sense of rotation."""
    system = System(mechanism)
    count = 2 if system.topology.iterated else len(system.modes())
    if count < 2:
        return []
    several = "" if system.topology.iterated else f" (one of {count} at the start)"
    turning = " and the sense of its drives" if system.topology.driven else ""
    return [
        f"the search keeps the assembly mode of the definition{several}{turning}; others may lead "
        "to better numbers: check --modes shows them, and assembly selects one"
    ]


def rewritten(
    mechanism: Mechanism, values: Mapping[str, object], remarks: Sequence[str]
) -> tuple[Mechanism, str]:
    """A mechanism with other numbers, and its definition as text.

    The text is the file with its comments, in which the numbers are exchanged. Where the file does
    not say all (values that were set besides, tables in files of their own), it is made anew.

    Parameters
    ----------
    mechanism
        Whose numbers they were.
    values
        Path → number, as `Mechanism.with_values` takes them.
    remarks
        Lines that stand on top as comments.
    """
    changed = mechanism.with_values(values)
    head = "".join(f"# {line}\n" for remark in remarks for line in remark.splitlines())
    text = _exchanged(mechanism, values)
    if text is not None:
        text = head + text
        try:
            if loads(text).components == changed.components:
                return changed, text
        except InputError:
            pass  # names files that stand elsewhere
    return changed, head + changed.to_yaml()


def _exchanged(mechanism: Mechanism, values: Mapping[str, object]) -> str | None:
    """The text of the file with other scalars; None if there is none, or they are not in it."""
    if mechanism.definition.folder is None:
        return None
    try:
        path = find(mechanism.definition.source)
        text = decode(path.read_bytes(), str(path))
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except (InputError, OSError, ValueError, yaml.YAMLError):
        return None
    found = []
    for name, value in values.items():
        node = _node(root, split(name) or ())
        if node is None:
            return None
        quote = node.style if node.style in ("'", '"') and isinstance(value, str) else ""
        found.append((node.start_mark.index, node.end_mark.index, f"{quote}{value}{quote}"))
    for start, end, value in sorted(found, reverse=True):
        text = text[:start] + value + text[end:]
    return text


def _node(root: Any, path: Path) -> yaml.ScalarNode | None:
    """The scalar at a path."""
    node = root
    for step in path:
        if isinstance(node, yaml.MappingNode):
            pairs = {key.value: value for key, value in node.value}
            node = pairs.get(str(step))
        elif isinstance(node, yaml.SequenceNode) and str(step).isdigit():
            node = node.value[int(step)] if int(step) < len(node.value) else None
        else:
            return None
    return node if isinstance(node, yaml.ScalarNode) else None
