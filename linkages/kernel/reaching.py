"""How far from assembly a mechanism is that cannot be assembled."""

from __future__ import annotations

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.assembly.settling import Settling
from linkages.kernel.numbers.layout import Layout
from linkages.kernel.numbers.parameters import definition_vector
from linkages.kernel.structure import structure_of, topology_of
from linkages.kernel.system import choose_free


def unreached(mechanism: Mechanism, time: float = 0.0) -> float:
    """How far from assembly a mechanism is: 0 where all blocks reach, 1 where that is not told.

    Parameters
    ----------
    mechanism
        Free coordinates that it does not name are chosen.
    time
        In seconds.
    """
    mechanism = choose_free(mechanism)
    structure = structure_of(mechanism)
    model = structure.model
    if not Settling.serves(model):
        return 1.0
    topology = topology_of(structure.topology, mechanism)
    given = np.zeros(2 * len(Layout.of(topology).coordinates))
    for row, name in enumerate(topology.coordinates):
        if name in mechanism.initial:
            given[row] = mechanism.initial[name].position
    hints = {
        hint.joint: np.array(hint.position, dtype=float)
        for hint in mechanism.hints.values()
        if hint.position is not None
    }
    settling = Settling(model, mechanism.hints)
    numbers = definition_vector(mechanism, model.inputs.parameters)
    return float(settling(numbers[:, None], given[:, None], time, hints).unreached[0])
