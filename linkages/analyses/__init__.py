"""Analyses that stand in files of their own, with their commands: found by themselves.

Modules here import what they need when they run, so that ``--help`` answers at once.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from inspect import signature
from typing import TYPE_CHECKING

from linkages.discovery import modules_of, plugged

if TYPE_CHECKING:
    import xarray as xr

GROUP = "linkages.analyses"
"""Entry points that name analyses, and the folder of those of this package."""

Analysis = Callable[..., "xr.Dataset"]
"""A function of a mechanism and of options by keyword: numbers, texts, or yes or no.

Its docstring describes them. What it returns has ``units`` and ``long_name``; an attribute
``warning`` is shown. Its name is that of the command, with hyphens there."""

_REGISTERED: dict[str, Analysis] = {}


@cache
def analyses() -> dict[str, Analysis]:
    """All of them by name."""
    result = [module.ANALYSIS for module in modules_of(GROUP)]
    result += [analysis for _, analysis in plugged(GROUP)]
    return {analysis.__name__: analysis for analysis in result} | _REGISTERED


def register(analysis: Analysis) -> None:
    """Add an analysis; one of the same name that was registered before is replaced.

    Raises
    ------
    ValueError
        If the name is that of an analysis of a package.
    """
    name = analysis.__name__
    if name in analyses() and name not in _REGISTERED:
        raise ValueError(f"expected a name for the analysis that is not taken, found {name!r}")
    _REGISTERED[name] = analysis
    analyses.cache_clear()


def unregister(name: str) -> None:
    """Take away an analysis that was registered; KeyError if none of that name was."""
    del _REGISTERED[name]
    analyses.cache_clear()


def options_of_analysis(name: str) -> list[str]:
    """Names of the options of an analysis, as `linkages.open` finds them; none if it is another."""
    result = analyses().get(name.replace("-", "_"))
    return [] if result is None else [*signature(result).parameters][1:]
