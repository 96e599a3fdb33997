"""Lyapunov exponents of a mechanism."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from linkages.chaos.growth.certificate import certificate, samples_within
from linkages.chaos.growth.exponents import (
    FEWEST_INTERVALS,
    Exponents,
    lyapunov_spectrum,
)
from linkages.chaos.growth.invariants import Invariant
from linkages.chaos.growth.tangents import LinkageTangents
from linkages.chaos.growth.volumes import Volumes
from linkages.chaos.sections.common_period import NoPeriodError, common_period
from linkages.chaos.sections.contact_log import (
    ContactLog,
    check_interval,
    contact_values,
    contact_variables,
)
from linkages.chaos.sections.free_states import require_free
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import Interrupted, UnfinishedError
from linkages.kernel.system import System
from linkages.options.exponents import ExponentKeywords, ExponentOptions
from linkages.options.option import OptionError
from linkages.options.signature import takes
from linkages.solution.options import options_of

if TYPE_CHECKING:
    import xarray as xr

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
    looked = check_interval(system, run=asked)
    log = None if looked is None else ContactLog(looked)

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

    found = lyapunov_spectrum(
        tangents,
        intervals=periods * parts,
        interval=length / parts,
        count=columns,
        skip=skip * parts,
        certify=certify if columns == whole else None,
        watch=watch,
    )
    return replace(found, touch=tangents.slowest(begun))


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
