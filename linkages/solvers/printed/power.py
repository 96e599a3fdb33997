"""Powers for step control, of operations with one rounding: the same bits on every machine.

They are right to about 1e-10: a step that is longer by so much is as good as any.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from linkages.kernel.code.instructions import Instructions

_ROOT_HALF = 0x3FE6A09E667F3BCD
"""The bits of sqrt(1/2): mantissas are taken from there to sqrt(2)."""
_FRACTION = 52
_LARGEST = 1000.0
"""Of logarithms to base two whose power is a normal number."""


def binary_logarithm(code: Instructions, x: str) -> str:
    """The logarithm to base two of a positive normal number.

    With the mantissa m it is ``k + 2/ln 2 · artanh((m - 1)/(m + 1))``, as a series.
    """
    bits = code.give(f"bitcast {code.number} {x} to {code.integer}")
    above = code.on_integers("sub", bits, code.whole(_ROOT_HALF))
    exponent = code.on_integers("ashr", above, code.whole(_FRACTION))
    scale = code.on_integers("shl", exponent, code.whole(_FRACTION))
    rest = code.on_integers("sub", bits, scale)
    m = code.give(f"bitcast {code.integer} {rest} to {code.number}")
    one = code.constant(1.0)
    s = code.divide(code.subtract(m, one), code.add(m, one))
    series = [2 / math.log(2) / k for k in range(1, 15, 2)]
    whole = code.give(f"sitofp {code.integer} {exponent} to {code.number}")
    return code.fused(s, _polynomial(code, code.multiply(s, s), series), whole)


def binary_power(code: Instructions, y: str) -> str:
    """Two to a power between ±1000; the nearest of these for others."""
    most, least = code.constant(_LARGEST), code.constant(-_LARGEST)
    y = code.select(code.compare("olt", y, most), y, most)
    y = code.select(code.compare("ogt", y, least), y, least)
    whole = code.call("llvm.rint", y)
    series = [math.log(2) ** k / math.factorial(k) for k in range(11)]
    power = _polynomial(code, code.subtract(y, whole), series)
    number = code.give(f"fptosi {code.number} {whole} to {code.integer}")
    shift = code.on_integers("shl", number, code.whole(_FRACTION))
    bits = code.give(f"bitcast {code.number} {power} to {code.integer}")
    sum_ = code.on_integers("add", bits, shift)
    return code.give(f"bitcast {code.integer} {sum_} to {code.number}")


def _polynomial(code: Instructions, x: str, coefficients: Sequence[float]) -> str:
    """The value of Σ c_k x^k by Horner's rule."""
    result = code.constant(coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        result = code.fused(result, x, code.constant(coefficient))
    return result
