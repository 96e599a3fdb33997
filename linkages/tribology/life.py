"""Life of a joint that wears: revolutions until a limit, over tolerances and uncertain wear rates.

With all wear rates f times as large the same wear comes f times as early, so that life is the life
with the rates of the file over f. Tolerances change the motion, and with it the life: they are
drawn, and each copy of the mechanism is worn. Life is the product of both.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at
from linkages.design.contributors import distribution
from linkages.errors import ComputationError
from linkages.options.analysis_options import WearKeywords, WearOptions
from linkages.options.option import OptionError, takes
from linkages.solution.run_options import options_of
from linkages.spec.conversion import ToleranceZone
from linkages.sweeps.engine import (
    Answer,
    Code,
    Computed,
    Field,
    Question,
    Watch,
    attempted,
    reasons,
)
from linkages.sweeps.places import swept
from linkages.sweeps.points import points_of
from linkages.sweeps.running import Executor, Threads, stopping
from linkages.tribology.cycle_jumps import wear

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

PARTS = (10, 50, 90)
"""Percentages of copies of a mechanism that are worn to the limit before their P."""

DRAWS = 30
"""Copies of the mechanism, if nothing is said."""

TWO_SIDED = 1.959963984540054
"""Standard deviations within which 95 of 100 are."""


@dataclass(frozen=True)
class Lives(Question):
    """How long copies of a mechanism last: the nominal one, ends of zones, then draws."""

    mechanism: Mechanism
    until: str
    given: Mapping[str, Any]
    draws: int
    seed: int

    @cached_property
    def zones(self) -> dict[str, ToleranceZone]:
        """Path → zone of all numbers with a tolerance."""
        return self.mechanism.tolerances

    @cached_property
    def copies(self) -> Floats:
        """Numbers of all copies, shape (copies, paths)."""
        zones = [*self.zones.values()]
        nominal = np.array([zone.nominal for zone in zones])
        rows = [nominal]
        for k, zone in enumerate(zones):
            for sign in (-1.0, 1.0):
                moved = nominal.copy()
                moved[k] += sign * zone.deviation
                rows.append(moved)
        if zones:
            over = {path: distribution(zone) for path, zone in self.zones.items()}
            rows += list(points_of(over, self.draws, self.seed, "random").draw_values.T)
        return np.array(rows).reshape(len(rows), len(zones))

    @property
    def count(self) -> int:
        """Number of copies."""
        return len(self.copies)

    @property
    def fields(self) -> Mapping[str, Field]:
        """Life and its error in revolutions."""
        return {"life": Field(), "error": Field()}

    @property
    def described(self) -> dict[str, Any]:
        """What tells this question from others."""
        return {
            "kind": "life", "until": self.until, "options": dict(self.given),
            "draws": self.draws, "seed": self.seed,
        }  # fmt: skip

    def numbers(self) -> Floats:
        """Of all copies."""
        return self.copies

    def answers(self, first: int, last: int) -> list[Answer]:
        """Lives of some copies."""
        return [attempted(partial(self._answer, row)) for row in self.copies[first:last]]

    def _answer(self, row: Floats) -> Answer:
        if stopping():
            raise KeyboardInterrupt
        values = dict(zip(self.zones, row.tolist(), strict=True))
        copy = self.mechanism.with_values(values) if values else self.mechanism
        data = wear(copy, until=self.until, **self.given)
        name = self.until.split(".")[1]
        if data.attrs["ended"] != "limit":
            return Answer({}, Code.STOPPED, "the limit is not reached")
        end = data.sel(clearance=name).isel(jump=-1)
        growth = float(end["size"] - data["size"].sel(clearance=name)[0])
        life = float(end["revolutions"])
        # an error of the growth is one of the life, as a part of each
        return Answer({"life": life, "error": life * float(end["error"]) / growth})


@takes(WearOptions)
def wear_life(
    mechanism: Mechanism,
    until: str,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    store: str | Path | None = None,
    cores: int | None = None,
    executor: Executor | None = None,
    watch: Watch | None = None,
    **options: Unpack[WearKeywords],
) -> xr.Dataset:
    """How long joints of a mechanism last until a limit, over its tolerances and its wear rates.

    Parameters
    ----------
    mechanism
        As `wear` takes it; numbers with a tolerance are drawn.
    until
        The limit, such as ``"clearances.gap.size = 0.5 mm"``.
    draws
        Copies of the mechanism that are drawn; one is enough for a file without tolerances.
    seed
        Of the draws.
    store, cores, executor, watch
        As `linkages.sweep` takes them.
    options
        As `WearOptions` describes them.

    Returns
    -------
    Dataset with `nominal` life in revolutions and its numerical `error`; `relative` life of each
    copy (draw) over the nominal one, with `outcome` and `reason`; `relative_quantile` and, with the
    uncertain wear rate, `life_quantile` in revolutions (percent: 10, 50, 90, of copies that are
    worn out by then); of each number with a tolerance (parameter) `exponent`, the change of life in
    percent for one percent of its size, and `ends`, the relative life a standard deviation below
    and above. The attribute ``uncertainty`` is the factor of wear rates that went in. A copy that
    does not reach the limit lives for ever.

    Raises
    ------
    InputError, ValueError
        For what makes no sense.
    ComputationError
        If the nominal mechanism does not reach the limit.
    Interrupted
        After Ctrl-C; ``kept["life"]`` has what there is.
    """
    if draws < 1:
        raise OptionError("draws", f"expected at least one draw, found {draws}")
    options_of(WearOptions, mechanism, options)
    given = {name: value for name, value in options.items() if value is not None}
    question = Lives(mechanism, " ".join(until.split()), given, draws, seed)
    question.copies  # noqa: B018  what does not fit is said before anything is computed
    made, where = partial(_dataset, question), executor or Threads(cores)
    return swept(
        question, mechanism, "life", "copies", made,
        executor=where, store=store, watch=watch, chunk=1,
    )  # fmt: skip


def _dataset(question: Lives, found: Computed) -> xr.Dataset:
    import xarray as xr

    mechanism, zones = question.mechanism, question.zones
    outcome, why = found.arrays["outcome"], reasons(found.arrays)
    lives = np.where(outcome == Code.STOPPED, np.inf, found.arrays["life"])
    if not np.isfinite(lives[0]) and outcome[0] != Code.MISSING:
        raise ComputationError(f"the nominal mechanism: {why[0]}", time=None)
    relative = lives / lives[0]
    ends = relative[1 : 1 + 2 * len(zones)].reshape(-1, 2)
    drawn = relative[1 + 2 * len(zones) :] if zones else relative[:1]
    own = slice(1 + 2 * len(zones), None) if zones else slice(0, 1)
    factor = max(each.wear.uncertainty for each in mechanism.worn if each.wear is not None)
    spread = math.log(factor) / TWO_SIDED
    known = drawn[~np.isnan(drawn)]
    parts = np.array(PARTS) / 100.0
    numbers = np.array([
        [zone.nominal - zone.deviation, zone.nominal + zone.deviation] for zone in zones.values()
    ]).reshape(-1, 2)  # fmt: skip
    with np.errstate(all="ignore"):
        exponents = np.diff(np.log(ends), axis=1) / np.diff(np.log(np.abs(numbers)), axis=1)
    data: dict[str, Any] = {
        "nominal": ((), lives[0], {"units": "1", "long_name": "life in revolutions"}),
        "error": ((), found.arrays["error"][0], {"units": "1"}),
        "relative": ("draw", drawn, {"units": "1", "long_name": "life over the nominal one"}),
        "outcome": ("draw", outcome[own]),
        "reason": ("draw", why[own]),
        "relative_quantile": (
            "percent", np.array([_quantile(known, 0.0, part) for part in parts]), {"units": "1"},
        ),
        "life_quantile": (
            "percent", np.array([lives[0] * _quantile(known, spread, part) for part in parts]),
            {"units": "1", "long_name": "life in revolutions"},
        ),
        "exponent": ("parameter", exponents[:, 0], {"units": "1"}),
        "ends": (("parameter", "end"), ends, {"units": "1"}),
        "value": (("parameter", "end"), numbers),
    }  # fmt: skip
    coords = {
        "percent": [*PARTS], "draw": np.arange(len(drawn)), "end": ["low", "high"],
        "parameter": np.array([*zones], dtype=object),
        "unit": ("parameter", np.array(
            [unit_at(mechanism.definition, path) for path in zones], dtype=object)),
    }  # fmt: skip
    attrs = {
        "name": mechanism.name, "source": mechanism.file_name, "until": question.until,
        "uncertainty": factor, "draws": question.draws, "seed": question.seed,
        "interrupted": int(found.interrupted),
    }  # fmt: skip
    return xr.Dataset(data, coords, attrs)


def _quantile(relative: Floats, spread: float, part: float) -> float:
    """Where a part of lives is below: of drawn ones times a lognormal factor, by bisection."""
    if not len(relative):
        return math.nan
    finite = np.log(relative[np.isfinite(relative)])
    if len(finite) <= part * len(relative):
        return math.inf
    logs = np.log(relative)
    if spread == 0.0:
        return float(np.quantile(relative, part, method="inverted_cdf"))
    from scipy.special import ndtr

    low, high = finite.min() - 12 * spread, finite.max() + 12 * spread
    while low < (middle := 0.5 * (low + high)) < high:
        below = float(ndtr((middle - logs) / spread).mean())
        low, high = (middle, high) if below < part else (low, middle)
    return math.exp(high)
