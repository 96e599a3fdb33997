"""Words that error messages share: the nearest right word, and how a value found is shown."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable

_LONGEST_SHOWN = 60

TOO_LARGE = (
    "Expected masses, lengths, speeds and times whose products double precision can hold: numbers "
    "from 1e-308 to 1e308."
)
"""What to say where a result is not a finite number."""


def nearest(word: str, words: Iterable[str]) -> str | None:
    """Return the word that was most likely meant, or None when none is near.

    A difference in capitals alone counts as nearest of all.
    """
    if len(word) > _LONGEST_SHOWN:
        return None
    candidates = list(dict.fromkeys(words))
    folded = word.casefold()
    for candidate in candidates:
        if candidate.casefold() == folded and candidate != word:
            return candidate
    matches = difflib.get_close_matches(word, candidates, n=1, cutoff=0.6)
    return matches[0] if matches and matches[0] != word else None


def suggestion(word: str, words: Iterable[str]) -> str:
    """Return ``"; did you mean 'length'?"``, or nothing when no word is near."""
    near = nearest(word, words)
    return f"; did you mean {near!r}?" if near is not None else ""


def shown(value: object) -> str:
    """Return a value as messages show it: on one line, and short."""
    if value is None:
        return "nothing"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}" if value else "an empty list"
    if isinstance(value, str) and len(value) > _LONGEST_SHOWN:
        return f"{value[:_LONGEST_SHOWN]!r}… ({len(value)} characters)"
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print integers of thousands of digits
        return f"a {type(value).__name__} too long to print"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"


def listed(words: Iterable[str], last: str = "or") -> str:
    """Return ``"a, b or c"``."""
    items = list(words)
    if len(items) < 2:
        return "".join(items)
    return f"{', '.join(items[:-1])} {last} {items[-1]}"


def to_error(value: float, error: float) -> tuple[str, str]:
    """A number and its error with as many digits as two digits of the error tell.

    ``0.00343939, 0.0059`` becomes ``0.0034`` and ``0.0059``.
    """
    if not (math.isfinite(value) and math.isfinite(error)) or error <= 0:
        return f"{value:.6g}", f"{error:.2g}"
    place = math.floor(math.log10(error)) - 1
    if -_MOST_DECIMALS <= place <= 2:
        decimals = max(0, -place)
        return f"{round(value, -place) + 0.0:.{decimals}f}", f"{round(error, -place):.{decimals}f}"
    digits = math.floor(math.log10(abs(value))) - place if value else 0
    return f"{value:.{max(0, digits)}e}", f"{error:.1e}"


_MOST_DECIMALS = 8
