"""A. G. Threlfall, *Mech. Mach. Theory* 13 (1978) 475: μ (1 − exp(−3 |v|/vr)) up to vr.

Beyond, it stays what it is there, 1 − exp(−3) = 0.9502, which is printed as 0.95.
"""

from linkages.components.contributed.friction_laws import Coefficients, FrictionLaw, beyond, odd
from linkages.components.contributed.functions import Function, applied


def _resists(numbers: Coefficients) -> Function:
    reached = numbers["slip"]

    def magnitude(slip: Function) -> Function:
        part = applied("where", beyond(reached), 1, slip / reached)
        return applied("sub", 1, applied("exp", applied("mul", -3, part)))

    return numbers["friction"] * odd(magnitude)


LAW = FrictionLaw("threlfall", ("slip",), _resists)
