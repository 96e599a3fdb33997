"""Names of laws in definition files: those of a folder of this package, and of other packages."""

from __future__ import annotations

from functools import cache
from typing import Any

from linkages.discovery import modules_of, plugged
from linkages.reading.wording import listed, shown, suggestion
from linkages.spec.conversion import QuantityError
from linkages.spec.quantities import FieldType


@cache
def laws_in(group: str) -> dict[str, Any]:
    """All laws of a group by their names.

    Parameters
    ----------
    group
        The folder, each of whose files has its ``LAW``, and what entry points call it.
    """
    own = [module.LAW for module in modules_of(group)]
    return {law.name: law for law in (*own, *(law for _, law in plugged(group)))}


class LawName(FieldType):
    """The name of a law of a group.

    Parameters
    ----------
    group
        As of `laws_in`.
    what
        What messages call such a law.
    """

    def __init__(self, group: str, what: str) -> None:
        self.group, self.what = group, what

    def read(self, value: Any) -> str:
        """Return the name."""
        if not isinstance(value, str) or value not in laws_in(self.group):
            near = suggestion(str(value), laws_in(self.group))
            raise QuantityError(self.expected(), f"{shown(value)}{near}")
        return str(value)

    def expected(self) -> str:
        """Return the names."""
        return f"{self.what} ({listed(laws_in(self.group))})"

    def json_schema(self) -> dict[str, Any]:
        """Return the names."""
        return {"enum": list(laws_in(self.group))}
