"""Steps one after the other, written out, until one of them needs more than arithmetic.

A lane whose step does raises its flag with its state unchanged: where something watches the motion,
a singular position may lie ahead, a block cannot be assembled, or the step has become too small.
That step is finished by the loop of the motion itself. Of several lanes, one with a sample within
its step does so only where something watches it, or dependent angles are counted; other samples are
taken by `linkages.solvers.loops.lane_loop.sample_lanes`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from linkages.kernel.code.instructions import PrintedLoop
from linkages.kernel.code.operands import (
    Real,
    Truth,
    Whole,
    choose,
    choose_of,
    fused,
    larger_of,
    smaller_of,
)
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.flow import LONGEST, MOST_DOUBT
from linkages.solvers.loops.control import SHRINK_TURNING, Judged, judge
from linkages.solvers.loops.memory import (
    ACCEPTED,
    ACTIVE,
    ALWAYS,
    BEFORE,
    CARRY,
    END,
    ERROR,
    FACTOR,
    FIRST,
    FROM,
    HALF,
    LARGEST_STATE,
    LENGTH,
    NEXT_CARRY,
    PLAIN,
    QUARTER,
    REJECTED_BEFORE,
    REJECTIONS,
    RTOL,
    SAMPLE,
    SMALLEST_STEP,
    STATUS,
    TAKEN,
    TO,
    TROUBLE,
    H,
    T,
)
from linkages.solvers.loops.predicates import (
    CrossedLevels,
    Modes,
    is_small,
    passes_zero,
    write_counted,
    write_expected,
)
from linkages.solvers.loops.shape import Shape, StepMemory, wrap
from linkages.solvers.tableau import Tableau

# With room for round-off: what watches tangents decides.
DOUBT, LONG = 0.9 * MOST_DOUBT, 0.9 * LONGEST


class Trial(NamedTuple):
    """Times of a step that is tried: lengths, and the least length that moves time reliably."""

    h: Real
    end: Real
    carry: Real
    finest: Real


class Advance:
    """Writes the function that makes steps.

    Parameters
    ----------
    code, tableau, shape
        Where, and of what.
    gain
        As `linkages.solvers.loops.control.next_factor` has it.
    """

    def __init__(self, code: Procedure, tableau: Tableau, shape: Shape, gain: float) -> None:
        self._code, self._tableau, self._shape, self._gain = code, tableau, shape, gain
        self._memory = StepMemory(code, shape)
        self._pace, self._statuses = self._memory["pace"], self._memory.integers("pace")
        self._levels = CrossedLevels(tableau, shape, self._memory)

    def write(self) -> None:
        """Write a loop over at most ``%ticks`` trials.

        Returns bits of the lanes with a flag, from bit `QUARTER` on those of lanes whose deviation
        vectors must be renormalised after samples, and in the upper half the number of trials.
        """
        code, pace = self._code, self._pace
        loop = PrintedLoop(code, [("i64", "0")])
        trial = self._begin()
        status = self._attempt()
        judged = judge(self._tableau, self._shape, self._memory, self._gain)
        sound = status == 0
        accepted, active = sound & judged.accepted, pace[ACTIVE] > 0.0
        modes = Modes(self._tableau, self._shape, self._memory, trial.h)
        flagged, halved = self._needs_more(modes, trial, judged, sound, accepted)
        flagged, halved = active & flagged, active & halved
        sampled = active & self._is_sampled(trial) & accepted & ~halved
        pace[ERROR], pace[FACTOR] = judged.error, judged.factor
        pace[ACCEPTED] = choose_of(Real, accepted, 1.0, 0.0)
        flagged = self._sample(sampled, flagged)
        observed = sampled & ~flagged if code.lanes > 1 and self._shape.tangents[0] else None
        self._statuses[STATUS] = status
        goes_on = active & ~flagged
        factor = choose(halved, SHRINK_TURNING, judged.factor)
        accepted = accepted & ~halved
        modes.halve(halved, goes_on & accepted)
        self._go_on(trial, judged._replace(factor=factor), accepted, goes_on)
        (tick,) = loop.values
        following = code.give(f"add i64 {tick}, 1")
        more = code.give(f"icmp ult i64 {following}, %ticks")
        halts = flagged | (active & (pace[T] == pace[END]))
        if observed is not None:
            halts = halts | observed
        calm = code.give(f"xor i1 {code.in_any_lane(halts.text)}, true")
        loop.repeat(code.give(f"and i1 {more}, {calm}"), [following])
        ticks = code.give(f"shl i64 {following}, {HALF}")
        found = code.give(f"or i64 {ticks}, {self._bits(flagged)}")
        if observed is not None:
            renormalised = code.give(f"shl i64 {self._bits(observed)}, {QUARTER}")
            found = code.give(f"or i64 {found}, {renormalised}")
        code.say(f"ret i64 {found}")

    def _bits(self, where: Truth) -> str:
        """Some lanes as bits of an integer."""
        code, bits = self._code, where.text
        if code.lanes > 1:
            bits = code.give(f"bitcast {code.truth} {bits} to i{code.lanes}")
        return code.give(f"zext i{code.lanes} {bits} to i64")

    def _attempt(self) -> Whole:
        """Try the step; returns the statuses."""
        found = self._code.give("call i64 @attempt(ptr %frame)")
        return Whole(self._code, found) if self._code.lanes == 1 else self._statuses[STATUS]

    def _begin(self) -> Trial:
        """The times of the next trial, summed with compensation: `CARRY` is what t is too large by.

        One that would end just before the last time ends there.
        """
        pace = self._pace
        t, carry, h, last = (pace[entry] for entry in (T, CARRY, H, END))
        moved = h - carry
        end = t + moved
        next_carry = (end - t) - moved
        remaining = (last - t) + carry
        ends = 1.01 * abs(h) >= abs(remaining)
        h, end = choose(ends, remaining, h), choose(ends, last, end)
        next_carry = choose(ends, 0.0, next_carry)
        for value, entry in ((t, FROM), (h, LENGTH), (end, TO), (next_carry, NEXT_CARRY)):
            pace[entry] = value
        return Trial(h, end, next_carry, SMALLEST_STEP * larger_of(abs(t), pace[FIRST]))

    def _needs_more(
        self, modes: Modes, trial: Trial, judged: Judged, sound: Truth, accepted: Truth
    ) -> tuple[Truth, Truth]:
        """In which lanes the step must be finished elsewhere, and in which it is to be halved."""
        special = self._margins_fall(trial) | self._tangents_fade()
        special = special | self._levels.need_more(trial.h, trial.end)
        small = abs(trial.h * judged.factor) < trial.finest
        found = choose(accepted, special, small) | ~sound | (self._pace[ALWAYS] > 0.0)
        looked, too_long = modes.need_more(accepted)
        halved = too_long & ~found & (abs(trial.h * SHRINK_TURNING) >= trial.finest)
        return found | (looked & ~halved), halved

    def _is_sampled(self, trial: Trial) -> Truth:
        """In which lanes a sample lies within the step."""
        left = trial.end - self._pace[SAMPLE]
        return choose(trial.h >= 0.0, left, -left) >= 0.0

    def _sample(self, sampled: Truth, flagged: Truth) -> Truth:
        """Take samples; returns the flags, raised where that takes more than arithmetic.

        That is where dependent angles are counted in several lanes, or a single motion is watched.
        """
        code = self._code
        if code.lanes > 1 and self._shape.counted:
            return sampled | flagged
        own = sampled & ~flagged
        if code.lanes == 1:
            own = own & (self._pace[PLAIN] > 0.0)
        refused = code.variable(False)
        with code.when(own):
            refused.set(self._take(own))
        return flagged | (sampled & ~own) | refused

    def _take(self, own: Truth) -> Truth:
        """Take samples in some lanes; returns where one cannot be evaluated."""
        code, memory = self._code, self._memory
        if code.lanes == 1:
            return Whole(code, code.give("call i64 @samples(ptr %frame)")) != 0
        sampler, lanes = memory["sampler"].pointer, memory["lanes"].pointer
        found = code.give(f"call i64 {sampler}(ptr {lanes}, i64 {self._bits(own)})")
        found = code.give(f"trunc i64 {found} to i{code.lanes}")
        return Truth(code, code.give(f"bitcast i{code.lanes} {found} to {code.truth}"))

    def _margins_fall(self, trial: Trial) -> Truth:
        """Whether a margin is too small at the end, or may have passed through zero on the way."""
        code, memory, shape = self._code, self._memory, self._shape
        scale, smallest, found = memory["scale"], memory["smallest"], code.variable(False)
        first, last = (memory.row(row, shape.margins) for row in (0, self._tableau.stages))
        fall, rise = (margins.after(shape.blocks) for margins in (first, last))
        for i in code.entries(shape.blocks):
            change = rise[i] * trial.h
            passes = passes_zero(first[i], fall[i] * trial.h, last[i], change)
            found.set(found | passes | is_small(last[i], change, scale[i], smallest[i]))
        return found

    def _tangents_fade(self) -> Truth:
        """Whether errors of steps may come to show in the shortest tangent at the end.

        Or one may be too long. Only what watches tangents knows. One that a contact has taken away
        is zero, and no matter.
        """
        code, shape = self._code, self._shape
        if not shape.tangents[0]:
            return code.value(False)
        least, longest = code.value(LARGEST_STATE), code.value(0.0)
        for square in self._squares():
            least = smaller_of(least, choose(square > 0.0, square, LARGEST_STATE))
            longest = larger_of(longest, square)
        rtol, atol = self._pace[RTOL], self._memory["atol"][2 * shape.n - 1]
        doubt = larger_of(rtol * rtol * longest, atol * atol)
        return (doubt > DOUBT**2 * least) | (longest > LONG**2)

    def _squares(self) -> Iterator[Real]:
        """Squared lengths of tangents at the end, each less its parts along those before it."""
        shape, end = self._shape, self._memory.row(self._tableau.stages)
        columns, size, placed, orthogonal = shape.tangents
        before: list[tuple[list[Real], Real]] = []
        for column in range(columns):
            first = shape.n - (columns - column) * size
            rates = range(shape.n + first, shape.n + first + size)
            values = [end[place] for place in (*range(first, first + placed), *rates)]
            for others, square in before:
                part = -choose(square > 0.0, product(others, values) / square, 0.0)
                pairs = zip(others, values, strict=True)
                values = [fused(part, other, value) for other, value in pairs]
            square = product(values, values)
            if orthogonal:
                before.append((values, square))
            yield square

    def _go_on(self, trial: Trial, judged: Judged, accepted: Truth, goes_on: Truth) -> None:
        """Make the end of accepted steps the start of the next ones; try others again."""
        pace, commits, rejects = self._pace, goes_on & accepted, goes_on & ~accepted
        again = (pace[REJECTED_BEFORE] > 0.0) & accepted
        grown = choose(again, smaller_of(judged.factor, 1.0), judged.factor)
        rejected = choose_of(Real, accepted, 0.0, 1.0)
        for where, value, entry in (
            (goes_on, trial.h * grown, H), (commits, trial.end, T), (commits, trial.carry, CARRY),
            (commits, judged.error, BEFORE), (commits, 0.0, TROUBLE),
            (goes_on, rejected, REJECTED_BEFORE), (commits, pace[TAKEN] + 1.0, TAKEN),
            (rejects, pace[REJECTIONS] + 1.0, REJECTIONS),
        ):  # fmt: skip
            pace[entry] = choose(where, value, pace[entry])
        self._levels.keep(commits, trial.end)
        self._commit(commits)

    def _commit(self, where: Truth) -> None:
        """Copy the end of the step into row 0, in some lanes; see `step_loop.commit`."""
        code, memory, shape = self._code, self._memory, self._shape
        start, end = memory.row(0), memory.row(self._tableau.stages)
        if shape.counted:
            with code.when(where):
                write_expected(shape, memory, self._pace[LENGTH], self._tableau.b.tolist())
                write_counted(shape, memory, end, memory["angles"], where)
        for i in code.entries(shape.width):
            start[i] = choose(where, end[i], start[i])
        for i in range(shape.carried):
            for half, found in ((0, 0), (shape.n, shape.carried)):
                place = half + shape.first_carried + i
                start[place] = choose(where, end[shape.settled + found + i], start[place])
        for i in range(shape.n):
            if shape.rotates[i]:
                wrap(start, memory.integers("turns"), i, where)


def product(one: Sequence[Real], other: Sequence[Real]) -> Real:
    """The scalar product."""
    total = one[0].code.value(0.0)
    for a, b in zip(one, other, strict=True):
        total = fused(a, b, total)
    return total
