"""Whether events, mode changes or whole turns may happen within a step.

The comparisons of `linkages.solvers.loops.crossings`, which looks for them, in either direction:
where none of them holds it would find nothing.

The same comparisons as those of `linkages.solvers.loops.mode_changes`, which looks for changes:
where none of them holds it would find none, so that the step needs nothing but arithmetic.
"""

from __future__ import annotations

from collections.abc import Sequence

from linkages.kernel.code.elementary_functions import arc_of
from linkages.kernel.code.instructions import Instructions
from linkages.solvers.loops.memory import FRESH, HALVED, REJECTED_BEFORE, TWO_PI, VALUES, T
from linkages.solvers.loops.shape import (
    Shape,
    StepMemory,
    call_at,
    call_at_time,
    larger,
    set_whole,
    smaller,
    whole_row,
)
from linkages.solvers.tableau import Tableau


def end_weights(code: Instructions, tableau: Tableau) -> list[tuple[str, int]]:
    """Weights of the rows at the end of a step."""
    return [(code.constant(w), row) for row, w in enumerate(tableau.b.tolist()) if w]


def write_expected(
    code: Instructions, shape: Shape, memory: StepMemory, h: str, weights: Sequence[tuple[str, int]]
) -> None:
    """Write where dependent angles are after a time h, from weights of their speeds in rows."""
    speeds = shape.cosines + 2 * shape.counted
    for i in range(shape.counted):
        mean = code.constant(0.0)
        for weight, row in weights:
            mean = code.fused(weight, code.load(memory.row(row, speeds), i), mean)
        code.store(code.fused(h, mean, code.load(memory["angles"], i)), memory["ahead"], i)


def write_counted(
    code: Instructions, shape: Shape, memory: StepMemory, row: str, into: str, where: str = ""
) -> None:
    """Write the angles in a row, with the turns that bring them closest to where they should be.

    In some lanes, if they are given.
    """
    cosines = code.address(row, shape.cosines)
    turn = code.constant(TWO_PI)
    for i in range(shape.counted):
        sine = code.load(cosines, shape.counted + i)
        angle = arc_of(code, sine, code.load(cosines, i))
        apart = code.subtract(code.load(memory["ahead"], i), angle)
        whole = code.call("llvm.rint", code.divide(apart, turn))
        found = code.fused(turn, whole, angle)
        code.store(code.select(where, found, code.load(into, i)) if where else found, into, i)


# A state on a level, as a run from a located crossing starts with, lies beyond it.
SLACK = 1e-12
# Entries of `Events.values` of an event: now, and at the end of the step before.
VALUE, RATE, BEFORE, VALUE_BEFORE, RATE_BEFORE = range(VALUES)


