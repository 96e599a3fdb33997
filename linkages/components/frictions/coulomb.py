"""Coulomb's set-valued friction: it sticks until more than the static friction is needed.

Where a static coefficient is given it falls to that of sliding as Stribeck's does.
"""

from linkages.components.contributed.friction_laws import Coefficients, FrictionLaw, stribeck
from linkages.components.contributed.functions import Function, V, applied


def _resists(numbers: Coefficients) -> Function:
    size: Function = numbers["friction"]
    if "static" in numbers and "stribeck_speed" in numbers:
        size = stribeck(size, numbers["static"], numbers["stribeck_speed"])
    return applied("mul", size, applied("sign", V))


LAW = FrictionLaw("coulomb", (), _resists, takes=("static", "stribeck_speed"))
