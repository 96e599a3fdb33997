"""Maps: an indicator of chaos over two parameters, or over a plane of initial states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.chaos.exponents import lyapunov_spectrum
from linkages.chaos.free_states import require_free
from linkages.chaos.indicators import fast_indicators
from linkages.chaos.lyapunov import characteristic_period
from linkages.chaos.section import section_settings
from linkages.chaos.sweep import Executor, Progress, sweep
from linkages.chaos.tangents import LinkageTangents
from linkages.chaos.varied import Axis, first_possible, require_different, varied
from linkages.chaos.varied import units as units_of
from linkages.components.mechanism import Mechanism
from linkages.kernel.system import System

if TYPE_CHECKING:
    import xarray as xr

INDICATORS = {
    "exponent": ("largest Lyapunov exponent", "1/s"),
    "fli": ("fast Lyapunov indicator", ""),
    "gali": ("generalised alignment index", ""),
}
PARTS = 16
"""Intervals within a period."""

ONE_SENSE = 0.9
"""Net angle of a rotation, in units of all that it turned."""


@dataclass(frozen=True)
class _Request:
    mechanism: Mechanism
    x: Axis
    y: Axis
    indicator: str
    periods: int
    method: str | None
    rtol: float | None

    def at(self, point: tuple[int, int]) -> Mechanism:
        """The mechanism at a column and a row."""
        column, row = point
        return varied(self.mechanism, {**self.x.at(column), **self.y.at(row)})

    def system(self, point: tuple[int, int]) -> System:
        """The same, assembled."""
        return System(self.at(point))

    def compute(self, point: tuple[int, int]) -> tuple[float, dict[str, str]]:
        """The indicator and what every free angle does."""
        mechanism = self.at(point)
        settings = section_settings(mechanism, self.method, self.rtol)
        count = 2 if self.indicator == "gali" else 1
        system = _Followed(
            System(mechanism),
            count,
            settings.method,
            settings.rtol,
            settings.atol,
            settings.step,
        )
        intervals = self.periods * PARTS
        interval = characteristic_period(mechanism) / PARTS
        if self.indicator == "exponent":
            exponents = lyapunov_spectrum(system, intervals=intervals, interval=interval, count=1)
            return float(exponents.values[0]), system.kinds()
        series = fast_indicators(system, intervals=intervals, interval=interval, count=count)
        found = series.fli if self.indicator == "fli" else series.gali
        return float(found[-1]), system.kinds()


class _Followed(LinkageTangents):
    """Tangents that remember where free angles were."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._places = [self.unwrapped]

    def advance(self, interval: float) -> None:
        """Integrate, and note where angles are."""
        super().advance(interval)
        self._places.append(self.unwrapped)

    def kinds(self) -> dict[str, str]:
        """Free angle → swing (less than a turn in all), rotation (nearly one sense) or mixed."""
        places = np.array(self._places)
        moved = np.abs(np.diff(places, axis=0)).sum(axis=0)
        net, extent = np.abs(places[-1] - places[0]), np.ptp(places, axis=0)
        found = {}
        for index, name in enumerate(self.system.topology.free):
            if self.angles[index]:
                turning = "rotation" if net[index] >= ONE_SENSE * moved[index] else "mixed"
                found[name] = "swing" if extent[index] < 2 * np.pi else turning
        return found


def chaos_map(
    mechanism: Mechanism,
    x: Axis,
    y: Axis,
    *,
    indicator: str = "exponent",
    periods: int = 100,
    method: str | None = None,
    rtol: float | None = None,
    executor: Executor | None = None,
    watch: Callable[[Progress], None] | None = None,
) -> xr.Dataset:
    """An indicator of chaos over a grid: of two parameters, or of an initial state.

    Parameters
    ----------
    mechanism
        From `linkages.load`.
    x, y
        Ranges of paths of the definition file, such as ``clearances.r1.angle`` and
        ``clearances.r1.speed`` for the plane of initial states.
    indicator
        ``"exponent"`` (1/s), ``"fli"`` (grows in proportion to time where motion is chaotic) or
        ``"gali"`` (shrinks to zero there, for motions that conserve energy).
    periods
        Length of each run.
    method, rtol
        As `linkages.simulate` takes them.
    executor, watch
        As `linkages.bifurcation` takes them.

    Returns
    -------
    Dataset with `indicator` (y, x), `rotation` (y, x, coordinate): what each free angle does, and
    `reason` (y, x) where nothing could be computed. The attribute ``interrupted`` is 1 after
    Ctrl-C.

    Raises
    ------
    InputError
        If a path names nothing or nothing is free.
    ValueError
        For arguments that make no sense.
    """
    import xarray as xr

    if indicator not in INDICATORS:
        raise ValueError(f"indicator must be one of {', '.join(INDICATORS)}, found {indicator!r}")
    if periods < 4:
        raise ValueError(f"a map needs at least 4 periods, found {periods}")
    request = _Request(mechanism, x, y, indicator, periods, method, rtol)
    require_different((x, y))
    points = [(column, row) for row in range(len(y)) for column in range(len(x))]
    first = first_possible(request.system, points)  # what is wrong everywhere shows here
    require_free(first)
    swept = sweep(request.compute, points, executor=executor, watch=watch)
    found = [None if outcome is None else outcome.value for outcome in swept.outcomes]
    bodies = first.mechanism.bodies
    angles = [name for name in first.topology.free if bodies[name].rotates]
    shape = (len(y), len(x))
    values = np.array([np.nan if f is None else f[0] for f in found]).reshape(shape)
    kinds = [["" if f is None else f[1].get(name, "") for name in angles] for f in found]
    words, units = INDICATORS[indicator]
    coordinates: dict[str, Any] = {"coordinate": np.array(angles, dtype=object)}
    for dim, axis in (("x", x), ("y", y)):
        coordinates |= {
            path: (dim, numbers, {"units": unit})
            for path, numbers, unit in zip(
                axis.paths, axis.values, units_of(mechanism, axis), strict=True
            )
        }
    return xr.Dataset(
        {
            "indicator": (("y", "x"), values, {"units": units, "long_name": words}),
            "rotation": (
                ("y", "x", "coordinate"),
                np.array(kinds, dtype=object).reshape(*shape, len(angles)),
            ),
            "reason": (("y", "x"), np.array(swept.reasons, dtype=object).reshape(shape)),
        },
        coordinates,
        {
            "name": mechanism.name,
            "source": mechanism.source,
            "kind": indicator,
            "x": x.label,
            "y": y.label,
            "periods": periods,
            "interrupted": int(swept.interrupted),
        },
    )
