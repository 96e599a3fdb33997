"""Angles within one turn, whole turns counted apart.

An angle of thousands of radians costs digits that Lyapunov exponents and sections need.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.solvers.steps.compiled import compiled, floats, fused, integers
from linkages.solvers.steps.views import TWO_PI, TWO_PI_TAIL, SystemView


@compiled
def wrap_angles(system: SystemView, angles: int, turns: int, into: int) -> None:
    """Bring rotating coordinates into [-π, π]; writes ``into = turns + turns taken away``.

    All three are addresses: of the coordinates and of turns to start from and to write.
    """
    rotates, q = integers(system.rotates), floats(angles)
    before, after = integers(turns), integers(into)
    for i in range(system.n):
        after[i] = before[i]
        if rotates[i] != 0 and abs(q[i]) > math.pi:
            whole = np.rint(q[i] / TWO_PI)
            q[i] = fused(-whole, TWO_PI_TAIL, fused(-whole, TWO_PI, q[i]))
            after[i] += int(whole)
