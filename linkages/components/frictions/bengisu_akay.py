"""M. T. Bengisu, A. Akay, *J. Sound Vib.* 171 (1994) 557: a parabola, then an exponential.

It rises to μ_s at v0, where it has a corner, and falls to μ over the Stribeck speed.
"""

from linkages.components.contributed.friction_laws import Coefficients, FrictionLaw, beyond, odd
from linkages.components.contributed.functions import Function, applied


def _resists(numbers: Coefficients) -> Function:
    sliding, static, peak = numbers["friction"], numbers["static"], numbers["slip"]

    def magnitude(slip: Function) -> Function:
        part, fast = slip / peak, beyond(peak)
        more = applied("where", fast, (slip - peak) / numbers["stribeck_speed"], 0)
        falling = sliding + (static - sliding) * applied("exp", applied("neg", more))
        return applied("where", fast, falling, static * part * applied("sub", 2, part))

    return odd(magnitude)


LAW = FrictionLaw("bengisu-akay", ("static", "slip", "stribeck_speed"), _resists)
