"""Steps one after the other, written out, until one of them needs more than arithmetic.

A lane whose step does raises its flag with its state unchanged: where a sample lies within the
step, something watches every step, a singular position may lie ahead, a block cannot be assembled,
or the step has become too small. That step is finished by the loop of the motion itself.
"""

from __future__ import annotations

from typing import NamedTuple

from linkages.kernel.closure.dyads import LEAST_MARGIN
from linkages.kernel.code.instructions import Instructions, Loop
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.printed.control import Judged, judge
from linkages.solvers.printed.shape import Memory, Shape, fold, larger, set_whole, whole_row
from linkages.solvers.steps.views import (
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
    LENGTH,
    NEXT_CARRY,
    REJECTED_BEFORE,
    REJECTIONS,
    SAMPLE,
    SMALLEST_STEP,
    STATUS,
    TAKEN,
    TO,
    TROUBLE,
    TWO_PI,
    TWO_PI_TAIL,
    H,
    T,
)

# The sine is concave on both sides of zero: over MOST_CHANGE, tan(x)/x stays below this.
CONCAVITY = 1.1


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
        As `linkages.solvers.printed.control.next_factor` has it.
    """

    def __init__(self, code: Instructions, tableau: Tableau, shape: Shape, gain: float) -> None:
        self._code, self._tableau, self._shape, self._gain = code, tableau, shape, gain
        self._memory = Memory(code, shape)

    def write(self) -> None:
        """Write a loop over at most ``%ticks`` trials.

        Returned are bits of the lanes with a flag, and in the upper half the number of trials.
        """
        code, memory = self._code, self._memory
        loop = Loop(code, [("i64", "0")])
        trial = self._begin()
        status = self._attempt()
        judged = judge(code, self._tableau, self._shape, memory, self._gain)
        sound = code.give(f"icmp eq {code.integer} {status}, {code.whole(0)}")
        accepted = code.all_of([sound, judged.accepted])
        active = self._above(ACTIVE)
        flagged = code.all_of([active, self._needs_more(trial, judged, sound, accepted)])
        set_whole(code, status, memory["pace"], STATUS)
        memory.set_pace(judged.error, ERROR)
        memory.set_pace(judged.factor, FACTOR)
        memory.set_pace(code.select(accepted, code.constant(1.0), code.constant(0.0)), ACCEPTED)
        goes_on = code.all_of([active, code.opposite(flagged)])
        self._go_on(trial, judged, accepted, goes_on)
        (tick,) = loop.values
        following = code.give(f"add i64 {tick}, 1")
        more = code.give(f"icmp ult i64 {following}, %ticks")
        calm = code.give(f"xor i1 {code.in_any_lane(flagged)}, true")
        loop.repeat(code.give(f"and i1 {more}, {calm}"), [following])
        bits = flagged
        if code.lanes > 1:
            bits = code.give(f"bitcast {code.truth} {flagged} to i{code.lanes}")
        bits = code.give(f"zext i{code.lanes} {bits} to i64")
        ticks = code.give(f"shl i64 {following}, 32")
        code.say(f"ret i64 {code.give(f'or i64 {ticks}, {bits}')}")

    def _above(self, entry: int) -> str:
        """Whether an entry of the pace is above zero."""
        return self._code.compare("ogt", self._memory.pace(entry), self._code.constant(0.0))

    def _attempt(self) -> str:
        """Try the step; returns the statuses."""
        code = self._code
        if code.lanes == 1:
            return code.give("call i64 @attempt(ptr %frame)")
        code.say("call void @attempt(ptr %frame)")
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

    def _needs_more(self, trial: Trial, judged: Judged, sound: str, accepted: str) -> str:
        """In which lanes the step must be finished elsewhere."""
        code, memory = self._code, self._memory
        left = code.subtract(trial.end, memory.pace(SAMPLE))
        left = code.select(trial.forward, left, code.negate(left))
        sampled = code.compare("oge", left, code.constant(0.0))
        special = code.any_of(sampled, self._margins_fall(trial))
        shorter = code.absolute(code.multiply(trial.h, judged.factor))
        small = code.compare("olt", shorter, trial.finest)
        found = code.select(accepted, special, small, code.truth)
        return code.any_of(code.any_of(found, code.opposite(sound)), self._above(ALWAYS))

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
        self._commit(commits)

    def _keep(self, where: str, value: str, entry: int) -> None:
        """Set an entry of the pace in some lanes."""
        memory = self._memory
        memory.set_pace(self._code.select(where, value, memory.pace(entry)), entry)

    def _commit(self, where: str) -> None:
        """Copy the end of the step into row 0, in some lanes; see `commit.commit`."""
        code, memory, shape = self._code, self._memory, self._shape
        start, end = memory.row(0), memory.row(self._tableau.stages)

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
                self._wrap(where, start, i)

    def _wrap(self, where: str, start: str, i: int) -> None:
        """Bring a coordinate within one turn; see `turns.wrap_angles`."""
        code, memory = self._code, self._memory
        angle = code.load(start, i)
        beyond = code.compare("ogt", code.absolute(angle), code.constant(TWO_PI / 2))
        beyond = code.all_of([where, beyond])
        turns = code.call("llvm.rint", code.divide(angle, code.constant(TWO_PI)))
        turns = code.select(beyond, turns, code.constant(0.0))
        back = code.negate(turns)
        within = code.fused(back, code.constant(TWO_PI), angle)
        within = code.fused(back, code.constant(TWO_PI_TAIL), within)
        code.store(code.select(beyond, within, angle), start, i)
        whole = code.give(f"fptosi {code.number} {turns} to {code.integer}")
        before = whole_row(code, memory["turns"], i)
        set_whole(code, code.on_integers("add", before, whole), memory["turns"], i)
