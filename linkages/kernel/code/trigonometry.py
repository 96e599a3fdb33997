"""Cosine and sine of an angle, of operations with one rounding: the same bits on every machine.

The argument is reduced by multiples of π/2 in three parts with fused multiply-adds, so that the
rest is known to twice the digits; then follow the polynomials of FreeBSD's library. Errors stay
below one unit in the last place up to `LARGEST`.

References
----------
W. J. Cody, W. Waite: Software Manual for the Elementary Functions, 1980 (reduction).
S. Boldo, M. Daumas, R.-C. Li: Formally verified argument reduction with a fused multiply-add. IEEE
Transactions on Computers 58 (2009) 1139.
FreeBSD, lib/msun/src: k_sin.c, k_cos.c (polynomials; Sun Microsystems 1993).
"""

from __future__ import annotations

from linkages.kernel.code.instructions import Instructions

LARGEST = 1e12
"""Angles beyond this have no cosine and sine (nan): less than five digits of the turn are left."""

_QUARTERS = 0.6366197723675814  # 2/π
_SHIFT = 1.5 * 2.0**52  # sums with it have no digits behind the point
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
    high = code.fused(back, code.constant(_QUARTER[0]), x)  # exact: the rest has as many bits
    low = code.multiply(quarters, code.constant(_QUARTER[1]))
    missing = code.fused(quarters, code.constant(_QUARTER[1]), code.negate(low))
    rest = code.subtract(high, low)
    # what the difference has lost, exactly (Knuth)
    taken = code.subtract(rest, high)
    kept = code.subtract(high, code.subtract(rest, taken))
    lost = code.subtract(kept, code.add(low, taken))
    tail = code.subtract(lost, missing)
    return rest, code.fused(back, code.constant(_QUARTER[2]), tail)


def _sine(code: Instructions, x: str, tail: str, square: str) -> str:
    """The sine of x + tail within ±π/4: x − ((z (tail/2 − x z r) − tail) − x z S1)."""
    cube = code.negate(code.multiply(square, x))
    inner = code.fused(
        cube, code.polynomial(square, _SINE[1:]), code.multiply(code.constant(0.5), tail)
    )
    outer = code.fused(square, inner, code.negate(tail))
    return code.subtract(x, code.fused(cube, code.constant(_SINE[0]), outer))


def _cosine(code: Instructions, x: str, tail: str, square: str) -> str:
    """The cosine of x + tail within ±π/4: 1 − z/2, what that rounds off, and the other terms."""
    half = code.multiply(code.constant(0.5), square)
    most = code.subtract(code.constant(1.0), half)
    rounded = code.subtract(code.subtract(code.constant(1.0), most), half)
    polynomial = code.multiply(square, code.polynomial(square, _COSINE))
    further = code.fused(square, polynomial, code.negate(code.multiply(x, tail)))
    return code.add(most, code.add(rounded, further))


def _turned(
    code: Instructions, angle: str, shifted: str, values: tuple[str, str]
) -> tuple[str, str]:
    """Cosine and sine after a number of quarter turns, which stands in the last bits of a sum."""
    cosine, sine = values
    number = code.give(f"bitcast {code.number} {shifted} to {code.integer}")
    odd = code.give(f"trunc {code.integer} {number} to {code.truth}")
    found = []
    for first, second, more in ((sine, cosine, 1), (cosine, sine, 0)):
        size = code.select(odd, first, second)
        quadrant = code.on_integers("add", number, code.whole(more))
        half = code.on_integers("and", quadrant, code.whole(2))
        sign = code.on_integers("shl", half, code.whole(62))
        bits = code.give(f"bitcast {code.number} {size} to {code.integer}")
        turned = code.on_integers("xor", bits, sign)
        found.append(code.give(f"bitcast {code.integer} {turned} to {code.number}"))
    zero = code.compare("oeq", angle, code.constant(0.0))
    return found[0], code.select(zero, angle, found[1])  # the sine of −0 is −0
