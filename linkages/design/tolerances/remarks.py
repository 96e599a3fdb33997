"""Where the linear analysis fails, in sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.tolerances.held import clearances_of, with_room
from linkages.sweeps.answers import Code

if TYPE_CHECKING:
    import xarray as xr

SIGNIFICANT = 3.0
"""Standard errors from which on a difference is no accident."""

MATTERS = 0.05
"""Share of a standard deviation, or of the spread, from which on a difference is worth saying."""

NOTHING = 1e-6
"""Share of the spread below which a linear one is rounding."""

SKEWED = 0.2
"""Difference of skewness from which on quantiles are misleading."""


def remarks(data: xr.Dataset, mechanism: Mechanism) -> list[str]:
    """Sentences on what the linear analysis does not see, measure by measure."""
    found = [f"{name}: {text}" for name in data["measure"].to_numpy() for text in _of(data, name)]
    if not found:
        found.append("linear analysis and samples agree within their errors")
    outcome = data["outcome"].to_numpy()
    failed = int(((outcome != Code.COMPUTED) & (outcome != Code.MISSING)).sum())
    if failed:
        first = next(str(text) for text in data["reason"].to_numpy()[outcome != Code.COMPUTED])
        found.append(
            f"{failed} of {len(outcome)} samples have no result, which a linear analysis cannot "
            f"see: {first}"
        )
    held = {each.name for each in clearances_of(mechanism)}
    moving = [each.name for each in with_room(mechanism) if each.name not in held]
    if moving:
        found.append(f"clearances in guides that move are left out: {', '.join(moving)}")
    return found


def _of(data: xr.Dataset, name: str) -> list[str]:
    own = data.sel(measure=name)
    number = {key: float(own[key]) for key in _NEEDED}
    linear = own["linear_sample"].to_numpy()[np.isfinite(own["sample"].to_numpy())]
    units = str(own["units"].values)
    found = []
    if number["computed"] >= 2 and number["deviation"] > 0.0:
        found += _moments(number, linear, units)
    for side in own["side"].to_numpy():
        corner = own.sel(side=side)
        found += _corner(str(side), corner, units, float(number["nominal"]))
    return found


_NEEDED = (
    "nominal", "mean", "deviation", "skewness", "error_of_mean", "computed", "linear_skewness",
)  # fmt: skip


def _moments(number: dict[str, float], linear: NDArray[np.float64], units: str) -> list[str]:
    """Differences from linear predictions of the same copies, which share their chance."""
    found = []
    count, linear_spread = len(linear), float(linear.std(ddof=1))
    spread, error = number["deviation"], number["error_of_mean"]
    shift = number["mean"] - float(linear.mean())
    if abs(shift) > max(SIGNIFICANT * error, MATTERS * spread):
        found.append(
            f"curvature shifts the mean by {shift:.2g} {units} ({shift / spread:+.0%} of the "
            "standard deviation) from the linear one"
        )
    if linear_spread < NOTHING * spread:
        return [
            *found,
            f"the linear analysis sees no effect; the samples vary by {spread:.3g} {units}",
        ]
    ratio = spread / linear_spread - 1.0
    if abs(ratio) > max(SIGNIFICANT / np.sqrt(2.0 * count), MATTERS):
        found.append(
            f"the standard deviation of the samples, {spread:.3g} {units}, differs from the linear "
            f"one by {ratio:+.0%}"
        )
    skewness, expected = number["skewness"], number["linear_skewness"]
    if abs(skewness - expected) > max(SIGNIFICANT * np.sqrt(6.0 / count), SKEWED):
        found.append(
            f"the samples are skewed by {skewness:+.2f}, the linear ones by {expected:+.2f}"
        )
    return found


def _corner(side: str, corner: xr.Dataset, units: str, nominal: float) -> list[str]:
    linear, real = float(corner["worst"]), float(corner["corner"])
    if not np.isfinite(real):
        reason = str(corner["corner_reason"].values)
        return [f"at the linear worst case ({side}) there is no result: {reason}"]
    change = abs(linear - nominal)
    if abs(real - linear) > MATTERS * change and change > 0.0:
        return [
            f"at the linear worst case ({side}) it is {real:.4g} {units}, not {linear:.4g} {units}"
        ]
    return []
