"""Sweeps as they are written on the command line, and in the files of their results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Unpack

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.options.signature import takes
from linkages.reading.overrides import parse_assignment
from linkages.sweeps.axes import parse_axis
from linkages.sweeps.sweep import sweep

if TYPE_CHECKING:
    import xarray as xr


@takes(SimulationOptions)
def sweep_asked(
    mechanism: Mechanism,
    measure: Sequence[str],
    vary: Sequence[str] = (),
    sample: Sequence[str] = (),
    *,
    draws: int | None = None,
    seed: int = 0,
    sequence: str = "random",
    time_per_point: float | None = None,
    **options: Unpack[SimulationKeywords],
) -> xr.Dataset:
    """The sweep of a command: measures, ``PATH=VALUES`` and ``PATH=DISTRIBUTION`` are texts.

    Parameters
    ----------
    mechanism, measure, draws, seed, sequence, time_per_point
        As `linkages.sweep` takes them.
    vary, sample
        Axes, and numbers that are drawn.
    options
        As `SimulationOptions` describes them.
    """
    over: dict[Any, Any] = {}
    for axis in map(parse_axis, vary):
        over[axis.paths if len(axis.paths) > 1 else axis.label] = axis
    over |= dict(map(parse_assignment, sample))
    return sweep(
        mechanism, over, measure, draws=draws, seed=seed, sequence=sequence,
        time_per_point=time_per_point, **options,
    )  # fmt: skip