class CrossedLevels:
    """Watches the events of a trial.

    Parameters
    ----------
    code, tableau, shape, memory
        Where, and of what.
    """

    def __init__(
        self, code: Instructions, tableau: Tableau, shape: Shape, memory: StepMemory
    ) -> None:
        self._code, self._tableau, self._shape, self._memory = code, tableau, shape, memory
        self._zero = code.constant(0.0)

    def need_more(self, h: str, end: str) -> str:
        """Evaluate all events at the end of a step, of length h; where it is to be looked at."""
        code = self._code
        found = code.compare("ogt", self._zero, self._zero)
        for event in range(self._shape.events):
            self._evaluate(event, end)
            found = code.any_of(found, self._crossed(event, h))
        return found

    def keep(self, where: str, end: str) -> None:
        """Make values at the end of a step those at the start of the next one, in some lanes."""
        code = self._code
        for event in range(self._shape.events):
            for value, entry in (
                (end, BEFORE),
                (self._kept(event, VALUE), VALUE_BEFORE),
                (self._kept(event, RATE), RATE_BEFORE),
            ):
                place = VALUES * event + entry
                chosen = code.select(where, value, self._kept(event, entry))
                code.store(chosen, self._memory["values"], place)

    def _kept(self, event: int, entry: int) -> str:
        return self._code.load(self._memory["values"], VALUES * event + entry)

    def _evaluate(self, event: int, end: str) -> None:
        """Evaluate a function and its rate at the end; nan where that is not possible."""
        code, memory = self._code, self._memory
        functions = memory.event(event)
        out = code.address(memory["values"], VALUES * event)
        first = call_at_time(code, functions, end)
        second = call_at(code, functions, memory.row(self._tableau.stages), out)
        status = code.give(f"or {code.integer} {first}, {second}")
        sound = code.give(f"icmp eq {code.integer} {status}, {code.whole(0)}")
        for entry in (VALUE, RATE):
            value = code.select(sound, code.load(out, entry), code.constant(float("nan")))
            code.store(value, out, entry)

    def _crossed(self, event: int, h: str) -> str:
        """Where a level may be crossed, or nothing is known of the start."""
        code, zero = self._code, self._zero
        level = code.load(self._memory["levels"], event)
        start, stop = (
            code.subtract(self._kept(event, entry), level) for entry in (VALUE_BEFORE, VALUE)
        )
        before, after = (
            code.multiply(h, self._kept(event, entry)) for entry in (RATE_BEFORE, RATE)
        )
        one = code.constant(1.0)
        slack = code.multiply(code.constant(SLACK), larger(code, one, code.absolute(level)))

        def beyond(side: str, low: str, high: str) -> str:
            low, high = (code.fused(side, value, slack) for value in (low, high))
            return code.all_of([code.compare("olt", low, zero), code.compare("oge", high, zero)])

        side = code.with_sign_of(one, code.subtract(stop, start))
        steady = beyond(side, start, stop)
        side = code.with_sign_of(one, after)
        apart = code.subtract(code.subtract(stop, after), start)
        meet = code.divide(code.multiply(before, apart), code.subtract(before, after))
        bound = code.add(start, meet)
        turned = code.any_of(beyond(side, bound, start), beyond(side, bound, stop))
        turns = code.compare("olt", code.multiply(before, after), zero)
        crossed = code.any_of(steady, code.all_of([turns, turned]))
        return code.any_of(
            crossed, code.compare("une", self._kept(event, BEFORE), self._memory.pace(T))
        )


# Value of a function that is no more than round-off, beside its change in a step.
ROUND_OFF = 1e-9
# How far from a cubic a function may be at a stage beside its variation, and how far from zero,
# beside that, it does not matter. Measured on 260 random motions between two walls with friction:
# 0.1 missed releases of a tenth of a period.
UNLIKE, FAR = 0.03, 10.0
# How often a step is halved to see what functions do: more is round-off.
HALVINGS = 8
# A stage is this far below zero, beside the ends of its step, before it is looked at.
BELOW = 1e-9


