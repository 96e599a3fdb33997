"""Fast path of the step loop, for one motion or several lanes.

It makes steps until one of them needs more than arithmetic: at an event or a mode switch, near a
singular position, where a block cannot be assembled, or where the step is too small. The lane then
raises its flag, and `step_loop` finishes that step for the motion alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from linkages.kernel.code.instructions import PhiLoop
from linkages.kernel.code.operands import (
    Bool,
    Int,
    Real,
    UniformInt,
    fma,
    maximum,
    minimum,
    select,
    select_of,
)
from linkages.solvers.flow import LONGEST, MOST_DOUBT
from linkages.solvers.loops.control import (
    SHRINK_TURNING,
    CrossedLevels,
    Judged,
    Modes,
    begin_trial,
    finest_step,
    is_small,
    judge,
    passes_zero,
    write_counted,
    write_expected,
)
from linkages.solvers.loops.memory import HALF, LARGEST_STATE, QUARTER
from linkages.solvers.loops.row_layout import RowLayout, StepMemory, wrap
from linkages.solvers.tableau import Collocation, Tableau

# With room for round-off: what watches tangents decides.
DOUBT, LONG = 0.9 * MOST_DOUBT, 0.9 * LONGEST


class Trial(NamedTuple):
    """A trial step: its length and end, what its end is too large by, and the shortest step."""

    h: Real
    end: Real
    carry: Real
    finest: Real


class Advance:
    """Writes the function that makes steps; `gain` is that of `control.next_factor`."""

    def __init__(
        self, memory: StepMemory, tableau: Tableau, layout: RowLayout, gain: float
    ) -> None:
        self._code, self._tableau, self._layout, self._gain = memory.code, tableau, layout, gain
        self._memory, self._stepper = memory, memory.stepper
        self._levels = CrossedLevels(tableau, layout, self._memory)

    def write(self) -> None:
        """Write a loop over at most ``%ticks`` trials.

        Returns bits of the lanes with a flag, from bit `QUARTER` on those of lanes whose deviation
        vectors must be renormalised after samples, and in the upper half the number of trials.
        """
        code, stepper = self._code, self._stepper
        loop = PhiLoop(code, [("i64", "0")])
        trial = Trial(*begin_trial(stepper), finest_step(stepper, stepper.t))
        status = self._attempt()
        judged = judge(self._tableau, self._layout, self._memory, self._gain)
        sound = status == 0
        accepted, active = sound & judged.accepted, stepper.active > 0.0
        modes = Modes(self._tableau, self._layout, self._memory, trial.h)
        flagged, halved = self._needs_more(modes, trial, judged, sound, accepted)
        flagged, halved = active & flagged, active & halved
        sampled = active & self._is_sampled(trial) & accepted & ~halved
        stepper.error, stepper.factor = judged.error, judged.factor
        stepper.accepted = select_of(Real, accepted, 1.0, 0.0)
        flagged = self._sample(sampled, flagged)
        observed = sampled & ~flagged if code.lanes > 1 and self._layout.tangents[0] else None
        self._memory.stepper.status = status
        goes_on = active & ~flagged
        factor = select(halved, SHRINK_TURNING, judged.factor)
        accepted = accepted & ~halved
        modes.halve(halved, goes_on & accepted)
        self._go_on(trial, judged._replace(factor=factor), accepted, goes_on)
        (tick,) = loop.values
        following = code.assign(f"add i64 {tick}, 1")
        more = code.assign(f"icmp ult i64 {following}, %ticks")
        halts = flagged | (active & (stepper.t == stepper.end))
        if observed is not None:
            halts = halts | observed
        calm = code.assign(f"xor i1 {code.any_lane(halts.text)}, true")
        loop.repeat(code.assign(f"and i1 {more}, {calm}"), [following])
        ticks = code.assign(f"shl i64 {following}, {HALF}")
        result = code.assign(f"or i64 {ticks}, {self._bits(flagged)}")
        if observed is not None:
            renormalised = code.assign(f"shl i64 {self._bits(observed)}, {QUARTER}")
            result = code.assign(f"or i64 {result}, {renormalised}")
        code.return_(UniformInt(code, result))

    def _bits(self, where: Bool) -> str:
        """Some lanes as bits of an integer."""
        code, bits = self._code, where.text
        if code.lanes > 1:
            bits = code.assign(f"bitcast {code.truth} {bits} to i{code.lanes}")
        return code.assign(f"zext i{code.lanes} {bits} to i64")

    def _attempt(self) -> Int:
        result = self._code.assign("call i64 @attempt(ptr %motion)")
        return Int(self._code, result) if self._code.lanes == 1 else self._memory.stepper.status

    def _needs_more(
        self, modes: Modes, trial: Trial, judged: Judged, sound: Bool, accepted: Bool
    ) -> tuple[Bool, Bool]:
        """In which lanes the step must be finished elsewhere, and in which it is to be halved."""
        special = self._margins_fall(trial) | self._tangents_fade()
        special = special | self._levels.need_more(trial.h, trial.end)
        small = abs(trial.h * judged.factor) < trial.finest
        result = select(accepted, special, small) | ~sound | (self._stepper.force_scalar > 0.0)
        looked, too_long = modes.need_more(accepted)
        halved = too_long & ~result & (abs(trial.h * SHRINK_TURNING) >= trial.finest)
        return result | (looked & ~halved), halved

    def _is_sampled(self, trial: Trial) -> Bool:
        """In which lanes a sample lies within the step."""
        left = trial.end - self._stepper.sample
        return select(trial.h >= 0.0, left, -left) >= 0.0

    def _sample(self, sampled: Bool, flagged: Bool) -> Bool:
        """Take samples; returns the flags, raised where that takes more than arithmetic.

        That is where dependent angles are counted in several lanes, or a single motion is watched.
        """
        code = self._code
        if code.lanes > 1 and self._layout.counted:
            return sampled | flagged
        own = sampled & ~flagged
        if code.lanes == 1:
            own = own & (self._stepper.unobserved > 0.0)
        refused = code.variable(False)
        with code.if_(own):
            refused.set(self._take(own))
        return flagged | (sampled & ~own) | refused

    def _take(self, own: Bool) -> Bool:
        """Take samples in some lanes; returns where one cannot be evaluated."""
        code = self._code
        if code.lanes == 1:
            return Int(code, code.assign("call i64 @samples(ptr %motion)")) != 0
        sampler = self._memory.sampler.pointer
        result = code.assign(f"call i64 {sampler}(ptr %motion, i64 {self._bits(own)})")
        result = code.assign(f"trunc i64 {result} to i{code.lanes}")
        return Bool(code, code.assign(f"bitcast i{code.lanes} {result} to {code.truth}"))

    def _margins_fall(self, trial: Trial) -> Bool:
        """Whether a margin is too small at the end, or may have passed through zero on the way."""
        code, memory, layout = self._code, self._memory, self._layout
        scale, smallest, result = memory.scale, memory.smallest, code.variable(False)
        first, last = (memory.row(row, layout.margins) for row in (0, self._tableau.stages))
        fall, rise = (margins.after(layout.blocks) for margins in (first, last))
        for i in code.for_entries(layout.blocks):
            change = rise[i] * trial.h
            passes = passes_zero(first[i], fall[i] * trial.h, last[i], change)
            result.set(result | passes | is_small(last[i], change, scale[i], smallest[i]))
        return result

    def _tangents_fade(self) -> Bool:
        """Whether errors may show in the shortest tangent that is not 0, or one may be too long."""
        code, layout = self._code, self._layout
        if not layout.tangents[0]:
            return code.value(False)
        least, longest = code.value(LARGEST_STATE), code.value(0.0)
        for square in self._squares():
            least = minimum(least, select(square > 0.0, square, LARGEST_STATE))
            longest = maximum(longest, square)
        rtol, atol = self._stepper.rtol, self._memory.atol[2 * layout.n - 1]
        doubt = maximum(rtol * rtol * longest, atol * atol)
        return (doubt > DOUBT**2 * least) | (longest > LONG**2)

    def _squares(self) -> Iterator[Real]:
        """Squared lengths of tangents at the end, each less its parts along those before it."""
        layout, end = self._layout, self._memory.row(self._tableau.stages)
        columns, size, placed, orthogonal = layout.tangents
        before: list[tuple[list[Real], Real]] = []
        for column in range(columns):
            first = layout.n - (columns - column) * size
            rates = range(layout.n + first, layout.n + first + size)
            values = [end[place] for place in (*range(first, first + placed), *rates)]
            for others, square in before:
                part = -select(square > 0.0, product(others, values) / square, 0.0)
                pairs = zip(others, values, strict=True)
                values = [fma(part, other, value) for other, value in pairs]
            square = product(values, values)
            if orthogonal:
                before.append((values, square))
            yield square

    def _go_on(self, trial: Trial, judged: Judged, accepted: Bool, goes_on: Bool) -> None:
        """Make the end of accepted steps the start of the next ones; try others again."""
        stepper, commits, rejects = self._stepper, goes_on & accepted, goes_on & ~accepted
        again = (stepper.rejected_before > 0.0) & accepted
        grown = select(again, minimum(judged.factor, 1.0), judged.factor)
        rejected = select_of(Real, accepted, 0.0, 1.0)
        for where, name, value in (
            (goes_on, "h", trial.h * grown),
            (commits, "t", trial.end),
            (commits, "carry", trial.carry),
            (commits, "before", judged.error),
            (commits, "last_status", 0.0),
            (goes_on, "rejected_before", rejected),
            (commits, "accepted_steps", stepper.accepted_steps + 1.0),
            (rejects, "rejected_steps", stepper.rejected_steps + 1.0),
        ):
            setattr(stepper, name, select(where, value, getattr(stepper, name)))
        if self._layout.active:
            fresh = commits & (stepper.after_switch > 0.0)
            stepper.first_length = select(fresh, abs(trial.h), stepper.first_length)
            stepper.after_switch = select(commits, 0.0, stepper.after_switch)
        self._levels.keep(commits, trial.end)
        commit(self._tableau, self._layout, self._memory, commits)


def expect_end(coefficients: Tableau | Collocation, layout: RowLayout, memory: StepMemory) -> None:
    """Write where dependent angles are at the end of the step in the workspace."""
    if layout.counted:
        weights = coefficients.extended_A[coefficients.end].tolist()
        write_expected(layout, memory, memory.stepper.length, weights)


def commit(
    coefficients: Tableau | Collocation, layout: RowLayout, memory: StepMemory, where: Bool
) -> None:
    """Copy the end of the step into row 0, in some lanes, with what iterations found there."""
    code, start, end = memory.code, memory.row(0), memory.row(coefficients.end)
    if layout.counted:
        with code.if_(where):
            expect_end(coefficients, layout, memory)
            write_counted(layout, memory, end, memory.angles, where)
    for i in code.for_entries(layout.width):
        start[i] = select(where, end[i], start[i])
    for i in code.for_entries(layout.carried):
        for half, corrected in ((0, 0), (layout.n, layout.carried)):
            place = half + layout.first_carried + i
            start[place] = select(where, end[layout.settled + corrected + i], start[place])
    for i in layout.turning(code):
        wrap(start, memory.turns, i, where)


def product(one: Sequence[Real], other: Sequence[Real]) -> Real:
    """The scalar product."""
    total = one[0].code.value(0.0)
    for a, b in zip(one, other, strict=True):
        total = fma(a, b, total)
    return total
