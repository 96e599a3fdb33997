"""Modes of a motion: on which side of zero functions of time and state were last seen.

A mode changes only where a motion crosses the zero of its function, at a time that solvers locate,
so that the equations between are smooth. In the graph modes and latched values are inputs.

Sampled states are updated at multiples of their periods: there a mode rises, where they jump to
their next values. Its function is a wave of time alone, so that motions whose states repeat after a
common period repeat with their modes. It consists of parabolas, which steps between two changes
tell from their ends. An update is a few units in the last place late. States at a multiple of the
period are therefore those before it, whatever times are rounded to, and one at the start follows
it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Parameter
from linkages.kernel.differentiation import derivative, derivative_along
from linkages.kernel.scalars import Level, Scalar

if TYPE_CHECKING:
    from linkages.kernel.model import Model

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Switch:
    """A mode, and what changes it.

    A switch that may `stick` has the mode 0 where the motion is pushed back to the zero from both
    sides; it stands for the value between −1 and 1 that keeps the function zero.
    """

    name: str  # what sentences and results call it
    function: Scalar  # the mode is +1 where this is not negative, otherwise −1
    # Number of another mode: where that is −1 the function is not watched and this one is −1 as
    # well. None if it is watched always
    active: int | None = None
    # Rates of the free coordinates and values of internal states behind a time at which the
    # function rises through zero; empty if they are those before it
    jump: tuple[Scalar, ...] = ()
    stick: bool = False
    # Whether functions of other switches may jump where this one changes
    couples_others: bool = False
    # Whether internal states alone jump where it rises, at a time that no state moves
    updates: bool = False


@dataclass(frozen=True, eq=False)
class LatchedValue:
    """A number that a motion keeps from the last time at which a switch rose."""

    name: str  # what results call it
    owner: int  # number of the switch
    node: Scalar  # what is kept
    # Whether neighbours keep the same number: what it is has no effect on the motion
    insensitive: bool = False


class Switches:
    """The switches of a model, in the order in which its accelerations need them."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self.switches: list[Switch] = []
        self.memories: list[LatchedValue] = []
        self.equivalent: dict[int, Scalar] = {}
        self._known: dict[tuple[int, int | None], int] = {}
        self._called: dict[str, int] = {}
        self._collecting = 0
        self._coupled = 0
        self._pressed: list[int] = []
        self._sliding_values: dict[int, tuple[Scalar, Scalar]] = {}

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """While the accelerations are built: what they ask for becomes a mode."""
        self._collecting += 1
        try:
            yield
        finally:
            self._collecting -= 1

    def add(
        self,
        name: str,
        function: Scalar,
        *,
        active: Scalar | None = None,
        jump: Sequence[Scalar] = (),
        stick: bool = False,
        couples_others: bool = False,
        falling: Scalar | None = None,
    ) -> Scalar:
        """The mode of a function, +1.0 or −1.0; equal functions have one mode.

        It falls with the function `falling` if that is another one (hysteresis), a larger one.

        What no acceleration depends on needs no mode: there, and where nothing is integrated, it is
        the sign of the function itself. Where the mode `active` is −1, so is this one; where that
        becomes +1, this mode is set from the sign of the function. A motion may `stick` where the
        function is zero (Filippov's sliding, Coulomb's sticking) if accelerations are affine in the
        mode there. Where they are so everywhere, as those of ``force·mode``, this is found without;
        `select` on a mode is not.
        """
        graph, moves = self._model.graph, function.level > Level.PARAMETERS
        if moves and not self._collecting and self._model.topology.coordinates:
            _ = self._model.free_accelerations  # so that the order is always the same
        owner = None if active is None else self.number(active)
        known = self._known.get((function.index, owner))
        if known is None and not (jump or stick):
            other = self._known.get((graph.negate(function).index, owner))
            if owner is None and other is not None and not self.switches[other].jump:
                return -self._model.inputs.mode(other)
        if known is None:
            if not (moves and self._collecting):
                if jump:
                    raise ValueError(f"switch {name!r} jumps, but no acceleration needs it")
                return graph.select(function, graph.one, -graph.one)
            known = len(self.switches)
            self._known[function.index, owner] = known
            behind = (*jump, *self._model.internal) if jump else ()
            if falling is not None:
                function = graph.select(self.next_mode(), falling, function)
            own = Switch(self._unused(name), function, owner, behind, stick, couples_others)
            self.switches.append(own)
        self._called.setdefault(name, known)
        return self._model.inputs.mode(known)

    def update(self, name: str, function: Scalar, values: Sequence[Scalar]) -> None:
        """Give internal states new values at times at which a function rises."""
        rates = map(self._model.inputs.rate, range(len(self._model.topology.free)))
        own = Switch(self._unused(name), function, jump=(*rates, *values), updates=True)
        self.switches.append(own)

    def side(self, name: str, function: Scalar, active: Scalar | None = None) -> Scalar:
        """The mode of a function, as `add` gives it, or that of what it is a multiple of.

        A motion that stays on a zero crosses those of all multiples by round-off.
        """
        graph = self._model.graph
        product = graph.negate(function) if function.operation == "neg" else function
        if product.operation in ("mul", "div"):
            factor, other = sorted(product.operands, key=lambda node: node.level)
            if factor.level <= Level.PARAMETERS < other.level:
                signed = factor if product is function else -factor
                sign = graph.select(signed, graph.one, -graph.one)
                turned = sign * self.side(name, other, active)
                return graph.select(-(factor * factor), graph.one, turned)
        return self.add(name, function, active=active)

    def jumps(self, mode: Scalar, rates: Sequence[Scalar]) -> None:
        """Give a mode new rates where its function rises, which may depend on modes added later."""
        if self._collecting:
            number = self.number(mode)
            behind = (*rates, *self._model.internal)
            self.switches[number] = replace(self.switches[number], jump=behind)

    def add_coupled(
        self,
        names: Sequence[str],
        active: Sequence[Scalar],
        functions: Callable[[Sequence[Scalar]], Sequence[Scalar]],
        *,
        couples_others: bool = False,
    ) -> list[Scalar]:
        """Modes whose functions, forces that press, depend on each other's modes."""
        if not self._collecting:
            _ = self._model.free_accelerations
        if all(name in self._called for name in names):
            return [self._model.inputs.mode(self._called[name]) for name in names]
        first, zero = len(self.switches), self._model.graph.zero
        self._coupled = max(self._coupled, len(names) if len(names) > 1 else 0)
        for name, owner in zip(names, active, strict=True):
            self._called[name] = len(self.switches)
            self._pressed.append(len(self.switches))
            self.switches.append(
                Switch(self._unused(name), zero, self.number(owner), couples_others=couples_others)
            )
        modes = [self._model.inputs.mode(first + k) for k in range(len(names))]
        for k, function in enumerate(functions(modes), first):
            self.switches[k] = replace(self.switches[k], function=function)
        return modes

    def set_sliding_value(self, mode: Scalar, over: Scalar, under: Scalar) -> None:
        """Say what a mode of 0 stands for, a ratio, for forces that know themselves what holds."""
        if self._collecting:
            self._sliding_values[self.number(mode)] = over, under

    def is_sliding(self, mode: Scalar) -> Scalar:
        """Not negative where a mode is 0."""
        return 0.5 - mode * mode

    def next_mode(self, further: int = 0) -> Scalar:
        """The mode that `add` will give, for a function that depends on its own mode."""
        return self._model.inputs.mode(len(self.switches) + further)

    def memory(self, name: str, node: Scalar, *, insensitive: bool = False) -> Scalar:
        """The value that a node had when a switch rose last, or at the start."""
        owner = self._called[name]
        for number, memory in enumerate(self.memories):
            if memory.owner == owner and memory.node is node:
                return self._model.inputs.memory(number)
        count = sum(memory.owner == owner for memory in self.memories)
        called = self.switches[owner].name + (f" ({count + 1})" if count else "")
        self.memories.append(LatchedValue(called, owner, node, insensitive))
        return self._model.inputs.memory(len(self.memories) - 1)

    def _unused(self, name: str) -> str:
        """The name, with a number behind it where it is taken."""
        taken = {switch.name for switch in self.switches}
        count = 2
        result = name
        while result in taken:
            result, count = f"{name} ({count})", count + 1
        return result

    def number(self, mode: Scalar) -> int:
        """The number of the switch that has a mode."""
        if mode.operation == "input" and mode.arguments[0] == "mode":
            return int(mode.arguments[1])
        raise ValueError(f"active must be the mode of a switch, found {mode!r}")

    @property
    def functions(self) -> list[Scalar]:
        """Whose signs the modes are."""
        return [switch.function for switch in self.switches]

    @property
    def watched(self) -> list[Scalar]:
        """What crosses zero where modes change: functions; while one sticks, 1 − (its value)²."""
        result, graph = self.functions, self._model.graph
        inputs, numbers = self._model.inputs, range(len(self.switches))
        stuck = {number: self.is_sliding(inputs.mode(number)) for number in numbers}
        values = dict(self.equivalent)
        for number, (over, under) in self._sliding_values.items():
            least = graph.select(stuck[number], self._completed(under), graph.one)
            values[number] = self._completed(over) / least
        for number, value in values.items():
            result[number] = graph.select(stuck[number], 1.0 - value * value, result[number])
        return result

    def _completed(self, node: Scalar) -> Scalar:
        """A node that is affine in modes that stick, with what these stand for."""
        return node + self.held(node) if self.equivalent else node

    def _sticky(self, changes: list[Scalar]) -> list[int]:
        """Switches on whose zeros motions may stay: those whose rates are affine in the mode."""
        inputs, zero = self._model.inputs, self._model.graph.zero
        speeds = [inputs.rate(i) for i in range(len(changes))]
        slopes = derivative(self.functions, speeds)
        moved = [
            number
            for number, switch in enumerate(self.switches)
            if not switch.jump
            and number not in self._sliding_values
            and any(slope is not zero for slope in slopes[number])
        ]
        modes, result = [inputs.mode(number) for number in moved], []
        for number, mode in zip(moved, modes, strict=True):
            effects = [effect for (effect,) in derivative(changes, [mode])]
            bends = derivative(effects, modes)
            affine = all(bend is zero for row in bends for bend in row)
            pairs = zip(slopes[number], effects, strict=True)
            felt = any(slope is not zero and effect is not zero for slope, effect in pairs)
            if self.switches[number].stick and not affine and self._model.walls.rough:
                self._refuse(number)
            if self.switches[number].stick or (affine and felt):
                result.append(number)
        return result

    def _refuse(self, number: int) -> None:
        """Raise where a block in its guide rubs beside other friction that sticks."""
        model, name = self._model, self.switches[number].name
        message = (
            f"{name!r} sticks as well: where two corners of a block hold, nothing says what each "
            "takes; expected one friction that sticks, and a law such as tanh(v/v0) for others"
        )
        raise model.mechanism.error([(rough.path, message) for rough in model.walls.rough.values()])

    def sticking(self, changes: list[Scalar]) -> list[Scalar]:
        """`changes` of a model with the values that modes of 0 stand for.

        The rates of functions are affine in the modes. Where they are to stay zero that is a linear
        system (equivalent control: A. F. Filippov, Differential Equations with Discontinuous
        Righthand Sides, Kluwer 1988; V. I. Utkin, Sliding Modes in Control and Optimization,
        Springer 1992).
        """
        sticky = self._sticky(changes)
        may = {*sticky, *self._sliding_values}
        self.switches = [replace(s, stick=k in may) for k, s in enumerate(self.switches)]
        if self._sliding_values:  # forces of contacts jump with any other friction
            self.switches = [
                replace(s, couples_others=s.couples_others or s.stick) for s in self.switches
            ]
        if not sticky:
            return changes
        graph, inputs = self._model.graph, self._model.inputs
        modes = [inputs.mode(number) for number in sticky]
        functions = [self.switches[number].function for number in sticky]
        rates = self.rates(functions, self._model.integrated_accelerations(changes))
        slopes = derivative(rates, modes)
        matrix, right = [], []
        for row, number in enumerate(sticky):
            stuck = self.is_sliding(inputs.mode(number))
            unit = [graph.one if row == column else graph.zero for column in range(len(sticky))]
            pairs = zip(slopes[row], unit, strict=True)
            matrix.append([graph.select(stuck, slope, other) for slope, other in pairs])
            right.append(graph.select(stuck, -rates[row], graph.zero))
        values = [right[0] / matrix[0][0]] if len(sticky) == 1 else graph.solve(matrix, right)
        self.equivalent = dict(zip(sticky, values, strict=True))
        for number in self._pressed:
            own = self.switches[number]
            self.switches[number] = replace(own, function=self._completed(own.function))
        effects = derivative(changes, modes)
        return [
            change + graph.total(e * v for e, v in zip(row, values, strict=True))
            for change, row in zip(changes, effects, strict=True)
        ]

    def held(self, value: Scalar) -> Scalar:
        """What forces that hold a motion where it sticks add to something affine in the modes."""
        modes = [self._model.inputs.mode(number) for number in self.equivalent]
        (slopes,) = derivative([value], modes)
        pairs = zip(slopes, self.equivalent.values(), strict=True)
        return self._model.graph.total(slope * item for slope, item in pairs)

    @property
    def nodes(self) -> list[Scalar]:
        """All that changes of modes depend on."""
        jumps = [rate for switch in self.switches for rate in switch.jump]
        return [*self.functions, *(memory.node for memory in self.memories), *jumps]

    @property
    def names(self) -> tuple[str, ...]:
        """Of everything that is held: modes, then memories."""
        modes = (f"mode {switch.name}" for switch in self.switches)
        return (*modes, *(f"memory {memory.name}" for memory in self.memories))

    def rates(self, nodes: Sequence[Scalar], accelerations: Sequence[Scalar]) -> list[Scalar]:
        """Derivatives of nodes with respect to time along the motion."""
        if not nodes:
            return []
        inputs = self._model.inputs
        direction = {inputs.time.index: self._model.graph.one}
        for index, acceleration in enumerate(accelerations):
            direction[inputs.coordinate(index).index] = inputs.rate(index)
            direction[inputs.rate(index).index] = acceleration
        return [rate for (rate,) in derivative_along(nodes, [direction])]

    def signed(self, inputs: Mapping[str, Floats]) -> dict[str, Floats]:
        """Modes by the signs of their functions, and memories as if the switches had just risen."""
        shape = np.broadcast_shapes(*(array.shape[1:] for array in inputs.values()))
        modes = np.full((len(self.switches), *shape), -1.0)
        memory = np.zeros((len(self.memories), *shape))
        result = {"mode": modes, "memory": memory}
        for _ in range(1 + self._coupled):
            before = modes.copy()
            self._sign(inputs, result)
            if (modes == before).all():
                break
        return result

    def _sign(self, inputs: Mapping[str, Floats], found: Mapping[str, Floats]) -> None:
        """Set modes and memories, one after the other."""
        modes, memory = found["mode"], found["memory"]
        for number, switch in enumerate(self.switches):
            (value,) = self._model.evaluator([switch.function])(**inputs, **found)
            on = value >= 0.0
            if switch.active is not None:
                on &= modes[switch.active] > 0.0
            modes[number] = np.where(on, 1.0, -1.0)
            for place, kept in enumerate(self.memories):
                if kept.owner == number:
                    memory[place] = self._model.evaluator([kept.node])(**inputs, **found)[0]


