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

from linkages.kernel.code.instructions import Instructions, PrintedLoop
from linkages.kernel.dyads import LEAST_MARGIN
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
    LARGEST_STATE,
    LENGTH,
    NEXT_CARRY,
    PLAIN,
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
    end_weights,
    write_counted,
    write_expected,
)
from linkages.solvers.loops.scalar_stages import HALF, QUARTER
from linkages.solvers.loops.shape import (
    Shape,
    StepMemory,
    fold,
    larger,
    set_whole,
    smaller,
    whole_row,
    wrap,
)
from linkages.solvers.tableau import Tableau

# The sine is concave on both sides of zero: over MOST_CHANGE, tan(x)/x stays below this.
CONCAVITY = 1.1
# With room for round-off: what watches tangents decides.
DOUBT, LONG = 0.9 * MOST_DOUBT, 0.9 * LONGEST


class Trial(NamedTuple):
    """Times of a step that is tried: lengths, and the least length that moves time reliably."""

    h: str
    end: str
    carry: str
    finest: str
    forward: str


class Advance:
    """Writes the function that makes steps.

    Parameters
    ----------
    code, tableau, shape
        Where, and of what.
    gain
        As `linkages.solvers.loops.control.next_factor` has it.
    """

    def __init__(self, code: Instructions, tableau: Tableau, shape: Shape, gain: float) -> None:
        self._code, self._tableau, self._shape, self._gain = code, tableau, shape, gain
        self._memory = StepMemory(code, shape)
        self._levels = CrossedLevels(code, tableau, shape, self._memory)

    def write(self) -> None:
        """Write a loop over at most ``%ticks`` trials.

        Returns bits of the lanes with a flag, from bit `QUARTER` on those of lanes whose deviation
        vectors must be renormalised after samples, and in the upper half the number of trials.
        """
        code, memory = self._code, self._memory
        loop = PrintedLoop(code, [("i64", "0")])
        trial = self._begin()
        status = self._attempt()
        judged = judge(code, self._tableau, self._shape, memory, self._gain)
        sound = code.give(f"icmp eq {code.integer} {status}, {code.whole(0)}")
        accepted = code.all_of([sound, judged.accepted])
        active = self._above(ACTIVE)
        modes = Modes(code, self._tableau, self._shape, memory, trial.h)
        flagged, halved = self._needs_more(modes, trial, judged, sound, accepted)
        flagged, halved = (code.all_of([active, where]) for where in (flagged, halved))
        sampled = code.all_of([active, self._is_sampled(trial), accepted, code.opposite(halved)])
        memory.set_pace(judged.error, ERROR)
        memory.set_pace(judged.factor, FACTOR)
        memory.set_pace(code.select(accepted, code.constant(1.0), code.constant(0.0)), ACCEPTED)
        flagged = self._sample(sampled, flagged)
        observed = None
        if code.lanes > 1 and self._shape.tangents[0]:
            observed = code.all_of([sampled, code.opposite(flagged)])
        set_whole(code, status, memory["pace"], STATUS)
        goes_on = code.all_of([active, code.opposite(flagged)])
        factor = code.select(halved, code.constant(SHRINK_TURNING), judged.factor)
        accepted = code.all_of([accepted, code.opposite(halved)])
        modes.halve(halved, code.all_of([goes_on, accepted]))
        self._go_on(trial, judged._replace(factor=factor), accepted, goes_on)
        (tick,) = loop.values
        following = code.give(f"add i64 {tick}, 1")
        more = code.give(f"icmp ult i64 {following}, %ticks")
        ended = code.compare("oeq", memory.pace(T), memory.pace(END))
        halts = code.any_of(flagged, code.all_of([active, ended]))
        if observed is not None:
            halts = code.any_of(halts, observed)
        calm = code.give(f"xor i1 {code.in_any_lane(halts)}, true")
        loop.repeat(code.give(f"and i1 {more}, {calm}"), [following])
        ticks = code.give(f"shl i64 {following}, {HALF}")
        found = code.give(f"or i64 {ticks}, {self._bits(flagged)}")
        if observed is not None:
            renormalised = code.give(f"shl i64 {self._bits(observed)}, {QUARTER}")
            found = code.give(f"or i64 {found}, {renormalised}")
        code.say(f"ret i64 {found}")

    def _bits(self, where: str) -> str:
        """Some lanes as bits of an integer."""
        code = self._code
        if code.lanes > 1:
            where = code.give(f"bitcast {code.truth} {where} to i{code.lanes}")
        return code.give(f"zext i{code.lanes} {where} to i64")

    def _above(self, entry: int) -> str:
        """Whether an entry of the pace is above zero."""
        return self._code.compare("ogt", self._memory.pace(entry), self._code.constant(0.0))

    def _attempt(self) -> str:
        """Try the step; returns the statuses."""
        code = self._code
        if code.lanes == 1:
            return code.give("call i64 @attempt(ptr %frame)")
        code.say("call i64 @attempt(ptr %frame)")
        return whole_row(code, self._memory["pace"], STATUS)

    def _begin(self) -> Trial:
        """The times of the next trial, summed with compensation: `CARRY` is what t is too large by.

        One that would end just before the last time ends there.
        """
        code, memory = self._code, self._memory
        t, carry, h, last = (memory.pace(entry) for entry in (T, CARRY, H, END))
        moved = code.subtract(h, carry)
        end = code.add(t, moved)
        next_carry = code.subtract(code.subtract(end, t), moved)
        remaining = code.add(code.subtract(last, t), carry)
        longer = code.multiply(code.constant(1.01), code.absolute(h))
        ends = code.compare("oge", longer, code.absolute(remaining))
        h = code.select(ends, remaining, h)
        end = code.select(ends, last, end)
        next_carry = code.select(ends, code.constant(0.0), next_carry)
        size = larger(code, code.absolute(t), memory.pace(FIRST))
        finest = code.multiply(code.constant(SMALLEST_STEP), size)
        for value, entry in ((t, FROM), (h, LENGTH), (end, TO), (next_carry, NEXT_CARRY)):
            memory.set_pace(value, entry)
        forward = code.compare("oge", h, code.constant(0.0))
        return Trial(h, end, next_carry, finest, forward)

    def _needs_more(
        self, modes: Modes, trial: Trial, judged: Judged, sound: str, accepted: str
    ) -> tuple[str, str]:
        """In which lanes the step must be finished elsewhere, and in which it is to be halved."""
        code = self._code
        special = code.any_of(self._margins_fall(trial), self._tangents_fade())
        special = code.any_of(special, self._levels.need_more(trial.h, trial.end))
        shorter = code.absolute(code.multiply(trial.h, judged.factor))
        small = code.compare("olt", shorter, trial.finest)
        found = code.select(accepted, special, small, code.truth)
        found = code.any_of(code.any_of(found, code.opposite(sound)), self._above(ALWAYS))
        looked, too_long = modes.need_more(accepted)
        half = code.absolute(code.multiply(trial.h, code.constant(SHRINK_TURNING)))
        possible = code.compare("oge", half, trial.finest)
        halved = code.all_of([too_long, code.opposite(found), possible])
        return code.any_of(found, code.all_of([looked, code.opposite(halved)])), halved

    def _is_sampled(self, trial: Trial) -> str:
        """In which lanes a sample lies within the step."""
        code = self._code
        left = code.subtract(trial.end, self._memory.pace(SAMPLE))
        left = code.select(trial.forward, left, code.negate(left))
        return code.compare("oge", left, code.constant(0.0))

    def _sample(self, sampled: str, flagged: str) -> str:
        """Take samples; returns the flags, raised where that takes more than arithmetic.

        That is where dependent angles are counted in several lanes, or a single motion is watched.
        """
        code = self._code
        if code.lanes > 1 and self._shape.counted:
            return code.any_of(sampled, flagged)
        own = code.all_of([sampled, code.opposite(flagged)])
        if code.lanes == 1:
            own = code.all_of([own, self._above(PLAIN)])
        elsewhere = code.all_of([sampled, code.opposite(own)])
        take, on, before = code.new_label("take"), code.new_label("on"), code.block
        code.branch(code.in_any_lane(own), take, on)
        code.begin(take)
        failed = self._taken(own)
        code.say(f"br label %{on}")
        code.begin(on)
        none = "false" if code.lanes == 1 else "zeroinitializer"
        refused = code.give(f"phi {code.truth} [ {none}, %{before} ], [ {failed}, %{take} ]")
        return code.any_of(code.any_of(flagged, elsewhere), refused)

    def _taken(self, own: str) -> str:
        """Take samples in some lanes; returns where one cannot be evaluated."""
        code, memory = self._code, self._memory
        if code.lanes == 1:
            status = code.give("call i64 @samples(ptr %frame)")
            return code.give(f"icmp ne i64 {status}, 0")
        narrow = f"i{code.lanes}"
        bits = code.give(f"bitcast {code.truth} {own} to {narrow}")
        bits = code.give(f"zext {narrow} {bits} to i64")
        called = f"{memory['sampler']}(ptr {memory['lanes']}, i64 {bits})"
        found = code.give(f"call i64 {called}")
        found = code.give(f"trunc i64 {found} to {narrow}")
        return code.give(f"bitcast {narrow} {found} to {code.truth}")

    def _margins_fall(self, trial: Trial) -> str:
        """Whether a margin is too small at the end, or may have passed through zero on the way."""
        code, memory, shape = self._code, self._memory, self._shape
        end, zero, one = self._tableau.stages, code.constant(0.0), code.constant(1.0)
        first, last = (memory.row(row, shape.margins) for row in (0, end))
        rates = [memory.row(row, shape.margins + shape.blocks) for row in (0, end)]

        def block(i: int | str, values: list[str]) -> list[str]:
            before, after = (code.load(row, i) for row in (first, last))
            fall, rise = (code.multiply(code.load(row, i), trial.h) for row in rates)
            side = code.compare("oge", before, zero)
            slope = code.constant(CONCAVITY)
            ahead = code.fused(slope, fall, before)
            behind = code.fused(code.negate(slope), rise, after)
            both = [code.select(side, value, code.negate(value)) for value in (ahead, behind)]
            crossed = code.all_of([code.compare("olt", value, zero) for value in both])
            size = code.absolute(after)
            least = code.multiply(code.constant(LEAST_MARGIN), code.load(memory["scale"], i))
            singular = code.compare("olt", size, least)
            falling = code.compare("olt", code.multiply(after, rise), zero)
            early = code.compare("olt", size, code.load(memory["smallest"], i))
            singular = code.any_of(singular, code.all_of([falling, early]))
            return [code.select(code.any_of(crossed, singular), one, values[0])]

        (found,) = fold(code, shape.blocks, [zero], block)
        return code.compare("ogt", found, zero)

    def _tangents_fade(self) -> str:
        """Whether errors of steps may come to show in the shortest tangent at the end.

        Or one may be too long. Only what watches tangents knows. One that a contact has taken away
        is zero, and no matter.
        """
        code, memory, shape = self._code, self._memory, self._shape
        zero = code.constant(0.0)
        if not shape.tangents[0]:
            return code.compare("ogt", zero, zero)
        least, longest = code.constant(LARGEST_STATE), zero
        for square in self._squares():
            there = code.select(code.compare("ogt", square, zero), square, least)
            least, longest = smaller(code, least, there), larger(code, longest, square)
        rtol, atol = memory.pace(RTOL), code.load(memory["atol"], 2 * shape.n - 1)
        doubt = larger(
            code, code.multiply(code.multiply(rtol, rtol), longest), code.multiply(atol, atol)
        )
        fades = code.compare("ogt", doubt, code.multiply(code.constant(DOUBT**2), least))
        return code.any_of(fades, code.compare("ogt", longest, code.constant(LONG**2)))

    def _squares(self) -> Iterator[str]:
        """Squared lengths of tangents at the end, each less its parts along those before it."""
        code, shape = self._code, self._shape
        columns, size, placed, orthogonal = shape.tangents
        end, zero = self._memory.row(self._tableau.stages), code.constant(0.0)
        before: list[tuple[list[str], str]] = []
        for column in range(columns):
            first = shape.n - (columns - column) * size
            places = (
                *range(first, first + placed),
                *range(shape.n + first, shape.n + first + size),
            )
            values = [code.load(end, place) for place in places]
            for others, square in before:
                present = code.compare("ogt", square, zero)
                part = code.divide(self._product(others, values), square)
                part = code.negate(code.select(present, part, zero))
                pairs = zip(others, values, strict=True)
                values = [code.fused(part, other, value) for other, value in pairs]
            square = self._product(values, values)
            if orthogonal:
                before.append((values, square))
            yield square

    def _product(self, one: Sequence[str], other: Sequence[str]) -> str:
        code, total = self._code, self._code.constant(0.0)
        for a, b in zip(one, other, strict=True):
            total = code.fused(a, b, total)
        return total

    def _go_on(self, trial: Trial, judged: Judged, accepted: str, goes_on: str) -> None:
        """Make the end of accepted steps the start of the next ones; try others again."""
        code, memory = self._code, self._memory
        zero, one = code.constant(0.0), code.constant(1.0)
        commits = code.all_of([goes_on, accepted])
        rejects = code.all_of([goes_on, code.opposite(accepted)])
        again = self._above(REJECTED_BEFORE)
        cautious = code.select(code.compare("olt", judged.factor, one), judged.factor, one)
        grown = code.select(code.all_of([again, accepted]), cautious, judged.factor)
        self._keep(goes_on, code.multiply(trial.h, grown), H)
        for value, entry in (
            (trial.end, T), (trial.carry, CARRY), (judged.error, BEFORE), (zero, TROUBLE),
        ):  # fmt: skip
            self._keep(commits, value, entry)
        self._keep(goes_on, code.select(accepted, zero, one), REJECTED_BEFORE)
        for where, entry in ((commits, TAKEN), (rejects, REJECTIONS)):
            self._keep(where, code.add(memory.pace(entry), one), entry)
        self._levels.keep(commits, trial.end)
        self._commit(commits)

    def _keep(self, where: str, value: str, entry: int) -> None:
        """Set an entry of the pace in some lanes."""
        memory = self._memory
        memory.set_pace(self._code.select(where, value, memory.pace(entry)), entry)

    def _commit(self, where: str) -> None:
        """Copy the end of the step into row 0, in some lanes; see `commit.commit`."""
        code, memory, shape = self._code, self._memory, self._shape
        start, end = memory.row(0), memory.row(self._tableau.stages)
        if shape.counted:
            self._count_turns(where, end)

        def entry(i: int | str, _: list[str]) -> list[str]:
            code.store(code.select(where, code.load(end, i), code.load(start, i)), start, i)
            return []

        fold(code, shape.width, (), entry)
        for i in range(shape.carried):
            for half, found in ((0, 0), (shape.n, shape.carried)):
                value = code.load(end, shape.settled + found + i)
                place = half + shape.first_carried + i
                code.store(code.select(where, value, code.load(start, place)), start, place)
        for i in range(shape.n):
            if shape.rotates[i]:
                wrap(code, start, i, memory["turns"], where)

    def _count_turns(self, where: str, end: str) -> None:
        """Take dependent angles at the end of committed steps."""
        code, memory, shape = self._code, self._memory, self._shape
        count, on = code.new_label("count"), code.new_label("on")
        code.branch(code.in_any_lane(where), count, on)
        code.begin(count)
        weights = end_weights(code, self._tableau)
        write_expected(code, shape, memory, memory.pace(LENGTH), weights)
        write_counted(code, shape, memory, end, memory["angles"], where)
        code.say(f"br label %{on}")
        code.begin(on)
