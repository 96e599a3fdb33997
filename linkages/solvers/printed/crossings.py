"""Whether events may happen within a step, written out.

The comparisons of `linkages.solvers.watched.crossings`, which looks for them, in either direction:
where none of them holds it would find nothing.
"""

from __future__ import annotations

from linkages.kernel.code.instructions import Instructions
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.printed.shape import Shape, StepMemory, call_at, call_at_time, larger
from linkages.solvers.steps.views import VALUES, T

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
