"""Angles within one turn, whole turns counted apart.

An angle of thousands of radians costs digits that Lyapunov exponents and sections need.
"""

from __future__ import annotations

import math

from linkages.kernel.code.operands import Whole, floats, fused, integers, rounded
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.steps.views import TWO_PI, TWO_PI_TAIL, SystemView


@printed
def wrap_angles(
    code: Procedure, system: SystemView, angles: Whole, turns: Whole, into: Whole
) -> None:
    """Bring rotating coordinates into [-π, π]; writes ``into = turns + turns taken away``.

    All three are addresses: of the coordinates and of turns to start from and to write.
    """
    rotates, q = integers(system.rotates), floats(angles)
    before, after = integers(turns), integers(into)
    with code.count(system.n) as i:
        after[i] = before[i]
        with code.when((rotates[i] != 0) & (abs(q[i]) > math.pi)):
            whole = rounded(q[i] / TWO_PI)
            q[i] = fused(-whole, TWO_PI_TAIL, fused(-whole, TWO_PI, q[i]))
            after[i] += whole.whole
