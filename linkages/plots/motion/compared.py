"""Series of one or several motions, and their differences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at
from linkages.kernel.outputs import VARIABLES
from linkages.plots.style import path_words
from linkages.reading.document import Document
from linkages.reading.paths import dotted
from linkages.reading.wording import shown
from linkages.solution.extremes import ROUND_OFF, largest_between
from linkages.solution.interpolated import through
from linkages.solution.measuring import FormulaSeries, is_formula
from linkages.solution.series import (
    TIME,
    available,
    data_series,
    find_series,
    system_series,
    with_sizes,
)
from linkages.solution.solution import Solution
from linkages.spec.grammar import NumberError, leading_number

if TYPE_CHECKING:
    import xarray as xr

    from linkages.plots.motion.curves import CurvePeak

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Curve:
    """One series of one motion, in SI; arrays of shape (samples,)."""

    source: str  # what tells the motion from others; empty if there is one
    name: str  # what the series is called
    quantity: str  # what it is one of
    units: str
    time: Array
    x: Array  # over time, it is `time`
    y: Array
    least: float = np.nan  # of `y`
    greatest: float = np.nan
    peak: CurvePeak | None = None  # that a figure marks


@dataclass(frozen=True, eq=False)
class Compared:
    """Curves over the same quantity."""

    curves: tuple[Curve, ...]  # at least one
    across: str  # what they are drawn over
    units: str  # of that
    heading: str = ""  # of the figure
    label: str = ""  # of the axis upwards; else what curves have in common
    horizon: float | None = None  # time beyond which they are not predictable

    @property
    def over_time(self) -> bool:
        """Whether they are drawn over time."""
        return self.across == TIME


def data_of(source: Any) -> xr.Dataset:
    """Data, or those of a solution."""
    return source if hasattr(source, "data_vars") else source.data


def resolved(source: Solution | xr.Dataset, variables: Sequence[str]) -> xr.Dataset:
    """Data with variables; those of a solution at samples that show every swing.

    What is not among its outputs is computed, but for what follows from a whole motion.
    """
    if not isinstance(source, Solution):
        return data_of(source)
    has = {*map(str, source.data.data_vars)}
    has |= {name for name in available(source.system) if not VARIABLES[name].whole}
    return source.dense([name for name in variables if name in has])


def with_samples(data: xr.Dataset, variable: str) -> xr.Dataset:
    """The data; ValueError if they lack a variable, or samples of it."""
    if variable not in data or not data[variable].size:
        raise ValueError(f"the data have no {variable}, or no samples of it")
    return data


class Viewed:
    """A motion whose series are asked for by name: a solution at close samples, or data.

    Of a solution they may be formulas as well.
    """

    def __init__(self, source: Solution | xr.Dataset, names: Sequence[str]) -> None:
        self.solution = source if isinstance(source, Solution) else None
        known = with_sizes(
            system_series(source.system) if isinstance(source, Solution) else data_series(source)
        )
        self.formulas = {
            name: FormulaSeries(self.solution, name)
            for name in names
            if self.solution and is_formula(known, name)
        }
        self.series = {n: find_series(known, n) for n in names if n not in self.formulas}
        variables = dict.fromkeys(s.variable for s in self.series.values() if s.variable != TIME)
        self.data = resolved(source, [*variables])
        for series in self.series.values():
            if series.variable not in self.data and series.variable != TIME:
                raise ValueError(f"the data have no {series.variable}; expected it in outputs")
        if not self.data.sizes.get(TIME):
            raise ValueError("there are no samples to draw")
        self.time = self.data[TIME].to_numpy().astype(float)

    def values(self, name: str) -> Array:
        """A series at the samples."""
        if name in self.formulas:
            return self.formulas[name].at(self.time)
        result = self.series[name]
        return (
            self.time if result.variable == TIME else result.of(self.data).to_numpy().astype(float)
        )

    def at(self, name: str, times: Array) -> Array:
        """A series at times within the motion."""
        if name in self.formulas:
            return self.formulas[name].at(times)
        if self.series[name].variable == TIME:
            return times
        order = 1 if self.time[-1] >= self.time[0] else -1
        count = np.arange(len(self.time), dtype=float)
        return self._between(name, np.interp(times, self.time[::order], count[::order]))

    def extremes(self, name: str) -> tuple[float, float]:
        """Least and largest value of a series, between samples where those are close enough."""
        values = self.values(name)
        close = name in self.formulas or (self.solution and self.solution.closely.close)
        if not close or name == TIME:
            return float(np.nanmin(values)), float(np.nanmax(values))
        if np.ptp(values) <= ROUND_OFF * np.abs(values).max():
            return float(values.min()), float(values.max())
        low = largest_between(-values[None], lambda _, places: -self._between(name, places))
        high = largest_between(values[None], lambda _, places: self._between(name, places))
        return -float(low.value[0]), float(high.value[0])

    def _between(self, name: str, places: Array) -> Array:
        """A series at places in samples from the first one."""
        if name in self.formulas:
            return self.at(name, np.interp(places, np.arange(len(self.time)), self.time))
        series = self.series[name]
        if self.solution is None:
            smooth = series.variable not in VARIABLES or VARIABLES[series.variable].smooth
            return through(self.values(name), places, smooth)
        import xarray as xr

        array = self.data[series.variable]
        result = self.solution.closely.between(series.variable, places)
        labels = {dim: array[dim] for dim in array.dims[1:]}
        there = xr.Dataset({series.variable: xr.DataArray(result, labels, array.dims)})
        return series.of(there).to_numpy().astype(float)

    def words(self, name: str) -> tuple[str, str, str]:
        """What a series is called, what quantity it is, and its unit."""
        if name in self.formulas:
            return name, "value", self.formulas[name].unit
        series = self.series[name]
        if series.variable == TIME:
            return TIME, TIME, "s"
        attrs = self.data[series.variable].attrs
        known = VARIABLES[series.variable].long_name if series.variable in VARIABLES else name
        quantity = str(attrs.get("long_name", known))
        return series.words(quantity), quantity, str(attrs.get("units", ""))


def compared(
    sources: Mapping[str, Solution | xr.Dataset],
    names: Sequence[str],
    against: str = TIME,
    *,
    difference: bool = False,
) -> Compared:
    """Series of motions as curves.

    `difference`: whether what the others differ in from the first motion is drawn, at the same time
    or at the same value of `against`, of which it must be a function then.
    """
    if not sources or not names:
        raise ValueError("nothing to draw; expected at least one motion and one series")
    wanted = list(dict.fromkeys([*names, against]))
    viewed = {label: Viewed(source, wanted) for label, source in sources.items()}
    if difference and len(viewed) < 2:
        raise ValueError("a difference needs two motions; found one")
    curves = []
    for place, (label, view) in enumerate(viewed.items()):
        if difference and not place:
            continue
        for name in names:
            words, quantity, units = view.words(name)
            result = Curve(
                label if len(viewed) > 1 else "", words, quantity, units,
                view.time, view.values(against), view.values(name), *view.extremes(name),
            )  # fmt: skip
            if difference:
                result = _less(result, next(iter(viewed.values())), name, against)
            curves.append(result)
    first = next(iter(viewed.values()))
    across, _, units = first.words(against)
    heading = str(first.data.attrs.get("name", ""))
    if difference:
        heading = f"{heading}: difference from {next(iter(viewed))}"
    return Compared(tuple(curves), across, units, heading)


def _less(curve: Curve, reference: Viewed, name: str, against: str) -> Curve:
    """A curve less the same series of another motion where that is at the same place."""
    own, times = reference.values(against), curve.time
    if against != TIME:
        steps = np.diff(own)
        if not ((steps > 0).all() or (steps < 0).all()):
            raise ValueError(
                f"{against} goes back and forth, so that a motion is at one value of it several "
                "times; expected a difference over time, or over what only grows"
            )
        from scipy.interpolate import CubicSpline

        order = 1 if steps[0] > 0 else -1
        times = CubicSpline(own[::order], reference.time[::order])(curve.x)
    low, high = sorted((float(own[0]), float(own[-1])))
    inside = (curve.x >= low) & (curve.x <= high)
    if not inside.any():
        raise ValueError(f"the motions have no {against} in common")
    there = reference.at(name, np.clip(times[inside], *sorted(reference.time[[0, -1]])))
    less = curve.y[inside] - there
    return replace(
        curve, time=curve.time[inside], x=curve.x[inside], y=less,
        least=float(less.min()), greatest=float(less.max()),
        quantity=f"difference in {curve.quantity}", name=f"difference in {curve.name}",
    )  # fmt: skip


def vectors(
    sources: Mapping[str, Solution | xr.Dataset], names: Sequence[str]
) -> tuple[Compared, ...]:
    """Vectors of motions, y over x, one set of curves for each: ``M.reaction``, ``P.velocity``.

    Raises
    ------
    ValueError
        For series that are no vectors.
    """
    result = []
    for name in names:
        curves = []
        for label, source in sources.items():
            view = Viewed(source, [name])
            series = view.series.get(name)
            if series is None or not series.size:
                raise ValueError(f"{name} has no direction; expected a vector such as M.reaction")
            array = view.data[series.variable].sel(dict(series.place)).transpose("time", "axis")
            x, y = array.to_numpy().astype(float).T
            words, quantity, units = view.words(name)
            shown = label if len(sources) > 1 else ""
            curves.append(
                Curve(shown, words, quantity, units, view.time, x, y, *view.extremes(name))
            )
        heading = str(view.data.attrs.get("name", ""))
        result.append(Compared(tuple(curves), f"{curves[0].name}, x", curves[0].units, heading))
    return tuple(result)


MOST = 3  # differences that a legend can say


def told_apart(mechanisms: Sequence[Mechanism | None], names: Sequence[str] = ()) -> list[str]:
    """A name for each of some motions, no two alike.

    Returns: the values in which the definitions differ, if these are few; else names of files or
    mechanisms. Those that are still alike are numbered.
    """
    result = [""] * len(mechanisms)
    known = [mechanism.definition for mechanism in mechanisms if mechanism]
    if len(known) == len(result):
        result = _differences(known)
    if len({*result}) < len(result):
        own = [m.name if m else "" for m in mechanisms]
        others = list(names) or own
        result = [", ".join(filter(None, pair)) for pair in zip(others, result, strict=True)]
    if len({*result}) < len(result) or not all(result):
        result = [f"{name or 'run'} ({k})" for k, name in enumerate(result, start=1)]
    return result


def _differences(definitions: Sequence[Document]) -> list[str]:
    """What each definition has where not all agree; empty texts where they differ in too much."""
    flat = [dict(_leaves(definition.content)) for definition in definitions]
    paths = dict.fromkeys(path for one in flat for path in one)
    differing = [p for p in paths if len({shown(one.get(p)) for one in flat}) > 1]
    differing = [p for p in differing if p not in (("name",), ("description",))]
    if not 0 < len(differing) <= MOST:
        return [""] * len(flat)
    return [
        ", ".join(
            f"{path_words(path)} = {_text(value, unit_at(definition, path))}"
            for path, value in ((dotted(steps), one.get(steps)) for steps in differing)
        )
        for one, definition in zip(flat, definitions, strict=True)
    ]


def _text(value: object, si: str) -> str:
    """A value with its unit: the one that it is written with, else that of SI."""
    if value is None:
        return "none"
    try:
        number, unit = leading_number(str(value))
    except NumberError:
        return str(value)
    return f"{number:.6g} {unit or si}".rstrip()


def _leaves(content: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[Any, Any]]:
    if isinstance(content, dict):
        for key, value in content.items():
            yield from _leaves(value, (*path, str(key)))
    elif isinstance(content, list | tuple):
        for place, value in enumerate(content):
            yield from _leaves(value, (*path, place))
    else:
        yield path, content
