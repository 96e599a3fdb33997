"""A motion as a page carries it: frames, series by name, and how they look best on axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.simulate import simulate
from linkages.solution.values.series import TIME, data_series
from linkages.viewer.frames import FEWEST, bounds, chosen
from linkages.viewer.ideal import PLACES, ideal_of
from linkages.viewer.packed import Packed

if TYPE_CHECKING:
    import xarray as xr


def recorded(data: xr.Dataset, system: System, packed: Packed) -> dict[str, Any]:
    """Frames of a motion.

    Parameters
    ----------
    data
        Samples of a motion; they should show every swing.
    system
        What moves.
    packed
        Gets the numbers.

    Returns
    -------
    ``time``, exactly, in two parts; ``series``, each with its values at the frames and, where
    those do not show it, its least and largest value of every ``stretch`` of frames; ``ghost``:
    joints of the same mechanism without clearances, where it has any; ``samples`` before frames
    were chosen.
    """
    frames = chosen(data)
    time = np.asarray(data["time"], dtype=float)
    series = []
    for name, found in data_series(data).items():
        if name == TIME or VARIABLES[found.variable].flags:
            continue
        values = np.asarray(found.of(data), dtype=float)
        between = bounds(values, frames)
        series.append(
            {
                "name": name,
                "values": packed.add(values[frames]),
                "bounds": None if between is None
                else {"stretch": between[0], "sides": [packed.add(side) for side in between[1:]]},
            }
        )  # fmt: skip
    return {
        "time": packed.add_exact(time[frames]),
        "samples": len(time),
        "series": series,
        "ghost": _ghost(time[frames], system, packed),
    }


def _ghost(time: np.ndarray[Any, Any], system: System, packed: Packed) -> Any:
    """The same motion without clearances; None where there are none, or it cannot move alike."""
    ideal = ideal_of(system)
    if ideal is None or ideal.topology.free:
        return None
    own = time[np.unique(np.linspace(0, len(time) - 1, FEWEST).round().astype(int))]
    moved = simulate(ideal.mechanism, times=own, outputs=[PLACES], throw=False)
    if not moved.completed:
        return None
    places = moved.data[PLACES].transpose("joint", "axis", "time")
    joints = {
        str(name): [packed.add(x), packed.add(y)]
        for name, (x, y) in zip(places["joint"].values, np.asarray(places), strict=True)
    }
    return {"time": packed.add_exact(own), "joints": joints}
