"""Mechanisms of the library satisfy Lagrange's equations of the first kind, derived with SymPy.

At random states, which need not be those of their own motion, and in all assembly modes.
"""

import numpy as np
import pytest
from test_kernel_lagrange import Kernel, Lagrange, agree

import linkages
from linkages.reading.document import shipped
from linkages.topology.topology import build_topology

WITHOUT_CLOSED_FORM = {
    "class-three", "slider-crank-contact", "contact-slider-crank", "idling-engine",
    "impact-oscillator",
}  # fmt: skip
"""Blocks solved by iteration need a place to start from: see test_mechanisms_class_three. A force
that remembers a rate is no function of the state: see test_mechanisms_contact. Of the others,
random states are far inside of walls, where forces are large; and impacts are no forces."""


@pytest.mark.slow_except("four-bar", "quick-return", "double-pendulum", "scotch-yoke")
@pytest.mark.parametrize("name", [n for n in shipped() if n not in WITHOUT_CLOSED_FORM])
def test_random_states(name):
    topology = build_topology(linkages.load(name))
    kernel, lagrange = Kernel(topology), Lagrange(topology)
    states = [state for seed in range(4) for state in kernel.states(seed)]
    assert len(states) >= 10
    for state in states[:40]:
        answer = lagrange.solve(state)
        # as in test_kernel_lagrange: lengths of order 1, angles from atan2
        np.testing.assert_allclose(answer.closure, 0.0, atol=1e-13)
        np.testing.assert_allclose(answer.closure_rate, 0.0, atol=1e-12)
        places = np.transpose([[*state.x.values()], [*state.y.values()]])
        np.testing.assert_allclose(places, answer.joints, atol=1e-13)
        agree([*state.energy.values()], answer.energies, 1.0 + np.abs(answer.energies))
        accelerations = [state.acceleration[body] for body in lagrange.names.values()]
        bodies = answer.acceleration[: len(accelerations)]
        agree(accelerations, bodies, 1.0 + np.abs(bodies))
        efforts = [*state.effort.values(), *(-force for force in state.link_force.values())]
        rows = [lagrange.q.index(coordinate) for coordinate in lagrange.held]
        agree(efforts, answer.efforts, answer.largest_terms[rows])
