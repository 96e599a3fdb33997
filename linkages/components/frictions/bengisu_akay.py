"""M. T. Bengisu, A. Akay, *J. Sound Vib.* 171 (1994) 557: a parabola, then an exponential.

It rises to μ_s at v0, where it has a corner, and falls to μ over the Stribeck speed.
"""

from linkages.components.contributed.friction_laws import Coefficients, FrictionLaw, odd
from linkages.components.contributed.functions import Function, applied


def _resists(numbers: Coefficients) -> Function:
    sliding, static, peak = numbers["friction"], numbers["static"], numbers["slip"]

    def magnitude(slip: Function) -> Function:
        part = slip / peak
        beyond = applied("max", slip - peak, 0) / numbers["stribeck_speed"]
        falling = sliding + (static - sliding) * applied("exp", applied("neg", beyond))
        return applied("where", slip - peak, falling, static * part * applied("sub", 2, part))

    return odd(magnitude)


LAW = FrictionLaw("bengisu-akay", ("static", "slip", "stribeck_speed"), _resists)
