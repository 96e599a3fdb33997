"""Samples and start of a motion, and the module of steps of a method."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

from linkages.kernel.code.instructions import Instructions, PrintedLoop
from linkages.kernel.code.machine import MachineCode
from linkages.kernel.code.writer import Module
from linkages.kernel.dyads import LEAST_MARGIN
from linkages.solvers.loops.advance import Advance
from linkages.solvers.loops.control import binary_logarithm, binary_power
from linkages.solvers.loops.memory import (
    AT,
    BEFORE,
    END,
    EVALUATIONS,
    FIRST,
    FROM,
    LENGTH,
    RTOL,
    SAMPLE,
    SAMPLES,
    STATUS,
    THETA,
    TO,
    H,
    T,
)
from linkages.solvers.loops.predicates import end_weights, write_counted, write_expected
from linkages.solvers.loops.shape import (
    Shape,
    Stages,
    StepMemory,
    call_clock,
    call_rates,
    fold,
    is_sound,
    larger,
    set_whole,
    smaller,
    whole_row,
    wrap,
)
from linkages.solvers.tableau import Tableau

ELSEWHERE = 1
"""Returned where the rest is for the loop of the motion itself."""


def write_interpolation(code: Instructions, tableau: Tableau, shape: Shape) -> None:
    """Write the state at the fraction `THETA` of a step into the last row, by the dense output."""
    _interpolate(code, tableau, shape, StepMemory(code, shape))
    code.say("ret i64 0")


def write_between(code: Instructions, tableau: Tableau, shape: Shape) -> None:
    """Write the same for several lanes, evaluated at the times `AT`, and statuses into the pace."""
    memory = StepMemory(code, shape)
    _interpolate(code, tableau, shape, memory)
    timed = call_clock(code, memory, memory.pace(AT))
    found = call_rates(code, memory, len(tableau.extended_c), shape.n)
    fine = code.give(f"icmp eq {code.integer} {timed}, {code.whole(0)}")
    set_whole(code, code.select(fine, found, timed, code.integer), memory["pace"], STATUS)
    code.say("ret i64 0")


def _interpolate(code: Instructions, tableau: Tableau, shape: Shape, memory: StepMemory) -> None:
    n = shape.n
    theta, h = memory.pace(THETA), memory.pace(LENGTH)
    begun, target = memory.row(0), memory.row(len(tableau.extended_c))
    terms = [(w, memory.row(row, n)) for w, row in _dense_weights(code, tableau, theta)]

    def entry(i: int | str, _: list[str]) -> list[str]:
        slope = code.constant(0.0)
        for weight, slopes in terms:
            slope = code.fused(weight, code.load(slopes, i), slope)
        code.store(code.fused(h, slope, code.load(begun, i)), target, i)
        return []

    fold(code, 2 * n, (), entry)


def _dense_weights(code: Instructions, tableau: Tableau, theta: str) -> list[tuple[str, int]]:
    """Weights of the rows at a fraction of a step, by the dense output."""
    found = []
    for row, coefficients in enumerate(tableau.dense.tolist()):
        if any(coefficients):
            weight = code.constant(coefficients[-1])
            for coefficient in reversed(coefficients[:-1]):
                weight = code.fused(weight, theta, code.constant(coefficient))
            found.append((code.multiply(weight, theta), row))
    return found


def write_sample(code: Instructions, shape: Shape) -> None:
    """Write ``%row`` as the next sample; see `linkages.solvers.loops.margins.write_sample`."""
    memory, n = StepMemory(code, shape), shape.n
    taken = whole_row(code, memory["counters"], SAMPLES)
    place = code.on_integers("mul", taken, code.whole(n))
    twice = code.on_integers("mul", taken, code.whole(2 * n))
    states = code.address(memory["states"], twice)
    found = code.address(memory["accelerations"], place)
    turns = code.address(memory["sampled_turns"], place)

    def copy(i: int | str, _: list[str]) -> list[str]:
        code.store(code.load("%row", i), states, i)
        return []

    def accompany(i: int | str, _: list[str]) -> list[str]:
        code.store(code.load(code.address("%row", 2 * n), i), found, i)
        set_whole(code, whole_row(code, memory["turns"], i), turns, i)
        return []

    fold(code, 2 * n, (), copy)
    fold(code, n, (), accompany)
    for i in range(n):
        if shape.rotates[i]:
            wrap(code, states, i, turns)
    if shape.counted:
        angles = code.on_integers("mul", taken, code.whole(shape.counted))
        into = code.address(memory["sampled"], angles)
        write_counted(code, shape, memory, "%row", into)
    following = code.on_integers("add", taken, code.whole(1))
    set_whole(code, following, memory["counters"], SAMPLES)
    memory.set_pace(code.load(memory["times"], following), SAMPLE)
    code.say("ret i64 0")


def write_samples(code: Instructions, tableau: Tableau, shape: Shape) -> None:
    """Write all samples within the step in the workspace, of which there is one at least.

    Returns `ELSEWHERE` where one of them cannot be evaluated, with all as it was.
    """
    memory, rows = StepMemory(code, shape), len(tableau.extended_c)
    t, h, end = (memory.pace(entry) for entry in (FROM, LENGTH, TO))
    forward = code.compare("oge", h, code.constant(0.0))
    counted = whole_row(code, memory["counters"], EVALUATIONS)
    taken = whole_row(code, memory["counters"], SAMPLES)
    first = memory.pace(SAMPLE)
    reached, last = memory.row(tableau.stages), memory.row(rows)
    fail = code.new_label("fail")
    further = rows - 1 - tableau.stages
    loop = PrintedLoop(code, [("i64", code.whole(0))])
    time = memory.pace(SAMPLE)
    at_end, between, evaluate, write = (
        code.new_label(name) for name in ("end", "between", "evaluate", "write")
    )
    code.branch(code.compare("oeq", time, end), at_end, between)
    code.begin(at_end)
    write_expected(code, shape, memory, h, end_weights(code, tableau))
    code.say(f"br label %{write}")
    code.begin(between)
    compute = code.new_label("compute")
    done = code.give(f"icmp eq i64 {loop.values[0]}, 0")
    code.branch(done, compute, evaluate)
    code.begin(compute)
    _continue_if_zero(code, code.give("call i64 @further(ptr %frame)"), fail)
    _count(code, memory, further)
    code.say(f"br label %{evaluate}")
    code.begin(evaluate)
    part = code.divide(code.subtract(time, t), h)
    memory.set_pace(smaller(code, part, code.constant(1.0)), THETA)
    code.say("call i64 @interpolate(ptr %frame)")
    _count(code, memory, 1)
    _continue_if_zero(code, call_clock(code, memory, time), fail)
    _continue_if_zero(code, call_rates(code, memory, rows, shape.n), fail)
    if shape.counted:
        weights = _dense_weights(code, tableau, memory.pace(THETA))
        write_expected(code, shape, memory, h, weights)
    inside = code.block
    code.say(f"br label %{write}")
    code.begin(write)
    row = code.give(f"phi ptr [ {reached}, %{at_end} ], [ {last}, %{inside} ]")
    known = code.give(f"phi i64 [ {loop.values[0]}, %{at_end} ], [ 1, %{inside} ]")
    code.say(f"call i64 @sample(ptr %frame, ptr {row})")
    left = code.subtract(end, memory.pace(SAMPLE))
    left = code.select(forward, left, code.negate(left))
    loop.repeat(code.compare("oge", left, code.constant(0.0)), [known])
    code.say("ret i64 0")
    code.begin(fail)
    set_whole(code, counted, memory["counters"], EVALUATIONS)
    set_whole(code, taken, memory["counters"], SAMPLES)
    memory.set_pace(first, SAMPLE)
    code.say(f"ret i64 {ELSEWHERE}")


def write_begin(code: Instructions, shape: Shape) -> None:
    """Write the start of a motion: row 0 is evaluated, and the first step chosen.

    Returns `ELSEWHERE` where anything is not as it should be, with nothing counted.
    """
    memory = StepMemory(code, shape)
    code.require(is_sound(code, shape, memory.row(0), 2 * shape.n), ELSEWHERE)
    for i in range(shape.n):
        if shape.rotates[i]:
            wrap(code, memory.row(0), i, memory["turns"])
    t, end = memory.pace(T), memory.pace(END)
    _require_zero(code, call_clock(code, memory, t), ELSEWHERE)
    _require_zero(code, call_rates(code, memory, 0, shape.n), ELSEWHERE)
    code.require(is_sound(code, shape, memory.row(0), 3 * shape.n), ELSEWHERE)
    code.require(_margins_are_fine(code, shape, memory), ELSEWHERE)
    _count(code, memory, 1)
    for i in range(shape.counted):
        code.store(code.load(memory["angles"], i), memory["ahead"], i)
    write_counted(code, shape, memory, memory.row(0), memory["angles"])
    sampled, on = code.new_label("sampled"), code.new_label("on")
    code.branch(code.compare("oeq", memory.pace(SAMPLE), t), sampled, on)
    code.begin(sampled)
    code.say(f"call i64 @sample(ptr %frame, ptr {memory.row(0)})")
    code.say(f"br label %{on}")
    code.begin(on)
    code.require(code.compare("une", t, end), 0)
    _count(code, memory, 1)
    code.say("call i64 @first(ptr %frame)")
    memory.set_pace(code.absolute(memory.pace(H)), FIRST)
    memory.set_pace(code.constant(1.0), BEFORE)
    code.say("ret i64 0")


def write_first(code: Instructions, shape: Shape, order: int) -> None:
    """Write the length of the first step to the last time, by Hairer, Nørsett & Wanner, II.4.

    Row 0 has been evaluated; row 1 is written. `order` is that of the error estimate.
    """
    memory, n = StepMemory(code, shape), shape.n
    t, span = memory.pace(T), code.subtract(memory.pace(END), memory.pace(T))
    most = code.absolute(span)
    memory.set_pace(span, H)
    if not n:
        code.say("ret i64 0")
        return
    begun, slopes, target = memory.row(0), memory.row(0, n), memory.row(1)
    d0 = _norm(code, shape, memory, lambda i: code.load(begun, i))
    d1 = _norm(code, shape, memory, lambda i: code.load(slopes, i))
    small = code.constant(1e-5)
    tiny = code.any_of(code.compare("olt", d0, small), code.compare("olt", d1, small))
    length = code.divide(code.multiply(code.constant(0.01), d0), d1)
    length = smaller(code, code.select(tiny, code.constant(1e-6), length), most)
    h = code.call("llvm.copysign", length, span)

    def entry(i: int | str, _: list[str]) -> list[str]:
        code.store(code.fused(h, code.load(slopes, i), code.load(begun, i)), target, i)
        return []

    fold(code, 2 * n, (), entry)
    memory.set_pace(code.multiply(code.constant(0.1), h), H)
    _require_zero(code, call_clock(code, memory, code.add(t, h)), 0)
    _require_zero(code, call_rates(code, memory, 1, n), 0)
    code.require(is_sound(code, shape, target, 3 * n), 0)
    beyond = memory.row(1, n)
    d2 = _norm(
        code, shape, memory, lambda i: code.subtract(code.load(beyond, i), code.load(slopes, i))
    )
    largest = larger(code, d1, code.divide(d2, length))
    other = larger(code, code.constant(1e-6), code.multiply(code.constant(1e-3), length))
    power = binary_logarithm(code, code.divide(code.constant(0.01), largest))
    root = binary_power(code, code.multiply(code.constant(1.0 / (order + 1)), power))
    known = code.compare("ogt", largest, code.constant(1e-15))
    other = smaller(code, code.select(known, root, other), most)
    other = smaller(code, code.multiply(code.constant(100.0), length), other)
    memory.set_pace(code.call("llvm.copysign", other, span), H)
    code.say("ret i64 0")


def _norm(
    code: Instructions, shape: Shape, memory: StepMemory, value: Callable[[int | str], str]
) -> str:
    """Root mean square of some numbers in units of the tolerance at row 0."""
    begun, rtol = memory.row(0), memory.pace(RTOL)

    def entry(i: int | str, values: list[str]) -> list[str]:
        size = code.absolute(code.load(begun, i))
        unit = code.fused(rtol, size, code.load(memory["atol"], i))
        scaled = code.divide(value(i), unit)
        return [code.fused(scaled, scaled, values[0])]

    (total,) = fold(code, 2 * shape.n, [code.constant(0.0)], entry)
    return code.call("llvm.sqrt", code.divide(total, code.constant(2.0 * shape.n)))


def _margins_are_fine(code: Instructions, shape: Shape, memory: StepMemory) -> str:
    """Whether no margin in row 0 is too small; see `loops.margins.is_too_small`."""
    margins, rates = memory.row(0, shape.margins), memory.row(0, shape.margins + shape.blocks)
    span = code.subtract(memory.pace(END), memory.pace(T))

    def block(i: int | str, values: list[str]) -> list[str]:
        margin = code.load(margins, i)
        size, rate = code.absolute(margin), code.multiply(code.load(rates, i), span)
        least = code.multiply(code.constant(LEAST_MARGIN), code.load(memory["scale"], i))
        falling = code.compare("ole", code.multiply(margin, rate), code.constant(0.0))
        early = code.compare("olt", size, code.load(memory["smallest"], i))
        small = code.any_of(code.compare("olt", size, least), code.all_of([falling, early]))
        return [code.select(small, code.constant(1.0), values[0])]

    (found,) = fold(code, shape.blocks, [code.constant(0.0)], block)
    return code.compare("oeq", found, code.constant(0.0))


def _require_zero(code: Instructions, status: str, otherwise: int) -> None:
    """Return a number where a status is not 0."""
    code.require(code.give(f"icmp eq i64 {status}, 0"), otherwise)


def _continue_if_zero(code: Instructions, status: str, fail: str) -> None:
    """Go to another block where a status is not 0."""
    on = code.new_label("on")
    code.branch(code.give(f"icmp eq i64 {status}, 0"), on, fail)
    code.begin(on)


def _count(code: Instructions, memory: StepMemory, evaluations: int) -> None:
    """Count evaluations."""
    before = whole_row(code, memory["counters"], EVALUATIONS)
    after = code.on_integers("add", before, code.whole(evaluations))
    set_whole(code, after, memory["counters"], EVALUATIONS)


def write_step(tableau: Tableau, shape: Shape, gain: float = 0.0, lanes: int = 1) -> str:
    """The text of a module with the functions of a step, which take the address of a frame.

    ``int64 attempt(frame)`` steps from row 0 to the end, over a time in the pace, and returns a
    status; ``int64 further(frame)`` computes the further rows of the dense output. Tableaus with an
    error estimate have ``int64 advance(frame, ticks)``, which goes on until a step needs more than
    arithmetic, and returns the number of trials in the upper half, below a bit for each lane that
    does. All arrays of several lanes consist of rows of W entries, their statuses stand in the
    pace, and ``int64 between(frame)`` evaluates states within a step.

    Parameters
    ----------
    tableau, shape
        Of the step.
    """
    module = Module(lanes)
    rows, last = len(tableau.extended_c) - 1, tableau.stages
    for name, first, end in (("attempt", 1, last), ("further", last + 1, rows)):
        code = module.instructions()
        memory = StepMemory(code, shape)
        status = Stages(code, tableau, shape, memory).write(first, end)
        if lanes == 1:
            code.say("ret i64 0")
            module.define(f"i64 @{name}(ptr %frame)", code)
        else:
            set_whole(code, status, memory["pace"], STATUS)
            code.say("ret i64 0")
            module.define(f"i64 @{name}(ptr %frame)", code)
    if lanes == 1:
        _single(module, tableau, shape)
    else:
        code = module.instructions()
        write_between(code, tableau, shape)
        module.define("i64 @between(ptr %frame)", code)
    if tableau.error.size:
        code = module.instructions()
        Advance(code, tableau, shape, gain).write()
        module.define("i64 @advance(ptr %frame, i64 %ticks)", code)
    return module.text


def _single(module: Module, tableau: Tableau, shape: Shape) -> None:
    """What a single motion has beside its steps."""
    code = module.instructions()
    write_interpolation(code, tableau, shape)
    module.define("i64 @interpolate(ptr %frame)", code)
    _start(module, shape, tableau.error_order)
    code = module.instructions()
    write_samples(code, tableau, shape)
    module.define("internal i64 @samples(ptr %frame)", code)
    code = module.instructions()
    write_begin(code, shape)
    module.define("i64 @begin(ptr %frame)", code)


def _start(module: Module, shape: Shape, order: int) -> None:
    """The first step and samples, which are those of any method."""
    code = module.instructions()
    write_first(code, shape, order)
    module.define("i64 @first(ptr %frame)", code)
    code = module.instructions()
    write_sample(code, shape)
    module.define("i64 @sample(ptr %frame, ptr %row)", code)


@lru_cache(maxsize=256)
def compiled_start(shape: Shape, order: int) -> MachineCode:
    """The first step and samples of a method that brings its own steps, as machine code."""
    module = Module(1)
    _start(module, shape, order)
    return MachineCode(module.text)


@lru_cache(maxsize=256)
def compiled_step(tableau: Tableau, shape: Shape, gain: float = 0.0, lanes: int = 1) -> MachineCode:
    """The functions of a step as machine code; see `write_step`."""
    return MachineCode(write_step(tableau, shape, gain, lanes))
