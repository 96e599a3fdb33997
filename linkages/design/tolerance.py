"""Tolerance analysis: linear, worst case, Monte Carlo."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, cast

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.contributors import Contributors, clearances_of, contributors_of, with_room
from linkages.design.linear_tolerances import LinearMeasure, linearised
from linkages.errors import Interrupted
from linkages.kernel.system import System
from linkages.options.option import takes
from linkages.options.run import SimulationKeywords, SimulationOptions
from linkages.solution.measure_names import example_measure, measure_units
from linkages.spec.grammar import NumberError, leading_number
from linkages.spec.measures import read_measure
from linkages.spec.units import UnitError, unit
from linkages.sweeps.engine import Code, Watch
from linkages.sweeps.running import Executor
from linkages.sweeps.sweep import measure_name, named_measures, sweep

if TYPE_CHECKING:
    import xarray as xr

EXPECTED = "expected limits such as 'stroke(piston.position) > 79.9 mm' or '1 mm < … < 2 mm'"

CONFIDENCE = 0.95
"""Of the interval in which a yield is said to lie."""

_SIGN = re.compile(r"[<>]=?")


@dataclass(frozen=True)
class MeasureLimits:
    """Limits of a measure: numbers with a unit, or in SI; empty where there is none."""

    text: str  # as it was written
    measure: str  # its text
    low: str
    high: str

    def numbers(self, units: str) -> tuple[float, float]:
        """Both limits in SI, else infinite; `units` is the SI unit of the measure."""
        low = self._number(self.low, units, -math.inf)
        high = self._number(self.high, units, math.inf)
        if not low < high:
            raise ValueError(f"limits {self.text!r}: nothing lies between them")
        return low, high

    def _number(self, text: str, units: str, nothing: float) -> float:
        if not text:
            return nothing
        try:
            number, named = leading_number(text.replace("−", "-"))
            if not named:
                return number
            result = unit(named)
            if not units or result.exponents != unit(units).exponents:
                measured = f"in {units}" if units else "a number without a unit"
                raise UnitError(f"the measure is {measured}")
            return result.convert(number)
        except (NumberError, UnitError) as error:
            raise ValueError(f"limits {self.text!r}: cannot use {text!r}: {error}") from None


def read_limits(text: str) -> MeasureLimits:
    """Read limits: a measure, ``<`` or ``>``, and a number; or a measure between two numbers."""
    parts, signs = _split(text)
    rising = {sign[0] for sign in signs}
    if len(signs) == 2 and len(rising) == 1:
        low, measure, high = parts if rising == {"<"} else reversed(parts)
    elif len(signs) == 1:
        left, right = parts
        if _is_number(left):  # 2 mm > measure
            left, right = right, left
            rising = {"<" if rising == {">"} else ">"}
        measure = left
        low, high = ("", right) if rising == {"<"} else (right, "")
    else:
        raise ValueError(f"{EXPECTED}, found {text!r}")
    if not measure or _is_number(measure) or not (low or high):
        raise ValueError(f"{EXPECTED}, found {text!r}")
    return MeasureLimits(" ".join(text.split()), measure, low, high)


def _split(text: str) -> tuple[list[str], list[str]]:
    """The text at its comparisons outside of parentheses."""
    parts, signs, depth, at = [""], [], 0, 0
    while at < len(text):
        sign = _SIGN.match(text, at)
        if sign and depth == 0:
            signs.append(sign.group())
            parts.append("")
            at = sign.end()
            continue
        depth += {"(": 1, ")": -1}.get(text[at], 0)
        parts[-1] += text[at]
        at += 1
    return [part.strip() for part in parts], signs


def _is_number(text: str) -> bool:
    try:
        _, rest = leading_number(text.replace("−", "-"))
        if rest:
            unit(rest)
    except (NumberError, UnitError):
        return False
    return True


def share_within(count: int, whole: int) -> tuple[float, float, float]:
    """A share, and its confidence interval (C. J. Clopper, E. S. Pearson, Biometrika 26, 1934)."""
    from scipy.stats import binomtest

    interval = binomtest(count, whole).proportion_ci(CONFIDENCE, method="exact")
    return count / whole, float(interval.low), float(interval.high)


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
    result = [f"{name}: {text}" for name in data["measure"].to_numpy() for text in _of(data, name)]
    if not result:
        result.append("linear analysis and samples agree within their errors")
    outcome = data["outcome"].to_numpy()
    failed = int(((outcome != Code.COMPUTED) & (outcome != Code.MISSING)).sum())
    if failed:
        first = next(str(text) for text in data["reason"].to_numpy()[outcome != Code.COMPUTED])
        result.append(
            f"{failed} of {len(outcome)} samples have no result, which a linear analysis cannot "
            f"see: {first}"
        )
    held = {each.name for each in clearances_of(mechanism)}
    moving = [each.name for each in with_room(mechanism) if each.name not in held]
    if moving:
        result.append(f"clearances in guides that move are left out: {', '.join(moving)}")
    return result


def _of(data: xr.Dataset, name: str) -> list[str]:
    own = data.sel(measure=name)
    number = {key: float(own[key]) for key in _NEEDED}
    linear = own["linear_sample"].to_numpy()[np.isfinite(own["sample"].to_numpy())]
    units = str(own["units"].values)
    result = []
    if number["computed"] >= 2 and number["deviation"] > 0.0:
        result += _moment_remarks(number, linear, units)
    for side in own["side"].to_numpy():
        corner = own.sel(side=side)
        result += _corner(str(side), corner, units, float(number["nominal"]))
    return result


_NEEDED = (
    "nominal", "mean", "deviation", "skewness", "error_of_mean", "computed", "linear_skewness",
)  # fmt: skip


def _moment_remarks(number: dict[str, float], linear: NDArray[np.float64], units: str) -> list[str]:
    """Differences from linear predictions of the same copies, which share their chance."""
    result = []
    count, linear_spread = len(linear), float(linear.std(ddof=1))
    spread, error = number["deviation"], number["error_of_mean"]
    shift = number["mean"] - float(linear.mean())
    if abs(shift) > max(SIGNIFICANT * error, MATTERS * spread):
        result.append(
            f"curvature shifts the mean by {shift:.2g} {units} ({shift / spread:+.0%} of the "
            "standard deviation) from the linear one"
        )
    if linear_spread < NOTHING * spread:
        return [
            *result,
            f"the linear analysis sees no effect; the samples vary by {spread:.3g} {units}",
        ]
    ratio = spread / linear_spread - 1.0
    if abs(ratio) > max(SIGNIFICANT / np.sqrt(2.0 * count), MATTERS):
        result.append(
            f"the standard deviation of the samples, {spread:.3g} {units}, differs from the linear "
            f"one by {ratio:+.0%}"
        )
    skewness, expected = number["skewness"], number["linear_skewness"]
    if abs(skewness - expected) > max(SIGNIFICANT * np.sqrt(6.0 / count), SKEWED):
        result.append(
            f"the samples are skewed by {skewness:+.2f}, the linear ones by {expected:+.2f}"
        )
    return result


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


Floats = NDArray[np.float64]

SAMPLES = 10_000
"""Copies of the mechanism that are drawn, if nothing is said."""

FEWEST = 100
"""Fewer copies say nothing of a distribution."""

ALL = "all limits"


@takes(SimulationOptions)
def tolerance(
    mechanism: Mechanism,
    of: str | Sequence[str] | Mapping[str, str],
    *,
    limits: str | Sequence[str] = (),
    draws: int = SAMPLES,
    seed: int = 0,
    sequence: str = "random",
    store: str | Path | None = None,
    cores: int | None = None,
    scheduler: str | None = None,
    executor: Executor | None = None,
    time_per_point: float | None = None,
    watch: Watch | None = None,
    **options: Unpack[SimulationKeywords],
) -> xr.Dataset:
    """What the tolerances and clearances of a mechanism do to measures of its motion.

    Parameters
    ----------
    mechanism
        Some of its numbers have a tolerance, or it has clearances. The pins of these rest against
        their holes, each in a direction that is drawn and stays during a motion.
    of
        Measures: one, several, or name → measure. ``error(x)`` in them is x less what it is in the
        nominal mechanism at the same time.
    limits
        Such as ``"stroke(piston.position) > 79.9 mm"``, for the yield.
    draws
        How many copies of the mechanism are drawn.
    seed, sequence, store, cores, scheduler, executor, time_per_point, watch
        As `linkages.sweep` takes them.
    options
        As `SimulationOptions` describes them.

    Returns
    -------
    Dataset with the dimensions `measure`, `contributor` and `draw`, in SI. Of the linear analysis,
    from exact derivatives: `sensitivity`, `contribution` (at the limit of each zone), `share` of
    the variance, `linear_deviation` (root of the sum of squares), `linear_mean` and
    `linear_spread` (expected mean and standard deviation; those of `linear_sample` for a measure of
    errors), `worst` (least and largest) and `corner` (what the measures really are there). Of the
    Monte Carlo: `sample` with `linear_sample` beside it, `outcome` and `reason` of each draw,
    `mean`, `deviation`, `skewness`, `error_of_mean`. `within` has the yield of each limit and its
    confidence interval: copies that cannot be assembled are not within. Its attribute `remarks`
    says where the linear analysis fails.

    Raises
    ------
    InputError, ValueError, TypeError
        For what makes no sense, or if nothing varies.
    ComputationError
        If the nominal motion stops, or a measure has no derivative.
    Interrupted
        After Ctrl-C; ``kept["tolerance"]`` has what there is.
    """
    if not draws >= FEWEST:
        raise ValueError(f"expected at least {FEWEST} draws, found {draws}")
    kept_to = [read_limits(text) for text in ([limits] if isinstance(limits, str) else limits)]
    measures = named_measures(of)
    for each in kept_to:
        measures.setdefault(measure_name(each.measure), read_measure(each.measure))
    if not measures:
        example = example_measure(mechanism)
        raise ValueError(f"nothing is asked for; expected a measure such as {example!r}")
    contributors = contributors_of(mechanism)
    units = measure_units(System(contributors.nominal), measures)
    bounds = [each.numbers(units[measure_name(each.measure)]) for each in kept_to]
    given = {name: value for name, value in options.items() if value is not None}
    linear = linearised(contributors, measures, given)
    texts = {name: each.text for name, each in measures.items()}
    corners = _at_corners(contributors, linear, texts, options)
    where: dict[str, Any] = {"cores": cores, "scheduler": scheduler, "executor": executor}
    interrupted = False
    try:
        drawn = sweep(
            contributors.varied, contributors.distributions, texts, draws=draws,
            seed=seed, sequence=sequence, store=store, nominal=contributors.nominal,
            time_per_point=time_per_point, watch=watch, **where, **options,
        )  # fmt: skip
    except Interrupted as stop:
        if not stop.kept:
            raise
        drawn, interrupted = cast("xr.Dataset", stop.kept["sweep"]), True
    data = _dataset(contributors, linear, drawn, corners, units)
    if kept_to:
        data = data.assign(_yields(kept_to, bounds, drawn))
    data.attrs |= {"interrupted": int(interrupted), "draws": draws, "seed": seed}
    data.attrs["remarks"] = "\n".join(remarks(data, mechanism))
    if interrupted:
        done = int((drawn["outcome"] != Code.MISSING).sum())
        message = f"interrupted after {done} of {draws} draws"
        raise Interrupted(message, kept={"tolerance": data})
    return data


def _at_corners(
    contributors: Contributors,
    linear: Mapping[str, LinearMeasure],
    texts: Mapping[str, str],
    options: Mapping[str, Any],
) -> dict[str, list[tuple[float, float, str]]]:
    """Name → what the measure is linearly and really at its two worst corners, and why not."""
    worst = {name: each.worst() for name, each in linear.items()}
    asked = [(n, side) for n, pair in worst.items() for side in (0, 1) if pair[side].moved]
    points = [contributors.overrides(*worst[name][side].deviations) for name, side in asked]
    result = {n: [(corner.value, corner.value, "") for corner in pair] for n, pair in worst.items()}
    if not points:
        return result
    paths = tuple(points[0])
    rows = [[point[path] for path in paths] for point in (*points, points[-1])]  # two at least
    over: dict[Any, Any] = {paths: rows} if len(paths) > 1 else {paths[0]: [r[0] for r in rows]}
    data = sweep(contributors.varied, over, texts, nominal=contributors.nominal, **options)
    for k, (name, side) in enumerate(asked):
        real, reason = float(data[name][k]), str(data["reason"].to_numpy()[k])
        result[name][side] = (worst[name][side].value, real, reason)
    return result


def _dataset(
    contributors: Contributors,
    linear: Mapping[str, LinearMeasure],
    drawn: xr.Dataset,
    corners: Mapping[str, Sequence[tuple[float, float, str]]],
    units: Mapping[str, str],
) -> xr.Dataset:
    import xarray as xr

    names = [*linear]
    samples = np.array([drawn[name].to_numpy() for name in names])
    values = {path: drawn[path].to_numpy() for path in contributors.distributions}
    offsets, shifts = contributors.drawn(values)
    predicted = np.array([each.predicted(offsets, shifts) for each in linear.values()])
    made = [*linear.values()]
    by_contributor = ("measure", "contributor")
    moments = np.array([_moments(row) for row in samples]).T
    computed = [row[np.isfinite(real)] for row, real in zip(predicted, samples, strict=True)]
    expected = np.array([each.moments(row) for each, row in zip(made, computed, strict=True)]).T
    sides = ("measure", "side")
    variables: dict[str, Any] = {
        "nominal": ("measure", [each.nominal for each in made]),
        "sensitivity": (by_contributor, np.array([each.sensitivities() for each in made])),
        "contribution": (by_contributor, np.array([each.contributions for each in made])),
        "share": (by_contributor, np.array([each.shares for each in made])),
        "linear_deviation": ("measure", [each.deviation for each in made]),
        "worst": (sides, np.array([[side[0] for side in corners[n]] for n in names])),
        "corner": (sides, np.array([[side[1] for side in corners[n]] for n in names])),
        "corner_reason": (sides, np.array([[side[2] for side in corners[n]] for n in names])),
        "sample": (("measure", "draw"), samples),
        "linear_sample": (("measure", "draw"), predicted),
        "mean": ("measure", moments[0]),
        "deviation": ("measure", moments[1]),
        "skewness": ("measure", moments[2]),
        "error_of_mean": ("measure", moments[1] / np.sqrt(np.maximum(moments[3], 1.0))),
        "computed": ("measure", moments[3].astype(int)),
        "linear_mean": ("measure", expected[0]),
        "linear_spread": ("measure", expected[1]),
        "linear_skewness": ("measure", [_moments(row)[2] for row in computed]),
        "outcome": drawn["outcome"].drop_vars([*values]),
        "reason": drawn["reason"].drop_vars([*values]),
        "stop_time": drawn["stop_time"].drop_vars([*values]),
        "evaluations": drawn["evaluations"].drop_vars([*values]),
        "half_width": ("contributor", contributors.halves),
        "standard_deviation": ("contributor", contributors.deviations),
    }
    coordinates = {
        "measure": names,
        "contributor": contributors.names,
        "side": ["least", "largest"],
        "units": ("measure", [units[name] for name in names]),
        "contributor_units": ("contributor", contributors.units),
        "draw": drawn["draw"].to_numpy(),
        **{path: drawn[path].variable for path in values},
    }
    about = {"name": contributors.mechanism.name, "source": contributors.mechanism.file_name}
    return xr.Dataset(variables, coordinates, about)


def _moments(values: Floats) -> tuple[float, float, float, int]:
    """Mean, standard deviation, skewness, and how many values there are."""
    values = values[np.isfinite(values)]
    count = len(values)
    if count < 2:
        return (float(values.mean()) if count else np.nan), np.nan, np.nan, count
    mean, deviation = float(values.mean()), float(values.std(ddof=1))
    third = float(np.mean((values - mean) ** 3))
    return mean, deviation, third / deviation**3 if deviation > 0.0 else 0.0, count


def _yields(
    limits: Sequence[MeasureLimits], bounds: Sequence[tuple[float, float]], drawn: xr.Dataset
) -> dict[str, Any]:
    """The share of copies within each limit, and within all, with its interval."""
    computed = drawn["outcome"].to_numpy() != Code.MISSING
    kept = []
    for each, (low, high) in zip(limits, bounds, strict=True):
        values = drawn[measure_name(each.measure)].to_numpy()
        kept.append((values >= low) & (values <= high))
    names = [each.text for each in limits]
    if len(limits) > 1:
        kept.append(np.all(kept, axis=0))
        names.append(ALL)
    whole = int(computed.sum())
    rows = [share_within(int((each & computed).sum()), whole) for each in kept]
    low, high = np.array([*bounds, *([(np.nan, np.nan)] * (len(names) - len(bounds)))]).T
    measured = [measure_name(each.measure) for each in limits] + [""] * (len(names) - len(limits))
    return {
        "within": (("limit", "bound"), np.array(rows)),
        "limit_low": ("limit", low),
        "limit_high": ("limit", high),
        "limit": names,
        "limited": ("limit", measured),
        "bound": ["share", "low", "high"],
    }
