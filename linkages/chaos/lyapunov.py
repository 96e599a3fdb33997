"""Lyapunov exponents of a mechanism."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.chaos.certificate import certificate, samples_within
from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.contact_log import (
    ContactLog,
    check_interval,
    contact_values,
    contact_variables,
)
from linkages.chaos.exponents import (
    FEWEST_INTERVALS,
    FURTHEST_APART,
    Exponents,
    UnfinishedExponentsError,
    lyapunov_spectrum,
)
from linkages.chaos.free_states import require_free
from linkages.chaos.invariants import Invariant
from linkages.chaos.section import how, section_settings
from linkages.chaos.tangents import LinkageTangents
from linkages.chaos.unfinished import UnfinishedError
from linkages.chaos.volumes import Volumes
from linkages.components.mechanism import Mechanism
from linkages.errors import Interrupted
from linkages.kernel.system import System
from linkages.solution.arguments import whole_number
from linkages.solution.motion import Settings
from linkages.solvers.integrate import MAX_STEPS

if TYPE_CHECKING:
    import xarray as xr

MOST_RUNS = 4
"""Runs with shorter and shorter intervals."""

PARTS = 4
"""Intervals within a period, more if tangents come too far apart within one."""


def lyapunov(
    mechanism: Mechanism,
    *,
    periods: int = 300,
    skip: int = 0,
    count: int | None = None,
    interval: float | None = None,
    method: str | None = None,
    rtol: float | None = None,
    max_steps: int = MAX_STEPS,
    watch: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Lyapunov exponents from the variational equations, with exact derivatives.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    periods
        Length of the run in common periods of the drives, or in units of `interval`.
    skip
        Periods before the average begins.
    count
        How many exponents, the largest; the whole spectrum if not given. The cost grows with it.
    interval
        What counts as a period, in seconds; the common period of the drives, or the file's end
        time where drives have none.
    method, rtol, max_steps
        As `linkages.simulate` takes them; those of the file if not given.
    watch
        Called now and then with the fraction done.

    Returns
    -------
    Dataset with `exponent` and `error` (index) in 1/s, the largest first, and their `history`
    (time, index). For the whole spectrum also what is known of it otherwise: `found`, `expected`
    and `tolerance` (invariant). Attributes: ``settled`` (0 or 1) with a ``warning`` if the history
    has not settled or an invariant is violated, ``sum`` and ``sum_error`` of the exponents. With
    clearances, `contact_lost` and `least_force` (clearance) as `linkages.poincare` has them, over
    what is averaged.

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
    system, settings = System(mechanism), section_settings(mechanism, method, rtol, max_steps)
    looked = check_interval(system)
    log = None if looked is None else ContactLog(system, looked)

    def labelled(exponents: Exponents) -> xr.Dataset:
        data = labelled_exponents(mechanism, exponents).assign_attrs(skip=skip, **how(settings))
        if log is None:
            return data
        contacts = log.contacts
        names = [contact.clearance for contact in contacts]
        values = contact_variables(contact_values(contacts, names), log.interval)
        return data.assign(values).assign_coords(clearance=np.array(names, dtype=object))

    try:
        exponents = run_exponents(
            system,
            settings,
            periods=periods,
            skip=skip,
            count=count,
            interval=interval,
            watch=watch,
            log=log,
        )
    except UnfinishedExponentsError as error:
        kept = {"lyapunov": labelled(error.exponents)}
        raise UnfinishedError(str(error), kept, time=error.time) from None
    except Interrupted as error:
        part = error.kept.get("exponents")
        kept = {} if part is None else {"lyapunov": labelled(part)}
        raise Interrupted(str(error), time=error.time, kept=kept) from None
    return labelled(exponents)


def labelled_exponents(mechanism: Mechanism, exponents: Exponents) -> xr.Dataset:
    """Exponents as `lyapunov` returns them."""
    import xarray as xr

    units = {"units": "1/s"}
    total, total_error = exponents.sum
    index = np.arange(1, len(exponents.values) + 1)
    violations = [found.violation for found in exponents.certificate if not found.holds]
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
            "invariant": np.array([found.name for found in exponents.certificate], dtype=object),
        },
        {
            "name": mechanism.name,
            "source": mechanism.source,
            "settled": int(exponents.settled),
            "warning": " ".join([*violations, *filter(None, [exponents.unsettled])]),
            "sum": total,
            "sum_error": total_error,
        },
    )


def _invariants(certificate: Sequence[Invariant]) -> dict[str, Any]:
    """What is known of the exponents, as variables over `invariant`."""
    columns = {
        "found": ([found.found for found in certificate], "from the exponents"),
        "expected": ([found.expected for found in certificate], "what is known"),
        "tolerance": ([found.tolerance for found in certificate], "allowed difference"),
    }
    return {
        name: ("invariant", np.array(values, dtype=float), {"units": "1/s", "long_name": text})
        for name, (values, text) in columns.items()
    }


def run_exponents(
    system: System,
    settings: Settings,
    *,
    periods: int,
    skip: int = 0,
    count: int | None = None,
    interval: float | None = None,
    watch: Callable[[float], None] | None = None,
    log: ContactLog | None = None,
) -> Exponents:
    """Exponents of a motion that is integrated in a certain way; a log notes it behind `skip`."""
    require_free(system)
    periods, skip = whole_number("periods", periods), whole_number("skip", skip)
    if periods < 1 or skip < 0:
        raise ValueError(f"expected periods > 0 and skip >= 0, found {periods} and {skip}")
    whole = 2 * len(system.topology.free)
    columns = whole if count is None else count
    if not 1 <= columns <= whole:
        raise ValueError(f"count must be from 1 to {whole}, found {count}")
    length = characteristic_period(system.mechanism) if interval is None else interval

    def run(parts: int) -> Exponents:
        if log is not None:
            log.restart(since=system.time + skip * length)
        tangents = LinkageTangents(
            system,
            columns,
            settings.method,
            settings.rtol,
            settings.atol,
            settings.step,
            settings.max_steps,
            samples_needed(system, periods * parts) if columns == whole else 0,
            log,
        )

        def certify(exponents: Exponents) -> tuple[Invariant, ...]:
            return certificate(tangents, exponents, skip * parts)

        return lyapunov_spectrum(
            tangents,
            intervals=periods * parts,
            interval=length / parts,
            count=columns,
            skip=skip * parts,
            certify=certify if columns == whole else None,
            watch=watch,
        )

    parts = max(PARTS, math.ceil(FEWEST_INTERVALS / periods))
    return run(parts) if interval is not None else resolved(run, parts)


def resolved(run: Callable[[int], Exponents], parts: int) -> Exponents:
    """Exponents with intervals short enough for all tangents.

    Parameters
    ----------
    run
        Computes them with so many intervals within a period.
    parts
        How many to begin with.
    """
    most = math.log(FURTHEST_APART)
    found = run(parts)
    for _ in range(MOST_RUNS - 1):
        if found.apart <= most:
            break
        # round-off hides how far tangents shrink, so that one more run may not be enough
        parts *= math.ceil(2 * found.apart / most)
        found = run(parts)
    return found


def samples_needed(system: System, intervals: int) -> int:
    """States of each interval that a certificate needs: only damping is averaged over them."""
    return 1 if Volumes(system).conservative else samples_within(intervals)


def characteristic_period(mechanism: Mechanism) -> float:
    """The common period of the drives, or the file's end time where there is none."""
    try:
        return common_period(mechanism)
    except NoPeriodError:
        return mechanism.simulation.end
