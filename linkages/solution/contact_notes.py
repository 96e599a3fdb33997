"""Notes on contacts after a motion: counts, speeds, durations, depths, dissipation."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.normal_forces import Contact, NormalForce, OilFilm
from linkages.components.joint_clearances import ContactClearance
from linkages.solution.contact_episodes import (
    FREE,
    STATES,
    Episodes,
    episodes,
    less_restored,
    losses_of_impacts,
    rests,
    slid,
    states,
    touches_so_far,
)
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.motion import Motion
from linkages.solution.series import OF_CONTACTS

if TYPE_CHECKING:
    from linkages.kernel.forces.contact_forces import GapNodes
    from linkages.solution.contact_episodes import Nodes

Floats = NDArray[np.float64]


def nearest_miss(motion: Motion, nodes: Nodes, found: Episodes) -> tuple[float, float] | None:
    """The least gap (m or rad) that opens again, and its time; None where there is none.

    It lies between two samples in free flight, on the cubic through both gaps and their rates.
    """
    least: tuple[float, float] | None = None
    jumps = np.sort(np.concatenate([found.begin, *_impacts(motion)]))
    for piece in motion.pieces:
        if len(piece.time) < 2:
            continue
        depth, rate = evaluate_nodes(piece, [nodes.gap.indentation, nodes.speed])
        time, step = piece.time[:-1], np.diff(piece.time)
        forward = np.sign(step)
        free = found.state(piece.time) == FREE
        apart = free[:-1] & free[1:] & ~_between(piece.time, jumps)
        turns = apart & (forward * rate[:-1] > 0.0) & (forward * rate[1:] < 0.0)
        for k in np.flatnonzero(turns):
            top, at = _top(depth[k], step[k] * rate[k], depth[k + 1], step[k] * rate[k + 1])
            if least is None or -top < least[0]:
                least = max(-top, 0.0), float(time[k] + at * step[k])
    return least


def _impacts(motion: Motion) -> list[Floats]:
    """Times at which rates jump, those of other contacts as well."""
    rigid = motion.pieces[0].system.model.rigid
    changes = (motion.changes.get(contact.touch) for contact in rigid)
    return [changed.time for changed in changes if changed is not None]


def _between(time: Floats, jumps: Floats) -> NDArray[np.bool_]:
    """Whether something happens between each two samples."""
    low, high = np.minimum(time[:-1], time[1:]), np.maximum(time[:-1], time[1:])
    first, last = (np.searchsorted(jumps, ends) for ends in (low, high))
    return np.asarray(last > first)


def _top(start: float, rise: float, end: float, fall: float) -> tuple[float, float]:
    """Greatest value on [0, 1] of the cubic with these values and slopes at 0 and 1, and where."""
    change = end - start
    c2, c3 = 3.0 * change - 2.0 * rise - fall, rise + fall - 2.0 * change
    roots = np.roots([3.0 * c3, 2.0 * c2, rise])
    real = roots[np.isreal(roots)].real
    places = [0.0, *real[(real > 0.0) & (real < 1.0)], 1.0]
    values = [start + x * (rise + x * (c2 + x * c3)) for x in places]
    best = int(np.argmax(values))
    return float(values[best]), float(places[best])


DEEPEST = 0.1
"""Indentation over size above which the laws of small areas of contact are extrapolated."""

WIDEST = math.radians(20.0)
"""Half angle of a contact above which they are, too."""

THINNEST = 0.05
"""Thickness of a film over the size below which the eccentricity says that it is none."""

MANY_STEPS = 10_000
"""Of an explicit method, from which on an implicit one is recommended for a film."""

LASTING = 0.5
"""Part of a motion that a contact lasts to be called one that is not lost again."""


GRAZING = 0.01
"""Part of the rate of the touch before it below which a touch grazes: no chatter is that fast."""

MISSED = 0.01
"""Part of the size that a gap closes to, and opens again, for a motion that nearly touches.

