"""Lyapunov exponents of mechanisms, alone or in batches, and their certificate.

References
----------
.. [1] U. Dressler, Phys. Rev. A 38 (1988) 2103: pairs of exponents under uniform damping.
.. [2] H. Haken, Phys. Lett. A 94 (1983) 71: a zero exponent along motions that do not end in rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.averages import mean_error
from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.contact_log import ContactLog, contact_values, contact_variables
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.exponents import (
    FEWEST_INTERVALS,
    Exponents,
    Growth,
    Invariant,
    Watch,
    lyapunov_spectrum,
    replace_lost,
    start_tangents,
)
from linkages.chaos.free_states import require_free
from linkages.chaos.volume_contraction import Volumes
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import Interrupted, LinkagesError, UnfinishedError
from linkages.kernel.system import System
from linkages.options.analysis_options import ExponentKeywords, ExponentOptions
from linkages.options.option import OptionError, takes
from linkages.solution.guards import free_vectors
from linkages.solution.many import Going, side_by_side
from linkages.solution.motion import Motion, Piece, Renormalised
from linkages.solution.run_options import options_of
from linkages.solvers.flow import MOST_DOUBT

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

MOST_SAMPLES = 2**20
"""States that are kept of a run."""

SAMPLES = 16
"""States within an interval over which the rate of damping is averaged, a power of two."""

ERRORS = 4.0
"""Standard errors beyond which what is known does not hold."""

SMALL = 0.1
"""Part of the standard error of exponents that errors of integration may reach."""

STEPS = 10.0
"""Errors of a step that may add up within an interval."""

GOES_ON = 0.5
"""Part of the speed at the beginning that a motion keeps which does not come to rest."""


def samples_within(intervals: int) -> int:
    """How many states to keep of each interval: a power of two. One is enough without damping."""
    return int(min(SAMPLES, 2 ** max(1, int(np.log2(MOST_SAMPLES / intervals)))))


def certificate(
    tangents: LinkageTangents, exponents: Exponents, skip: int
) -> tuple[Invariant, ...]:
    """Invariants that a whole spectrum must show.

    - The sum of all exponents is the mean rate at which volumes of states change. It is computed
      from the mass matrix and the loads, along the same motion.
    - Where no force depends on velocities, exponents come in pairs λ and −λ; where momenta decay at
      the same rate γ in all directions, in pairs whose sum is −γ [1]_. Forces that follow from no
      energy part the pairs.
    - Where accelerations do not depend on time, an exponent is zero unless the motion comes to rest
      [2]_; a second one if energy is conserved.

    Where forces may jump as a speed changes its sign, volumes and momenta change at once there, and
    nothing is said of the sum and of pairs.
    """
    if not exponents.some:
        return ()
    volumes, intervals = Volumes(tangents.system), len(exponents.growth)
    parts = 1 if volumes.conservative else min(tangents.parts, samples_within(intervals))
    between = tangents.parts // parts
    first, last = skip * tangents.parts, (skip + intervals) * tangents.parts + 1
    passed = tangents.motion.part(first, last, between)
    damping = _joined(passed, Volumes.damping_rates)
    logarithms = _joined(passed.part(each=parts), Volumes.logarithm)
    if tangents.metric.exchanged:  # which measures volumes of momenta
        logarithms = np.zeros_like(logarithms)
    numeric = _numeric(tangents.tolerance, exponents)
    floor = max(SMALL * float(exponents.errors.max()), numeric)
    traces = np.trace(damping, axis1=1, axis2=2) + _joined(passed, Volumes.relaxation)
    result = [_sum(exponents, traces, logarithms, parts, floor)] if volumes.told else []
    rate = volumes.uniform(damping) if volumes.told else None
    if rate is not None and volumes.potential:
        result += _pairs(exponents, rate, floor)
    count = len(tangents.system.topology.free)
    rates = free_vectors(tangents.system, passed)[:, count : 2 * count]
    if volumes.autonomous and _goes_on(rates, numeric):
        result += _zeros(exponents, volumes.conservative and volumes.potential, floor)
    return tuple(result)


def _numeric(tolerance: float, exponents: Exponents) -> float:
    """Errors of integration that growth rates may have.

    Those of as many steps as may add up in an interval, or in each of the stretches within it after
    which tangents that come apart are brought back.
    """
    stretch = max(1.0, math.log(MOST_DOUBT / tolerance))
    stretches = int(np.ptp(exponents.values) * exponents.lengths.mean() / stretch)
    return STEPS * max(tolerance, stretches * MOST_DOUBT) / float(exponents.lengths.min())


def _joined(motion: Motion, values: Callable[[Volumes, Piece], Floats]) -> Floats:
    """Values along a motion, in whatever coordinates it was integrated."""
    of_system = {piece.system: Volumes(piece.system) for piece in motion.pieces}
    return np.concatenate([values(of_system[piece.system], piece) for piece in motion.pieces])


def _sum(
    exponents: Exponents, damping: Floats, logarithms: Floats, parts: int, floor: float
) -> Invariant:
    """Every interval has its own sum, so that only errors of integration are left."""
    moved = np.diff(logarithms) / exponents.lengths
    expected = -moved - _means(damping, parts)
    coarse = expected if parts == 1 else -moved - _means(damping[::2], parts // 2)
    result, mean = float(exponents.growth.sum(axis=1).mean()), float(expected.mean())
    return Invariant(
        name="sum of all exponents",
        reason="the mean rate of change of volumes, from inertia and loads",
        found=result,
        expected=mean,
        tolerance=max(floor, abs(float(coarse.mean()) - mean)),
    )


def _means(values: Floats, parts: int) -> Floats:
    """Means over intervals of so many parts, by the trapezoidal rule."""
    between = 0.5 * (values[:-1] + values[1:])
    return np.asarray(between.reshape(-1, parts).mean(axis=1))


def pair_sums(exponents: Exponents) -> tuple[Floats, Floats]:
    """Sums λ_i + λ_{d+1-i} and their standard errors, shape (d/2,) each."""
    whole, size = exponents.growth.shape[1], exponents.states.shape[1]
    if whole != size or whole % 2:
        raise ValueError(f"pairs need the whole spectrum of an even number, not {whole} of {size}")
    half = whole // 2
    sums = exponents.growth[:, :half] + exponents.growth[:, : -half - 1 : -1]
    return sums.mean(axis=0), mean_error(sums)[0]


def _pairs(exponents: Exponents, rate: float, floor: float) -> list[Invariant]:
    """One pair alone would be the sum of all."""
    size = exponents.states.shape[1]
    sums, errors = pair_sums(exponents)
    reason = "momenta decay at one rate" if rate else "no force depends on velocities"
    return [
        Invariant(
            name=f"sum of exponents {first + 1} and {size - first}",
            reason=reason,
            found=float(sums[first]),
            expected=0.0 - rate,
            tolerance=max(ERRORS * float(errors[first]), floor),
        )
        for first in range(len(sums) if len(sums) > 1 else 0)
    ]


def _goes_on(rates: Floats, least: float) -> bool:
    """Whether the last quarter of a motion is about as fast as the first, and does not rest.

    Slower than `least` is what moves within an interval by errors of integration only. `rates` has
    shape (samples, n).
    """
    quarter = len(rates) // 4
    first, last = (np.sqrt(np.mean(part**2)) for part in (rates[:quarter], rates[-quarter:]))
    return bool(last > max(GOES_ON * first, least))


def _zeros(exponents: Exponents, conservative: bool, floor: float) -> list[Invariant]:
    """The exponents nearest to zero."""
    count = 2 if conservative else 1
    nearest = sorted(np.argsort(np.abs(exponents.values), kind="stable")[:count].tolist())
    reason = "along the motion itself, since nothing depends on time"
    return [
        Invariant(
            name=f"exponent {index + 1}",
            reason=reason if number == 0 else "towards motions of other energy",
            found=float(exponents.values[index]),
            expected=0.0,
            tolerance=max(ERRORS * float(exponents.errors[index]), floor),
        )
        for number, index in enumerate(nearest)
    ]


def certified(
    verdict: str, reasons: Sequence[str], invariants: Sequence[Invariant]
) -> tuple[str, list[str]]:
    """A verdict and its reasons: none where something that must hold does not."""
    violations = [item.violation for item in invariants if not item.holds]
    if not violations:
        return verdict, list(reasons)
    return "undecided", [*violations, *reasons]


TOUCH = ("least_touch", "least_touch_time", "least_touch_of")
"""Attributes: smallest rate of a touch, when, and of what."""

PARTS = 4
"""Intervals within a period."""


@takes(ExponentOptions)
def lyapunov(
    mechanism: Mechanism,
    *,
    watch: Callable[[float], None] | None = None,
    **options: Unpack[ExponentKeywords],
) -> xr.Dataset:
    """Lyapunov exponents from the variational equations, with exact derivatives.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    watch
        Called now and then with the fraction done.
    options
        As `ExponentOptions` describes them.

    Returns
    -------
    Dataset with `exponent` and `error` (index) in 1/s, the largest first, and their `history`
    (time, index). For the whole spectrum also what is known of it otherwise: `found`, `expected`
    and `tolerance` (invariant). Attributes: ``settled`` (0 or 1) with a ``warning`` if the history
    has not settled or an invariant is violated, ``sum`` and ``sum_error`` of the exponents,
    ``lost``, the number of those that are −∞, for motions merge with neighbours where rigid
    contacts close and where friction sticks,
    and where something touches, ``least_touch``, ``least_touch_time`` and ``least_touch_of``: the
    smallest rate of a touch behind `skip`, its time, and the name of the contact. With clearances,
    `contact_lost` and `least_force` (clearance) as `linkages.poincare` has them, over what is
    averaged.

    Raises
    ------
    InputError
        If nothing is free.
    ValueError
        For arguments that make no sense.
    ComputationError
        If the motion cannot go on. An `UnfinishedError` has the exponents up to there in
        ``kept["lyapunov"]``, if there were enough intervals for an error.
    Interrupted
        After Ctrl-C, with the same.
    """
    asked = options_of(ExponentOptions, mechanism, options)
    system = System(mechanism)
    log = ContactLog.of(system, run=asked)

    def labelled(exponents: Exponents) -> xr.Dataset:
        length = asked.interval or characteristic_period(mechanism)
        data = labelled_exponents(mechanism, exponents).assign_attrs(
            periods=asked.periods, skip=asked.skip, period=length, **asked.how
        )
        if log is None:
            return data
        contacts = log.contacts
        names = [contact.clearance for contact in contacts]
        values = contact_variables(contact_values(contacts, names), log.interval)
        return data.assign(values).assign_coords(clearance=np.array(names, dtype=object))

    try:
        exponents = run_exponents(system, asked, watch, log)
    except (UnfinishedError, Interrupted) as error:
        kept = {"lyapunov": labelled(error.kept["exponents"])} if error.kept else {}
        raise type(error)(str(error), kept=kept, time=error.time) from None
    return labelled(exponents)


def labelled_exponents(mechanism: Mechanism, exponents: Exponents) -> xr.Dataset:
    """Exponents as `lyapunov` returns them."""
    import xarray as xr

    units = {"units": "1/s"}
    total, total_error = exponents.sum
    index = np.arange(1, len(exponents.values) + 1)
    touch = exponents.touch
    violations = [item.violation for item in exponents.certificate if not item.holds]
    return xr.Dataset(
        {
            "exponent": ("index", exponents.values, {**units, "long_name": "Lyapunov exponent"}),
            "error": ("index", exponents.errors, {**units, "long_name": "standard error"}),
            "history": (("time", "index"), exponents.history, {**units, "long_name": "exponent"}),
            **_invariants(exponents.certificate),
        },
        {
            "time": ("time", exponents.times[1:], {"units": "s", "long_name": "time"}),
            "index": index,
            "invariant": np.array([item.name for item in exponents.certificate], dtype=object),
        },
        {
            "name": mechanism.name,
            "source": mechanism.file_name,
            "settled": int(exponents.settled),
            "warning": " ".join([*violations, *filter(None, [exponents.unsettled])]),
            "sum": total,
            "sum_error": total_error,
            "lost": exponents.lost,
            **({} if touch is None else dict(zip(TOUCH, touch, strict=True))),
        },
    )


def _invariants(certificate: Sequence[Invariant]) -> dict[str, Any]:
    """What is known of the exponents, as variables over `invariant`."""
    columns = {
        "found": ([item.found for item in certificate], "from the exponents"),
        "expected": ([item.expected for item in certificate], "what is known"),
        "tolerance": ([item.tolerance for item in certificate], "allowed difference"),
    }
    return {
        name: ("invariant", np.array(values, dtype=float), {"units": "1/s", "long_name": text})
        for name, (values, text) in columns.items()
    }


def run_exponents(
    system: System,
    options: ExponentOptions,
    watch: Callable[[float], None] | None = None,
    log: ContactLog | None = None,
) -> Exponents:
    """Exponents of a motion that is integrated in a certain way; a log notes it behind `skip`."""
    require_free(system)
    periods, skip, count = options.periods, options.skip, options.count
    whole = system.layout.directions
    columns = whole if count is None else count
    if columns > whole:
        raise OptionError("count", f"count must be from 1 to {whole}, found {count}")
    length = options.interval or characteristic_period(system.mechanism)

    parts, begun = parts_of(options), system.time + skip * length
    if log is not None:
        log.restart(since=begun)
    needed = samples_needed(system, periods * parts) if columns == whole else 0
    tangents = LinkageTangents(system, columns, options, parts=needed, log=log)

    def certify(exponents: Exponents) -> tuple[Invariant, ...]:
        return certificate(tangents, exponents, skip * parts)

    result = lyapunov_spectrum(
        tangents,
        intervals=periods * parts,
        interval=length / parts,
        count=columns,
        skip=skip * parts,
        certify=certify if columns == whole else None,
        watch=watch,
    )
    return replace(result, touch=tangents.slowest(begun))


def parts_of(options: ExponentOptions) -> int:
    """Intervals of a period."""
    return max(PARTS, math.ceil(FEWEST_INTERVALS / options.periods))


def samples_needed(system: System, intervals: int) -> int:
    """States of each interval that a certificate needs: only damping is averaged over them."""
    return 1 if Volumes(system).conservative else samples_within(intervals)


def characteristic_period(mechanism: Mechanism) -> float:
    """The common period of the drives, or the file's end time where there is none."""
    try:
        return common_period(mechanism)
    except NoPeriodError:
        return mechanism.simulation.end


