"""From a definition to a mechanism: from a file, from a text, or from a document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path as FilePath

from linkages.components.mechanisms.gathered import read_components
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.document import Document, parse, read
from linkages.reading.locate import find
from linkages.reading.overrides import apply


def load(
    file: str | FilePath,
    set: Mapping[str, object] | None = None,  # noqa: A002
    *,
    tables_from: str | FilePath | None = None,
) -> Mechanism:
    """Read a definition file.

    Parameters
    ----------
    file
        A path, or the name of a mechanism shipped with the package.
    set
        Dotted path of the file → value to use instead, as `Mechanism.with_values` takes them, e.g.
        ``{"clearances.r1.size": 1e-4}``.
    tables_from
        A folder: the CSV files of tables that the definition names may be below it as well.
        Otherwise they must be below the folder of the definition.

    Raises
    ------
    InputError
        With every problem of the file: line, what was found and what is expected.

    Examples
    --------
    >>> import linkages
    >>> linkages.load("pendulum", set={"bars.rod.length": "350 mm"})
    Mechanism('Pendulum', gravity=1, joints=1, bars=1, free=1, simulate=1)
    """
    if not isinstance(file, str | FilePath):
        raise TypeError(f"file must be a path or a name, found {file!r}")
    tables = None if tables_from is None else FilePath(tables_from)
    return from_document(apply(replace(read(find(file)), tables=tables), set or {}))


def loads(text: str, set: Mapping[str, object] | None = None) -> Mechanism:  # noqa: A002
    """Read a definition from a text.

    Parameters
    ----------
    text
        YAML, as it would stand in a definition file. It cannot name files of tables, for there is
        no folder to look for them in.
    set
        As in `load`.

    Raises
    ------
    InputError
        With every problem of the text: line, what was found and what is expected.
    """
    if not isinstance(text, str):
        raise TypeError(f"text must be the text of a definition, found {text!r}")
    return from_document(apply(parse(text, "text"), set or {}))


def from_document(document: Document) -> Mechanism:
    """Build the mechanism that a document defines; raises InputError like `load`."""
    document, components = read_components(document)
    return Mechanism(
        components=components,
        defined=components,
        name=str(document.content.get("name") or FilePath(document.source).stem),
        source=document.source,
        document=document,
    )
