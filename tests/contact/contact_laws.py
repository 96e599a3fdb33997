"""Normal forces in a clearance, and what one impact of a free body by them comes to.

F = K dᵖ (1 + χ d′/d′₀) with the indentation d and its rate d′₀ at the touch. The balance of energy
of a free impact is separable whatever K, p, mass and speed are, so that the restitution e obeys
(1 + χ)/(1 − χ e) = exp(χ (1 + e)), and the largest indentation d follows from
dᵖ⁺¹ = (p + 1) m v²/K · (χ − ln(1 + χ))/χ².
"""

import math
from collections.abc import Callable

from scipy.integrate import quad
from scipy.special import lambertw

DAMPING_FACTORS: dict[str, Callable[[float], float]] = {
    "hunt-crossley": lambda c: 3 * (1 - c) / 2,  # J. Appl. Mech. 42 (1975) 440
    "herbert-mcwhannell": lambda c: 6 * (1 - c) / ((2 * c - 1) ** 2 + 3),  # J. Eng. Ind. 99, 795
    "lee-wang": lambda c: 3 * (1 - c) / 4,  # J. Mech. Transm. Autom. Des. 105 (1983)
    "lankarani-nikravesh": lambda c: 3 * (1 - c**2) / 4,  # J. Mech. Des. 112 (1990) 369
    "gonthier": lambda c: (1 - c**2) / c,  # Multibody Syst. Dyn. 11 (2004) 209
    "zhiying-qishao": lambda c: 3 * (1 - c**2) * math.exp(2 * (1 - c)) / 4,  # 2006
    "flores": lambda c: 8 * (1 - c) / (5 * c),  # Multibody Syst. Dyn. 25 (2011) 357
    "hu-guo": lambda c: 3 * (1 - c) / (2 * c),  # 2015
    "carvalho-martins": lambda c: 3 * (1 - c) * (11 - c) / (2 * (1 + 9 * c)),  # MMT 138 (2019)
    "safaeifar-farshidianfar": lambda c: 5 * (1 - c) / (4 * c),  # Multibody Syst. Dyn. (2020)
    "exact": lambda c: exact_factor(c),
}
"""Law → wanted restitution → χ."""


def exact_factor(restitution: float) -> float:
    """The χ whose impact has exactly this restitution, by bisection of the energy balance."""
    low, high = 0.0, 1 / restitution
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if reached(middle) > restitution else (low, middle)
    return (low + high) / 2


def reached(chi: float) -> float:
    """Restitution of a free impact, by the principal branch of Lambert's W."""
    if chi == 0:
        return 1.0
    return (1 + float(lambertw(-(1 + chi) * math.exp(-1 - chi)).real)) / chi


def largest_indentation(
    chi: float, mass: float, speed: float, stiffness: float, exponent: float = 1.5
) -> float:
    """Where a free impact comes to rest."""
    part = 0.5 if chi == 0 else (chi - math.log1p(chi)) / chi**2
    return ((exponent + 1) * mass * speed**2 / stiffness * part) ** (1 / (exponent + 1))


def undamped_duration(mass: float, speed: float, stiffness: float, exponent: float = 1.5) -> float:
    """From the touch to the leave of an elastic impact, by Euler's beta function."""
    depth, part = largest_indentation(0.0, mass, speed, stiffness, exponent), 1 / (exponent + 1)
    return 2 * depth / speed * math.sqrt(math.pi) * math.gamma(1 + part) / math.gamma(0.5 + part)


def halves(
    chi: float, mass: float, speed: float, stiffness: float, exponent: float = 1.5
) -> tuple[float, float]:
    """Times of compression and of restitution, by quadrature over the rate.

    With u = d′/d′₀ the indentation is a function of u alone, and dt = −m v du/(K dᵖ (1 + χ u)):
    dᵖ⁺¹ = (p + 1) m v²/K · ((1 − u) − ln((1 + χ)/(1 + χ u))/χ)/χ. At both ends dᵖ goes to zero with
    a broken power of the distance from there, so that this distance is taken as a power itself.
    """
    end, power = -reached(chi), 1 / (exponent + 1)
    scale = (exponent + 1) * mass * speed**2 / stiffness

    def depth_power(base: float, sign: float, away: float) -> float:
        """dᵖ⁺¹ at a distance from one end, from where u itself would be rounded."""
        if chi == 0:
            return scale * away * (2 - away) / 2
        return scale * (math.log1p(chi * sign * away / (1 + chi * base)) / chi - sign * away) / chi

    def half(base: float, sign: float) -> float:
        span = abs(base)
        order = 1 / (1 - exponent * power)

        def integrand(s: float) -> float:
            away = span * s**order
            depth = depth_power(base, sign, away) ** (exponent * power)
            force = stiffness * depth * (1 + chi * (base + sign * away))
            return mass * speed * span * order * s ** (order - 1) / force

        return float(quad(integrand, 0, 1, epsabs=0, epsrel=1e-13, limit=200)[0])

    return half(1.0, -1.0), half(end, 1.0)


def duration(
    chi: float, mass: float, speed: float, stiffness: float, exponent: float = 1.5
) -> float:
    """From the touch to the leave."""
    return sum(halves(chi, mass, speed, stiffness, exponent))