Of a stop it is a part of how far the motion is from it at most.
"""


def contact_notes(motion: Motion) -> list[str]:
    """A sentence on each clearance that opens, and on what its law is not made for; on stops."""
    system = motion.pieces[0].system
    contacts, ends = system.mechanism.contacts, system.mechanism.ends
    if not (contacts or ends) or len(motion.time) < 2:
        return []
    rows = zip(system.model.contacts, contacts, episodes(motion), strict=True)
    said = [note for row in rows for note in _notes(motion, *row)]
    if less := less_restored(motion):
        said.append(
            f"{less} impacts with friction bounced less than their restitution says: with all of "
            "it energy would have grown"
        )
    if ends:
        for nodes, end, rest in zip(system.model.ends, ends, rests(motion), strict=True):
            unit = "rad" if end.twists else "m"
            summary = _summary(motion, rest, f"{unit}/s")
            said += [f"stop {rest.name}: {summary}", *_grazes(rest, f"{unit}/s")]
            said += _misses(motion, nodes, rest, _farthest(motion, nodes), unit)
    return said


def _grazes(found: Episodes, unit: str = "m/s") -> Iterator[str]:
    """Touches that neighbours of the motion miss."""
    rate, begin = found.rate[1:], found.begin[1:]
    slow = np.flatnonzero(rate < GRAZING * found.rate[:-1])
    if len(slow):
        least = slow[np.argmin(rate[slow])]
        yield (
            f"{found.name} grazes at t = {begin[least]:.6g} s, at {rate[least]:.3g} {unit}: "
            "neighbours that miss the wall move otherwise, so exponents converge slowly"
        )


def _farthest(motion: Motion, nodes: Nodes) -> float:
    """How far from its end a motion is at most: a stop has no size."""
    depths = (evaluate_nodes(piece, [nodes.gap.indentation]) for piece in motion.pieces)
    return max(float(-depth.min(initial=0.0)) for depth in depths)


def _misses(
    motion: Motion, nodes: Nodes, found: Episodes, size: float, unit: str = "m"
) -> Iterator[str]:
    """Where neighbours touch and the motion does not."""
    miss = nearest_miss(motion, nodes, found)
    if miss is not None and miss[0] < MISSED * size:
        gap, time = miss
        yield (
            f"{found.name} nearly touches at t = {time:.6g} s: the gap closes to {gap:.3g} {unit}, "
            "and neighbours that touch the wall move otherwise, so exponents converge slowly"
        )


def _notes(motion: Motion, nodes: GapNodes, contact: Contact, found: Episodes) -> Iterator[str]:
    name, normal, size = contact.called, contact.normal, contact.size.value
    deepest = max(
        float(evaluate_nodes(piece, [nodes.gap.indentation]).max(initial=-np.inf))
        for piece in motion.pieces
    )
    if isinstance(normal, OilFilm):
        yield _of_film(name, -deepest, size)
        steps = motion.cost.get("steps", 0)
        if steps >= MANY_STEPS and motion.method != "radau":
            yield (
                f"{name}: {motion.method} took {steps:,} steps; a thin film is stiff and "
                "bounds them, while those of --method radau follow the tolerance alone"
            )
        return
    yield f"{name}: {_summary(motion, found)}"
    yield from _grazes(found)
    yield from _misses(motion, nodes, found, size)
    if deepest > DEEPEST * size:
        yield (
            f"{name}: the indentation reaches {deepest:.3g} m, {deepest / size:.0%} of "
            f"the size; laws of contact are made for less than {DEEPEST:.0%}"
        )
    yield from _wide(motion, nodes, found.name)
    remembers = isinstance(normal, NormalForce) and normal.least_rate is not None
    if remembers and np.isnan(found.rate[:1]).any():
        yield (
            f"{name} touches from the start, and no state says how fast it was touched: "
            "the damping is that of the present rate"
        )
    lasting = found.lasting[-1:] > LASTING * abs(motion.stop_time - motion.time[0])
    follows = len(found.end) and found.end[-1] == motion.stop_time and not found.impact[-1]
    if remembers and follows and lasting.all():
        yield (
            f"{name} has followed its wall since t = {found.begin[-1]:.6g} s; its "
            "damping is what the rate of that touch has made it, so that other starts end on "
            "other motions: hunt-crossley-constant has no such memory"
        )


def _wide(motion: Motion, nodes: GapNodes, name: str) -> Iterator[str]:
    """How far around the pin the contact reaches, where material and width tell."""
    named = {own.name: own for own in motion.pieces[0].system.mechanism.clearances}
    own = named.get(name)  # not that of a corner
    if not isinstance(own, ContactClearance):
        return
    pressed = max(
        float(evaluate_nodes(piece, [nodes.force]).max(initial=0.0)) for piece in motion.pieces
    )
    half = own.half_angle(pressed)
    if half is not None and half > WIDEST:
        yield (
            f"clearance {name}: under {pressed:.3g} N the contact reaches "
            f"{math.degrees(half):.0f}° to either side; laws of contact are made for less than "
            f"{math.degrees(WIDEST):.0f}°, and beyond it journal and bearing conform (Persson 1964)"
        )


def _of_film(name: str, thinnest: float, size: float) -> str:
    """How thin a film gets, and whether there would be one."""
    result = f"{name}: the film is at least {thinnest:.3g} m thick, {thinnest / size:.1%}"
    if thinnest >= THINNEST * size:
        return f"{result} of the size"
    return (
        f"{result} of the size; below {THINNEST:.0%} real surfaces touch, and the theory of short "
        "bearings ends: expected more viscosity or width, or a law of contact"
    )


def _summary(motion: Motion, found: Episodes, unit: str = "m/s") -> str:
    """Touches, their rates, and parts of the time in each state."""
    if not found.touches:
        return "contact throughout" if len(found.begin) else "free throughout"
    rates = found.rate[np.isfinite(found.rate)]
    count = f"{found.touches} touch{'es' if found.touches > 1 else ''}"
    whole = abs(motion.stop_time - motion.time[0])
    impact, following = (float(found.lasting[kind].sum()) for kind in (found.impact, ~found.impact))
    parts = zip((whole - impact - following, impact, following), STATES, strict=True)
    shares = ", ".join(f"{part / whole:.0%} {state}" for part, state in parts)
    if not len(rates):  # it met its wall in impacts of others
        return f"{count}; {shares}"
    return f"{count} at {rates.min():.3g} to {rates.max():.3g} {unit}; {shares}"


def dissipated(motion: Motion) -> tuple[Floats, Floats]:
    """Energy in J dissipated up to each sample across walls and along, (samples, clearances)."""
    model, losses = motion.pieces[0].system.model, motion.losses
    assert losses is not None
    places = {name: k for k, name in enumerate(model.mechanism.clearance_names)}
    own = [places[nodes.contact.name] for nodes in model.contacts]
    result = np.zeros((2, len(motion.time), len(places)))
    result[:, :, own] = losses[: 2 * len(own)].reshape(2, len(own), -1).transpose(0, 2, 1)
    impacts = losses_of_impacts(motion)
    for number, contact in enumerate(model.rigid):
        if contact.geometry is not None:  # a stop is no clearance
            for row, lost in zip(result, impacts, strict=True):
                row[:, places[contact.name]] += lost[:, number]
    return result[0], result[1]


def _slid(motion: Motion) -> Floats:
    """Work (J) and distance (m) of slip up to each sample, (2, samples, clearances)."""
    mechanism = motion.pieces[0].system.mechanism
    names = mechanism.clearance_names
    own = [names.index(term.name) for term in mechanism.rubbing]
    result = np.zeros((2, len(motion.time), len(names)))
    result[:, :, own] = np.transpose(slid(motion), (0, 2, 1))
    return result


def worn_volumes(motion: Motion) -> Floats:
    """Volumes (m³) worn up to each sample by Archard's law, (samples, clearances, sides)."""
    mechanism = motion.pieces[0].system.mechanism
    rates = np.zeros((len(mechanism.clearance_names), 2))
    for own in mechanism.worn:
        assert own.wear is not None
        for place, name in enumerate(mechanism.clearance_names):
            if name == own.name or name.startswith(f"{own.name}.corner"):
                rates[place] = own.wear.rates
    return np.asarray(_slid(motion)[0][:, :, None] * rates)


_COMPUTED: list[Callable[[Motion], NDArray[Any]]] = [
    states,
    touches_so_far,
    lambda motion: np.sum(losses_of_impacts(motion), axis=0),
    lambda motion: dissipated(motion)[0],
    lambda motion: dissipated(motion)[1],
    lambda motion: _slid(motion)[0],
    lambda motion: _slid(motion)[1],
    worn_volumes,
]

CONTACT_OUTPUTS = dict(zip(OF_CONTACTS, _COMPUTED, strict=True))
"""Outputs that jump at changes of mode, and what computes them at samples of a motion."""
