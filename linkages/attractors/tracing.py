"""Attractors that are followed from value to value of a parameter until they are lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from linkages.attractors.matching import LINKED, SAME, Attractor, distance
from linkages.attractors.settling import (
    Clock,
    Kind,
    Settled,
    leaves,
    sections,
    settling,
)
from linkages.attractors.starts import Starts
from linkages.chaos.continuation import end_of
from linkages.chaos.free_states import circular
from linkages.errors import LinkagesError
from linkages.solution.many import Going, side_by_side
from linkages.solution.motion import Motion
from linkages.sweeps.axes import Axis

Floats = NDArray[np.float64]

STEPS = 8
"""Parts in which a parameter changes from a value to the next where an attractor is followed."""


@dataclass(frozen=True)
class Jump:
    """Where an attractor is lost as a parameter changes.

    `lost`, `became`: places of the attractor and of that which its motion tends to behind; None
    where that is not known.
    `last`, `behind`: numbers of the values between which it is lost.
    """

    lost: int
    became: int | None
    last: int
    behind: int


@dataclass(eq=False)
class Traced:
    """Attractors at all values, those met by starts first, then those that were followed there."""

    attractors: list[Attractor]  # at their values, which are their `node`
    jumps: list[Jump] = field(default_factory=list)  # where they are lost


def traced(question: Starts, axis: Axis, met: Sequence[Attractor], scale: Floats) -> Traced:
    """Follow each attractor to both sides until it is lost, as hysteresis does it.

    At a neighbouring value at which none of its kind is near, a motion starts from its last state.
    It tends to the same attractor moved, to one that starts met there, or to another one, which is
    followed as well.

    Parameters
    ----------
    met
        Attractors by value; undecided motions are not followed.
    scale
        Range of each entry of states.
    """
    result = Traced([each for each in met if each.kind != Kind.UNDECIDED])
    angles = circular(question.first)
    ends: dict[int, Settled] = {}
    for way in (1, -1):
        values = range(len(axis))[::way]
        for pair in pairwise(values):
            _step(question, axis, result, pair, ends, angles, scale)
    return result


def _step(
    question: Starts,
    axis: Axis,
    found: Traced,
    way: tuple[int, int],
    ends: dict[int, Settled],
    angles: NDArray[np.bool_],
    scale: Floats,
) -> None:
    """Follow what has no counterpart from one value to the next."""
    here, there = way
    own, other = (_at(found.attractors, node) for node in (here, there))

    def away(one: int, two: int) -> float:
        return distance(found.attractors[one], found.attractors[two], angles, scale)

    def counterpart(index: int) -> bool:
        near = min(((away(index, one), one) for one in other), default=(np.inf, -1))
        back = min((away(one, near[1]) for one in own), default=np.inf) if near[1] >= 0 else np.inf
        return near[0] <= LINKED and near[0] <= back

    lost = [index for index in own if not counterpart(index)]
    again = zip(lost, _ends(question, found, lost, ends), strict=True)
    ends.update({index: settled for index, settled in again if isinstance(settled, Settled)})
    tried = [index for index in lost if index in ends]
    moved = side_by_side([_moved(question, axis, ends[index], way) for index in tried])
    for index in lost:
        new = moved[tried.index(index)] if index in tried else None
        became = None
        if isinstance(new, Settled):
            made = Attractor.of(vars(new), -1, there)
            near = [
                n
                for n in _at(found.attractors, there)
                if _same(found, n, made, question, angles, scale)
            ]
            if near:
                became = near[0]
            else:
                became = len(found.attractors)
                found.attractors.append(made)
                ends[became] = new
                if distance(found.attractors[index], made, angles, scale) <= LINKED:
                    continue
        found.jumps.append(Jump(index, became, here, there))


def _at(attractors: Sequence[Attractor], node: int) -> list[int]:
    return [index for index, each in enumerate(attractors) if each.node == node]


def _same(
    found: Traced,
    index: int,
    made: Attractor,
    question: Starts,
    angles: NDArray[np.bool_],
    scale: Floats,
) -> bool:
    """Whether an attractor is that of a place: that of many side by side, if it is a family."""
    known = found.attractors[index]
    away = distance(known, made, angles, scale)
    if known.kind >= Kind.QUASI_PERIODIC:
        return bool(away <= LINKED)
    alike = known.kind == made.kind and len(known.points) == len(made.points)
    return bool(away <= SAME * question.options.settled) or (known.family and alike)


def _ends(
    question: Starts, found: Traced, places: Sequence[int], ends: dict[int, Settled]
) -> list[Settled | LinkagesError]:
    """Where the motions end that showed some attractors."""
    missing = [place for place in places if place not in ends]
    made = question.again([found.attractors[place].place for place in missing])
    again = dict(zip(missing, made, strict=True))
    return [ends[place] if place in ends else again[place] for place in places]


def _moved(
    question: Starts, axis: Axis, settled: Settled, way: tuple[int, int]
) -> Going[Settled | None]:
    """What a motion tends to from a state at another value; None if that attracts nothing.

    The parameter changes in small steps, so that the motion is lost where its attractor is, and not
    thrown out of its basin before.
    """
    first, last = (axis.values[:, node] for node in way)
    result, system = settled, settled.march.system
    for step in range(1, STEPS + 1):
        end = end_of(result.march.system, Motion(pieces=(result.march.sample,)))
        between = last if step == STEPS else first + (last - first) * (step / STEPS)
        here = Axis(axis.paths, between[:, None], axis.unit)
        system = end.system(question.varying.mechanism_at(here.at(0)))
        clock = Clock.of(system, question.options)
        guards = () if clock.driven else sections(system)
        result = yield from settling(system, clock, question.options, guards)
    if result.kind == Kind.UNDECIDED:
        return None
    if result.kind < Kind.QUASI_PERIODIC:
        left = yield from leaves(result, question.clock(system, way[1]), question.options)
        if left:
            return None
    return result


def renumbered(jumps: Sequence[Jump], numbers: Sequence[int]) -> list[Jump]:
    """The same with the numbers of families, without those within one."""
    made = [
        replace(
            jump,
            lost=numbers[jump.lost],
            became=None if jump.became is None else numbers[jump.became],
        )
        for jump in jumps
    ]
    return [jump for jump in made if jump.lost != jump.became]
