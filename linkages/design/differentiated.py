"""Measures as functions of numbers of the definition, with exact derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.derived import Derivatives, nodes_of
from linkages.design.law_breaks import (
    Break,
    advance_past_breaks,
    breaks,
    breaks_of_branches,
    breaks_of_modes,
    changing_modes,
    merged_breaks,
    times_around_changes,
    with_sides,
)
from linkages.design.moved import Moved
from linkages.design.reductions import as_far_as_finite, differentiated, followed
from linkages.errors import ComputationError
from linkages.kernel.dual_numbers import Varied
from linkages.kernel.inputs import Effects, slots
from linkages.kernel.number_effects import (
    Number,
    effects,
    given_number,
    ideal_number,
    number_value,
    numbers_of,
    value_of,
)
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.run import SimulationOptions
from linkages.reading.paths import split
from linkages.solution.interpolated import (
    compared_series,
    denser,
    driven_times,
    evaluable,
    factor_of,
)
from linkages.solution.march import March, compute_motion
from linkages.solution.measure_names import known_series, measure_unit, resolved
from linkages.solution.motion import Motion, Settings
from linkages.solution.run_options import options_of
from linkages.solution.series import Series
from linkages.solution.simulate import require_inertia
from linkages.spec.measures import Measure, argument, read_measure

Floats = NDArray[np.float64]


MORE_STEPS, FEWEST_STEPS = 20, 100
"""How many times as many steps as the motion alone a motion with derivatives may take."""


@dataclass(frozen=True)
class Evaluated:
    """Measures at some numbers."""

    values: Floats  # in SI, shape (M,)
    derivatives: Floats | None  # SI per SI, shape (M, P); None if they were not asked for


class Differentiated:
    """Measures of a mechanism as functions of numbers of its definition, with their derivatives.

    `paths` may be patterns such as ``bars.*``; the attribute has all P numbers, `values` in SI.
    Derivatives are measured in `scales` within a motion. Raises InputError if a path leads to no
    number or the mechanism cannot be assembled, ValueError if a text is no measure of it.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        measures: Sequence[str],
        paths: Sequence[str],
        *,
        run: Mapping[str, Any] | None = None,
    ) -> None:
        self._numbers = numbers_of(mechanism, paths)
        self.paths = tuple(number.path for number in self._numbers)
        self.mechanism = mechanism.keeping(self.paths)
        self.values: Floats = np.array([value_of(mechanism, one) for one in self._numbers])
        # what tangents are measured in: then they are as large as what they change
        self.scales = np.where(self.values == 0.0, 1.0, np.abs(self.values))
        read = [read_measure(text) for text in measures]
        for each in read:
            if each.compares:
                raise ValueError(
                    f"measure {each.text!r}: an error has the derivative of its series, and a "
                    "corner where it is zero; expected the series itself"
                )
        self._run = options_of(SimulationOptions, mechanism, run or {})
        self._derivatives = Derivatives()
        self._plain: Moved | None = None
        self._varying = Varying(self.mechanism)
        system = self._varying.at({})
        if system.chosen:
            message = (
                f"free coordinates ({', '.join(system.chosen)}) start where hints put them; name "
                "them in 'free', so that it is known what stays while numbers change"
            )
            raise mechanism.error([(("free",), message)])
        self._measures = [resolved(system, each) for each in read]
        result = [known_series(system, each.series) for each in self._measures]
        self.system = system
        self.units = tuple(measure_unit(system, each) for each in self._measures)
        self._named = tuple({path for each in self._measures for path in each.numbers})
        self.series = {name: series for each in result for name, series in each.items()}

    def at(self, numbers: Floats, derivatives: bool = True) -> Evaluated:
        """The measures at other numbers in SI, shape (P,), and their derivatives there."""
        return self.reduced(self.moved(numbers, self.series, derivatives))

    def reduced(self, moved: Moved) -> Evaluated:
        """The measures of a motion, with their derivatives if it has any; raises as `at` does."""
        result = [differentiated(each, moved) for each in self._measures]
        values = np.array([each.value for each in result], dtype=float)
        if not moved.count:
            return Evaluated(values, None)
        slopes = np.array([each.slopes for each in result], dtype=float)
        return Evaluated(values, slopes.reshape(len(result), -1) / self.scales)

    def each(self, moved: Moved) -> list[tuple[float, Floats, str]]:
        """Value, derivatives (P,) of each measure, and a reason where one is nan."""
        result = []
        for measure in self._measures:
            try:
                own, missing = as_far_as_finite(measure, moved)
            except ComputationError as error:
                missing = str(error)
                own = Varied(self._alone(measure), np.full(moved.count, np.nan))
            result.append((float(own.value), own.slopes / self.scales, missing))
        return result

    def _alone(self, measure: Measure) -> Floats:
        """A measure without derivatives; nan if it has no value either."""
        if self._plain is None:
            self._plain = self.moved(self.values, self.series, derivatives=False)
        try:
            return as_far_as_finite(measure, self._plain)[0].value
        except ComputationError:
            return np.array(np.nan)

    def along(
        self, numbers: Floats, series: Sequence[str], times: Floats, derivatives: bool = True
    ) -> Evaluated:
        """Series at times in s, shape (series, T), and derivatives, shape (series, P, T)."""
        measures = [resolved(self.system, read_measure(f"max({text})")) for text in series]
        known = [known_series(self.system, each.series) for each in measures]
        named = {name: one for each in known for name, one in each.items()}
        self._named = tuple({*self._named, *(path for each in measures for path in each.numbers)})
        moved = self.moved(numbers, named, derivatives)
        places = moved.places(np.asarray(times, dtype=float))
        result = [followed(argument(each), moved, places) for each in measures]
        values = np.array([each.value for each in result])
        if not derivatives:
            return Evaluated(values, None)
        slopes = np.array([each.slopes for each in result])
        return Evaluated(values, slopes / self.scales[:, None])

    def moved(
        self, numbers: Floats, series: Mapping[str, Series], derivatives: bool = True
    ) -> Moved:
        """The motion with other numbers; its derivatives are by numbers in `scales`."""
        system = self._system(np.asarray(numbers, dtype=float))
        asked = self._numbers if derivatives else ()
        own = {name: compared_series(each) or each for name, each in series.items()}
        moved = self._followed(system, asked, own)
        compared = {name: own[name] for name, each in series.items() if compared_series(each)}
        if not compared:
            return moved
        ideal = System(system.mechanism.ideal())
        kept = [ideal_number(system.mechanism, ideal.mechanism, number) for number in asked]
        beside = self._followed(ideal, kept, compared, moved.time)  # places are among its samples
        return moved.against(beside, [*compared])

    def _followed(
        self,
        system: System,
        asked: Sequence[Number | None],
        series: Mapping[str, Series],
        times: Floats | None = None,
    ) -> Moved:
        """The motion of a system with its derivatives by some numbers, maybe at given times."""
        require_inertia(system)
        changing = effects(system, asked).scaled(self.scales[: len(asked)])
        counting = any(each.angle for each in series.values())
        if asked and system.layout.moved:
            system = system.affected(changing)
        known = [one for one in series.values() if asked or evaluable(one)]
        nodes = [node for one in known for node in nodes_of(one, system.model)]
        if system.layout.moved:
            nodes += system.model.changes
        result = breaks(system, nodes, changing, self._run.end)
        if times is None and system.layout.moved:
            times = denser(self.sample_times, self.factor)
        elif times is None:
            times = driven_times(system, self._run.end)
        motion = self._motion(system, counting, times, result)
        if not system.layout.moved and (
            more := breaks_of_branches(nodes, motion, changing, self._derivatives)
        ):
            result = [*result, *more]
            motion = self._motion(system, counting, times, result)
        modes = changing_modes(motion, self._run.end)
        if modes:
            motion = self._motion(system, counting, times_around_changes(times, modes), result)
            result = [*result, *breaks_of_modes(modes, motion, changing, self._derivatives)]
        events = merged_breaks(result)
        named = {path: self._number(system, path, asked, changing) for path in self._named}
        return Moved(system, motion, series, changing, self._derivatives, times, events, named)

    def _number(
        self, system: System, path: str, asked: Sequence[Number | None], changing: Effects
    ) -> Varied:
        """A number of the definition, and how the numbers asked for change it, in their scales."""
        value, slopes = number_value(system.mechanism, path), np.zeros(len(asked))
        own = given_number(system.mechanism, path)
        if own is not None:
            same = [one is not None and (one.component, one.keys) == (own.component, own.keys)
                    for one in asked]  # fmt: skip
            slopes[same] = self.scales[: len(asked)][same]
        else:
            where = split(path)
            for (k, parameter), slope in zip(slots(changing.fed), changing.slopes, strict=True):
                if parameter == where:
                    slopes[k] = slope
        assert value is not None
        return Varied(np.array(value), slopes if len(asked) else None)

    def _system(self, numbers: Floats) -> System:
        if numbers.shape != self.values.shape:
            raise ValueError(f"expected {len(self.values)} numbers, found shape {numbers.shape}")
        changed = numbers != self.values  # what is as it was need not be read again
        pairs = zip(self.paths, numbers.tolist(), changed, strict=True)
        return self._varying.at({path: number for path, number, new in pairs if new})

    def _motion(
        self, system: System, counting: bool, times: Floats, found: Sequence[Break]
    ) -> Motion:
        """The motion to its end, with both sides of breaks among its samples."""
        times = with_sides(times, found)
        with np.errstate(over="ignore", invalid="ignore"):
            if system.effects is None:
                settings = Settings(times=times, run=self._run, counting=counting)
                motion = compute_motion(system, settings)
            else:
                # tangents of a number that takes a change point away grow without bound there
                most = min(self._run.most_steps, MORE_STEPS * (self._first[1] + FEWEST_STEPS))
                march = March(
                    system,
                    replace(self._run, max_steps=most),
                    tangents=len(system.effects),
                    tangent_atol=self._run.atol or self._run.rtol,
                    counting=counting,
                )
                motion = advance_past_breaks(
                    march, times, [one for one in found if one.moved.any()]
                )
                if motion.failure is not None and not motion.interrupted:
                    self._require_bounded(system, motion)
        if motion.interrupted:
            raise KeyboardInterrupt
        if motion.failure is not None:
            raise ComputationError(motion.failure, time=motion.stop_time)
        return motion

    def _require_bounded(self, system: System, motion: Motion) -> None:
        """Where the motion alone goes on, it is the derivatives that do not."""
        times = np.array([0.0, self._run.end])
        alone = compute_motion(system.affected(None), Settings(times=times, run=self._run))
        if alone.failure is None:
            message = (
                "derivatives grow without bound here, as by a number without which a change point "
                "is none; ask for others, or for a shorter motion"
            )
            raise ComputationError(message, time=motion.stop_time)

    @property
    def sample_times(self) -> Floats:
        """Times in s at which a simulation has samples."""
        return np.linspace(0.0, self._run.end, self._run.samples)

    def sampled(self, moved: Moved, names: Sequence[str]) -> Floats:
        """Derivatives of series at these, shape (series, P, samples)."""
        if moved.integrated:
            rows = moved.sampled(names)[..., :: self.factor]
        else:
            rows = np.array(moved.slopes(names, moved.places(self.sample_times)))
        return np.asarray(rows / self.scales[:, None])

    @property
    def factor(self) -> int:
        """How many times as close samples must be, for the numbers of the definition."""
        return self._first[0]

    @cached_property
    def _first(self) -> tuple[int, int]:
        """The factor, and the steps of the motion of the definition."""
        if not self.system.layout.moved:
            return 1, 0
        motion = compute_motion(self.system, Settings(times=self.sample_times, run=self._run))
        return factor_of(motion, self._run.samples), motion.cost["steps"]
