"""Evidence for a verdict on a mechanism: section, motion, exponents."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period, incommensurate_periods
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.free_states import PAIRS, free_names, labelled_states, wrapped
from linkages.chaos.indicators import (
    FEWEST_POINTS,
    CorrelationDimension,
    PowerSpectrum,
    correlation_dimension,
    power_spectrum,
)
from linkages.chaos.periods import Rotation, classify_angle, refined
from linkages.chaos.sections import NeverCrossedError, crossing
from linkages.chaos.stretch import Evidence
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.inputs import law_values
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.options.analysis_options import SectionOptions
from linkages.options.run import RunOptions
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.guards import TOUCH, free_vectors
from linkages.solution.march import March
from linkages.solution.motion import Motion, Settings
from linkages.solution.remarks import assumptions, doubts
from linkages.solution.series import labelled_arrays, system_series
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

PER_PERIOD = 512
"""Samples of the motion within a period."""

RETURNS = 64
"""Crossings of a section from which the mean time between them is taken."""

FEWEST_RETURNS = 8
"""Crossings below which a section is seldom crossed, and another one is tried."""

GOES_ON = 0.2
"""Part of the mean time between crossings below which later ones accumulate."""

ALIKE = 1e-4
"""Part of its range by which an entry of the state may differ and be the same."""

ERRORS = 100.0
"""Tolerances of the integration that errors of a stretch may amount to."""

RESOLVED, NOISE = 1e-4, 0.1
"""Parts of its range by which an entry may differ from a run of smaller error and be resolved, and
from which on it is nothing but errors."""

CREEPING = 1.5
"""Way of an entry, in its ranges, up to which it moves in one direction."""

ROUND_OFF = 1e-13
"""Part of sizes, and of a radian, below which differences are those of round-off."""

MARGIN = 10.0
"""Differences from a run of smaller error that a resolved entry may have from itself."""

LONGER = 2.0
"""Part of the stretch, in its length, in which its crossings are looked for."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class SectionPlane:
    """Where section points are taken.

    `text`, `direction`: of a geometric section, as `linkages.poincare` takes it; empty for a
    stroboscopic one.
    """

    period: float  # seconds from point to point, or about that
    text: str = ""
    direction: str = "up"
    # Periods of drives and loads that have none in common with that of a stroboscopic one
    others: tuple[float, ...] = ()

    @property
    def attributes(self) -> dict[str, object]:
        """As `linkages.poincare` puts them into its dataset."""
        if self.text:
            return {"section": self.text, "direction": self.direction, "warning": ""}
        others = {"other_periods": list(self.others)} if self.others else {}
        return {"period": self.period, "phase": 0.0, "warning": "", **others}

    def points(
        self, system: System, start: System, run: RunOptions, count: int
    ) -> tuple[Floats, Floats]:
        """Points of a geometric section in the coordinates of a system, and their times.

        Returns: shape (points, 2n) and (points,): at most `count`, and fewer if the motion seldom
        crosses.
        """
        options = SectionOptions.like(
            run, section=self.text, direction=self.direction, periods=count
        )
        plan = crossing(start, options, start.time + LONGER * count * self.period, options)
        followed = March(start, options).advance(plan.times, guards=plan.guards)
        try:
            motion = plan.points(followed).motion
        except NeverCrossedError:
            return np.empty((0, system.layout.directions)), np.empty(0)
        return free_vectors(system, motion, turns=False), motion.time


def section_for(system: System, run: RunOptions, periods: int) -> SectionPlane:
    """Stroboscopic, or where the motion returns: its rate vanishes, or it rotates past.

    Where drives have no common period the longest one counts, so that a stretch shows the others.
    """
    with contextlib.suppress(NoPeriodError):
        return SectionPlane(period=common_period(system.mechanism))
    with contextlib.suppress(NoPeriodError):
        longest, *others = incommensurate_periods(system.mechanism)
        return SectionPlane(period=longest, others=tuple(others))
    end = system.mechanism.simulation.end
    tried = [SectionPlane(period=end, text=t, direction=d) for t, d in _sections(system)]
    for section in tried:
        probe = replace(section, period=end * periods / RETURNS / LONGER)
        _, times = probe.points(system, system, run, RETURNS)
        if len(times) >= FEWEST_RETURNS and _goes_on(times):
            return replace(section, period=float(np.ptp(times)) / (len(times) - 1))
    return next(section for section in tried if not section.text.endswith(f".{TOUCH}"))


