"""Elementary functions of operations with one rounding: the same bits on every machine.

Errors stay below one unit in the last place for sine and cosine (up to `LARGEST`), angles of
points, atan, exp and log, below 1.5 for tanh, 3 for sinh and 2 for others. Arguments of sine and
cosine are reduced by multiples of π/2 in three parts with fused multiply-adds, so that the rest is
known to twice the digits. A function that is not here comes from the C library, one state at a
time.

References
----------
FreeBSD, lib/msun/src: s_atan.c, e_exp.c, e_log.c, k_sin.c, k_cos.c (Sun Microsystems 1993).
S. L. Moshier: Cephes Mathematical Library, tanh.c (1995).
W. J. Cody, W. Waite: Software Manual for the Elementary Functions, 1980 (reduction).
S. Boldo, M. Daumas, R.-C. Li: Formally verified argument reduction with a fused multiply-add. IEEE
Transactions on Computers 58 (2009) 1139.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    copysign,
    fma,
    polynomial,
    select,
    select_of,
    sqrt,
)

_EVEN = (
    3.33333333333329318027e-01, 1.42857142725034663711e-01, 9.09088713343650656196e-02,
    6.66107313738753120669e-02, 4.97687799461593236017e-02, 1.62858201153657823623e-02,
)  # fmt: skip
_ODD = (
    -1.99999999998764832476e-01, -1.11111104054623557880e-01, -7.69187620504482999495e-02,
    -5.83357013379057348645e-02, -3.65315727442169155270e-02,
)  # fmt: skip
# up to which ratio an arc is measured from which other one, and this arc in two parts
_FROM = (
    (0.6875, 0.5, 4.63647609000806093515e-01, 2.26987774529616870924e-17),
    (1.1875, 1.0, 7.85398163397448278999e-01, 3.06161699786838301793e-17),
    (2.4375, 1.5, 9.82793723247329054082e-01, 1.39033110312309984516e-17),
)
_SMALL = 0.4375
_HALF_PI = (1.57079632679489655800e00, 6.12323399573676603587e-17)
_HALF = (3.14159265358979311600e00, 1.22464679914735317722e-16)


def arc_of(y: Real, x: Real) -> Real:
    """Write the angle between −π and π of a point (x, y), whose coordinates stay below 1e307."""
    code, across, along = y.code, abs(y), abs(x)
    both = _equal(across, math.inf) & _equal(along, math.inf)
    across, along = (select(both, 1.0, size) for size in (across, along))
    result, rest = _first_quarter(across, along)
    negative = x.bits < 0  # also −0
    turned = _HALF[0] - result
    lost = (_HALF[0] - turned) - result
    turned = turned + ((_HALF[1] - rest) + lost)
    result = select(negative, turned, result + rest)
    # of a point on the axis, also of the origin
    flat = select_of(Real, negative, _HALF[0], 0.0)
    result = select(_equal(y, 0.0), flat, result)
    unknown = Bool(code, code.assign(f"fcmp uno {code.number} {x.text}, {y.text}"))
    result = select(unknown, math.nan, result)
    return copysign(result, y)


def _first_quarter(y: Real, x: Real) -> tuple[Real, Real]:
    """The angle of a point with y ≥ 0, x ≥ 0, as a sum of two numbers.

    It is measured from that of five directions which is near: tan(a − b) is a quotient.
    """
    over, under = -x, y
    high, low = (y.code.value(part) for part in _HALF_PI)
    for limit, ratio, first, second in reversed(_FROM):
        nearer = y < limit * x
        slope = y.code.value(ratio)
        over = select(nearer, fma(-slope, x, y), over)
        under = select(nearer, fma(slope, y, x), under)
        high, low = select(nearer, first, high), select(nearer, second, low)
    small = y < _SMALL * x
    over, under = select(small, y, over), select(small, x, under)
    high, low = select(small, 0.0, high), select(small, 0.0, low)
    t = over / under
    square = t * t
    fourth = square * square
    even = square * polynomial(fourth, _EVEN)
    series = fma(fourth, polynomial(fourth, _ODD), even)
    # high + t is not exact: what it loses goes to the second number
    rest = low - t * series
    result = high + t
    lost = t - (result - high)
    return result, rest + lost


def arc_tangent(x: Real) -> Real:
    """Write the angle between −π/2 and π/2 with a tangent."""
    return arc_of(x, x.code.value(1.0))


def arc_sine(x: Real) -> Real:
    """Write the angle between −π/2 and π/2 with a sine."""
    return arc_of(x, _other_leg(x))


def arc_cosine(x: Real) -> Real:
    """Write the angle between 0 and π with a cosine."""
    return arc_of(_other_leg(x), x)


def _other_leg(x: Real) -> Real:
    """Of a right triangle with hypotenuse 1; nan where there is none."""
    return sqrt((1.0 - x) * (1.0 + x))


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


def exponential(x: Real) -> Real:
    """Write eˣ = 2ⁿ eʳ with |r| ≤ ln(2)/2."""
    x = select(x > _MOST, _MOST, x)
    x = select(x < _LEAST, _LEAST, x)
    shifted = x * _LOG2E + _SHIFT
    n = shifted - _SHIFT
    high = fma(-n, _LN2[0], x)  # exact
    low = n * _LN2[1]
    rest = high - low
    square = rest * rest
    c = fma(-square, polynomial(square, _EXP), rest)
    quotient = rest * c / (2.0 - c)
    grown = (low - quotient) - high
    return _scaled(1.0 - grown, shifted)


def _scaled(x: Real, shifted: Real) -> Real:
    """Write x·2ⁿ, given n + `_SHIFT`, in two steps: 2ⁿ itself may be too small or too large."""
    n = shifted.bits - _SHIFT_BITS
    half = n >> 1
    for power in (half, n - half):
        x = x * ((power << 52) + _ONE).with_bits
    return x


def logarithm(x: Real) -> Real:
    """Write ln x = n ln 2 + ln(1 + f)."""
    code, small = x.code, x < _SMALLEST
    scaled = x * select_of(Real, small, 2.0**54, 1.0)
    bits = scaled.bits + (_ONE - _ROOT_HALF)
    shifted = Int(code, code.int_operation("lshr", bits.text, code.int_constant(52)))
    n = (shifted + (_SHIFT_BITS - 1023)).with_bits - _SHIFT
    n = n - select_of(Real, small, 54.0, 0.0)
    f = ((bits & _FRACTION) + _ROOT_HALF).with_bits - 1.0
    s = f / (2.0 + f)
    square = s * s
    series = square * polynomial(square, _LOG)
    half = 0.5 * f * f
    rest = fma(n, _LN2[1], s * (half + series))
    result = (rest - half) + f
    result = fma(n, _LN2[0], result)
    result = select(x < math.inf, result, x)  # of infinity and nan: itself
    result = select(_equal(x, 0.0), -math.inf, result)
    return select(x < 0.0, math.nan, result)


def hyperbolic_tangent(x: Real) -> Real:
    """Write tanh x: a quotient of polynomials for small x, 1 − 2/(e²ˣ + 1) for others."""
    size = abs(x)
    square = x * x
    over = size * square * polynomial(square, _TANH_OVER)
    under = polynomial(square, _TANH_UNDER)
    grown = exponential(2.0 * size)
    small = size < _TANH_SMALL
    over = select(small, over, -2.0)
    under = select(small, under, grown + 1.0)
    result = select(small, size, 1.0) + over / under
    return copysign(result, x)


def hyperbolic_cosine(x: Real) -> Real:
    """Write cosh x = (eˣ + e⁻ˣ)/2."""
    half, grown = x.code.value(0.5), exponential(abs(x))
    return fma(half, grown, half / grown)


def hyperbolic_sine(x: Real) -> Real:
    """Write sinh x = tanh x · cosh x."""
    return hyperbolic_tangent(x) * hyperbolic_cosine(x)


LARGEST = 1e12
"""Angles beyond this have no cosine and sine (nan): less than five digits of the turn are left."""

_QUARTERS = 0.6366197723675814  # 2/π
# π/2 to 160 bits: its first part, what that leaves, and what both leave
_QUARTER = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33)

_SINE = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
    2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
_COSINE = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
    -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip


def cosine_and_sine(angle: Real) -> tuple[Real, Real]:
    """Write the cosine and the sine of an angle in radians."""
    x = select(abs(angle) <= LARGEST, angle, math.nan)
    # rounded to an integer, which stands in the last bits
    shifted = x * _QUARTERS + _SHIFT
    rest, tail = _reduced(x, shifted - _SHIFT)
    square = rest * rest
    sine = _sine(rest, tail, square)
    cosine = _cosine(rest, tail, square)
    return _turned(angle, shifted.bits, cosine, sine)


def _reduced(x: Real, quarters: Real) -> tuple[Real, Real]:
    """What remains of x without a number of quarter turns, as a sum of two numbers."""
    back = -quarters
    high = fma(back, _QUARTER[0], x)  # exact: the rest has as many bits
    low = quarters * _QUARTER[1]
    missing = fma(quarters, _QUARTER[1], -low)
    rest = high - low
    # what the difference has lost, exactly (Knuth)
    taken = rest - high
    kept = high - (rest - taken)
    lost = kept - (low + taken)
    tail = lost - missing
    return rest, fma(back, _QUARTER[2], tail)


def _sine(x: Real, tail: Real, square: Real) -> Real:
    """The sine of x + tail within ±π/4: x − ((z (tail/2 − x z r) − tail) − x z S1)."""
    cube = -(square * x)
    inner = fma(cube, polynomial(square, _SINE[1:]), 0.5 * tail)
    outer = fma(square, inner, -tail)
    return x - fma(cube, _SINE[0], outer)


def _cosine(x: Real, tail: Real, square: Real) -> Real:
    """The cosine of x + tail within ±π/4: 1 − z/2, what that rounds off, and the other terms."""
    half = 0.5 * square
    most = 1.0 - half
    rounded = (1.0 - most) - half
    further = fma(square, square * polynomial(square, _COSINE), -(x * tail))
    return most + (rounded + further)


def _turned(angle: Real, number: Int, cosine: Real, sine: Real) -> tuple[Real, Real]:
    """Cosine and sine after a number of quarter turns, which stands in the last bits."""
    odd, result = number.converted("trunc", Bool), []
    for first, second, more in ((sine, cosine, 1), (cosine, sine, 0)):
        size = select(odd, first, second)
        sign = ((number + more) & 2) << 62
        result.append((size.bits ^ sign).with_bits)
    # the sine of −0 is −0
    return result[0], select(_equal(angle, 0.0), angle, result[1])


def _equal(one: Real, other: float) -> Bool:
    result: Bool = one == other
    return result


def elementary(name: str, *given: Real) -> Real:
    """A function by its name in `linkages.operations`, written out where that is known."""
    if name in FUNCTIONS:
        return FUNCTIONS[name](*given)
    code = given[0].code
    return Real(code, code.call_library(name, *(x.text for x in given)))


FUNCTIONS: dict[str, Callable[..., Real]] = {
    "exp": exponential,
    "log": logarithm,
    "sinh": hyperbolic_sine,
    "cosh": hyperbolic_cosine,
    "tanh": hyperbolic_tangent,
    "asin": arc_sine,
    "acos": arc_cosine,
    "atan": arc_tangent,
    "atan2": arc_of,
}
"""Each writes what becomes of its operands."""
