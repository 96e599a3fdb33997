"""Arguments that count something."""

from __future__ import annotations

import operator


def require_whole(**arguments: object) -> None:
    """Whether arguments that count something are whole numbers.

    Raises
    ------
    TypeError
        Names the first that is not: ``periods=20.0`` as well as ``periods="20"``.
    """
    for name, value in arguments.items():
        try:
            operator.index(value)  # type: ignore[arg-type]
        except TypeError:
            raise TypeError(f"{name} must be a whole number, found {value!r}") from None
