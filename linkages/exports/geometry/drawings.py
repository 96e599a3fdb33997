"""Options that all drawings to scale have, said once."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import partial, wraps
from typing import TYPE_CHECKING, Any, Concatenate

from linkages.exports import Export, Subject

if TYPE_CHECKING:
    from linkages.exports.geometry.parts import Drawn

Content = Mapping[str, str | bytes]

_ENTRY = "    drawn\n        What `drawn_of` returns.\n"
_OPTIONS = """\
    hole, width
        Diameter of holes and width of links in metres; default: as the mechanism's size wants.
    paths, links
        Whether to write either.
"""


def drawn_of(
    subject: Subject,
    *,
    hole: float | None = None,
    width: float | None = None,
    paths: bool = True,
    links: bool = True,
) -> Drawn:
    """What a drawing shows, in millimetres; its options are those of all formats of drawings.

    Raises
    ------
    ValueError
        For sizes that make no sense, and if there is nothing to show.
    """
    from linkages.exports.geometry.parts import Drawn, first_pose, parts_of, paths_of, sizes_of

    pose = first_pose(subject)
    sizes = sizes_of(pose, hole, width)
    shown = parts_of(pose, sizes) if links else []
    lines = paths_of(subject) if paths else {}
    if not shown and not lines:
        raise ValueError("nothing to export: no link and no path of a joint is asked for")
    return Drawn(shown, lines, sizes)


def drawing(
    write: Callable[Concatenate[Subject, Callable[[], Drawn], ...], Content],
) -> Export:
    """Let a format have the options of drawings before its own, and write what they ask for.

    Parameters
    ----------
    write
        A function of a `Subject`, of what returns the drawing, and of options of its own. The entry
        of the second in its docstring makes way for the options.
    """
    subject, _, *own = inspect.signature(write).parameters.values()
    _, *shared = inspect.signature(drawn_of).parameters.values()
    names = [parameter.name for parameter in own]

    @wraps(write)
    def written(subject: Subject, **options: Any) -> Content:
        kept: Any = {name: options.pop(name) for name in names if name in options}
        return write(subject, partial(drawn_of, subject, **options), **kept)

    made: Any = written
    made.__signature__ = inspect.Signature([subject, *shared, *own])
    made.__doc__ = (write.__doc__ or "").replace(_ENTRY, _OPTIONS)
    return written