class Modes:
    """Watches the modes of a trial.

    Parameters
    ----------
    code, tableau, shape, memory
        Where, and of what.
    h
        Length of the trial.
    """

    def __init__(
        self, code: Instructions, tableau: Tableau, shape: Shape, memory: StepMemory, h: str
    ) -> None:
        self._code, self._tableau, self._shape, self._memory = code, tableau, shape, memory
        self._h, self._zero = h, code.constant(0.0)

    def need_more(self, accepted: str) -> tuple[str, str]:
        """In which lanes a step, accepted or not, is to be looked at; in which it is too long.

        It is also looked at where it follows a change. Where it is too long to say what functions
        do, it is halved and nothing else, unless a change ahead says where to end it.
        """
        code, zero, pace = self._code, self._zero, self._memory.pace
        no = changes = ahead = unresolved = code.compare("ogt", zero, zero)
        if not self._shape.active:
            return no, no
        for switch in range(len(self._shape.active)):
            watched = self._watched(switch)
            here = [code.all_of([watched, where]) for where in self._switch(switch)]
            changes, ahead, unresolved = (
                code.any_of(one, other)
                for one, other in zip((changes, ahead, unresolved), here, strict=True)
            )
        fresh, again = (
            code.compare("ogt", pace(entry), zero) for entry in (FRESH, REJECTED_BEFORE)
        )
        ahead = code.all_of([ahead, code.opposite(again)])
        halved = whole_row(code, self._memory["pace"], HALVED)
        left = code.give(f"icmp slt {code.integer} {halved}, {code.whole(HALVINGS)}")
        plain = code.opposite(code.any_of(ahead, fresh))
        too_long = code.all_of([accepted, unresolved, left, plain])
        found = code.select(accepted, code.any_of(changes, unresolved), ahead, code.truth)
        return code.any_of(found, fresh), too_long

    def halve(self, where: str, commits: str) -> None:
        """Count how often steps are halved, in some lanes; it ends with a step that counts."""
        code, memory = self._code, self._memory
        if not self._shape.active:
            return
        before = whole_row(code, memory["pace"], HALVED)
        more = code.on_integers("add", before, code.whole(1))
        found = code.select(where, more, before, code.integer)
        found = code.select(commits, code.whole(0), found, code.integer)
        set_whole(code, found, memory["pace"], HALVED)

    def _held(self, switch: int) -> str:
        return self._code.load(self._memory["held"], switch)

    def _watched(self, switch: int) -> str:
        """Where a switch is watched: always, or where another mode is +1."""
        code, owner = self._code, self._shape.active[switch]
        if owner < 0:
            return code.compare("oge", self._zero, self._zero)
        return code.compare("ogt", self._held(owner), self._zero)

    def _seen(self, switch: int, row: int) -> str:
        """Function of a switch in a row, not negative as long as its mode is right."""
        code, place = self._code, self._shape.functions + switch
        return code.multiply(self._side(switch), code.load(self._memory.row(row, place), 0))

    def _moving(self, switch: int, row: int) -> str:
        """Its rate, over the whole step."""
        code, place = self._code, self._shape.functions + len(self._shape.active) + switch
        rate = code.multiply(self._side(switch), code.load(self._memory.row(row, place), 0))
        return code.multiply(rate, self._h)

    def _side(self, switch: int) -> str:
        """Its mode, 1 where it sticks."""
        code, mode = self._code, self._held(switch)
        sticks = code.compare("oeq", mode, self._zero)
        return code.select(sticks, code.constant(1.0), mode)

    def _switch(self, switch: int) -> tuple[str, str, str]:
        """Where it may change within an accepted step, crosses its zero, or cannot be told of."""
        code, zero, end = self._code, self._zero, self._tableau.stages
        start, rise = self._seen(switch, 0), self._moving(switch, 0)
        stop, fall = self._seen(switch, end), self._moving(switch, end)
        negative = code.compare("olt", stop, zero)
        positive = code.compare("ogt", start, zero)
        found = code.any_of(negative, self._dips(start, rise, stop, fall))
        slack = larger(
            code,
            code.multiply(code.constant(ROUND_OFF), rise),
            code.multiply(code.constant(-2.0), start),
        )
        below = code.multiply(code.constant(BELOW), code.add(code.absolute(start), stop))
        least, depth = code.negate(larger(code, slack, below)), code.constant(float("inf"))
        for row in range(1, end):
            depth = smaller(code, depth, self._seen(switch, row))
        found = code.any_of(found, code.compare("olt", depth, least))
        unresolved = self._unresolved(switch, start, rise, stop, fall)
        return found, code.all_of([positive, negative]), unresolved

    def _dips(self, start: str, rise: str, stop: str, fall: str) -> str:
        """Where it may be below zero between the ends: no deeper than where the tangents meet."""
        code, zero = self._code, self._zero
        apart = code.subtract(code.subtract(stop, fall), start)
        meet = code.divide(code.multiply(rise, apart), code.subtract(rise, fall))
        below = code.compare("olt", code.add(start, meet), zero)
        turns = [code.compare("olt", rise, zero), code.compare("ogt", fall, zero)]
        return code.all_of([code.compare("ogt", start, zero), *turns, below])

    def _unresolved(self, switch: int, start: str, rise: str, stop: str, fall: str) -> str:
        """Where stages are so far from the cubic through both ends that these say nothing."""
        code, apart = self._code, self._zero
        change = code.subtract(stop, start)
        c2 = code.multiply(code.constant(3.0), change)
        c2 = code.subtract(code.subtract(c2, code.multiply(code.constant(2.0), rise)), fall)
        c3 = code.subtract(code.add(rise, fall), code.multiply(code.constant(2.0), change))
        low, high = smaller(code, start, stop), larger(code, start, stop)
        for row in self._tableau.quarters:
            x = code.constant(float(self._tableau.c[row]))
            here = self._seen(switch, row)
            cubic = code.fused(x, code.fused(x, code.fused(x, c3, c2), rise), start)
            apart = larger(code, apart, code.absolute(code.subtract(here, cubic)))
            low, high = smaller(code, low, here), larger(code, high, here)
        most = code.multiply(code.constant(UNLIKE), code.subtract(high, low))
        unlike = code.compare("ogt", apart, most)
        near = code.compare("olt", low, code.multiply(code.constant(FAR), apart))
        return code.all_of([unlike, near])
