"""Many starts, each followed to its attractor: a question of a sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.attractors.matching import Attractor
from linkages.attractors.settling import (
    Clock,
    Kind,
    Settled,
    leaves,
    require_attractors,
    sections,
    settling,
)
from linkages.chaos.diagram import touchable
from linkages.chaos.free_states import require_free
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import LinkagesError
from linkages.kernel.inputs import definition_vector
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import BasinOptions
from linkages.solution.many import Going, cpu_only, side_by_side
from linkages.solution.run_options import options_of
from linkages.spec.units import unit
from linkages.sweeps.axes import Axis, Vary, axis_of, first_possible
from linkages.sweeps.engine import (
    SIDE_BY_SIDE,
    Answer,
    Field,
    Question,
    attempted,
    begun,
    end_when_stopping,
)
from linkages.sweeps.points import probabilities
from linkages.sweeps.running import per_period

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Starts(Question):
    """The attractor of each of many starts.

    `paths`, `units`: what starts differ in, and the units of its numbers; empty for SI.
    """

    varying: Varying  # what is started
    paths: tuple[str, ...]
    units: tuple[str, ...]
    rows: Floats  # numbers of every start, shape (starts, paths); nan for that of the definition
    nodes: Integers  # starts with the same number have the same parameters, shape (starts,)
    given: Mapping[str, Any]  # options that were asked for
    about: Mapping[str, Any]  # what tells this question from others, in terms of JSON

    @property
    def count(self) -> int:
        """Number of starts."""
        return len(self.rows)

    @property
    def described(self) -> dict[str, Any]:
        """What is asked."""
        return {**self.about, "paths": list(self.paths), "options": dict(self.given)}

    def numbers(self) -> Floats:
        """Numbers of all starts."""
        return self.rows

    @cached_property
    def first(self) -> System:
        """The first system that can be built; what is wrong everywhere shows there."""
        places = sorted(
            {0, len(self.rows) - 1} | set(range(0, len(self.rows), 1 + self.count // 64))
        )
        system = first_possible(lambda place: self.varying.at(self._overrides(place)), places)
        require_free(system)
        require_attractors(system)
        Clock.of(system, self.options)
        return system

    @cached_property
    def fields(self) -> Mapping[str, Field]:
        """What a motion tends to: see `Settled`."""
        size, free = self.first.layout.directions, len(self.first.topology.free)
        return {
            "kind": Field("i1"), "period": Field(), "count": Field("i8"), "section": Field("i8"),
            "points": Field(shape=(self.options.longest, size)), "turns": Field(shape=(free,)),
            "touches": Field(shape=(len(touchable(self.first)),)),
            "reach": Field(shape=(size,)), "left": Field(), "lasted": Field(),
        }  # fmt: skip

    @cached_property
    def options(self) -> BasinOptions:
        """How motions are followed."""
        options = options_of(BasinOptions, self.varying.mechanism, self.given)
        return per_period(options, options.periods)

    @property
    def cpu_only(self) -> str:
        """What of it is computed on the CPU only."""
        return cpu_only(self.first, self.options)

    together = SIDE_BY_SIDE

    def answers(self, first: int, last: int) -> list[Answer]:
        """The attractors of some starts."""
        _ = self.first  # all are built upon the same one, wherever they are computed
        along = self.varying.along([self._overrides(place) for place in range(first, last)])
        tasks, result = begun(
            along, lambda place, system: self.task(system, int(self.nodes[first + place]))
        )
        ended = side_by_side(list(tasks.values()), end_when_stopping)
        for place, settled in zip(tasks, ended, strict=True):
            result[place] = attempted(partial(self._answer, settled))
        return [result[place] for place in range(len(along))]

    def again(self, places: Sequence[int]) -> list[Settled | LinkagesError]:
        """Where the motions of some starts end, with their states there."""
        along = self.varying.along([self._overrides(place) for place in places])
        systems = [along.system(index) for index in range(len(along))]
        nodes = self.nodes[list(places)].tolist()
        return side_by_side([self.task(*each) for each in zip(systems, nodes, strict=True)])

    def unstable(self, attractors: Sequence[Attractor]) -> dict[int, bool]:
        """Number of each cycle and state at rest → whether its neighbours leave it."""
        tested = [n for n, each in enumerate(attractors) if each.kind < Kind.QUASI_PERIODIC]
        ends = self.again([attractors[number].place for number in tested])
        tasks: dict[int, Going[bool]] = {}
        for number, settled in zip(tested, ends, strict=True):
            if isinstance(settled, Settled):
                clock = self.clock(settled.march.system, attractors[number].node)
                tasks[number] = leaves(settled, clock, self.options)
        found = side_by_side(list(tasks.values()))
        return {n: left is True for n, left in zip(tasks, found, strict=True)}

    def clock(self, system: System, node: int) -> Clock:
        """What gives a motion its rhythm; the same for all starts with the same parameters."""
        known = self._clocks
        if node not in known:
            known[node] = Clock.of(system, self.options)
        return known[node]

    @cached_property
    def _clocks(self) -> dict[int, Clock]:
        return {}

    def task(self, system: System, node: int) -> Going[Settled]:
        """Follow a motion with the parameters of a number."""
        clock = self.clock(system, node)
        guards = () if clock.driven else sections(system)
        return settling(system, clock, self.options, guards)

    def _answer(self, settled: Settled | LinkagesError) -> Answer:
        if isinstance(settled, LinkagesError):
            raise settled
        points = np.full(self.fields["points"].shape, np.nan)
        points[: len(settled.points)] = settled.points
        result = {
            "kind": int(settled.kind), "period": settled.period, "count": len(settled.points),
            "section": settled.section, "points": points, "turns": settled.turns,
            "touches": settled.touches,
            "reach": settled.reach, "left": settled.left, "lasted": settled.march.time,
        }  # fmt: skip
        return Answer(result, evaluations=settled.march.cost["evaluations"])

    def _overrides(self, place: int) -> dict[str, object]:
        """Of a start, in SI."""
        row = self.rows[place].tolist()
        kinds = [unit(text) if text else None for text in self.units]
        return {
            path: value if kind is None else kind.convert(value)
            for path, kind, value in zip(self.paths, kinds, row, strict=True)
            if value == value
        }


def sides_of(given: Vary | Sequence[Vary]) -> list[Axis]:
    """Sides of a box."""
    one = isinstance(given, str | Axis) or (isinstance(given, Mapping) and bool(given))
    sides: Any = [given] if one else given
    return [axis_of(side) for side in sides]


def is_state(mechanism: Mechanism, axis: Axis) -> bool:
    """Whether an axis changes initial states only, and no parameter of the equations."""
    varying = Varying(mechanism)
    last = len(axis) - 1
    one, other = (
        first_possible(lambda place: varying.at(axis.at(place)), order)
        for order in (range(last + 1), range(last, -1, -1))
    )
    if one.structure.key != other.structure.key:
        return False
    numbers, others = (
        definition_vector(each.mechanism, each.model.inputs.parameters) for each in (one, other)
    )
    return bool(np.array_equal(numbers, others, equal_nan=True))


def drawn(axes: Sequence[Axis], states: Sequence[bool], draws: int, seed: int) -> Floats:
    """Numbers drawn uniformly from a box, shape (draws, paths).

    Each is a function of seed, path and number of the draw alone. States are drawn between the ends
    of their range, parameters from its values.
    """
    if not draws:
        return np.zeros((0, sum(len(axis.paths) for axis in axes)))
    chances = probabilities([axis.label for axis in axes], draws, seed)
    columns = []
    for axis, state, chance in zip(axes, states, chances, strict=True):
        if state:
            first, last = axis.values[:, [0]], axis.values[:, [-1]]
            columns.append(first + (last - first) * chance)
        else:
            columns.append(axis.values[:, (chance * len(axis)).astype(np.int64)])
    return np.concatenate(columns).T


def box_words(box: Sequence[Axis]) -> str:
    """The ranges of a box."""
    sides = [(side.label, *side.values[0, [0, -1]].tolist(), side.unit) for side in box]
    return "; ".join(f"{path}={a:.6g}:{b:.6g} {units}".rstrip() for path, a, b, units in sides)
