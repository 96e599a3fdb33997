"""Stiffness K and exponent n of the force K·dⁿ between journal and bearing, from material."""

from __future__ import annotations

import math

NARROWEST, WIDEST = 5e-6, 1e-2
"""Sizes between which Pereira's exponent is given (m)."""


def stiffness_of_spheres(modulus: float, poisson: float, hole: float, pin: float) -> float:
    """K = 4/(3 s) √(R_h R_p/(R_h − R_p)) in N/m^1.5, with s = 2 (1 − ν²)/E for equal materials.

    Publications on journals in bearings use it most, although these touch along a line.

    Parameters
    ----------
    modulus, poisson
        E in Pa and ν, of both.
    hole, pin
        Radii in metres.
    """
    compliance = 2.0 * (1.0 - poisson**2) / modulus
    return 4.0 / (3.0 * compliance) * math.sqrt(hole * pin / (hole - pin))


def stiffness_of_cylinders(
    modulus: float, poisson: float, size: float, width: float
) -> tuple[float, float]:
    """K in N/mⁿ and n of a cylinder in a bearing, as Pereira, Ramalho and Ambrósio fit them [1]_.

    In mm and N/mm² it is F = (0.965 c + 0.0965) L E*/c · d^n with n = Y c^−0.005.

    Parameters
    ----------
    modulus, poisson
        E in Pa and ν, of both.
    size, width
        c and L in metres; c from `NARROWEST` to `WIDEST`.

    References
    ----------
    .. [1] C. M. Pereira, A. L. Ramalho, J. A. Ambrósio, "A critical overview of internal and
       external cylinder contact force models", Nonlinear Dyn. 63 (2011) 681-697.
    """
    clearance, length = 1e3 * size, 1e3 * width
    plane = 1e-6 * modulus / (2.0 * (1.0 - poisson**2))
    if clearance < 0.35:
        fitted = 1.51 * math.log(1e3 * clearance) ** -0.151
    else:
        fitted = 0.0151 * clearance + 1.151
    exponent = fitted * clearance**-0.005
    stiffness = (0.965 * clearance + 0.0965) * length * plane / clearance
    return stiffness * 1e3**exponent, exponent
