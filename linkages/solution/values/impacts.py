"""What impacts of rigid contacts did to a motion: energy that they took, and where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.forces.impacts import Unilateral
from linkages.kernel.outputs import VARIABLES
from linkages.solution.moving.evaluation import evaluate_nodes
from linkages.solution.moving.motion import Motion, Piece

Floats = NDArray[np.float64]

_LESS = 1e-6
"""Part of a restitution that is not taken for round-off."""


def energy_of_impacts(motion: Motion) -> Floats:
    """Energy that rigid impacts have given up to each sample, with the impulses of drives, in J."""
    found = np.zeros(len(motion.time))
    model = motion.pieces[0].system.model
    (kinetic,) = VARIABLES["kinetic_energy"].evaluated(model)
    for contact in model.walls.contacts:
        for piece, rises in _impacts(motion, contact):
            gained = evaluate_nodes(behind(piece, contact), [kinetic])[0]
            gained -= evaluate_nodes(piece, [kinetic])[0]
            found += _since(motion, piece.time[rises], gained[rises])
    return found


def losses_of_impacts(motion: Motion) -> tuple[Floats, Floats]:
    """Energy that impacts have lost up to each sample, across walls and along them, in J.

    What an impulse P takes is P (d'⁻ + d'⁺)/2, with the rates of the indentation before and behind
    the impact (Kelvin); in an impact of one contact others that are closed take impulses as well.
    What friction takes is the same with its impulse and the slip. Where slip ends within an impact
    this holds for the sum of both alone; friction takes what it does up to there and from there.

    Returns
    -------
    Shape (samples, rigid contacts) each.
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


def less_restored(motion: Motion) -> int:
    """How many impacts had less than their restitution, because energy would have grown."""
    walls, count = motion.pieces[0].system.model.walls, 0
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