class Grown:
    """A linkage whose growth has been computed: gives it out as `TangentSystem` does.

    `state`, `tangents`, `angles`, `time`, `furthest`: as they were at its start; state and time
    then as what was given out leaves them.
    """

    def __init__(self, system: LinkageTangents) -> None:
        self.state, self.tangents = system.state, system.tangents
        self.angles, self.time = system.angles, system.time
        self.furthest = system.furthest
        self.parts: list[Growth] = []
        self._given = 0
        self.error: LinkagesError | None = None

    def advance(self, interval: float) -> None:
        """Nothing is left to be computed."""
        raise AssertionError(f"growth over {interval:g} s has been computed")

    def grow(
        self,
        intervals: int,
        interval: float,  # noqa: ARG002
        *,
        orthogonal: bool = True,  # noqa: ARG002
        watch: Watch | None = None,  # noqa: ARG002
    ) -> Iterator[Growth]:
        """Yield what was computed of so many intervals, then raise what ended it early."""
        done = 0
        while done < intervals and self._given < len(self.parts):
            part = self.parts[self._given]
            self._given += 1
            done += len(part.times)
            if done:
                self.state, self.time = part.states[-1], float(part.times[-1])
            yield part
        if done < intervals and self.error is not None:
            raise self.error


def _batches(
    system: LinkageTangents, skip: int, intervals: int, length: float, orthogonal: bool
) -> Iterator[tuple[Floats, Renormalised]]:
    """The integrations for intervals that are skipped, and for those behind them."""
    yield from system.batches(skip, length, orthogonal=True)
    if skip:
        replace_lost(system)
    yield from system.batches(intervals, length, orthogonal)


