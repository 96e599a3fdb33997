"""Whether pin and hole stay in contact, as the massless clearance link assumes."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Contact:
    """The force along a clearance link over time.

    A pin in a hole can be pulled away from the hole's centre only as far as the clearance goes: it
    presses outward, which is tension in the link. Where the model asks for compression, a real pin
    would leave the hole and fly, until it hits it again.

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
    """

    clearance: str
    share_lost: float
    first_loss: float | None
    smallest: float
    largest: float

    @property
    def sentence(self) -> str:
        """What it means; empty where contact is never lost."""
        if self.first_loss is None:
            return ""
        return (
            f"The force in {self.clearance} has the wrong sign for {100 * self.share_lost:.2g} % "
            f"of the time, first at t = {self.first_loss:.4g} s: a real pin would leave its hole "
            "there, and move otherwise from then on."
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)


def contact_check(clearance: str, time: ArrayLike, force: ArrayLike) -> Contact:
    """Check a clearance force, shape (samples,), in newtons at times in seconds.

    Raises
    ------
    ValueError
        For fewer than two samples, or other numbers of them.
    """
    t, f = np.asarray(time, dtype=float), np.asarray(force, dtype=float)
    if t.shape != f.shape or t.ndim != 1 or t.size < 2:
        raise ValueError("time and force need equally many samples, at least two")
    lost = f < 0
    share, first = _lost_time(t, f), None
    if lost.any():
        index = int(np.argmax(lost))
        first = float(t[0])
        if index:
            part = f[index - 1] / (f[index - 1] - f[index])
            first = float(t[index - 1] + part * (t[index] - t[index - 1]))
    return Contact(clearance, share, first, float(f.min()), float(f.max()))


def contact_of(data: xr.Dataset) -> tuple[Contact, ...]:
    """The check of every clearance whose force a solution's data have."""
    if "clearance_force" not in data or data.sizes["time"] < 2:
        return ()
    time = data["time"].to_numpy()
    return tuple(
        contact_check(str(name), time, data["clearance_force"].sel(clearance=name).to_numpy())
        for name in data["clearance"].to_numpy()
    )


def _lost_time(t: np.ndarray, f: np.ndarray) -> float:
    """Part of the time with a negative force, linear between samples."""
    spans, before, after = np.diff(t), f[:-1], f[1:]
    lower, upper = np.minimum(before, after), np.maximum(before, after)
    steep = np.where(upper > lower, upper - lower, 1.0)
    share = np.where(upper <= 0, lower < 0, np.clip(-lower / steep, 0.0, 1.0))
    return float((share * spans).sum() / spans.sum())
