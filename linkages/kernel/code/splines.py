"""A function that interpolates tables: value and derivatives of piecewise cubics."""

from __future__ import annotations

from collections.abc import Sequence

from linkages.components.contributed.interpolation import cubic
from linkages.kernel.code.instructions import INTEGER, TRUTH, Instructions, PrintedLoop
from linkages.kernel.code.statements import build_block
from linkages.kernel.code.writer import SPLINE, Writer, triple_of
from linkages.kernel.graph.scalars import Level, ScalarGraph, reachable


def spline_function(code: Instructions) -> str:
    """Write the function; returns its signature.

    Its arguments are a time, the address of knots and coefficients, the number of intervals, and
    whether they repeat.
    """
    first, last = code.load("%p", 0), code.load("%p", "%count")
    time = _within_period(code, first, last)
    inner = code.select(code.compare("ogt", first, time), first, time)
    inner = code.select(code.compare("olt", last, inner), last, inner)
    low = _interval(code, inner)
    end = code.give(f"add {INTEGER} %count, 1")
    coefficients = code.address("%p", end)
    place = code.on_integers("shl", low, code.whole(2))
    x = code.subtract(inner, code.gather("%p", low))
    outside = code.subtract(time, inner)
    further = [code.gather(code.address(coefficients, k), place) for k in range(4)]
    value, slope, curvature = _cubic(code, [x, outside, *further])
    beyond = code.compare("une", outside, code.constant(0.0))
    results = (value, slope, code.select(beyond, code.constant(0.0), curvature))
    triple, kind = "poison", triple_of(code)
    for k, result in enumerate(results):
        triple = code.give(f"insertvalue {kind} {triple}, {code.number} {result}, {k}")
    code.say(f"ret {kind} {triple}")
    arguments = f"{code.number} %t, ptr %p, {INTEGER} %count, {TRUTH} %periodic"
    return f"{kind} @{SPLINE}({arguments})"


def _within_period(code: Instructions, first: str, last: str) -> str:
    """The time, or where it stands in its period if there is one.

    What is left of a time without whole periods has as many bits as the period. It is exact,
    but for a negative time in the period before the first.
    """
    span = code.subtract(last, first)
    past = code.subtract("%t", first)
    periods = code.call("llvm.floor", code.divide(past, span))
    rest = code.fused(code.negate(periods), span, past)
    negative = code.compare("olt", rest, code.constant(0.0))  # the quotient was rounded up
    rest = code.select(negative, code.add(rest, span), rest)
    inside = code.add(first, rest)
    return code.give(f"select {TRUTH} %periodic, {code.number} {inside}, {code.number} %t")


def _interval(code: Instructions, inner: str) -> str:
    """Number of the interval in which a time lies, by bisection.

    All lanes take as many turns as the longest needs: further ones change nothing.
    """
    search = PrintedLoop(
        code, [(code.integer, code.whole(0)), (code.integer, code.everywhere("%count"))]
    )
    low, high = search.values
    middle = code.on_integers("lshr", code.on_integers("add", low, high), code.whole(1))
    above = code.compare("ole", code.gather("%p", middle), inner)
    ends = (
        code.select(above, middle, low, code.integer),
        code.select(above, high, middle, code.integer),
    )
    apart = code.on_integers("sub", ends[1], ends[0])
    wide = code.give(f"icmp sgt {code.integer} {apart}, {code.whole(1)}")
    search.repeat(code.in_any_lane(wide), ends)
    return ends[0]


def _cubic(code: Instructions, values: Sequence[str]) -> list[str]:
    """The formula of `linkages.components.contributed.interpolation.cubic`."""
    graph = ScalarGraph()
    inputs = [graph.input("y", k, Level.STATE) for k in range(len(values))]
    results = cubic(*inputs)
    known: dict[int, str | list[str]] = {
        node.index: value for node, value in zip(inputs, values, strict=True)
    }
    block = build_block(reachable(results), dict.fromkeys(known, ""), results)
    writer = Writer(block, code, known)
    writer.write()
    return [writer.value(result) for result in results]
