"""Measures of the motion at every point of a sweep."""

from __future__ import annotations

import time
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.scene import TARGETS
from linkages.errors import ComputationError, InputError, LinkagesError
from linkages.kernel.number_effects import number_value
from linkages.kernel.system import System
from linkages.kernel.varying import Along, Varying
from linkages.options.run import SimulationOptions
from linkages.solution.contact_episodes import unrecorded
from linkages.solution.interpolated import (
    InterpolatedMotions,
    Resolved,
    can_be_batched,
    can_be_repeated,
    denser,
    evaluable,
    factor_of,
    resolved_motion,
    times_around_modes,
)
from linkages.solution.many import cpu_only, march_many, side_by_side
from linkages.solution.march import March, compute_motion
from linkages.solution.measure_names import (
    Source,
    known_series,
    measure_units,
    measured_series,
    needed_outputs,
    resolved,
)
from linkages.solution.measured import Reduced, reduced
from linkages.solution.motion import Motion, Settings
from linkages.solution.run_options import options_of
from linkages.solution.series import TIME, Series
from linkages.solution.simulate import have_inertia, require_inertia, simulate
from linkages.spec.measures import Measure
from linkages.spec.units import UnitError
from linkages.sweeps.driven_batch import complete_motions, serves
from linkages.sweeps.engine import (
    SIDE_BY_SIDE,
    Answer,
    Code,
    Field,
    OverTimeError,
    Question,
    answered,
    attempted,
    begun,
    evaluations,
    first_system,
    stop_code,
)
from linkages.sweeps.points import Points
from linkages.sweeps.running import stopping

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

TOGETHER = 256, 512
"""Fewest and most driven mechanisms that are evaluated together."""


