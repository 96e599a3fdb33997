"""J. A. C. Ambrósio, *Virtual Nonlinear Multibody Systems* (Kluwer 2003) 57: none in slow slip.

It rises in a straight line from 0 at v0 to μ at v1.
"""

from linkages.components.contributed.friction_laws import Coefficients, FrictionLaw
from linkages.components.contributed.functions import Function, V, applied


def _resists(numbers: Coefficients) -> Function:
    low, high = numbers["least_slip"], numbers["slip"]

    def part(slip: Function) -> Function:
        rising = applied("where", slip - high, 1, (slip - low) / (high - low))
        return applied("where", slip - low, rising, 0)

    # not of the magnitude, which has a corner of its own where there is no friction
    return numbers["friction"] * (part(V) - part(applied("neg", V)))


LAW = FrictionLaw("ambrosio", ("least_slip", "slip"), _resists)
