"""Write the page of a motion."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.reading.replacing import replaced
from linkages.solution.opened import Opened
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution
from linkages.viewer.content import written
from linkages.viewer.frames import dense, wanted

Source: TypeAlias = Solution | Mechanism | Opened


def view(source: Source, path: str | Path | None = None) -> Path:
    """Write one HTML file that shows a motion: no network, no server, nothing beside it.

    Parameters
    ----------
    source
        A solution; a mechanism, which is simulated as its definition says; or results that
        `linkages.open` found.
    path
        Of the file; default: the name of the definition file, ending in ``.html``, in the current
        directory.

    Returns
    -------
    Where the file is.

    Raises
    ------
    ValueError
        If results do not say where joints are.
    """
    text = html(source)
    mechanism = source if isinstance(source, Mechanism) else source.mechanism
    stem = Path(mechanism.source).stem or "mechanism"
    file = Path(f"{stem}.html") if path is None else Path(path)
    with replaced(file) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return file


def html(source: Source) -> str:
    """The text of the file that `view` writes."""
    match source:
        case Solution():
            options, notes = source.options, source.notes
            return written(source.mechanism, dense(source), options, notes, source.motion.failure)
        case Mechanism():
            outputs = wanted(System(source))
            return html(simulate(source, outputs=outputs, throw=False))
        case Opened():
            return written(source.mechanism, source.data, source.arguments, source.notes, None)
        case _:
            expected = "a solution, a mechanism or opened results"
            raise TypeError(f"expected {expected}, found {source!r}")
