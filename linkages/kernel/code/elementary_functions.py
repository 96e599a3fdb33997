"""Elementary functions of operations with one rounding: the same bits on every machine.

Errors of angles of points and of atan stay below one unit in the last place, of others below two.

References
----------
FreeBSD, lib/msun/src: s_atan.c (Sun Microsystems 1993).

Errors stay below one unit in the last place, those of tanh below 1.5 and of sinh below 3.

References
----------
FreeBSD, lib/msun/src: e_exp.c, e_log.c (Sun Microsystems 1993).
S. L. Moshier: Cephes Mathematical Library, tanh.c (1995).

The argument is reduced by multiples of π/2 in three parts with fused multiply-adds, so that the
rest is known to twice the digits; then follow the polynomials of FreeBSD's library. Errors stay
below one unit in the last place up to `LARGEST`.

References
----------
W. J. Cody, W. Waite: Software Manual for the Elementary Functions, 1980 (reduction).
S. Boldo, M. Daumas, R.-C. Li: Formally verified argument reduction with a fused multiply-add. IEEE
Transactions on Computers 58 (2009) 1139.
FreeBSD, lib/msun/src: k_sin.c, k_cos.c (polynomials; Sun Microsystems 1993).

Others come from the C library, which differs from one machine to the next, and takes one state at a
time. No function of formulas is among them.
"""

from __future__ import annotations

from collections.abc import Callable

from linkages.kernel.code.instructions import Instructions

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


def arc_of(code: Instructions, y: str, x: str) -> str:
    """Write the angle between −π and π of a point (x, y), whose coordinates stay below 1e307."""
    across, along = code.absolute(y), code.absolute(x)
    infinite = code.constant(float("inf"))
    far = [code.compare("oeq", size, infinite) for size in (across, along)]
    both = code.logical_and(far)
    one, zero = code.constant(1.0), code.constant(0.0)
    across, along = (code.select(both, one, size) for size in (across, along))
    result, rest = _first_quarter(code, across, along)
    bits = code.assign(f"bitcast {code.number} {x} to {code.integer}")
    negative = code.assign(f"icmp slt {code.integer} {bits}, {code.int_constant(0)}")  # also −0
    turned = code.subtract(code.constant(_HALF[0]), result)
    lost = code.subtract(code.subtract(code.constant(_HALF[0]), turned), result)
    turned = code.add(turned, code.add(code.subtract(code.constant(_HALF[1]), rest), lost))
    result = code.select(negative, turned, code.add(result, rest))
    # of a point on the axis, also of the origin
    flat = code.select(negative, code.constant(_HALF[0]), zero)
    result = code.select(code.compare("oeq", y, zero), flat, result)
    unknown = code.assign(f"fcmp uno {code.number} {x}, {y}")
    result = code.select(unknown, code.constant(float("nan")), result)
    return code.copysign(result, y)


def _first_quarter(code: Instructions, y: str, x: str) -> tuple[str, str]:
    """The angle of a point with y ≥ 0, x ≥ 0, as a sum of two numbers.

    It is measured from that of five directions which is near: tan(a − b) is a quotient.
    """
    zero = code.constant(0.0)
    over, under = code.negate(x), y
    high, low = (code.constant(part) for part in _HALF_PI)
    for limit, ratio, first, second in reversed(_FROM):
        nearer = code.compare("olt", y, code.multiply(code.constant(limit), x))
        slope = code.constant(ratio)
        over = code.select(nearer, code.fma(code.negate(slope), x, y), over)
        under = code.select(nearer, code.fma(slope, y, x), under)
        high = code.select(nearer, code.constant(first), high)
        low = code.select(nearer, code.constant(second), low)
    small = code.compare("olt", y, code.multiply(code.constant(_SMALL), x))
    over, under = code.select(small, y, over), code.select(small, x, under)
    high, low = code.select(small, zero, high), code.select(small, zero, low)
    t = code.divide(over, under)
    square = code.multiply(t, t)
    fourth = code.multiply(square, square)
    even = code.multiply(square, code.polynomial(fourth, _EVEN))
    series = code.fma(fourth, code.polynomial(fourth, _ODD), even)
    # high + t is not exact: what it loses goes to the second number
    rest = code.subtract(low, code.multiply(t, series))
    result = code.add(high, t)
    lost = code.subtract(t, code.subtract(result, high))
    return result, code.add(rest, lost)


