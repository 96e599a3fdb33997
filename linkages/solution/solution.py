"""What a simulation returns: labelled arrays, how they were computed, and until when to believe it.

The last follows from a comparison with a run at a tighter tolerance.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.discovery import html_of
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.guards import free_vectors
from linkages.solution.march import compute_motion
from linkages.solution.motion import Motion, Settings, passes
from linkages.solution.series import LabelledArrays, labelled
from linkages.solvers.integration import LEAST_RTOL, METHODS

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.dense import DenseMotion
    from linkages.solution.interpolated import Resolved


class _Data:
    """A dataset, built on first access."""

    def __get__(self, solution: Solution | None, _: type) -> xr.Dataset:
        if solution is None:  # a field without a default
            raise AttributeError("data")
        own = vars(solution)
        if isinstance(own["data"], LabelledArrays):
            own["data"] = own["data"].dataset()
        data: xr.Dataset = own["data"]
        return data

    def __set__(self, solution: Solution, data: xr.Dataset | LabelledArrays) -> None:
        vars(solution)["data"] = data


@dataclass(frozen=True, kw_only=True, repr=False)
class Solution:
    """Results of a simulation.

    Parameters
    ----------
    data
        Dataset with dimensions time, bar, slider, clearance, joint, axis, drive; SI units, named
        in the attribute ``units`` of every variable. Given as `LabelledArrays`, it is built on
        first access.
    mechanism
        What was simulated, with the free coordinates that were chosen for it.
    system
        Its topology and equations.
    motion
        Free coordinates at the sample times, and how the computation ended.
    settings
        How it was computed.
    notes
        What could not be computed, or was assumed.
    events
        Event that was asked for → dataset of its crossings, ordered in time: the outputs of `data`
        at each. Angles that are not integrated lie within one turn there.
    asked
        Arguments `times`, `state` and `events` of `linkages.simulate`, where they were given.
    """

    data: _Data = _Data()  # no default, but a descriptor
    mechanism: Mechanism
    system: System
    motion: Motion
    settings: Settings
    notes: tuple[str, ...] = ()
    events: Mapping[str, xr.Dataset] = field(default_factory=dict)
    asked: Mapping[str, Any] = field(default_factory=dict)

    def __getstate__(self) -> dict[str, Any]:
        """Without what is computed when it is asked for, and without the callback of the run."""
        own = {each.name: vars(self)[each.name] for each in fields(self)}
        return own | {"settings": replace(self.settings, watch=None)}

    def __repr__(self) -> str:
        return f"Solution({self.mechanism.name!r}, {self.summary})"

    def _repr_html_(self) -> str:
        """What notebooks show: the motion to play with, how it was computed, largest values."""
        return html_of(self)

    @property
    def summary(self) -> str:
        """Samples, time and number of outputs, in words."""
        time, count = self.time, len(self.arrays.variables)
        span = f"t = {time[0]:g} s to {time[-1]:g} s" if len(time) else "no time"
        whole = "" if self.completed else f", stopped at t = {self.motion.stop_time:g} s"
        return f"{len(time)} samples from {span}, {count} outputs{whole}"

    @property
    def arrays(self) -> LabelledArrays:
        """The arrays and attributes of `data`, without building a dataset."""
        own = vars(self)["data"]
        return own if isinstance(own, LabelledArrays) else LabelledArrays.of(own)

    @property
    def time(self) -> NDArray[np.float64]:
        """Sample times in seconds, shape (samples,)."""
        return self.arrays.coordinates["time"][1]

    @property
    def completed(self) -> bool:
        """Whether the motion was computed to its end."""
        return self.motion.failure is None

    @cached_property
    def maxima(self) -> list[dict[str, Any]]:
        """Largest and least values with their times, like the paper's table.

        They are those of the motion, whatever its samples are: located between them where it is
        smooth, or may jump. Residuals, which are noise, are taken at samples.

        Returns
        -------
        A row per series, of velocities, accelerations and reactions of joints per magnitude:
        ``variable, element, value, time``: the largest absolute value, signed, and its time;
        ``least, least_time, greatest, greatest_time``; ``units, long_name``; and ``missed``: by
        what part the motion may exceed `value`. It is 0 but for motions that are too long to be
        looked at so closely.
        """
        from linkages.solution.extremes import extreme_rows

        names = self.arrays.variables
        return [dict(row) for name in names for row in extreme_rows(self.closely, name)]

    @cached_property
    def resolved(self) -> dict[bool, Resolved]:
        """Whether it is integrated over time → the motion that measures are taken of, if any is."""
        return {}

    @cached_property
    def closely(self) -> DenseMotion:
        """The motion at samples that show all it does, computed when it is first asked for."""
        from linkages.solution.dense import DenseMotion

        return DenseMotion.of(
            self.system, self.settings, self.motion, self.time, self.arrays.values
        )

    def dense(self, names: Iterable[str]) -> xr.Dataset:
        """Outputs at samples that show all that the motion does, whatever its own samples are.

        Parameters
        ----------
        names
            Of outputs; those that follow from a whole motion must be among those of the solution.

        Returns
        -------
        Like `data`; where series are farthest from zero is in ``attrs["farthest"]``: name of the
        element → value and time.
        """
        from linkages.solution.extremes import extreme_rows

        values = {name: self.closely.values(name) for name in names}
        result = labelled(self.system, self.closely.motion, values)
        for name in values:
            rows = extreme_rows(self.closely, name)
            result[name].attrs["farthest"] = {r["element"]: (r["value"], r["time"]) for r in rows}
        return result.assign_attrs(self.arrays.attrs)

    @cached_property
    def horizon(self) -> Horizon | None:
        """Until when the solution can be believed; computed when it is first asked for.

        That takes a second integration at a tolerance a hundred times tighter, at about 1.7 times
        the cost of the first one. None where nothing was integrated.
        """
        return find_horizon(self.system, self.settings, self.motion)

    def save(self, folder: str | Path) -> list[Path]:
        """Write ``simulate.nc`` (NetCDF 4) and ``simulate.csv``; returns their paths.

        The former says how it was computed, from what and by which version, so that
        `linkages.open` can compute it again. Events, if any were asked for, are in ``events.csv``,
        a crossing per row.
        """
        from linkages.solution.files import origin_of, save_arrays, save_events

        notes = json.dumps(self.notes, ensure_ascii=False)
        origin = {"verb": "simulate", **origin_of(self.mechanism, self.options), "notes": notes}
        arrays = replace(self.arrays, attrs=self.arrays.attrs | origin)
        paths = save_arrays(arrays, Path(folder), "simulate")
        times = {name: data["time"].to_numpy() for name, data in self.events.items()}
        return [*paths, save_events(times, Path(folder) / "events.csv")] if times else paths

    @property
    def options(self) -> dict[str, Any]:
        """How it was computed, as arguments of `linkages.simulate`."""
        settings = self.settings
        sampled = {"end": float(settings.times[-1]), "samples": len(settings.times)}
        return {
            **({} if "times" in self.asked else sampled),
            **self.asked,
            **settings.run.integration,
            "method": self.motion.method or settings.run.method,
            "change_points": "pass" if passes(self.system, settings.run) else "stop",
            "outputs": [*self.arrays.variables],
        }


class IncompleteError(ComputationError):
    """A motion that could not be computed to its end; `solution` has everything up to there."""

    def __init__(self, solution: Solution) -> None:
        motion = solution.motion
        super().__init__(str(motion.failure), time=motion.stop_time)
        self.solution = solution


TIGHTER = 0.01
"""Factor on the tolerance of the comparison run (on the step of a fixed-step method: one half)."""

WRONG = 0.5e-3
"""Difference from which on the third digit is wrong, in units of the amplitude."""


ADDED_UP = 1e3

_MORE_STEPS = 10
"""What a tighter tolerance may take in steps: order 4 needs 3 times as many."""


@dataclass(frozen=True)
class Horizon:
    """The last sample time at which a solution has three correct digits.

    From there on a free coordinate or its rate differs from the comparison run by more than half a
    unit in the third digit of its amplitude.
    """

    time: float
    whole: bool  # whether that is the end of the solution: then the horizon lies beyond it
    # Largest difference of a free coordinate over the solution, in units of its amplitude
    error: float


def cost_factor(method: str) -> float:
    """Cost of a run with its comparison run, in runs: steps of order p shrink with rtol^(1/p)."""
    return 1.0 + TIGHTER ** (-1.0 / METHODS[method].order)


def find_horizon(system: System, settings: Settings, motion: Motion) -> Horizon | None:
    """Compare a motion with one at a tighter tolerance; None where there is nothing to compare."""
    if not system.layout.moved or len(motion.time) < 2:
        return None
    tighter = _tighter(settings, motion)
    if tighter is None:
        return None
    other = compute_motion(system, tighter)
    if other.interrupted:
        raise KeyboardInterrupt
    return horizon_between(system, settings.run, motion, other)


def horizon_between(system: System, run: RunOptions, motion: Motion, other: Motion) -> Horizon:
    """Until when a motion is like another one with smaller errors."""
    count = min(len(motion.time), len(other.time))
    if count < 2:  # the comparison run went elsewhere at once
        return Horizon(time=float(motion.time[0]), whole=False, error=math.inf)
    differences = _relative(system, run, motion, other, count)
    wrong = differences > WRONG
    first = int(np.argmax(wrong)) if wrong.any() else count
    last = max(0, first - 1)
    return Horizon(
        time=float(motion.time[last]),
        whole=first == len(motion.time),
        error=float(differences.max()),
    )


def _tighter(settings: Settings, motion: Motion) -> Settings | None:
    run = settings.run
    if run.step is not None:
        closer = replace(run, step=run.step / 2)
    elif run.rtol <= LEAST_RTOL:
        return None
    else:
        rtol = max(LEAST_RTOL, run.rtol * TIGHTER)
        closer = replace(run, rtol=rtol, atol=run.atol and run.atol * rtol / run.rtol)
    closer = replace(closer, max_steps=_MORE_STEPS * run.most_steps)
    return replace(settings.plain(motion.time), run=closer)


def _relative(
    system: System, run: RunOptions, motion: Motion, other: Motion, count: int
) -> NDArray[np.float64]:
    """Largest difference at each of `count` samples in units of the amplitudes.

    The amplitude of an angle is at most half a turn. Differences within some absolute tolerances
    are never wrong, because errors of steps add up.
    """
    own, better = (free_vectors(system, item)[:count].T for item in (motion, other))
    amplitude = 0.5 * (better.max(axis=1) - better.min(axis=1))
    for row, name in enumerate(system.topology.free):
        if system.mechanism.bodies[name].rotates:
            amplitude[row] = min(amplitude[row], np.pi)
    within = run.rtol if run.atol is None else run.atol
    scale = np.maximum(amplitude, ADDED_UP * within / WRONG)[:, None]
    return (np.abs(own - better) / scale).max(axis=0)
