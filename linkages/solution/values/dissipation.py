"""Energy that contacts in clearances dissipate, across their walls and along them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.solution.moving.motion import Motion
from linkages.solution.values.impacts import losses_of_impacts

Floats = NDArray[np.float64]


def dissipated(motion: Motion) -> tuple[Floats, Floats]:
    """Energy dissipated up to each sample across walls and along them, in J.

    Powers of forces are integrated along with the motion; impacts of rigid bodies add theirs.

    Returns
    -------
    Shape (samples, clearances) each; zero where journal and bearing cannot part.
    """
    model, losses = motion.pieces[0].system.model, motion.losses
    assert losses is not None
    places = {name: k for k, name in enumerate(model.mechanism.clearance_names)}
    own = [places[nodes.contact.name] for nodes in model.contacts]
    found = np.zeros((2, len(motion.time), len(places)))
    found[:, :, own] = losses.reshape(2, len(own), -1).transpose(0, 2, 1)
    impacts = losses_of_impacts(motion)
    for number, contact in enumerate(model.walls.contacts):
        if contact.geometry is not None:  # a stop is no clearance
            for row, lost in zip(found, impacts, strict=True):
                row[:, places[contact.name]] += lost[:, number]
    return found[0], found[1]
