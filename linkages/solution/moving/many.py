"""Many motions, each of which goes its own way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.errors import Interrupted, LinkagesError
from linkages.solution.moving.march import March
from linkages.solution.moving.motion import Motion
from linkages.solution.moving.renormalising import Renormalised

Floats = NDArray[np.float64]


def march_many(
    marches: Sequence[March],
    times: ArrayLike,
    *,
    renormalised: Sequence[Renormalised] | None = None,
) -> list[Motion | LinkagesError]:
    """Move many linkages on, each to the last of some times or to where it cannot go on.

    Every motion is equal, in all bits, to that which `March.advance` gives for it alone.

    Parameters
    ----------
    marches
        What moves; they need not be of one structure.
    times
        Sample times in seconds, shape (samples,), or those of every motion, (motions, samples).
    renormalised
        For every motion which samples bring its tangents back to length one; keeps how they grew.

    Returns
    -------
    The motions in their order; in the place of one that cannot even begin, why.

    Raises
    ------
    Interrupted
        After Ctrl-C.
    """
    rows = np.broadcast_to(np.asarray(times, dtype=float), (len(marches), np.shape(times)[-1]))
    found: list[Motion | LinkagesError] = []
    for index, march in enumerate(marches):
        own = None if renormalised is None else renormalised[index]
        try:
            motion = march.advance(rows[index], renormalised=own)
        except LinkagesError as error:
            found.append(error)
            continue
        if motion.interrupted:
            raise Interrupted(str(motion.failure), time=motion.stop_time)
        found.append(motion)
    return found
