"""How exactly each thing that is integrated is wanted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.numbers.layout import Layout
from linkages.options.run import RunOptions
from linkages.solution.remarks.forgotten_units import longest

TANGENT_ATOL = 1e-6
"""Absolute tolerance of tangents that are only asked how they grow: they are of length one when
they start."""

ANYTHING = 1e300
"""Absolute tolerance of what means nothing."""


def absolute_tolerances(
    mechanism: Mechanism, layout: Layout, run: RunOptions, tangent_atol: float
) -> NDArray[np.float64]:
    """Absolute tolerances of everything that a layout places, shape (2n,).

    Unless they are given, lengths are measured in sizes where clearances open, and angles by what
    they move: a touch makes errors larger by far.
    """
    found = np.full(2 * layout.size, run.rtol if run.atol is None else run.atol)
    if run.atol is None and mechanism.contacts:
        length = min(contact.size.value for contact in mechanism.contacts)
        turned = length / (max(map(longest, mechanism.bodies.values())) or 1.0)
        bodies = mechanism.bodies
        sizes = {name: turned if bodies[name].rotates else length for name in bodies}
        scales = [sizes.get(name, 1.0) for name in layout.coordinates]
        found[layout.motion_rows] *= [*scales, *scales]
    if layout.internal:
        found[layout.internal_rows] *= [state.scale for state in mechanism.internal.values()]
    found[layout.tangent_rows] = tangent_atol
    found[layout.idle_rows] = ANYTHING
    return found
