"""Sections of the clearance's motion over size and speed, and the power laws of their spread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

import linkages
from linkages.sweeps.running import Executor
from make.reproduction.reported import ANGLE, DRIVES, SIZE, SPEED_RANGE, STARTS, press

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

SMALL, LARGE = 3e-5, 1.5e-4
"""Radial clearances up to and from these sizes, in m, are the ends of the paper's range."""

SLOW, FAST, INERTIA = 1.6 * np.pi, 3.9 * np.pi, 7.0 * np.pi
"""Speeds in rad/s: up to the first weight makes up the joint force; with the second one begins the
end of the paper's range; from the third one on, beyond it, inertia makes up the force."""


def start_angles(step: float) -> list[dict[str, object]]:
    """Clearance angles α at t = 0 all around, in steps of so many degrees."""
    return [{ANGLE: f"{angle:g} deg"} for angle in np.arange(0.0, 360.0, step)]


def own_starts() -> list[dict[str, object]]:
    """The two initial conditions of our files."""
    documents = [press(name).document for name in STARTS]
    return [{ANGLE: document.content["clearances"]["r1"]["angle"]} for document in documents]


def over_sizes(
    sizes: Sequence[float] | Floats,
    initial: Sequence[Mapping[str, object]],
    periods: int,
    executor: Executor | None = None,
) -> xr.Dataset:
    """Stroboscopic section points for each radial clearance and each initial condition."""
    return linkages.bifurcation(
        press(), {SIZE: sizes}, periods=periods, skip=0, initial=initial, executor=executor
    )


def over_speeds(
    speeds: Sequence[float] | Floats,
    initial: Sequence[Mapping[str, object]],
    periods: int,
    executor: Executor | None = None,
) -> xr.Dataset:
    """The same for each speed of the cranks."""
    vary = {path: sign * np.asarray(speeds) for path, sign in DRIVES.items()}
    return linkages.bifurcation(
        press(), vary, periods=periods, skip=0, initial=initial, executor=executor
    )


def spread(data: xr.Dataset) -> Floats:
    """Standard deviation of α̇ over the section points in rad/s, shape (starts, values)."""
    return np.asarray(data.clearance_speed.isel(clearance=0).std("crossing"))


@dataclass(frozen=True)
class PowerLaw:
    """y ∝ x^exponent."""

    exponent: float  # with the standard error of the straight line through the logarithms
    error: float
    offset: float  # logarithm of y at x = 1
    points: int  # number of points

    def at(self, x: Floats) -> Floats:
        """Values on the line."""
        return np.asarray(np.exp(self.offset) * np.asarray(x) ** self.exponent)

    def beside(self, x: Floats, y: Floats) -> Floats:
        """Values at x on the line of this slope that has half of the points above it."""
        offset = np.median(np.log(y) - self.exponent * np.log(x))
        return np.asarray(np.exp(offset) * x**self.exponent)

    def agrees(self, expected: float) -> bool:
        """Whether the expected exponent is within the 99 % interval."""
        reach = float(student.ppf(0.995, self.points - 2)) * self.error
        return abs(self.exponent - expected) <= reach

    def __str__(self) -> str:
        return f"{self.exponent:+.3f} ± {self.error:.3f}".replace("-", "−")


def power_law(x: Floats, y: Floats) -> PowerLaw:
    """Fit by least squares of the logarithms; the scatter about the line gives the error."""
    a, b = np.log(x), np.log(y)
    (slope, offset), covariance = np.polyfit(a, b, 1, cov=True)
    return PowerLaw(float(slope), float(np.sqrt(covariance[0, 0])), float(offset), len(a))


def mean_law(x: Floats, spreads: Floats) -> PowerLaw:
    """The power law of the geometric mean over all initial conditions."""
    return power_law(x, np.exp(np.log(spreads).mean(axis=0)))


def gains(x: Floats, spreads: Floats, ends: tuple[float, float]) -> list[float]:
    """Spread from one place on in units of that up to another, for each initial condition."""
    logs = np.log(spreads)
    below, beyond = x <= ends[0], x >= ends[1]
    return [float(np.exp(row[beyond].mean() - row[below].mean())) for row in logs]


def size_laws(sizes: Floats, spreads: Floats) -> tuple[PowerLaw, list[float]]:
    """Power law of the mean spread over r, and what each initial condition loses over the range."""
    losses = [1 / gain for gain in gains(sizes, spreads, (SMALL, LARGE))]
    return mean_law(sizes, spreads), losses


def speed_laws(speeds: Floats, spreads: Floats) -> tuple[PowerLaw, PowerLaw, list[float]]:
    """Power laws of the mean spread over ω where weight and where inertia makes up the joint force,
    and how much each start gains over the paper's range.
    """
    inside, slow, fast = speeds <= 1.001 * SPEED_RANGE[1], speeds <= SLOW, speeds >= INERTIA
    slow_law, fast_law = (mean_law(speeds[part], spreads[:, part]) for part in (slow, fast))
    return slow_law, fast_law, gains(speeds[inside], spreads[:, inside], (SLOW, FAST))
