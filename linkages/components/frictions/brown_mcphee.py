"""P. Brown, J. McPhee, *J. Comput. Nonlinear Dyn.* 11 (2016) 054502: smooth, with a maximum.

It reaches about μ_s at the velocity vt of transition.
"""

from linkages.components.contributed.friction_laws import Coefficients, FrictionLaw
from linkages.components.contributed.functions import Function, V, applied


def _resists(numbers: Coefficients) -> Function:
    sliding = numbers["friction"]
    part = V / numbers["slip"]
    hump = part / applied("add", applied("mul", 0.25, part**2), 0.75) ** 2
    return sliding * applied("tanh", applied("mul", 4, part)) + (numbers["static"] - sliding) * hump


LAW = FrictionLaw("brown-mcphee", ("static", "slip"), _resists)