def growing(
    system: LinkageTangents, intervals: int, length: float, *, orthogonal: bool, skip: int = 0
) -> Going[Grown]:
    """Grow the tangents of a linkage by integrations that it asks for; see `grow_together`."""
    result = Grown(system)
    try:
        for times, renormalised in _batches(system, skip, intervals, length, orthogonal):
            motion = yield from system.march.advancing(times, renormalised=renormalised)
            result.parts.append(system.taken(motion, renormalised, length))
            system.require(motion)
    except LinkagesError as error:
        result.error = error
    return result


def grow_together(
    systems: Sequence[LinkageTangents],
    intervals: int,
    lengths: Sequence[float],
    *,
    orthogonal: bool,
    skip: int = 0,
    watch: Watch | None = None,
) -> list[Grown]:
    """Grow the tangents of many linkages; each as `LinkageTangents.grow` does it, in all bits.

    `intervals`, `lengths`: how many, and their length in seconds for each system.
    """
    going = [
        growing(system, intervals, length, orthogonal=orthogonal, skip=skip)
        for system, length in zip(systems, lengths, strict=True)
    ]
    result = side_by_side(going, watch)
    return [grown for grown in result if isinstance(grown, Grown)]


def exponents_of(system: System, options: ExponentOptions) -> Going[Exponents]:
    """The largest exponents of a motion, by integrations that it asks for.

    As `linkages.chaos.lyapunov.run_exponents` has them, where these are not all of them.
    """
    assert options.count is not None
    require_free(system)
    parts, length = parts_of(options), options.interval or characteristic_period(system.mechanism)
    tangents = LinkageTangents(system, options.count, options)
    start_tangents(tangents, options.count)
    intervals, interval, skip = options.periods * parts, length / parts, options.skip * parts
    grown = yield from growing(tangents, intervals, interval, orthogonal=True, skip=skip)
    return lyapunov_spectrum(
        grown, intervals=intervals, interval=interval, count=options.count, skip=skip
    )
