"""Error norm and next step length.

They are right to about 1e-10: a step that is longer by so much is as good as any.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
       Springer 1993, (II.10.17).
.. [2] E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996,
       section IV.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from linkages.kernel.code.instructions import Instructions
from linkages.solvers.loops.memory import BEFORE, LENGTH, RTOL
from linkages.solvers.loops.shape import Shape, StepMemory, fold, larger, smaller
from linkages.solvers.tableau import Tableau

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


# Measured on pendulums and Duffing's equation at rtol 1e-10: against the usual 0.9, fewer rejected
# steps outweigh shorter ones, so that 0.8 takes 4 to 11 % fewer evaluations and errs less. On the
# nine-bar proportional-integral control (exponents 0.7 and 0.4, 0.8 and 0.3, 0.8 and 0.2 of 1/p)
# rejects fewer steps, yet for the same error dop853 and vern9 need 2 to 18 % more evaluations.
SAFETY = 0.8
SHRINK_MOST, GROW_MOST = 1 / 3, 6.0
# Halving is enough for links that turned too far to be watched.
SHRINK_TURNING = 0.5
# Most that a relative margin, the sine of an angle, may change by within a step at the rates of its
# stages: over longer steps its extrapolation from the ends says nothing about what lies between.
MOST_CHANGE = 0.35
# An end at which everything is so much steeper than at the start says nothing about round-off: a
# trial that dived into a wall must not excuse itself.
WILD = 1e4
OVERFLOW = 1e150
# Steps that were much better than asked for say nothing about how the error develops.
LEAST_BEFORE = 1e-4
LEAST_ERROR = 1e-30
# The factor is measured: a nine-bar on its way to a change point scatters by 0.01 to 0.05 ε/m³
# where its time and state are moved by units in their last place.
ROUNDING, TINY = 0.05 * 2.220446049250313e-16, 1e-30


class Judged(NamedTuple):
    """What is thought of a step that has been tried.

    Parameters
    ----------
    error
        Root mean square of the error estimate in units of the tolerance and of round-off.
    factor
        From its length to that of the next one, or of its repetition.
    accepted
        Whether it counts.
    """

    error: str
    factor: str
    accepted: str


def judge(
    code: Instructions, tableau: Tableau, shape: Shape, memory: StepMemory, gain: float
) -> Judged:
    """Write what is thought of the step in the workspace; `gain` as `next_factor` has it."""
    h = memory.pace(LENGTH)
    error = _error_norm(code, tableau, shape, memory, code.absolute(h))
    factor = next_factor(code, error, memory.pace(BEFORE), tableau.error_order, gain)
    small = code.compare("ole", error, code.constant(1.0))
    if not shape.blocks:
        return Judged(error, factor, small)
    far = _turns_too_far(code, tableau.stages, shape, memory, code.absolute(h))
    halved = code.all_of([small, far])
    factor = code.select(halved, code.constant(SHRINK_TURNING), factor)
    return Judged(error, factor, code.all_of([small, code.opposite(far)]))


def _rounding(code: Instructions, end: int, shape: Shape, memory: StepMemory) -> str:
    """Relative round-off of accelerations, from the least margin at both ends of a step.

    A link's component found as ``sqrt(L² - n²)`` carries a relative error ε/m² at the relative
    margin m, and accelerations divide by it once more. No step is short enough to show a smaller
    error, however smooth the motion is; without this allowance the steps before a singular
    position would shrink to nothing.
    """
    first, last = memory.row(0, shape.margins), memory.row(end, shape.margins)

    def block(i: int | str, values: list[str]) -> list[str]:
        at_start, at_end = (code.absolute(code.load(row, i)) for row in (first, last))
        here = code.divide(smaller(code, at_start, at_end), code.load(memory["scale"], i))
        return [smaller(code, values[0], here)]

    (least,) = fold(code, shape.blocks, [code.constant(1.0)], block)
    cube = code.multiply(code.multiply(least, least), least)
    return code.divide(code.constant(ROUNDING), larger(code, cube, code.constant(TINY)))


def _error_norm(
    code: Instructions, tableau: Tableau, shape: Shape, memory: StepMemory, length: str
) -> str:
    """The error of a step of some length.

    With two estimates e₅ and e₃ it is ``|h| |e₅|² / sqrt(|e₅|² + 0.01 |e₃|²)`` [1]_; with one, its
    norm.
    """
    n, end, zero = shape.n, tableau.stages, code.constant(0.0)
    noise = code.multiply(length, _rounding(code, end, shape, memory))
    slopes = [memory.row(row, n) for row in range(end + 1)]
    begun, reached = memory.row(0), memory.row(end)

    def steepest(i: int | str, values: list[str]) -> list[str]:
        sizes = (code.absolute(code.load(slopes[row], i)) for row in (0, end))
        return [larger(code, value, size) for value, size in zip(values, sizes, strict=True)]

    early, late = fold(code, 2 * n, [zero, zero], steepest)
    wild = code.compare("ogt", late, code.multiply(code.constant(WILD), early))
    rtol = memory.pace(RTOL)
    rows = [[(j, w) for j, w in enumerate(row) if w] for row in tableau.error.tolist()]

    def entry(i: int | str, values: list[str]) -> list[str]:
        start, stop = (code.absolute(code.load(row, i)) for row in (begun, reached))
        first, last = (code.absolute(code.load(slopes[row], i)) for row in (0, end))
        steep = code.select(wild, first, larger(code, first, last))
        allowed = code.fused(rtol, larger(code, start, stop), code.load(memory["atol"], i))
        allowed = code.fused(noise, steep, allowed)
        unit = code.divide(code.constant(1.0), allowed)
        found = []
        for weights, total in zip(rows, values, strict=True):
            estimate = zero
            for j, weight in weights:
                estimate = code.fused(code.constant(weight), code.load(slopes[j], i), estimate)
            scaled = code.multiply(estimate, unit)
            found.append(code.fused(scaled, scaled, total))
        return found

    main, *low = fold(code, 2 * n, [zero for _ in rows], entry)
    both = code.fused(code.constant(0.01), low[0], main) if low else main
    spread = code.call("llvm.sqrt", code.multiply(both, code.constant(2.0 * n)))
    norm = code.divide(code.multiply(length, main), spread)
    return code.select(code.compare("oeq", main, zero), zero, norm)


def next_factor(code: Instructions, error: str, before: str, order: int, gain: float) -> str:
    """Factor from a step to the next one, or to its repetition, from the error norm.

    With a `gain` above 0 this is Gustafsson's PI control in the form of [2]_, with the exponent
    ``1/(order + 1)``: ``safety · error^-(exponent - 0.75 gain) · before^gain``, where `before` is
    the error norm of the step before. With 0 it is the elementary control by the last error alone.
    """
    exponent = 1.0 / (order + 1) - 0.75 * gain
    # Written so that nan, the quotient of two overflows, is caught as well.
    fine = code.compare("olt", error, code.constant(OVERFLOW))
    known = code.select(fine, larger(code, error, code.constant(LEAST_ERROR)), code.constant(1.0))
    power = code.multiply(code.constant(-exponent), binary_logarithm(code, known))
    if gain:
        last = larger(code, before, code.constant(LEAST_BEFORE))
        power = code.fused(code.constant(gain), binary_logarithm(code, last), power)
    factor = code.multiply(code.constant(SAFETY), binary_power(code, power))
    least = code.constant(SHRINK_MOST)
    factor = smaller(code, larger(code, factor, least), code.constant(GROW_MOST))
    return code.select(fine, factor, least)


def _turns_too_far(
    code: Instructions, end: int, shape: Shape, memory: StepMemory, length: str
) -> str:
    """Whether links turn so far within a step that a singular position could be overlooked."""
    rates = [memory.row(row, shape.margins + shape.blocks) for row in range(end + 1)]

    def block(i: int | str, values: list[str]) -> list[str]:
        most = code.constant(0.0)
        for row in rates:
            most = larger(code, most, code.absolute(code.load(row, i)))
        limit = code.multiply(code.constant(MOST_CHANGE), code.load(memory["scale"], i))
        excess = code.subtract(code.multiply(length, most), limit)
        return [larger(code, values[0], excess)]

    (excess,) = fold(code, shape.blocks, [code.constant(0.0)], block)
    return code.compare("ogt", excess, code.constant(0.0))
