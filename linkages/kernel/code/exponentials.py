"""Exponential, logarithm and hyperbolic functions, of operations with one rounding.

Errors stay below one unit in the last place, those of tanh below 1.5 and of sinh below 3.

References
----------
FreeBSD, lib/msun/src: e_exp.c, e_log.c (Sun Microsystems 1993).
S. L. Moshier: Cephes Mathematical Library, tanh.c (1995).
"""

from __future__ import annotations

from linkages.kernel.code.instructions import Instructions

_SHIFT = 1.5 * 2.0**52  # sums with it have no digits behind the point
_SHIFT_BITS = 0x4338000000000000
_LOG2E = 1.44269504088896338700
# ln 2: its first 32 bits, so that products with integers are exact, and the rest
_LN2 = (6.93147180369123816490e-01, 1.90821492927058770002e-10)
_LEAST, _MOST = -746.0, 710.0  # beyond, exponentials are 0 and infinite

_EXP = (
    1.66666666666666019037e-01, -2.77777777770155933842e-03, 6.61375632143793436117e-05,
    -1.65339022054652515390e-06, 4.13813679705723846039e-08,
)  # fmt: skip
_LOG = (
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01,
    2.222219843214978396e-01, 1.818357216161805012e-01, 1.531383769920937332e-01,
    1.479819860511658591e-01,
)  # fmt: skip
_ONE = 0x3FF0000000000000
_ROOT_HALF = 0x3FE6A09E00000000  # bits of about the root of 1/2
_FRACTION = 0x000FFFFFFFFFFFFF
_SMALLEST = 2.0**-1022  # with all digits

_TANH_OVER = (-1614.68768441708447952, -99.2877231001918586564, -0.964399179425052238628)
_TANH_UNDER = (4844.06305325125486048, 2235.48839060100448583, 112.811678491632931402, 1.0)
_TANH_SMALL = 0.625


def exponential(code: Instructions, x: str) -> str:
    """Write eˣ = 2ⁿ eʳ with |r| ≤ ln(2)/2."""
    for relation, limit in (("ogt", _MOST), ("olt", _LEAST)):
        x = code.select(code.compare(relation, x, code.constant(limit)), code.constant(limit), x)
    shift = code.constant(_SHIFT)
    shifted = code.add(code.multiply(x, code.constant(_LOG2E)), shift)
    n = code.subtract(shifted, shift)
    high = code.fused(code.negate(n), code.constant(_LN2[0]), x)  # exact
    low = code.multiply(n, code.constant(_LN2[1]))
    rest = code.subtract(high, low)
    square = code.multiply(rest, rest)
    c = code.fused(code.negate(square), code.polynomial(square, _EXP), rest)
    quotient = code.divide(code.multiply(rest, c), code.subtract(code.constant(2.0), c))
    grown = code.subtract(code.subtract(low, quotient), high)
    return _scaled(code, code.subtract(code.constant(1.0), grown), shifted)


def _scaled(code: Instructions, x: str, shifted: str) -> str:
    """Write x·2ⁿ, given n + `_SHIFT`, in two steps: 2ⁿ itself may be too small or too large."""
    bits = code.give(f"bitcast {code.number} {shifted} to {code.integer}")
    n = code.on_integers("sub", bits, code.whole(_SHIFT_BITS))
    half = code.on_integers("ashr", n, code.whole(1))
    for power in (half, code.on_integers("sub", n, half)):
        place = code.on_integers("shl", power, code.whole(52))
        place = code.on_integers("add", place, code.whole(_ONE))
        factor = code.give(f"bitcast {code.integer} {place} to {code.number}")
        x = code.multiply(x, factor)
    return x


def logarithm(code: Instructions, x: str) -> str:
    """Write ln x = n ln 2 + ln(1 + f)."""
    zero, one = code.constant(0.0), code.constant(1.0)
    small = code.compare("olt", x, code.constant(_SMALLEST))
    scaled = code.multiply(x, code.select(small, code.constant(2.0**54), one))
    bits = code.give(f"bitcast {code.number} {scaled} to {code.integer}")
    bits = code.on_integers("add", bits, code.whole(_ONE - _ROOT_HALF))
    n = code.on_integers("lshr", bits, code.whole(52))
    n = code.on_integers("add", n, code.whole(_SHIFT_BITS - 1023))
    n = code.give(f"bitcast {code.integer} {n} to {code.number}")
    n = code.subtract(n, code.constant(_SHIFT))
    n = code.subtract(n, code.select(small, code.constant(54.0), zero))
    bits = code.on_integers("and", bits, code.whole(_FRACTION))
    bits = code.on_integers("add", bits, code.whole(_ROOT_HALF))
    f = code.subtract(code.give(f"bitcast {code.integer} {bits} to {code.number}"), one)
    s = code.divide(f, code.add(code.constant(2.0), f))
    square = code.multiply(s, s)
    series = code.multiply(square, code.polynomial(square, _LOG))
    half = code.multiply(code.multiply(code.constant(0.5), f), f)
    rest = code.fused(n, code.constant(_LN2[1]), code.multiply(s, code.add(half, series)))
    found = code.add(code.subtract(rest, half), f)
    found = code.fused(n, code.constant(_LN2[0]), found)
    infinite = code.constant(float("inf"))
    found = code.select(code.compare("olt", x, infinite), found, x)  # of infinity and nan: itself
    found = code.select(code.compare("oeq", x, zero), code.constant(float("-inf")), found)
    return code.select(code.compare("olt", x, zero), code.constant(float("nan")), found)


def hyperbolic_tangent(code: Instructions, x: str) -> str:
    """Write tanh x: a quotient of polynomials for small x, 1 − 2/(e²ˣ + 1) for others."""
    one, size = code.constant(1.0), code.absolute(x)
    square = code.multiply(x, x)
    over = code.multiply(code.multiply(size, square), code.polynomial(square, _TANH_OVER))
    under = code.polynomial(square, _TANH_UNDER)
    grown = exponential(code, code.multiply(code.constant(2.0), size))
    small = code.compare("olt", size, code.constant(_TANH_SMALL))
    over = code.select(small, over, code.constant(-2.0))
    under = code.select(small, under, code.add(grown, one))
    found = code.add(code.select(small, size, one), code.divide(over, under))
    return code.with_sign_of(found, x)


def hyperbolic_cosine(code: Instructions, x: str) -> str:
    """Write cosh x = (eˣ + e⁻ˣ)/2."""
    half, grown = code.constant(0.5), exponential(code, code.absolute(x))
    return code.fused(half, grown, code.divide(half, grown))


def hyperbolic_sine(code: Instructions, x: str) -> str:
    """Write sinh x = tanh x · cosh x."""
    return code.multiply(hyperbolic_tangent(code, x), hyperbolic_cosine(code, x))
