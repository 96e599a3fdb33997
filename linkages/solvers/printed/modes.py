"""Whether a mode may change within a step, written out.

The same comparisons as those of `linkages.solvers.watched.switches`, which looks for changes: where
none of them holds it would find none, so that the step needs nothing but arithmetic.
"""

from __future__ import annotations

from linkages.kernel.code.instructions import Instructions
from linkages.solvers.coefficients.tableau import Tableau
from linkages.solvers.printed.shape import Shape, StepMemory, larger, smaller
from linkages.solvers.steps.views import FRESH, REJECTED_BEFORE

# Value of a function that is no more than round-off, beside its change in a step.
ROUND_OFF = 1e-9
# How far from a cubic a function may be at a stage beside its variation, and how far from zero,
# beside that, it does not matter. Measured on 260 random motions between two walls with friction:
# 0.1 missed releases of a tenth of a period.
UNLIKE, FAR = 0.03, 10.0
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

    def need_more(self, accepted: str) -> str:
        """In which lanes a step, accepted or not, is to be looked at, or follows a change."""
        code, zero = self._code, self._zero
        found = no = code.compare("ogt", zero, zero)
        for switch in range(len(self._shape.active)):
            changes, ahead = self._switch(switch)
            again = code.compare("ogt", self._memory.pace(REJECTED_BEFORE), zero)
            ahead = code.select(again, no, ahead, code.truth)
            seen = code.select(accepted, changes, ahead, code.truth)
            found = code.any_of(found, code.all_of([self._watched(switch), seen]))
        if not self._shape.active:
            return no
        return code.any_of(found, code.compare("ogt", self._memory.pace(FRESH), zero))

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

    def _switch(self, switch: int) -> tuple[str, str]:
        """Where it may change within an accepted step, and where one too long crosses its zero."""
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
        found = code.any_of(found, self._unresolved(switch, start, rise, stop, fall))
        return found, code.all_of([positive, negative])

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
