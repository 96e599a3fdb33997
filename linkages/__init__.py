"""Dynamics of planar linkages, from one definition file to a labelled solution.

>>> import linkages
>>> mechanism = linkages.load("ninebar.yaml", set={"clearances.r1.size": 1e-4})
>>> solution = linkages.simulate(mechanism, end=2.0)
>>> solution.data  # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from linkages.discovery import RENDERERS
from linkages.old_names import keep_old_names

keep_old_names()


def _html(module: str, name: str) -> Callable[[Any], str]:
    """A renderer whose module is imported when a notebook first shows something."""
    return lambda thing: str(getattr(import_module(module), name)(thing))


RENDERERS.update(
    Mechanism=_html("linkages.reports.pages", "mechanism_html"),
    Topology=_html("linkages.reports.pages", "topology_html"),
    Solution=_html("linkages.viewer.content", "solution_html"),
)


def _homes() -> dict[str, str]:
    """Name → module, as the file beside this one has them for editors and type checkers."""
    # by hand: parsers would take longer to import than everything else here
    with open(__file__ + "i", encoding="utf-8") as stub:
        lines = [line.partition("#")[0].strip() for line in stub]
    homes: dict[str, str] = {}
    for statement in "\n".join(lines).split("\nfrom linkages.")[1:]:
        module, _, names = statement.partition("\n\n")[0].partition(" import ")
        for name in names.strip("()\n ").split(","):
            if name.strip():
                homes[name.split()[-1]] = f"linkages.{module}"
    return homes


# Names are imported when they are first used: `import linkages` and `--help` stay fast.
_HOMES = _homes()

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("linkages")
    if name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
        globals()[name] = value
        return value
    # what was registered, or is not in the list; modules of the package are imported by themselves
    if not name.startswith("_") and find_spec(f"{__name__}.{name}") is None:
        from linkages.analyses import analyses
        from linkages.components.mechanisms.registry import components

        result: dict[str, Any] = {**components(), **analyses()}
        if name in result:
            return result[name]
    raise AttributeError(f"module 'linkages' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
