"""Whether journal and bearing stay in contact, as the massless clearance link assumes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.kernel.outputs import links

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LinkForce:
    """The force along a clearance link over time.

    A journal in a bearing can be pulled away from the bearing's centre only as far as the clearance
    goes: it presses outward, which is tension in the link. Where the model asks for compression, a
    real journal would leave the bearing and fly, until it hits it again.

    Parameters
    ----------
    clearance
        Its name.
    share_lost
        Part of the time in which the link is compressed.
    first_loss
        First time of that in seconds, linearly interpolated; None if there is none.
    smallest, largest
        Extreme forces in newtons, tension positive.
    least_time
        When the smallest was found, in seconds.
    steps
        Steps of the integration between two looks, on average. Methods take many steps per
        oscillation: with too many, oscillations between two looks are not seen.
    """

    clearance: str
    share_lost: float
    first_loss: float | None
    smallest: float
    largest: float
    least_time: float
    steps: float = 0.0

    @property
    def sentence(self) -> str:
        """What it means; empty where contact is never lost."""
        if self.first_loss is None:
            return ""
        return (
            f"The force in {self.clearance} has the wrong sign for {100 * self.share_lost:.2g} % "
            f"of the time, first at t = {self.first_loss:.4g} s: a real journal would leave "
            "its bearing there, and move otherwise from then on."
        )


def contact_check(clearance: str, time: ArrayLike, force: ArrayLike) -> LinkForce:
    """Check a clearance force, shape (samples,), in newtons at times in seconds.

    Raises
    ------
    ValueError
        For fewer than two samples, or other numbers of them.
    """
    t, f = np.asarray(time, dtype=float), np.asarray(force, dtype=float)
    if t.shape != f.shape or t.ndim != 1 or t.size < 2:
        raise ValueError("time and force need equally many samples, at least two")
    spans = lost_spans(t, f)
    share = sum(end - begin for begin, end in spans) / float(t[-1] - t[0])
    first = spans[0][0] if spans else None
    least = float(t[np.argmin(f)])
    return LinkForce(clearance, share, first, float(f.min()), float(f.max()), least)


def lost_spans(time: Floats, force: Floats) -> list[tuple[float, float]]:
    """Beginning and end of each span of negative force, with zeros between samples by line."""
    lost = force < 0
    edges = np.flatnonzero(np.diff(lost.astype(np.int8)))
    marks = [_zero(time, force, int(edge)) for edge in edges]
    marks = [float(time[0])] * bool(lost[0]) + marks + [float(time[-1])] * bool(lost[-1])
    return list(zip(marks[::2], marks[1::2], strict=True))


def _zero(time: Floats, force: Floats, index: int) -> float:
    before, after = force[index], force[index + 1]
    share = before / (before - after) if np.isfinite(before - after) else 0.5
    return float(time[index] + share * (time[index + 1] - time[index]))


def force_of(solution: Solution) -> xr.DataArray | None:
    """Clearance forces that a solution has, (time, clearance), wherever its samples are."""
    if "clearance_force" not in solution.data or solution.data.sizes["time"] < 2:
        return None
    return solution.dense(["clearance_force"])["clearance_force"]


def contact_of(solution: Solution, force: xr.DataArray | None = None) -> tuple[LinkForce, ...]:
    """The check of every massless link; `force` is that of `force_of` if it is known."""
    force = force_of(solution) if force is None else force
    if force is None:
        return ()
    time = force["time"].to_numpy()
    return tuple(
        contact_check(name, time, force.sel(clearance=name).to_numpy())
        for name in links(solution.system.model)
    )
