"""How contacts change on an orbit: their sequence, near misses, and what tells two orbits apart."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar
from linkages.kernel.switches import Switch
from linkages.orbits.shooting import Change, Shooting, Shot
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.guards import Guard

Floats = NDArray[np.float64]

TOUCH, PRESS = ": touch", ": press"
"""How names of switches end that say whether a contact is closed, and whether it presses."""


GRADIENT_STEP = 1e-5
"""Step of differences of a gap, in amplitudes; gaps are smooth and known to round-off."""


class Miss(NamedTuple):
    """An extremum of what a switch watches: its time, its value, and its second derivative."""

    time: float
    value: float
    second: float

    @property
    def highest(self) -> bool:
        """Whether it is a maximum."""
        return self.second < 0.0


class Difference(NamedTuple):
    """What tells the contacts of two orbits apart.

    `kind`: grazing, contact loss, sticking or contact sequence.
    `name`: of the switch.
    `time`: of the additional contact, in the orbit that has it; nan if there is none.
    `more`: whether the second orbit has it.
    """

    kind: str
    name: str
    time: float
    more: bool


def switch_named(model: Model, name: str) -> Switch:
    """The switch of a name, of a model whose accelerations are known."""
    _ = model.changes
    return next(switch for switch in model.switches.switches if switch.name == name)


@lru_cache(maxsize=64)
def watched_function(model: Model, name: str) -> Scalar:
    """What a switch watches; of rigid contacts the indentation, without what holds pins at rest."""
    _ = model.changes
    rigid = {contact.touch: contact.gap.indentation for contact in model.rigid}
    return rigid[name] if name in rigid else switch_named(model, name).function


@lru_cache(maxsize=64)
def watched_rate(model: Model, name: str) -> Scalar:
    """Its rate."""
    accelerations = model.integrated_accelerations(model.changes)
    return model.switches.rates([watched_function(model, name)], accelerations)[0]


@lru_cache(maxsize=64)
def _second(model: Model, name: str) -> Scalar:
    """The rate of that."""
    accelerations = model.integrated_accelerations(model.changes)
    return model.switches.rates([watched_rate(model, name)], accelerations)[0]


def rigid_touches(model: Model) -> list[str]:
    """Names of the switches at which rates of bodies jump."""
    _ = model.changes
    return [switch.name for switch in model.switches.switches if switch.jump and not switch.updates]


def extremum_guard(name: str) -> Guard:
    """What finds extrema of what a switch watches, which must not depend on accelerations."""

    def nodes(model: Model) -> tuple[Scalar, Scalar]:
        return watched_rate(model, name), _second(model, name)

    return Guard(nodes=nodes, key=("extremum", name), name=name)


def misses(shots: Sequence[Shot], name: str) -> list[Miss]:
    """Extrema of what a switch watches, in motions that looked for them."""
    result = []
    for shot in shots:
        for piece in shot.motion.crossings[name].pieces:
            if not len(piece.time):
                continue
            model = piece.system.model
            rows = evaluate_nodes(piece, [watched_function(model, name), _second(model, name)])
            for time, value, second in zip(piece.time.tolist(), *rows.tolist(), strict=True):
                result.append(Miss(time, value, second))
    return result


def touch_rates(shots: Sequence[Shot], names: Sequence[str]) -> list[tuple[str, float, float]]:
    """Name, time and rate of every touch of rigid contacts."""
    result = []
    for shot in shots:
        for name in names:
            changed = shot.motion.changes.get(name)
            if changed is None:
                continue
            rises = iter(changed.rises.tolist())
            for piece in changed.pieces:
                if not len(piece.time):
                    continue
                (rate,) = evaluate_nodes(piece, [watched_rate(piece.system.model, name)])
                for time, value in zip(piece.time.tolist(), rate.tolist(), strict=True):
                    if next(rises):
                        result.append((name, time, value))
    return result


def watched_gradient(
    shooting: Shooting, places: Floats, shot: Shot, time: float, name: str
) -> Floats:
    """Gradient of what a switch watches by the state at the end of a motion, shape (x,)."""
    steps = GRADIENT_STEP * np.diag(shooting.scale)
    states = [*(shot.end + steps), *(shot.end - steps)]
    systems = [shooting.system_at(places, state) for state in states]
    system = systems[0]
    names = system.model.switches.names
    held = np.array([[shot.held[each][0]] for each in names])
    (row,) = system.evaluate(
        [watched_function(system.model, name)],
        np.full(len(states), time),
        np.array([each.state for each in systems]).T,
        held=np.repeat(held, len(states), axis=1),
    )
    half = len(states) // 2
    return np.asarray((row[:half] - row[half:]) / (2 * GRADIENT_STEP * shooting.scale))


def sequence(changes: Sequence[Change]) -> tuple[tuple[str, bool], ...]:
    """Switches that change over an orbit, from a place that does not depend on its beginning."""
    own = [(change.name, change.rises) for change in changes]
    return min((tuple(own[k:] + own[:k]) for k in range(len(own))), default=())


def contacts(changes: Sequence[Change]) -> int:
    """How often a contact closes."""
    return sum(change.rises and change.name.endswith(TOUCH) for change in changes)


def difference(
    before: Sequence[Change], after: Sequence[Change], period: float, rigid: Sequence[str]
) -> Difference | None:
    """What tells the contacts of two neighbouring orbits apart; None if nothing does."""
    if sequence(before) == sequence(after):
        return None
    counts = [Counter((c.name, c.rises) for c in side) for side in (before, after)]
    apart = {
        key: counts[1][key] - counts[0][key]
        for key in sorted({*counts[0], *counts[1]})
        if counts[1][key] != counts[0][key]
    }
    if not apart:
        return Difference("contact sequence", before[0].name, np.nan, True)
    for (name, _), number in apart.items():
        own = [c for c in (after if number > 0 else before) if c.name == name]
        if name.endswith(TOUCH) and name in rigid:
            return Difference("grazing", name, np.nan, number > 0)
        if name.endswith(TOUCH):
            time, closed = _shortest(own, period)
            return Difference("grazing" if closed else "contact loss", name, time, number > 0)
    (name, _), number = next(iter(apart.items()))
    kind = "contact loss" if name.endswith(PRESS) else "sticking"
    return Difference(kind, name, np.nan, number > 0)


def _shortest(changes: Sequence[Change], period: float) -> tuple[float, bool]:
    """Middle of the shortest time between changes of a switch, and whether it is closed then."""
    best = (np.inf, np.nan, True)
    for first, second in zip(changes, [*changes[1:], changes[0]], strict=True):
        lasting = (second.time - first.time) % period if len(changes) > 1 else period
        if first.rises != second.rises and lasting < best[0]:
            best = lasting, (first.time + 0.5 * lasting) % period, first.rises
    return best[1], best[2]
