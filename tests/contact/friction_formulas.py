"""Laws of friction as publications print them: force against the slip over the normal force.

They are compared with each other in F. Marques, P. Flores, J. C. Pimenta Claro, H. M. Lankarani,
Nonlinear Dyn. 86 (2016) 1407.
"""

import math
from collections.abc import Callable, Mapping

Numbers = Mapping[str, float]


def tanh(v: float, k: Numbers) -> float:
    return k["friction"] * math.tanh(v / k["slip"])


def ambrosio(v: float, k: Numbers) -> float:
    """c_d μ sgn v with the dynamic correction c_d."""
    low, high = k["least_slip"], k["slip"]
    if abs(v) < low:
        return 0.0
    part = (abs(v) - low) / (high - low) if abs(v) < high else 1.0
    return part * k["friction"] * math.copysign(1, v)


def threlfall(v: float, k: Numbers) -> float:
    part = min(abs(v) / k["slip"], 1.0)
    return k["friction"] * (1 - math.exp(-3 * part)) * math.copysign(1, v)


def bengisu_akay(v: float, k: Numbers) -> float:
    slip, static = k["slip"], k["static"]
    if abs(v) < slip:
        size = -static / slip**2 * (abs(v) - slip) ** 2 + static
    else:
        falling = math.exp(-(abs(v) - slip) / k["stribeck_speed"])
        size = k["friction"] + (static - k["friction"]) * falling
    return size * math.copysign(1, v)


def brown_mcphee(v: float, k: Numbers) -> float:
    part = abs(v) / k["slip"]
    size = k["friction"] * math.tanh(4 * part)
    size += (k["static"] - k["friction"]) * part / (part**2 / 4 + 3 / 4) ** 2
    return size * math.copysign(1, v)


def coulomb(v: float, k: Numbers) -> float:
    """Of slip: at rest it is whatever keeps that."""
    size = k["friction"]
    if "static" in k:
        size += (k["static"] - size) * math.exp(-((v / k["stribeck_speed"]) ** 2))
    return size * math.copysign(1, v)


FORMULAS: dict[str, Callable[[float, Numbers], float]] = {
    "tanh": tanh,
    "ambrosio": ambrosio,
    "threlfall": threlfall,
    "bengisu-akay": bengisu_akay,
    "brown-mcphee": brown_mcphee,
    "coulomb": coulomb,
}