def arc_tangent(code: Instructions, x: str) -> str:
    """Write the angle between −π/2 and π/2 with a tangent."""
    return arc_of(code, x, code.constant(1.0))


def arc_sine(code: Instructions, x: str) -> str:
    """Write the angle between −π/2 and π/2 with a sine."""
    return arc_of(code, x, _other_leg(code, x))


def arc_cosine(code: Instructions, x: str) -> str:
    """Write the angle between 0 and π with a cosine."""
    return arc_of(code, _other_leg(code, x), x)


def _other_leg(code: Instructions, x: str) -> str:
    """Of a right triangle with hypotenuse 1; nan where there is none."""
    one = code.constant(1.0)
    return code.call_intrinsic("llvm.sqrt", code.multiply(code.subtract(one, x), code.add(one, x)))


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
    high = code.fma(code.negate(n), code.constant(_LN2[0]), x)  # exact
    low = code.multiply(n, code.constant(_LN2[1]))
    rest = code.subtract(high, low)
    square = code.multiply(rest, rest)
    c = code.fma(code.negate(square), code.polynomial(square, _EXP), rest)
    quotient = code.divide(code.multiply(rest, c), code.subtract(code.constant(2.0), c))
    grown = code.subtract(code.subtract(low, quotient), high)
    return _scaled(code, code.subtract(code.constant(1.0), grown), shifted)


def _scaled(code: Instructions, x: str, shifted: str) -> str:
    """Write x·2ⁿ, given n + `_SHIFT`, in two steps: 2ⁿ itself may be too small or too large."""
    bits = code.assign(f"bitcast {code.number} {shifted} to {code.integer}")
    n = code.int_operation("sub", bits, code.int_constant(_SHIFT_BITS))
    half = code.int_operation("ashr", n, code.int_constant(1))
    for power in (half, code.int_operation("sub", n, half)):
        place = code.int_operation("shl", power, code.int_constant(52))
        place = code.int_operation("add", place, code.int_constant(_ONE))
        factor = code.assign(f"bitcast {code.integer} {place} to {code.number}")
        x = code.multiply(x, factor)
    return x


def logarithm(code: Instructions, x: str) -> str:
    """Write ln x = n ln 2 + ln(1 + f)."""
    zero, one = code.constant(0.0), code.constant(1.0)
    small = code.compare("olt", x, code.constant(_SMALLEST))
    scaled = code.multiply(x, code.select(small, code.constant(2.0**54), one))
    bits = code.assign(f"bitcast {code.number} {scaled} to {code.integer}")
    bits = code.int_operation("add", bits, code.int_constant(_ONE - _ROOT_HALF))
    n = code.int_operation("lshr", bits, code.int_constant(52))
    n = code.int_operation("add", n, code.int_constant(_SHIFT_BITS - 1023))
    n = code.assign(f"bitcast {code.integer} {n} to {code.number}")
    n = code.subtract(n, code.constant(_SHIFT))
    n = code.subtract(n, code.select(small, code.constant(54.0), zero))
    bits = code.int_operation("and", bits, code.int_constant(_FRACTION))
    bits = code.int_operation("add", bits, code.int_constant(_ROOT_HALF))
    f = code.subtract(code.assign(f"bitcast {code.integer} {bits} to {code.number}"), one)
    s = code.divide(f, code.add(code.constant(2.0), f))
    square = code.multiply(s, s)
    series = code.multiply(square, code.polynomial(square, _LOG))
    half = code.multiply(code.multiply(code.constant(0.5), f), f)
    rest = code.fma(n, code.constant(_LN2[1]), code.multiply(s, code.add(half, series)))
    result = code.add(code.subtract(rest, half), f)
    result = code.fma(n, code.constant(_LN2[0]), result)
    infinite = code.constant(float("inf"))
    result = code.select(code.compare("olt", x, infinite), result, x)  # of infinity and nan: itself
    result = code.select(code.compare("oeq", x, zero), code.constant(float("-inf")), result)
    return code.select(code.compare("olt", x, zero), code.constant(float("nan")), result)


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
    result = code.add(code.select(small, size, one), code.divide(over, under))
    return code.copysign(result, x)


