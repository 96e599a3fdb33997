"""The mechanism without clearances as a page computes it beside the one that it shows."""

from __future__ import annotations

from linkages.errors import InputError
from linkages.exports.kernels.javascript import javascript_module
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.values.requests import available

PLACES = "joint_position"


def ideal_of(system: System) -> System | None:
    """The mechanism without clearances; None where there are none, or it cannot move alike."""
    if not system.mechanism.clearance_names:
        return None
    try:
        return System(system.mechanism.ideal())
    except InputError:  # without clearances it has no mobility left, or too much
        return None


def ideal_module(system: System, options: RunOptions) -> str:
    """Its module of JavaScript, with what deviations are measured against; empty for none."""
    ideal = ideal_of(system)
    if ideal is None:
        return ""
    compared = [VARIABLES[name].compared for name in available(system)]
    return javascript_module(ideal, options, [PLACES, *filter(None, compared)])
