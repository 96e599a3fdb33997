"""Stages of an explicit Runge–Kutta step in lanes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.instructions import Instructions
from linkages.solvers.printed.shape import (
    Shape,
    StepMemory,
    call_clock,
    call_rates,
    fold,
    set_whole,
    whole_row,
)
from linkages.solvers.steps.memory import (
    FROM,
    LARGEST_ANGLE,
    LARGEST_STATE,
    LENGTH,
    NOT_FINITE,
    TO,
    TWO_PI,
    TWO_PI_TAIL,
)
from linkages.solvers.tableau import Tableau

KEEP, NODE, STEP_END = range(3)
"""When a row is evaluated: at the time of the row before, at its node, at the end of the step."""


class Stages:
    """Writes rows of the workspace; each is evaluated as soon as its state is known.

    The step goes from row 0, evaluated, over a time in the pace. Rows at its end are evaluated at
    that very time, so that the end of a step and the start of the next one are at the same time
    to the last bit.

    Parameters
    ----------
    code
        Where.
    tableau, shape, memory
        Of the step.
    """

    def __init__(
        self, code: Instructions, tableau: Tableau, shape: Shape, memory: StepMemory
    ) -> None:
        self._code, self._shape, self._memory = code, shape, memory
        self._weights, self._nodes = tableau.extended_A, tableau.extended_c
        self._clocks = clocks(tableau)
        self._end = tableau.stages

    def write(self, first: int, last: int) -> str:
        """Write rows first to last; returns statuses, of a single state 0: others are returned.

        What is returned with a status is the row in the upper half of the number.
        """
        code, memory = self._code, self._memory
        t, h, end = (memory.pace(entry) for entry in (FROM, LENGTH, TO))
        status = code.whole(0)
        for row in range(first, last + 1):
            self._combine(row, h)
            if self._clocks[row] == NODE:
                node = code.constant(self._nodes[row])
                status = self._met(status, call_clock(code, memory, code.fused(node, h, t)), 0)
            elif self._clocks[row] == STEP_END:
                status = self._met(status, call_clock(code, memory, end), 0)
            found = call_rates(code, memory, row, self._shape.n)
            status = self._met(status, found, row)
        if first <= self._end <= last:
            status = self._sound(status)
        return status

    def _combine(self, row: int, h: str) -> None:
        """The state in a row, from the derivatives in those before it."""
        code, memory, n = self._code, self._memory, self._shape.n
        terms = [
            (code.constant(weight), memory.row(stage, n))
            for stage, weight in enumerate(self._weights[row].tolist())
            if weight
        ]
        begun, target = memory.row(0), memory.row(row)

        def entry(i: int | str, _: list[str]) -> list[str]:
            (weight, slopes), *rest = terms
            slope = code.multiply(weight, code.load(slopes, i))
            for weight, slopes in rest:
                slope = code.fused(weight, code.load(slopes, i), slope)
            code.store(code.fused(h, slope, code.load(begun, i)), target, i)
            return []

        fold(code, 2 * n, (), entry)

    def _met(self, before: str, found: str, row: int) -> str:
        """Statuses so far; a single state ends with one at once."""
        code = self._code
        if code.lanes > 1:
            fine = code.give(f"icmp eq {code.integer} {before}, {code.whole(0)}")
            return code.select(fine, found, before, code.integer)
        leave, on = code.new_label("leave"), code.new_label("on")
        code.branch(code.give(f"icmp eq i64 {found}, 0"), on, leave)
        code.begin(leave)
        code.say(f"ret i64 {code.give(f'or i64 {found}, {row << 32}')}")
        code.begin(on)
        return before

    def _sound(self, status: str) -> str:
        """Statuses with that of ends which are not numbers that a motion can have."""
        code, shape = self._code, self._shape
        fine = is_sound(code, shape, self._memory.row(self._end), 3 * shape.n)
        found = code.select(fine, code.whole(0), code.whole(NOT_FINITE), code.integer)
        return self._met(status, found, 0)


def is_sound(code: Instructions, shape: Shape, row: str, columns: int) -> str:
    """Whether the first columns of a row are numbers that a motion can have."""
    one = code.constant(1.0)

    def entry(i: int | str, values: list[str]) -> list[str]:
        # Written so that nan, which compares false with everything, is caught.
        fine = code.compare("olt", code.absolute(code.load(row, i)), code.constant(LARGEST_STATE))
        return [code.select(fine, values[0], code.constant(0.0))]

    (sound,) = fold(code, columns, [one], entry)
    fine = code.compare("oeq", sound, one)
    for i in range(shape.n):
        if shape.rotates[i]:
            near = code.compare(
                "ole", code.absolute(code.load(row, i)), code.constant(LARGEST_ANGLE)
            )
            fine = code.all_of([fine, near])
    return fine


def wrap(code: Instructions, angles: str, i: int, turns: str, where: str | None = None) -> None:
    """Bring an angle within one turn, in some lanes; see `turns.wrap_angles`."""
    angle = code.load(angles, i)
    beyond = code.compare("ogt", code.absolute(angle), code.constant(TWO_PI / 2))
    if where is not None:
        beyond = code.all_of([where, beyond])
    taken = code.call("llvm.rint", code.divide(angle, code.constant(TWO_PI)))
    taken = code.select(beyond, taken, code.constant(0.0))
    back = code.negate(taken)
    within = code.fused(back, code.constant(TWO_PI), angle)
    within = code.fused(back, code.constant(TWO_PI_TAIL), within)
    code.store(code.select(beyond, within, angle), angles, i)
    whole = code.give(f"fptosi {code.number} {taken} to {code.integer}")
    set_whole(code, code.on_integers("add", whole_row(code, turns, i), whole), turns, i)


def clocks(tableau: Tableau) -> NDArray[np.int64]:
    """When each row is evaluated; see `KEEP`."""
    c = tableau.extended_c
    found = np.where(c == 1.0, STEP_END, NODE)
    found[1:][c[1:] == c[:-1]] = KEEP
    # Before these rows, samples or another trial may have moved the clock.
    for row in (1, tableau.stages + 1):
        found[row : row + 1][c[row : row + 1] < 1.0] = NODE
    return found