def _goes_on(times: Floats) -> bool:
    """Whether later crossings are about as far apart as all, unlike impacts before rest."""
    gaps = np.diff(times)
    return bool(np.median(gaps[len(gaps) // 2 :]) > GOES_ON * gaps.mean())


def _sections(system: System) -> Iterator[tuple[str, str]]:
    """Geometric sections and their directions, in the order in which they are tried.

    Where something touches, rates jump past zero, and impacts are the points of the motion.
    """
    contacts, ends = system.mechanism.contacts, system.mechanism.ends
    for touched in [*(contact.name for contact in contacts), *(end.name for end in ends)]:
        yield f"{touched}.{TOUCH}", "up"
    known = system_series(system).values()
    for dim, names in free_names(system).items():
        value, rate = PAIRS[dim]
        for name in names:
            told = {s.variable: s.name for s in known if s.place.get(dim) == name}
            yield f"{told[rate]}=0", "up"
            at = system.state[system.topology.free.index(name)]
            yield f"{told[value]}={at:.17g}", "up"
            yield f"{told[value]}={at:.17g}", "down"


def alike(
    system: System, period: float, run: RunOptions
) -> Callable[[Floats, Floats | None], Floats]:
    """Difference of entries of states that counts as none, shape (d,), from states of a stretch.

    A ten-thousandth of what the entry ranges over, of an angle at most of a radian; or what its own
    errors amount to. These are at most `ERRORS` tolerances of the entry; the comparison with a run
    of smaller error shows how much of that. An entry that moves by no more than they allow counts
    as constant if it is different in that run, or creeps in one direction.
    """
    mechanism, free = system.mechanism, system.topology.free
    rotates = np.array([mechanism.bodies[name].rotates for name in free])
    places = np.array(list(system.places().values()))
    whole = np.where(rotates, 1.0, float(np.ptp(places, axis=0).max()))
    scales = [state.scale for state in mechanism.internal.values()]
    round_off = ROUND_OFF * np.concatenate([whole, whole * 2 * np.pi / period, scales])
    turning = np.concatenate([rotates, np.zeros(len(free) + len(scales), dtype=bool)])
    scale = np.array([*[1.0] * (2 * len(free)), *scales])
    atol = (run.rtol if run.atol is None else run.atol) * scale

    def tolerance(states: Floats, errors: Floats | None) -> Floats:
        ranges = np.ptp(states, axis=0)
        ranges = np.where(turning, np.minimum(ranges, 1.0), ranges)
        allowed = ERRORS * (run.rtol * np.abs(states).max(axis=0) + atol)
        if errors is None:
            return np.maximum(ALIKE * ranges, np.maximum(allowed, round_off))
        blurred = np.where(errors <= RESOLVED * ranges, np.minimum(MARGIN * errors, allowed), 0.0)
        creeps = np.abs(np.diff(states, axis=0)).sum(axis=0) <= CREEPING * ranges
        noise = np.where(creeps | (errors >= NOISE * ranges), allowed, blurred)
        return np.maximum(ALIKE * ranges, np.maximum(noise, round_off))

    return tolerance


def labelled_section(system: System, section: SectionPlane, evidence: Evidence) -> xr.Dataset:
    """Section points as `linkages.poincare` returns them."""
    free, size = list(system.topology.free), len(system.topology.free)
    values = {}
    for dim, names in free_names(system).items():
        columns = [free.index(name) for name in names]
        value, rate = PAIRS[dim]
        at = evidence.points[:, columns]
        values[value] = wrapped(at) if VARIABLES[value].angle else at
        values[rate] = evidence.points[:, [size + column for column in columns]]
    if system.topology.internal:
        values["internal_state"] = evidence.points[:, 2 * size :]
    time = ("crossing", evidence.times, {"units": "s", "long_name": "time"})
    return labelled_states(system, values, "crossing", {"time": time}, section.attributes)


def kept(tangents: LinkageTangents, periods: int) -> Motion:
    """The motion of a stretch at `PER_PERIOD` times in a period."""
    motion = tangents.motion
    return motion.part(each=(len(motion.time) - 1) // (periods * PER_PERIOD))


def followed(tangents: LinkageTangents, run: RunOptions, periods: int) -> Solution:
    """The motion of a stretch that was kept: free coordinates and clearance forces over time."""
    system, motion = tangents.system, kept(tangents, periods)
    outputs = [output for dim in free_names(system) for output in PAIRS[dim]]
    if "clearance_angle" in outputs:
        outputs.append("clearance_force")
    if system.topology.internal:
        outputs.append("internal_state")
    return Solution(
        data=labelled_arrays(system, motion, evaluate_variables(motion, outputs)),
        mechanism=system.mechanism,
        system=system,
        motion=motion,
        settings=Settings(times=motion.time, run=run),
        notes=(*assumptions(system), *doubts(system.mechanism), *motion.notes),
    )


def dimension_of(evidence: Evidence) -> CorrelationDimension | None:
    """Correlation dimension of the section; None for too few points.

    Not that of the motion between section points: along each turn of a torus samples lie on a
    curve, and only very long runs show more than that.
    """
    if len(evidence.points) < FEWEST_POINTS:
        return None
    return correlation_dimension(evidence.points, angles=evidence.angles)


def spectra_of(system: System, solution: Solution) -> dict[str, PowerSpectrum]:
    """Free coordinate → power spectrum of its rate."""
    interval = float(solution.data.time[1] - solution.data.time[0])
    free = _series(system, solution)
    return {name: power_spectrum(rate.to_numpy(), interval) for name, _, rate in free}


def rotation_of(system: System, solution: Solution) -> dict[str, Rotation]:
    """Free angle → what it does."""
    time = solution.data.time.to_numpy()
    return {
        name: classify_angle(*refined(time, value.to_numpy()))
        for name, value, _ in _series(system, solution)
        if VARIABLES[str(value.name)].angle
    }


def rates_of(
    system: System, solution: Solution, rotation: Mapping[str, Rotation]
) -> dict[str, tuple[float, str]]:
    """Free coordinate → its mean rate, that of `rotation` for an angle, and the unit of that."""
    result, time = {}, solution.data.time.to_numpy()
    for name, value, rate in _series(system, solution):
        mean = float(value[-1] - value[0]) / float(time[-1] - time[0])
        own = rotation[name].rate if name in rotation else mean
        result[name] = own, str(rate.attrs["units"])
    return result


def _series(system: System, solution: Solution) -> Iterator[tuple[str, xr.DataArray, xr.DataArray]]:
    """Free coordinates, their values and their rates over time."""
    for dim, names in free_names(system).items():
        value, rate = (solution.data[output] for output in PAIRS[dim])
        for name in names:
            yield name, value.sel({dim: name}), rate.sel({dim: name})


def driven(mechanism: Mechanism, first: float, last: float) -> bool:
    """Whether a drive moves between two times in seconds."""
    times = np.linspace(first, last, PER_PERIOD)
    laws = [drive.law for drive in mechanism.prescribed.values()]
    return any(np.ptp(law_values(law, times)) > 0 for law in laws)


def conservative(mechanism: Mechanism) -> bool:
    """Whether nothing dissipates: the flow then keeps volumes of states, and has no attractor.

    Drives and given forces may still put energy in and take it out.
    """
    loads, contacts = mechanism.loads, mechanism.contacts
    dissipating = [*(a.dissipates for a in loads), *(b.dissipates for b in contacts)]
    return not any([*dissipating, *mechanism.internal, *mechanism.ends])