LATE, LATER = 16 * 2.220446049250313e-16, 1e-12
"""By how much an update is late: parts of its time, and of the period."""

TOGETHER = 1e-6
"""Part of the shorter period below which updates of two periods are one."""

LONGEST_STEP = 0.49
"""Part of the period that a step may take: none may pass two changes of a wave."""


def add_updates(model: Model) -> None:
    """Give a model the modes of its updates."""
    states = model.mechanism.internal.values()
    periods = [None if s.period is None else s.period.parameter for s in states]
    known = list(dict.fromkeys(period for period in periods if period is not None))
    for place, own in enumerate(known):
        values = []
        for period, now, following in zip(periods, model.internal, model.next_values, strict=True):
            value = now if period is None else following
            if period not in (None, own):
                value = model.graph.select(_near(model, period, own), value, now)
            for other in known[:place]:  # what comes at the same time is done there
                value = model.graph.select(_near(model, other, own), now, value)
            values.append(value)
        names = [s.name for s in states if s.period is not None and s.period.parameter == own]
        model.switches.update(f"update of {', '.join(names)}", _wave(model, own), values)


def _cycles(model: Model, period: Parameter) -> Scalar:
    """Time in periods."""
    return model.inputs.time * (1.0 - LATE) / model.inputs.parameter(period) - LATER


def _wave(model: Model, period: Parameter) -> Scalar:
    """Rises through zero at multiples of a period, and falls through zero between them."""
    cycles = _cycles(model, period)
    part = cycles - model.graph.apply("floor", cycles)
    half = part - 0.5
    return model.graph.select(half, half * (part - 1.0), -half * part)


def _near(model: Model, period: Parameter, own: Parameter) -> Scalar:
    """Not negative next to a multiple of a period, at one of another period."""
    graph, cycles = model.graph, _cycles(model, period)
    length, other = map(model.inputs.parameter, (period, own))
    apart = length * (cycles - graph.apply("floor", cycles + 0.5))
    most = TOGETHER * graph.select(length - other, other, length)
    return most * most - apart * apart