def hyperbolic_cosine(code: Instructions, x: str) -> str:
    """Write cosh x = (eˣ + e⁻ˣ)/2."""
    half, grown = code.constant(0.5), exponential(code, code.absolute(x))
    return code.fma(half, grown, code.divide(half, grown))


def hyperbolic_sine(code: Instructions, x: str) -> str:
    """Write sinh x = tanh x · cosh x."""
    return code.multiply(hyperbolic_tangent(code, x), hyperbolic_cosine(code, x))


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


def cosine_and_sine(code: Instructions, angle: str) -> tuple[str, str]:
    """Write the cosine and the sine of an angle in radians; returns their names."""
    near = code.compare("ole", code.absolute(angle), code.constant(LARGEST))
    x = code.select(near, angle, code.constant(float("nan")))
    # rounded to an integer, which stands in the last bits
    shifted = code.add(code.multiply(x, code.constant(_QUARTERS)), code.constant(_SHIFT))
    rest, tail = _reduced(code, x, code.subtract(shifted, code.constant(_SHIFT)))
    square = code.multiply(rest, rest)
    sine = _sine(code, rest, tail, square)
    cosine = _cosine(code, rest, tail, square)
    return _turned(code, angle, shifted, (cosine, sine))


def _reduced(code: Instructions, x: str, quarters: str) -> tuple[str, str]:
    """What remains of x without a number of quarter turns, as a sum of two numbers."""
    back = code.negate(quarters)
    high = code.fma(back, code.constant(_QUARTER[0]), x)  # exact: the rest has as many bits
    low = code.multiply(quarters, code.constant(_QUARTER[1]))
    missing = code.fma(quarters, code.constant(_QUARTER[1]), code.negate(low))
    rest = code.subtract(high, low)
    # what the difference has lost, exactly (Knuth)
    taken = code.subtract(rest, high)
    kept = code.subtract(high, code.subtract(rest, taken))
    lost = code.subtract(kept, code.add(low, taken))
    tail = code.subtract(lost, missing)
    return rest, code.fma(back, code.constant(_QUARTER[2]), tail)


def _sine(code: Instructions, x: str, tail: str, square: str) -> str:
    """The sine of x + tail within ±π/4: x − ((z (tail/2 − x z r) − tail) − x z S1)."""
    cube = code.negate(code.multiply(square, x))
    inner = code.fma(
        cube, code.polynomial(square, _SINE[1:]), code.multiply(code.constant(0.5), tail)
    )
    outer = code.fma(square, inner, code.negate(tail))
    return code.subtract(x, code.fma(cube, code.constant(_SINE[0]), outer))


def _cosine(code: Instructions, x: str, tail: str, square: str) -> str:
    """The cosine of x + tail within ±π/4: 1 − z/2, what that rounds off, and the other terms."""
    half = code.multiply(code.constant(0.5), square)
    most = code.subtract(code.constant(1.0), half)
    rint = code.subtract(code.subtract(code.constant(1.0), most), half)
    polynomial = code.multiply(square, code.polynomial(square, _COSINE))
    further = code.fma(square, polynomial, code.negate(code.multiply(x, tail)))
    return code.add(most, code.add(rint, further))


def _turned(
    code: Instructions, angle: str, shifted: str, values: tuple[str, str]
) -> tuple[str, str]:
    """Cosine and sine after a number of quarter turns, which stands in the last bits of a sum."""
    cosine, sine = values
    number = code.assign(f"bitcast {code.number} {shifted} to {code.integer}")
    odd = code.assign(f"trunc {code.integer} {number} to {code.truth}")
    result = []
    for first, second, more in ((sine, cosine, 1), (cosine, sine, 0)):
        size = code.select(odd, first, second)
        quadrant = code.int_operation("add", number, code.int_constant(more))
        half = code.int_operation("and", quadrant, code.int_constant(2))
        sign = code.int_operation("shl", half, code.int_constant(62))
        bits = code.assign(f"bitcast {code.number} {size} to {code.integer}")
        turned = code.int_operation("xor", bits, sign)
        result.append(code.assign(f"bitcast {code.integer} {turned} to {code.number}"))
    zero = code.compare("oeq", angle, code.constant(0.0))
    return result[0], code.select(zero, angle, result[1])  # the sine of −0 is −0


FUNCTIONS: dict[str, Callable[..., str]] = {
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
"""Each writes what becomes of its operands, and returns the name of that."""
