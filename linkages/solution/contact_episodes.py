"""Episodes of contact, and the effects of impacts.

A contact that lasts no longer than twice the impact of a free body at the same rate is an impact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.load_measures import End
from linkages.components.contributed.normal_forces import (
    Contact,
    NormalForce,
    OilFilm,
    RigidContact,
)
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Changed, Motion, Piece

if TYPE_CHECKING:
    from linkages.kernel.forces.contact_forces import GapNodes
    from linkages.kernel.forces.rigid_impacts import EndNodes, Unilateral

    Nodes = GapNodes | EndNodes

Floats = NDArray[np.float64]

Law = NormalForce | RigidContact | OilFilm

FREE, IMPACT, FOLLOWING = 0, 1, 2
STATES = ("free", "impact", "following")

AT_REST = 1e-8
"""Rate over the least one that bounces below which a rigid contact was not touched, but met."""

LONGEST = 2.0
"""Durations of an impact of a free body after which a contact follows the wall."""


class Touch(NamedTuple):
    """A touch: rate of the indentation (m/s), time in seconds, name of the contact."""

    rate: float
    time: float
    name: str


@dataclass(frozen=True)
class Episodes:
    """Contacts of one clearance: their begin and end within the motion, shape (contacts,)."""

    name: str  # of the clearance
    begin: Floats
    end: Floats
    # Rate of the indentation at each touch in m/s; nan for one that the motion starts in
    rate: Floats
    impact: NDArray[np.bool_]  # whether it is an impact
    # How often the journal touched its bearing; more than there are contacts here if not all were
    # kept
    touches: int

    @property
    def lasting(self) -> Floats:
        """How long each contact lasts in seconds, shape (contacts,)."""
        return np.abs(self.end - self.begin)

    def state(self, times: Floats) -> NDArray[np.int8]:
        """What is at some times: one of `STATES`, by its number."""
        result = np.full(len(times), FREE, dtype=np.int8)
        for begin, end, impact in zip(self.begin, self.end, self.impact, strict=True):
            result[(times >= begin) & (times <= end)] = IMPACT if impact else FOLLOWING
        return result


def episodes(motion: Motion) -> list[Episodes]:
    """The contacts of every clearance that opens."""
    system = motion.pieces[0].system
    # the nodes are those of all mechanisms of the structure, numbers are those of this one
    pairs = zip(system.model.contacts, system.mechanism.contacts, strict=True)
    return [_of_contact(motion, nodes, contact) for nodes, contact in pairs]


def states(motion: Motion) -> NDArray[np.int8]:
    """Numbers of `STATES` at the samples, shape (samples, clearances)."""
    names = motion.pieces[0].system.mechanism.clearance_names
    result = np.full((len(motion.time), len(names)), FOLLOWING, dtype=np.int8)
    for contact in episodes(motion):
        result[:, names.index(contact.name)] = contact.state(motion.time)
    return result


def rests(motion: Motion) -> list[Episodes]:
    """The contacts of every end of a way at which bodies bounce."""
    system = motion.pieces[0].system
    pairs = zip(system.model.ends, system.mechanism.ends, strict=True)
    return [_of_contact(motion, nodes, end) for nodes, end in pairs]


def slowest_touch(motion: Motion) -> Touch | None:
    """The touch of a motion at the smallest rate; None if nothing touches."""
    result = [
        Touch(float(rate), float(time), contact.name)
        for contact in (*episodes(motion), *rests(motion))
        for rate, time in zip(contact.rate, contact.begin, strict=True)
        if np.isfinite(rate)
    ]
    return min(result, default=None)


def touch_counts(motion: Motion) -> dict[str, int]:
    """How often journals touch bearings, blocks guides, bodies stops; by their names."""
    return {name: _count(motion, nodes, rigid) for name, nodes, rigid in _touched(motion)}


def touches_so_far(motion: Motion) -> Floats:
    """Touches up to each sample, shape (samples, contacts); nan after the last recorded one."""
    result, forward = [], 1.0 if motion.time[-1] >= motion.time[0] else -1.0
    for _, nodes, rigid in _touched(motion):
        changed = motion.changes.get(nodes.touch, Changed.none())
        times = changed.time[changed.rises] if changed.pieces else np.zeros(0)
        count = np.searchsorted(forward * times, forward * motion.time, side="right").astype(float)
        if len(times) < _count(motion, nodes, rigid):
            count[count == len(times)] = np.nan
        result.append(count)
    return np.array(result).T


def _touched(motion: Motion) -> Iterator[tuple[str, Nodes, bool]]:
    """Names of all contacts, what they are made of, and whether they are rigid."""
    system = motion.pieces[0].system
    for contact, gap in zip(system.mechanism.contacts, system.model.contacts, strict=True):
        yield contact.name, gap, _is_rigid(contact)
    for end, way in zip(system.mechanism.ends, system.model.ends, strict=True):
        yield end.name, way, _is_rigid(end)


def _count(motion: Motion, nodes: Nodes, rigid: bool) -> int:
    """Touches in a motion, also those that were not kept: with leaves they take turns."""
    changed = motion.changes.get(nodes.touch, Changed.none())
    beyond = changed.count - len(changed.rises)
    return int(changed.rises.sum()) + beyond // (1 if rigid else 2)


def _is_rigid(about: Contact | End) -> bool:
    law = about.law if isinstance(about, End) else about.normal
    return isinstance(law, RigidContact)


def _of_contact(motion: Motion, nodes: Nodes, about: Contact | End) -> Episodes:
    law = about.law if isinstance(about, End) else about.normal
    rigid = _is_rigid(about)
    changed = motion.changes.get(nodes.touch, Changed.none())
    time, rises = changed.time if changed.pieces else np.zeros(0), changed.rises
    rates, lasting = (row[rises] for row in _at_touches(changed, nodes, law))
    begin, end = time[rises], np.append(time, motion.stop_time)[1:][rises]
    if rigid:  # thrown back at once, or closed
        number = [switch.name for switch in nodes.model.switches.switches].index(nodes.touch)
        held = [piece.held for piece in changed.pieces if piece.held is not None]
        closed = np.concatenate([rows[number] > 0 for rows in held] or [rises])
        end = np.where(closed[rises], end, begin)
    if _touching_at_start(motion, nodes):
        begin, rates = np.append(motion.time[:1], begin), np.append(np.nan, rates)
        end = np.append(np.append(time, motion.stop_time)[:1], end)
        lasting = np.append(np.nan, lasting)
    touches = _count(motion, nodes, rigid)
    return Episodes(about.name, begin, end, rates, end - begin <= LONGEST * lasting, touches)


def _touching_at_start(motion: Motion, nodes: Nodes) -> bool:
    first = next((piece for piece in motion.pieces if len(piece.time)), None)
    return first is not None and bool(evaluate_nodes(first, [nodes.touching])[0, 0] > 0.0)


def _at_touches(changed: Changed, nodes: Nodes, law: Law) -> tuple[Floats, Floats]:
    """Rates at all changes, and how long impacts of free bodies would last, shape (changes,)."""
    model = nodes.model
    rows = [n for row in model.mass_matrix for n in row]
    along = [nodes.gap.rate(partial) for partial in model.partials]
    if not changed.pieces:
        return np.zeros(0), np.zeros(0)
    result = [evaluate_nodes(piece, [nodes.speed, *along, *rows]) for piece in changed.pieces]
    speed, *values = np.hstack(result)
    if isinstance(law, RigidContact):  # it comes to rest there with another one
        speed = np.where(np.abs(speed) <= AT_REST * law.least_rate.value, np.nan, speed)
    mass = _effective_mass(np.array(values[: len(along)]), np.array(values[len(along) :]))
    return speed, _duration(law, mass, np.abs(speed))


def _effective_mass(along: Floats, rows: Floats) -> Floats:
    """1/(N J⁻¹ Nᵀ) with the derivatives N of the indentation by the free coordinates."""
    count, times = along.shape
    inertia = np.zeros((times, count, count))
    lower = np.tril_indices(count)
    inertia[:, lower[0], lower[1]] = inertia[:, lower[1], lower[0]] = rows.T
    column = along.T[:, :, None]
    moved = np.linalg.solve(inertia, column)
    return np.asarray(1.0 / (column * moved).sum(axis=(1, 2)))


def _duration(law: Law, mass: Floats, speed: Floats) -> Floats:
    """Of an elastic impact: 2 (d/v) √π Γ(1 + 1/m)/Γ(1/2 + 1/m) with m = n + 1."""
    if not isinstance(law, NormalForce):
        return np.zeros(speed.shape)
    stiffness, exponent = law.numbers
    power = exponent.value + 1.0
    factor = 2.0 * math.sqrt(math.pi) * math.gamma(1.0 + 1.0 / power)
    factor /= math.gamma(0.5 + 1.0 / power)
    with np.errstate(divide="ignore"):
        deepest = (power * mass * speed**2 / (2.0 * stiffness.value)) ** (1.0 / power)
        return np.asarray(factor * deepest / speed)


def unrecorded(motion: Motion) -> str:
    """Which impacts of a motion are not all recorded, in words; empty if all are."""
    for contact in motion.pieces[0].system.model.rigid:
        changed = motion.changes.get(contact.touch, Changed.none())
        known = len(changed.rises)
        if changed.count > known:
            return f"'{contact.touch}' changes {changed.count} times, of which {known} are recorded"
    return ""


_LESS = 1e-6
"""Part of a restitution that is not taken for round-off."""


def energy_of_impacts(motion: Motion) -> Floats:
    """Energy that rigid impacts have given up to each sample, with the impulses of drives, in J."""
    result = np.zeros(len(motion.time))
    model = motion.pieces[0].system.model
    (kinetic,) = VARIABLES["kinetic_energy"].evaluated(model)
    for contact in model.rigid:
        for piece, rises in _impacts(motion, contact):
            gained = evaluate_nodes(behind(piece, contact), [kinetic])[0]
            gained -= evaluate_nodes(piece, [kinetic])[0]
            result += _since(motion, piece.time[rises], gained[rises])
    return result


def losses_of_impacts(motion: Motion) -> tuple[Floats, Floats]:
    """Energy in J lost in impacts up to each sample, across walls and along, (samples, contacts).

    An impulse P takes P (d'⁻ + d'⁺)/2 with the rates of the indentation before and after the impact
    (Kelvin), also in other contacts that are closed; friction likewise with its impulse and the
    slip. Where slip ends within an impact, this holds for the sum of both alone.
    """
    walls = motion.pieces[0].system.model.walls
    count, rough = len(walls.contacts), walls.rough
    across, along = np.zeros((2, len(motion.time), count))
    rates = [-contact.speed for contact in walls.contacts]
    rates += [rubbing.slip for rubbing in rough.values()]
    places = [*range(count), *rough]
    for contact in walls.contacts:
        for piece, rises in _impacts(motion, contact):
            nodes = [*contact.impulses, *contact.rubbed]
            impulses, rubbed = np.split(evaluate_nodes(piece, nodes), [len(places)])
            both = evaluate_nodes(piece, rates) + evaluate_nodes(behind(piece, contact), rates)
            for place, lost in zip(places, -0.5 * impulses * both, strict=True):
                across[:, place] += _since(motion, piece.time[rises], lost[rises])
            for place, lost in zip(rough, rubbed, strict=True):
                taken = _since(motion, piece.time[rises], lost[rises])
                along[:, place] += taken
                across[:, place] -= taken
    return across, along


def sliding_in_impacts(motion: Motion) -> Iterator[tuple[Piece, Floats, Floats]]:
    """States before rigid impacts, with work of sliding (J) and impulses (N s) of what wears.

    Shapes are (terms, impacts), in the order of `Mechanism.rubbing`.

    Raises
    ------
    ComputationError
        If more impacts were met than are recorded.
    """
    model = motion.pieces[0].system.model
    if not model.mechanism.rubbing or not model.rigid:
        return
    from linkages.kernel.forces.sliding import SlidingNodes

    if result := unrecorded(motion):
        raise ComputationError(f"{result}; expected a shorter motion for wear", time=None)
    for place, contact in enumerate(model.rigid):
        for piece, rises in _impacts(motion, contact):
            if not rises.any():
                continue
            own, here = piece.part(rises), piece.system.model
            hit = here.rigid[place]
            terms = [SlidingNodes(here, term) for term in here.mechanism.rubbing]
            nodes = [term.in_impact(hit) for term in terms] + [term.impulse(hit) for term in terms]
            work, impulses = np.split(evaluate_nodes(own, nodes), 2)
            yield own, work, impulses


def slid(motion: Motion) -> tuple[Floats, Floats]:
    """Work (J) and distance (m) of slip of what wears up to each sample, (terms, samples).

    Impacts take no time, and add no distance.
    """
    mechanism, losses = motion.pieces[0].system.mechanism, motion.losses
    assert losses is not None
    work, distance = np.split(losses[2 * len(mechanism.contacts) :], 2)
    for piece, taken, _ in sliding_in_impacts(motion):
        work = work + [_since(motion, piece.time, row) for row in taken]
    return work, distance


def less_restored(motion: Motion) -> int:
    """How many impacts had less than their restitution, because energy would have grown."""
    model, count = motion.pieces[0].system.model, 0
    if not model.rigid:
        return 0
    walls = model.walls
    for contact in walls.contacts if walls.rough else ():
        for piece, rises in _impacts(motion, contact):
            (part,) = evaluate_nodes(piece, [walls.restored(contact)])
            count += int((part[rises] < 1.0 - _LESS).sum())
    return count


def behind(piece: Piece, contact: Unilateral) -> Piece:
    """States behind impacts of a contact."""
    state, count = piece.state.copy(), len(piece.state) // 2
    rates = evaluate_nodes(piece, contact.rates_behind)
    state[count : count + len(rates)] = rates
    return replace(piece, state=state)


def _impacts(motion: Motion, contact: Unilateral) -> list[tuple[Piece, NDArray[np.bool_]]]:
    """States before changes of a contact, and which of these are impacts."""
    changed = motion.changes.get(contact.touch)
    if changed is None:
        return []
    parts = np.cumsum([len(piece.time) for piece in changed.pieces])[:-1]
    return list(zip(changed.pieces, np.split(changed.rises, parts), strict=True))


def _since(motion: Motion, times: Floats, amounts: Floats) -> Floats:
    """Sums of what came before each sample."""
    order = np.argsort(times, kind="stable")
    sums = np.concatenate([[0.0], np.cumsum(amounts[order])])
    return np.asarray(sums[np.searchsorted(times[order], motion.time, side="left")])
