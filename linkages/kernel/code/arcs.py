"""Inverse trigonometric functions, of operations with one rounding.

Errors of angles of points and of atan stay below one unit in the last place, of others below two.

References
----------
FreeBSD, lib/msun/src: s_atan.c (Sun Microsystems 1993).
"""

from __future__ import annotations

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
_QUARTER = (1.57079632679489655800e00, 6.12323399573676603587e-17)
_HALF = (3.14159265358979311600e00, 1.22464679914735317722e-16)


def arc_of(code: Instructions, y: str, x: str) -> str:
    """Write the angle between −π and π of a point (x, y), whose coordinates stay below 1e307."""
    across, along = code.absolute(y), code.absolute(x)
    infinite = code.constant(float("inf"))
    far = [code.compare("oeq", size, infinite) for size in (across, along)]
    both = code.all_of(far)
    one, zero = code.constant(1.0), code.constant(0.0)
    across, along = (code.select(both, one, size) for size in (across, along))
    found, rest = _first_quarter(code, across, along)
    bits = code.give(f"bitcast {code.number} {x} to {code.integer}")
    negative = code.give(f"icmp slt {code.integer} {bits}, {code.whole(0)}")  # also −0
    turned = code.subtract(code.constant(_HALF[0]), found)
    lost = code.subtract(code.subtract(code.constant(_HALF[0]), turned), found)
    turned = code.add(turned, code.add(code.subtract(code.constant(_HALF[1]), rest), lost))
    found = code.select(negative, turned, code.add(found, rest))
    # of a point on the axis, also of the origin
    flat = code.select(negative, code.constant(_HALF[0]), zero)
    found = code.select(code.compare("oeq", y, zero), flat, found)
    unknown = code.give(f"fcmp uno {code.number} {x}, {y}")
    found = code.select(unknown, code.constant(float("nan")), found)
    return code.with_sign_of(found, y)


def _first_quarter(code: Instructions, y: str, x: str) -> tuple[str, str]:
    """The angle of a point with y ≥ 0, x ≥ 0, as a sum of two numbers.

    It is measured from that of five directions which is near: tan(a − b) is a quotient.
    """
    zero = code.constant(0.0)
    over, under = code.negate(x), y
    high, low = (code.constant(part) for part in _QUARTER)
    for limit, ratio, first, second in reversed(_FROM):
        nearer = code.compare("olt", y, code.multiply(code.constant(limit), x))
        slope = code.constant(ratio)
        over = code.select(nearer, code.fused(code.negate(slope), x, y), over)
        under = code.select(nearer, code.fused(slope, y, x), under)
        high = code.select(nearer, code.constant(first), high)
        low = code.select(nearer, code.constant(second), low)
    small = code.compare("olt", y, code.multiply(code.constant(_SMALL), x))
    over, under = code.select(small, y, over), code.select(small, x, under)
    high, low = code.select(small, zero, high), code.select(small, zero, low)
    t = code.divide(over, under)
    square = code.multiply(t, t)
    fourth = code.multiply(square, square)
    even = code.multiply(square, code.polynomial(fourth, _EVEN))
    series = code.fused(fourth, code.polynomial(fourth, _ODD), even)
    # high + t is not exact: what it loses goes to the second number
    rest = code.subtract(low, code.multiply(t, series))
    found = code.add(high, t)
    lost = code.subtract(t, code.subtract(found, high))
    return found, code.add(rest, lost)


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
    return code.call("llvm.sqrt", code.multiply(code.subtract(one, x), code.add(one, x)))
