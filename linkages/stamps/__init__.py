"""What files of results hold of their origin: the definition as computed, options, command.

Each format has a place for texts that programs which show it pass over. A file of results is a
definition file, too: `stamped` reads what `stamp` has written.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from linkages.stamps import documents, dxf, films, images, netcdf, programs


@dataclass(frozen=True)
class Format:
    """How a kind of file holds a text.

    Parameters
    ----------
    put
        Content and a text → the content with that text, in the place of an earlier one.
    taken
        Content → the text in it; None if there is none.
    """

    put: Callable[[bytes, str], bytes]
    taken: Callable[[bytes], str | None]


FORMATS = {
    ".nc": Format(netcdf.put, netcdf.taken),
    ".png": Format(images.put_png, images.taken_png),
    ".svg": Format(documents.put_svg, documents.taken_svg),
    ".pdf": Format(documents.put_pdf, documents.taken_pdf),
    ".html": Format(documents.put_html, documents.taken_html),
    ".json": Format(documents.put_json, documents.taken_json),
    ".dxf": Format(dxf.put, dxf.taken),
    ".gif": Format(films.put_gif, films.taken_gif),
    ".webp": Format(films.put_webp, films.taken_webp),
    ".mp4": Format(films.put_mp4, films.taken_mp4),
    **dict.fromkeys((".c", ".h", ".js"), Format(programs.put_braces, programs.taken_braces)),
    ".py": Format(programs.put_python, programs.taken_python),
    ".xml": Format(programs.put_xml, programs.taken_xml),
}
"""Ending → how such files hold texts. Tables have none: what is beside them says it."""


def stamp(path: Path, origin: Mapping[str, str]) -> bool:
    """Write into a file what it was computed from.

    Parameters
    ----------
    path
        The file; it is written in place.
    origin
        Names and texts, such as ``definition`` and ``options``.

    Returns
    -------
    Whether files of this kind can hold it.
    """
    found = FORMATS.get(path.suffix.lower())
    if found is None:
        return False
    path.write_bytes(found.put(path.read_bytes(), json.dumps(dict(origin), ensure_ascii=False)))
    return True


def stamped(path: Path) -> dict[str, str] | None:
    """What a file of results was computed from; None if it does not say so.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    found = FORMATS.get(path.suffix.lower())
    text = None if found is None else found.taken(path.read_bytes())
    if text is None:
        return None
    try:
        content = json.loads(text)
    except ValueError:
        return None
    return {str(name): str(value) for name, value in content.items()} if content else None
