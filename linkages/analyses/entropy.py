"""Permutation entropy: how many of the orders that values can have follow each other."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import ArrayLike, NDArray

    from linkages.components.mechanisms.mechanism import Mechanism

ORDERS = (2, 7)
"""Fewest and most values whose order is compared: 7! = 5040 patterns need 25,000 points."""

FEWEST = 5
"""Points per possible pattern, so that one that is missing is forbidden and not just rare."""

EQUAL = 1e-6
"""Of the largest magnitude: values closer than this are equal, as those of a periodic motion are up
to the error of its integration."""


def entropy(
    mechanism: Mechanism, *, order: int = 4, periods: int = 500, skip: int = 100
) -> xr.Dataset:
    """Permutation entropy of section points: zero for periodic motions, one for noise.

    Parameters
    ----------
    mechanism
        With at least one free coordinate, and drives or loads that have a common period.
    order
        Number of points, one period after the other, whose order is a pattern: from 2 to 7.
    periods
        Number of points.
    skip
        Points left out before.

    Returns
    -------
    Dataset with `entropy` (coordinate), from 0 to 1, of the rate of every free coordinate, and
    `missing` (coordinate), the number of patterns that never occur.

    Raises
    ------
    ValueError
        For arguments that make no sense, and for too few points: 5 for each possible pattern.

    References
    ----------
    C. Bandt, B. Pompe, Permutation entropy: a natural complexity measure for time series, Physical
    Review Letters 88 (2002) 174102.
    """
    import numpy as np
    import xarray as xr

    from linkages.chaos.sections import poincare
    from linkages.kernel.outputs import VARIABLES

    require_points(order, periods)
    section = poincare(mechanism, periods=periods, skip=skip)
    rates = {variable.rate for variable in VARIABLES.values() if variable.coordinate}
    result = {
        str(name): permutation_entropy(section[rate].sel({dim: name}), order)
        for rate in section.data_vars
        if rate in rates
        for dim in section[rate].dims[1:]
        for name in section[dim].to_numpy()
    }
    values = {
        "entropy": ("coordinate", [value for value, _ in result.values()],
                    {"units": "1", "long_name": "permutation entropy"}),
        "missing": ("coordinate", [missing for _, missing in result.values()],
                    {"units": "1", "long_name": "patterns that never occur"}),
    }  # fmt: skip
    names = {"coordinate": np.array(list(result), dtype=object)}
    kept = {name: section.attrs[name] for name in ("name", "source", "method", "rtol", "skip")}
    return xr.Dataset(values, names, {**kept, "order": order, "periods": periods})


def require_points(order: int, points: int) -> None:
    """Make sure that there are points enough for all patterns of an order.

    Raises
    ------
    ValueError
        If there are not, or the order is out of bounds.
    """
    if not ORDERS[0] <= order <= ORDERS[1]:
        raise ValueError(f"order must be from {ORDERS[0]} to {ORDERS[1]}, found {order}")
    fewest = FEWEST * math.factorial(order) + order - 1
    if points < fewest:
        raise ValueError(f"order {order} needs at least {fewest} periods, found {points}")


def permutation_entropy(values: ArrayLike, order: int) -> tuple[float, int]:
    """Entropy of the orders of values that follow each other, and how many orders never occur.

    Parameters
    ----------
    values : (m,)
        A series; values that are equal up to its resolution count as increasing.
    order
        Length n of a pattern. The entropy is divided by its greatest value, ln n!.
    """
    import numpy as np

    series: NDArray[np.float64] = np.asarray(values, dtype=float)
    size = EQUAL * float(np.abs(series).max(initial=0.0))
    rounded = np.round(series / size) if size else series
    windows = np.lib.stride_tricks.sliding_window_view(rounded, order)
    patterns = np.argsort(windows, axis=1, kind="stable")
    _, counts = np.unique(patterns, axis=0, return_counts=True)
    shares = counts / counts.sum()
    possible = math.factorial(order)
    return abs(float(-(shares * np.log(shares)).sum() / math.log(possible))), possible - len(counts)


ANALYSIS = entropy