@dataclass(frozen=True, eq=False)
class MeasureQuestion(Question):
    """Measures of a simulation at every point."""

    varying: Varying
    points: Points
    measures: Mapping[str, Measure]  # name → measure
    given: Mapping[str, Any]  # options of the simulation that are given
    seconds: float | None = None  # how long a point may take; None for any time
    # Whose motion errors are against; that which is varied if not given
    nominal: Mechanism | None = None

    @property
    def count(self) -> int:
        """Number of points."""
        return self.points.count

    @property
    def together(self) -> tuple[int, int]:
        """Many where drives determine the motion or motions go side by side, else one by one."""
        if self._driven:
            return TOGETHER
        return SIDE_BY_SIDE if self._side_by_side else (1, 1)

    @property
    def cpu_only(self) -> str:
        """What of it is computed on the CPU only."""
        if self._own:
            return "a sweep over options of the simulation"
        if self.seconds is not None:
            return "a sweep with a time for each point"
        if self._whole:
            return f"a measure of a whole motion ({', '.join(self._whole)})"
        return cpu_only(self.first, self._run)

    @property
    def room(self) -> int:
        """Bytes of the samples of a point, and of what they are measured by."""
        sample = 16 * len(self.first.state) + 8 * len(self._series)
        return super().room + 4 * sample * self._factor * self._run.samples

    @property
    def fields(self) -> Mapping[str, Field]:
        """A number for each measure."""
        return {name: Field() for name in self.measures}

    @property
    def described(self) -> dict[str, Any]:
        """Measures, options and points."""
        return {
            "measures": {name: each.text for name, each in self.measures.items()},
            "options": {name: value for name, value in self.given.items() if value is not None},
            "seconds per point": self.seconds,
            **({} if self.nominal is None else {"nominal": self.nominal.to_yaml()}),
            **self.points.described,
        }

    def numbers(self) -> Floats:
        """Numbers of all points."""
        return self.points.matrix_of(np.arange(self.count))

    @cached_property
    def first(self) -> System:
        """The first system that can be built; what is wrong everywhere shows there."""
        for path in self.points.paths:
            if path.split(".")[0] == TARGETS:
                raise ValueError(f"{path}: motions are compared with the targets of the file alone")
        system = first_system(self.varying, self.points)
        measure_units(system, self.measures)
        return system

    def prepare(self) -> None:
        """Compute what all points need; raises what is wrong with it."""
        _ = self.first, self._reference

    @cached_property
    def _resolved(self) -> dict[str, Measure]:
        return {name: resolved(self.first, each) for name, each in self.measures.items()}

    @cached_property
    def _series(self) -> dict[str, Series]:
        result = [known_series(self.first, each.series) for each in self._resolved.values()]
        return {name: series for each in result for name, series in each.items()}

    @cached_property
    def _driven(self) -> bool:
        """Whether motions follow from drives alone, so that all are evaluated at once."""
        return not self._own and serves(self.first, self._series)

    @cached_property
    def _own(self) -> bool:
        """Whether points have options of their own."""
        return any(path.split(".")[0] == "simulate" for path in self.points.paths)

    @cached_property
    def _plain(self) -> bool:
        """Whether numbers in SI are read as texts with units are, which takes longer."""
        try:
            text, si = (self.points.overrides(0, 1, si=si)[0] for si in (False, True))
            one, other = (self.varying.at(overrides) for overrides in (text, si))
        except (InputError, UnitError):
            return False
        same = one.structure.key == other.structure.key
        return same and np.array_equal(one.numbers, other.numbers)

    def units(self) -> dict[str, str]:
        """Unit of each measure."""
        return measure_units(self.first, self.measures)

    def answers(self, first: int, last: int) -> list[Answer]:
        """The measures at some points."""
        _ = self.first  # all points are built upon the same one, wherever they are computed
        along = self.varying.along(self.points.overrides(first, last, si=self._plain))
        result: dict[int, Answer] = {}
        if self._driven:
            result = self._at_once(along)
        elif self._side_by_side:
            result = self._marched(along)
        return [
            result[k] if k in result else answered(along, k, self._of) for k in range(len(along))
        ]

    def _at_once(self, along: Along) -> dict[int, Answer]:
        """Answers at points whose motion goes to its end without any doubt."""
        base, settled = self.varying.base, along.settled
        if base is None or settled is None:
            return {}
        columns = {k: column for k, column in enumerate(along.columns) if column is not None}
        chosen = np.array([*columns.values()], dtype=int)
        parameters, scales = settled.parameters[:, chosen], settled.margin_scale[:, chosen]
        result: dict[int, Answer] = {}
        keys = [*columns]
        batch = base.system, parameters, scales, self._run, self._series
        for which, motions in complete_motions(*batch):
            places = [keys[k] for k in which]
            motions.numbers = partial(self._numbers_of, along, places)
            result |= zip(places, self._measured(motions, [0] * len(places)), strict=True)
        return result

    def _numbers_of(self, along: Along, places: Sequence[int], path: str) -> Floats:
        """A number of the definition at some points."""
        mechanisms = (self.varying.mechanism_at(along.points[place]) for place in places)
        return np.array([number_value(each, path) for each in mechanisms], dtype=float)

    def _measured(self, source: Source, costs: Sequence[int]) -> Iterator[Answer]:
        """Answers of all motions of a source, and how many evaluations each took."""
        found: dict[str, Reduced | str] = {}
        for name, measure in self._resolved.items():
            try:
                found[name] = reduced(measure, source, self._reference)
            except ComputationError as error:
                found[name] = str(error)
        for row, cost in enumerate(costs):
            numbers, missing = {}, []
            for name, each in found.items():
                if reason := each if isinstance(each, str) else each.reason(row):
                    missing.append(reason)
                else:
                    assert isinstance(each, Reduced)
                    numbers[name] = float(each.values[row])
            code = Code.UNDEFINED if missing else Code.COMPUTED
            yield Answer(numbers, code, "; ".join(missing), None, cost)

    @cached_property
    def _whole(self) -> list[str]:
        """Outputs that need more than the motion at one time."""
        needed = needed_outputs(self.first, self.measures.values())
        return [name for name in needed if not evaluable(Series(name, name, {}))]

    @cached_property
    def _integrated(self) -> bool:
        """Whether measures are integrals over time."""
        return any(each.integrates for each in self.measures.values())

    @cached_property
    def _run(self) -> SimulationOptions:
        return options_of(SimulationOptions, self.varying.mechanism, self.given)

    @cached_property
    def _times(self) -> Floats:
        return np.linspace(0.0, self._run.end, self._run.samples)

    @property
    def _counting(self) -> bool:
        return any(each.variable != TIME and each.angle for each in self._series.values())

    @cached_property
    def _side_by_side(self) -> bool:
        """Whether motions are integrated side by side: not where each has its own time."""
        free = bool(self.first.topology.coordinates)
        return free and not (self._own or self._whole or self.seconds)

    @cached_property
    def _factor(self) -> int:
        """How many times as close most motions want their samples, as the first one does."""
        settings = Settings(times=self._times, run=self._run, counting=self._counting)
        try:
            return factor_of(compute_motion(self.first, settings), len(self._times))
        except LinkagesError:
            return 1

    def _marched(self, along: Along) -> dict[int, Answer]:
        """Answers at points whose motions are integrated side by side."""
        systems, result = begun(along, lambda _, system: system)
        for place in self._doubtful(systems):
            checked = attempted(partial(_with_inertia, systems[place]))
            if checked.code != Code.COMPUTED:
                result[place] = checked
                del systems[place]
        waiting = {self._factor: systems}
        while waiting:
            factor, group = waiting.popitem()
            times = denser(self._times, factor)
            marches = [March(one, self._run, counting=self._counting) for one in group.values()]
            with np.errstate(over="ignore", invalid="ignore"):
                motions = march_many(marches, times, watch=self._watch())
            moved: dict[int, tuple[System, Motion]] = {}
            for (place, system), motion in zip(group.items(), motions, strict=True):
                if isinstance(motion, LinkagesError):
                    result[place] = Answer.of(motion, stop_code(motion))
                    continue
                whole = motion.failure is None
                wanted = factor_of(motion, len(self._times)) if whole else factor
                if wanted == factor:
                    moved[place] = system, motion
                else:  # which follows from its steps alone
                    waiting.setdefault(wanted, {})[place] = system
            result |= self._of_moved(self._closely(moved, times))
        return result

    def _doubtful(self, systems: Mapping[int, System]) -> list[int]:
        """Places of those that may lack inertia."""
        alike: dict[Hashable, list[int]] = {}
        for place, system in systems.items():
            alike.setdefault((system.structure.key, system.topology.free), []).append(place)
        result: list[int] = []
        for places in alike.values():
            sound = have_inertia([systems[place] for place in places])
            result += [place for place, good in zip(places, sound, strict=True) if not good]
        return result

    def _closely(
        self, moved: Mapping[int, tuple[System, Motion]], time: Floats
    ) -> dict[int, tuple[System, Resolved]]:
        """Motions with samples beside changes of mode, where what is measured needs these."""
        result = {place: (one, Resolved(motion, time)) for place, (one, motion) in moved.items()}
        if not self._integrated:
            return result
        own = {
            place: times_around_modes(motion, time)
            for place, (_, motion) in moved.items()
            if motion.failure is None and can_be_repeated(motion)
        }
        own = {place: times for place, times in own.items() if len(times) > len(time)}
        going = [
            March(moved[place][0], self._run, counting=self._counting).advancing(times)
            for place, times in own.items()
        ]
        with np.errstate(over="ignore", invalid="ignore"):
            motions = side_by_side(going, self._watch())
        for place, motion in zip(own, motions, strict=True):
            assert isinstance(motion, Motion)  # as it was before
            result[place] = moved[place][0], Resolved(motion, time)
        return result

    def _of_moved(self, moved: Mapping[int, tuple[System, Resolved]]) -> dict[int, Answer]:
        """Answers of motions with the same samples, as many together as can be."""
        alike: dict[Hashable, dict[int, tuple[System, Resolved]]] = {}
        result: dict[int, Answer] = {}
        for place, (system, own) in moved.items():
            motion = own.motion
            known = not (self._integrated and unrecorded(motion))
            if motion.failure is None and known and can_be_batched(motion, self._series):
                key = system.structure.key, system.topology.coordinates
                alike.setdefault(key, {})[place] = system, own
            else:
                result[place] = self._answer(system, own, None)
        for group in alike.values():
            systems = [system for system, _ in group.values()]
            motions = [own.motion for _, own in group.values()]
            time = next(iter(group.values()))[1].time
            source = InterpolatedMotions(systems, motions, self._series, time)
            costs = [evaluations(motion) for motion in motions]
            result |= zip(group, self._measured(source, costs), strict=True)
        return result

    @cached_property
    def _reference(self) -> InterpolatedMotions | None:
        """The motion that errors are against."""
        if not any(each.compares for each in self.measures.values()):
            return None
        system = System(self.nominal or self.varying.mechanism)
        for each in self.measures.values():
            measured_series(system, each)
        resolved, data = self._moved(system)
        motion = resolved.motion
        if motion.failure is not None:
            raise ComputationError(f"the nominal motion: {motion.failure}", time=motion.stop_time)
        return self._alone(system, resolved, data)

    def _alone(
        self, system: System, resolved: Resolved, data: xr.Dataset | None
    ) -> InterpolatedMotions:
        motion, time, settings = resolved
        return InterpolatedMotions(
            [system], [motion], self._series, time, data=data, settings=settings
        )

    def _of(self, system: System) -> Answer:
        """The answer of one mechanism by itself."""
        return self._answer(system, *self._moved(system))

    def _moved(self, system: System) -> tuple[Resolved, xr.Dataset | None]:
        """The motion of one mechanism by itself, and outputs that need more than one time."""
        mechanism, watch = system.mechanism, self._watch()
        if self._whole:
            solution = simulate(mechanism, outputs=self._whole, watch=watch, **self.given)
            motion, settings, data = solution.motion, solution.settings, solution.data
        else:
            run = options_of(SimulationOptions, mechanism, self.given)
            times = np.linspace(0.0, run.end, run.samples)
            settings = Settings(times=times, run=run, counting=self._counting, watch=watch)
            require_inertia(system)
            with np.errstate(over="ignore", invalid="ignore"):
                motion, data = compute_motion(system, settings), None
        if motion.failure is None:
            return resolved_motion(system, motion, settings, self._integrated), data
        return Resolved(motion, motion.time), data

    def _answer(self, system: System, moved: Resolved, data: xr.Dataset | None) -> Answer:
        motion = moved.motion
        if motion.interrupted:
            raise KeyboardInterrupt
        if motion.failure is not None:
            stopped = ComputationError(motion.failure, time=motion.stop_time)
            return Answer.of(stopped, stop_code(stopped), evaluations(motion))
        source = self._alone(system, moved, data)
        return next(self._measured(source, [evaluations(motion)]))

    def _watch(self) -> Any:
        """Called now and then: ends a point that takes too long, or when the sweep ends."""
        begun = time.monotonic()

        def look(fraction: float) -> None:
            if stopping():
                raise KeyboardInterrupt
            if self.seconds is not None and time.monotonic() - begun > self.seconds:
                done = f"{100 * fraction:.0f} % of its motion"
                raise OverTimeError(f"took more than {self.seconds:g} s; {done} were computed")

        return look


def _with_inertia(system: System) -> Answer:
    require_inertia(system)
    return Answer()
