"""Which motions a graphics processor can integrate."""

from __future__ import annotations

from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solvers.choice import AUTO, choose
from linkages.solvers.methods.method import RungeKutta
from linkages.solvers.methods.named import METHODS


def cpu_only(system: System, run: RunOptions) -> str:
    """Why motions of a system are integrated on the CPU only, as what they are; empty if not so.

    Parameters
    ----------
    system
        That moves.
    run
        How it is integrated.
    """
    if not system.topology.coordinates:
        return "a motion that drives determine"
    name = choose(run.rtol).name if run.method == AUTO else run.method
    if run.step is not None:
        return "a motion in steps of one length"
    method = METHODS.get(name)
    if method is not None and not (method.adaptive and isinstance(method, RungeKutta)):
        return f"a motion by the method '{name}'"
    return ""
