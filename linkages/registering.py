"""Components, outputs and analyses that come from outside the package."""

from __future__ import annotations

from typing import Any

from linkages.components import registry
from linkages.kernel import outputs


def register(thing: Any, name: str = "") -> None:
    """Add a component or an output of one's own to those of the package, for this process.

    Parameters
    ----------
    thing
        A component: a class with a `section`, from then on read from definition files, checked and
        written like all others. Or a `linkages.kernel.outputs.Variable`, an output.
    name
        Of an output, such as ``"joint_jerk"``.

    Raises
    ------
    TypeError, ValueError
        For what is neither, and for a name that is taken by a package.

    Notes
    -----
    A package that is installed registers by entry points of the groups ``linkages.components`` and
    ``linkages.outputs``, and needs no call.
    """
    if isinstance(thing, outputs.Variable):
        outputs.register(name, thing)
    else:
        registry.register(thing)


def unregister(name: str) -> None:
    """Take away what was registered in this process: an output, or a component by its class's name.

    Raises
    ------
    KeyError
        If nothing of that name was.
    """
    try:
        outputs.unregister(name)
    except KeyError:
        registry.unregister(name)
