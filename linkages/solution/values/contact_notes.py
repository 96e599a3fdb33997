"""What is said of contacts after a motion: how often, how fast, how long, how deep."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from linkages.components.contact_clearance import ContactClearance
from linkages.components.contributed.contacts import Contact, NormalForce, OilFilm
from linkages.kernel.forces.across import GapNodes
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Motion
from linkages.solution.values.episodes import STATES, Episodes, Nodes, episodes, rests
from linkages.solution.values.impacts import less_restored
from linkages.solution.values.near_misses import nearest_miss

DEEPEST = 0.1
"""Indentation over size above which the laws of small areas of contact are extrapolated."""

WIDEST = math.radians(20.0)
"""Half angle of a contact above which they are, too."""

THINNEST = 0.05
"""Thickness of a film over the size below which the eccentricity says that it is none."""

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
        for nodes, end, found in zip(system.model.ends, ends, rests(motion), strict=True):
            unit = "rad" if end.twists else "m"
            summary = _summary(motion, found, f"{unit}/s")
            said += [f"stop {found.name}: {summary}", *_grazes(found, f"{unit}/s")]
            said += _misses(motion, nodes, found, _farthest(motion, nodes), unit)
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
    name, normal, size = found.name, contact.normal, contact.size.value
    deepest = max(
        float(evaluate_nodes(piece, [nodes.gap.indentation]).max(initial=-np.inf))
        for piece in motion.pieces
    )
    if isinstance(normal, OilFilm):
        yield _of_film(name, -deepest, size)
        return
    yield f"clearance {name}: {_summary(motion, found)}"
    yield from _grazes(found)
    yield from _misses(motion, nodes, found, size)
    if deepest > DEEPEST * size:
        yield (
            f"clearance {name}: the indentation reaches {deepest:.3g} m, {deepest / size:.0%} of "
            f"the size; laws of contact are made for less than {DEEPEST:.0%}"
        )
    yield from _wide(motion, nodes, name)
    remembers = isinstance(normal, NormalForce) and normal.least_rate is not None
    if remembers and np.isnan(found.rate[:1]).any():
        yield (
            f"clearance {name} touches from the start, and no state says how fast it was touched: "
            "the damping is that of the present rate"
        )
    lasting = found.lasting[-1:] > LASTING * abs(motion.stop_time - motion.time[0])
    follows = len(found.end) and found.end[-1] == motion.stop_time and not found.impact[-1]
    if remembers and follows and lasting.all():
        yield (
            f"clearance {name} has followed its wall since t = {found.begin[-1]:.6g} s; its "
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
    found = f"clearance {name}: the film is at least {thinnest:.3g} m thick, {thinnest / size:.1%}"
    if thinnest >= THINNEST * size:
        return f"{found} of the size"
    return (
        f"{found} of the size; below {THINNEST:.0%} real surfaces touch, and the theory of short "
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
