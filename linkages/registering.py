"""Components, outputs and analyses that come from outside the package."""

from __future__ import annotations

from contextlib import suppress
from inspect import isfunction
from typing import Any

from linkages import analyses
from linkages.components.mechanisms import registry
from linkages.kernel import outputs


def register(thing: Any, name: str = "") -> None:
    """Add a component or an output of one's own to those of the package, for this process.

    Parameters
    ----------
    thing
        A component: a class with a `section`, from then on read from definition files, checked and
        written like all others. Or a `linkages.kernel.outputs.Variable`, an output. Or an analysis:
        a function of a mechanism and of options by keyword that returns a dataset.
    name
        Of an output, such as ``"joint_jerk"``.

    Raises
    ------
    TypeError, ValueError
        For what is neither, and for a name that is taken by a package.

    Notes
    -----
    A package that is installed registers by entry points of the groups ``linkages.components``,
    ``linkages.outputs`` and ``linkages.analyses``, and needs no call. Its analyses are commands.
    """
    if isinstance(thing, outputs.Variable):
        outputs.register(name, thing)
    elif isfunction(thing):
        analyses.register(thing)
    else:
        registry.register(thing)


def unregister(name: str) -> None:
    """Take away what was registered in this process, by its name: components by their class's.

    Raises
    ------
    KeyError
        If nothing of that name was.
    """
    for place in (outputs, analyses):
        with suppress(KeyError):
            place.unregister(name)
            return
    registry.unregister(name)
