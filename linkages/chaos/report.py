"""One verdict on a motion, with its evidence: periodic, quasi-periodic, chaotic or undecided."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.closed_curves import ClosedCurves, closed_curves
from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.contact import Contact, contact_check
from linkages.chaos.exponents import Exponents
from linkages.chaos.free_states import PAIRS, free_names, require_free
from linkages.chaos.indicators import Verdict, classify
from linkages.chaos.lyapunov import characteristic_period, exponents_of, labelled_exponents
from linkages.chaos.periods import find_period
from linkages.chaos.rotation import Rotation, classify_angle, refined
from linkages.chaos.section import poincare
from linkages.chaos.spectrum import PowerSpectrum, power_spectrum
from linkages.chaos.zero_one import zero_one
from linkages.components.mechanism import Mechanism
from linkages.kernel.system import System
from linkages.solution.horizon import Horizon
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

PER_PERIOD = 512
"""Samples of the motion within a period."""

TIGHTER = 0.1
"""Factor on the tolerance under which a verdict must not change."""

SIGNIFICANT = 4.0
"""Standard errors by which the largest exponent of a chaotic motion exceeds zero."""

REGULAR_GROWTH, CHAOTIC_GROWTH = 0.3, 0.6
"""Results of the 0–1 test that speak for regular and for chaotic motion."""

FEWEST_PERIODS = 200
"""The 0–1 test and the section need so many points."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ChaosReport:
    """A verdict and what it rests on.

    Parameters
    ----------
    name, source
        The mechanism.
    verdict
        ``"periodic"``, ``"quasi-periodic"``, ``"chaotic"`` or ``"undecided"``.
    reasons
        Sentences that lead to it.
    conservative
        Whether nothing dissipates: there is no attractor then, and the verdict is about this
        initial state.
    exponents
        As `linkages.lyapunov` returns them.
    zero_one
        Free coordinate → growth of the 0–1 test and its spread.
    spectra
        Free coordinate → power spectrum of its rate.
    section
        As `linkages.poincare` returns it.
    rotation
        Free angle → what it does.
    period
        Section points until the motion repeats; None if it does not.
    curves
        Whether section points lie on closed curves.
    horizon
        Until when the simulated motion has correct digits.
    contact
        Per clearance, whether pin and hole stay in contact.
    tighter
        ``rtol`` and ``verdict`` of the repetition with a tenfold tighter tolerance, and the
        largest ``exponent`` with its ``error``.
    force
        Clearance forces over time (time, clearance); None without clearances.
    """

    name: str
    source: str
    verdict: str
    reasons: tuple[str, ...]
    conservative: bool
    exponents: xr.Dataset
    zero_one: dict[str, tuple[float, float]]
    spectra: dict[str, PowerSpectrum]
    section: xr.Dataset
    rotation: dict[str, Rotation]
    period: int | None
    curves: ClosedCurves | None
    horizon: Horizon | None
    contact: tuple[Contact, ...]
    tighter: dict[str, Any]
    force: xr.DataArray | None = None
    notes: tuple[str, ...] = field(default=())

    def to_dict(self) -> dict[str, Any]:
        """As plain data for JSON."""
        exponents = self.exponents
        return {
            "mechanism": self.name,
            "source": self.source,
            "verdict": self.verdict,
            "reasons": list(self.reasons),
            "conservative": self.conservative,
            "exponents": [float(v) for v in exponents["exponent"]],
            "errors": [float(v) for v in exponents["error"]],
            "settled": bool(exponents.attrs["settled"]),
            "sum": exponents.attrs["sum"],
            "zero_one": {n: {"growth": k, "spread": s} for n, (k, s) in self.zero_one.items()},
            "lines": {
                name: {
                    "frequencies": [float(f) for f in spectrum.lines],
                    "share": spectrum.line_share,
                }
                for name, spectrum in self.spectra.items()
            },
            "rotation": {
                name: {"kind": str(found.kind), "rate": found.rate}
                for name, found in self.rotation.items()
            },
            "period": self.period,
            "closed_curves": None if self.curves is None else self.curves.count,
            "horizon": None
            if self.horizon is None
            else {"time": self.horizon.time, "whole": self.horizon.whole},
            "contact": [contact.to_dict() for contact in self.contact],
            "tighter": self.tighter,
            "notes": list(self.notes),
        }


def chaos(
    mechanism: Mechanism,
    *,
    periods: int = 300,
    skip: int = 0,
    method: str | None = None,
    rtol: float | None = None,
    watch: Callable[[float], None] | None = None,
) -> ChaosReport:
    """Say whether a motion is periodic, quasi-periodic or chaotic.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    periods
        Length of the motion in common periods of the drives (or in units of the file's end time,
        where there is none), at least 200.
    skip
        Periods before it is judged: a motion with friction needs them to find its attractor.
    method, rtol
        As `linkages.simulate` takes them; those of the file if not given.
    watch
        Called now and then with the fraction done.

    Raises
    ------
    InputError
        If nothing is free.
    ValueError
        For arguments that make no sense.
    ComputationError
        If the motion cannot go on.
    """
    system = System(mechanism)
    require_free(system)
    if periods < FEWEST_PERIODS:
        raise ValueError(f"a verdict needs at least {FEWEST_PERIODS} periods, found {periods}")
    tolerance = mechanism.simulation.rtol if rtol is None else rtol
    parts, tight = _Parts(watch, 3), max(TIGHTER * tolerance, 1e-14)
    exponents, again = (
        exponents_of(
            mechanism,
            periods=periods,
            skip=skip,
            count=count,
            method=method,
            rtol=wanted,
            watch=parts.of(part),
        )
        for part, (count, wanted) in enumerate([(None, tolerance), (1, tight)])
    )
    section = _section(mechanism, system, periods, skip, method, tolerance)
    solution = _followed(mechanism, system, periods, skip, method, tolerance, parts.of(2))
    points, angles = _points(system, section)
    names = system.topology.free
    tests = {name: _zero_one(points[:, i], bool(angles[i])) for i, name in enumerate(names)}
    period = find_period(points, angles=angles).count
    curves = closed_curves(points, angles=angles) if period is None else None
    verdict, reasons = _judged(exponents, tests, period, curves)
    tighter_verdict, _ = _judged(again, tests, period, curves)
    if tighter_verdict != verdict:
        reasons.append(
            f"At rtol {tight:g} the verdict would be {tighter_verdict!r}: it changes with the step "
            "size, so it is none."
        )
        verdict = "undecided"
    else:
        reasons.append(f"The verdict is the same at rtol {tight:g}.")
    conservative = _conservative(mechanism)
    if conservative:
        reasons.append(
            "Nothing dissipates: there is no attractor, and the verdict is about this initial "
            "state; others may move otherwise."
        )
    force = solution.data.get("clearance_force")
    return ChaosReport(
        name=mechanism.name,
        source=mechanism.source,
        verdict=verdict,
        reasons=tuple(reasons),
        conservative=conservative,
        exponents=labelled_exponents(mechanism, exponents),
        zero_one=tests,
        spectra=_spectra(system, solution),
        section=section,
        rotation=_rotation(system, solution),
        period=period,
        curves=curves,
        horizon=solution.horizon,
        contact=_contact(solution),
        tighter={
            "rtol": tight,
            "verdict": tighter_verdict,
            "exponent": float(again.values[0]),
            "error": float(again.errors[0]),
        },
        force=force,
        notes=solution.notes,
    )


class _Parts:
    """Progress of several computations of about equal length."""

    def __init__(self, watch: Callable[[float], None] | None, count: int) -> None:
        self._watch, self._count = watch, count

    def of(self, index: int) -> Callable[[float], None] | None:
        """Progress of one of them."""
        watch, count = self._watch, self._count
        return None if watch is None else lambda done: watch((index + done) / count)


def _section(
    mechanism: Mechanism,
    system: System,
    periods: int,
    skip: int,
    method: str | None,
    rtol: float,
) -> xr.Dataset:
    """Stroboscopic, or where the first free coordinate comes to rest."""
    try:
        common_period(mechanism)
    except NoPeriodError:
        dim, (name, *_) = next(iter(free_names(system).items()))
        rate = "velocity" if dim == "slider" else "speed"
        return poincare(
            mechanism, periods=periods, skip=skip, section=f"{name}.{rate}=0", method=method,
            rtol=rtol,
        )  # fmt: skip
    return poincare(mechanism, periods=periods, skip=skip, method=method, rtol=rtol)


def _followed(
    mechanism: Mechanism,
    system: System,
    periods: int,
    skip: int,
    method: str | None,
    rtol: float,
    watch: Callable[[float], None] | None,
) -> Solution:
    """The motion over time: free coordinates and clearance forces."""
    outputs = [output for dim in free_names(system) for output in PAIRS[dim]]
    if "clearance_angle" in outputs:
        outputs.append("clearance_force")
    whole = periods + skip
    return simulate(
        mechanism,
        end=whole * characteristic_period(mechanism),
        samples=whole * PER_PERIOD + 1,
        method=method,
        rtol=rtol,
        outputs=outputs,
        watch=watch,
    )


def _points(system: System, section: xr.Dataset) -> tuple[Floats, NDArray[np.bool_]]:
    """Free coordinates and rates at section points, shape (points, 2n), and which are angles."""
    columns, rates, angles = [], [], []
    for dim, names in free_names(system).items():
        value, rate = PAIRS[dim]
        for index in range(len(names)):
            columns.append(section[value].to_numpy()[:, index])
            rates.append(section[rate].to_numpy()[:, index])
            angles.append(dim != "slider")
    return np.array([*columns, *rates]).T, np.array([*angles, *[False] * len(rates)])


def _zero_one(series: Floats, angle: bool) -> tuple[float, float]:
    # Section points are not oversampled: every one counts.
    found = zero_one(np.cos(series) if angle else series, lag=1)
    return found.growth, found.spread


def _judged(
    exponents: Exponents,
    tests: dict[str, tuple[float, float]],
    period: int | None,
    curves: ClosedCurves | None,
) -> tuple[str, list[str]]:
    """A verdict and the sentences that lead to it."""
    value, error = float(exponents.values[0]), float(exponents.errors[0])
    growth = np.cumsum(exponents.growth[:, 0] * np.diff(exponents.times))
    law = classify(exponents.times[1:] - exponents.times[0], growth)
    tested = max(tests.values(), key=lambda found: found[0])[0]
    reasons = [
        f"The largest exponent is {value:.4g} ± {error:.2g} 1/s; tangents grow "
        + {
            Verdict.CHAOTIC: "in proportion to time, as along chaotic motions.",
            Verdict.REGULAR: "like a power of time, as along regular motions.",
            Verdict.UNDECIDED: "neither clearly like a power of time nor exponentially.",
        }[law],
        f"The 0–1 test gives {tested:.3f}.",
    ]
    if exponents.unsettled:
        reasons.append(exponents.unsettled)
    significant = value > SIGNIFICANT * error
    if law is Verdict.CHAOTIC and significant and tested > CHAOTIC_GROWTH:
        return "chaotic", reasons
    calm = law is Verdict.REGULAR or value < -SIGNIFICANT * error
    if calm and period is not None:
        reasons.append(f"The section repeats after {period} point{'s' if period > 1 else ''}.")
        return "periodic", reasons
    if calm and curves is not None and curves.count:
        number = "a closed curve" if curves.count == 1 else f"{curves.count} closed curves"
        reasons.append(f"Section points lie on {number}.")
        return "quasi-periodic", reasons
    if calm and tested < REGULAR_GROWTH:
        if curves is not None:
            reasons.append(f"Section points are not clearly on a curve: {curves.reason}")
        return "quasi-periodic", reasons
    reasons.append("The evidence does not agree; run more periods.")
    return "undecided", reasons


def _conservative(mechanism: Mechanism) -> bool:
    """Whether no load dissipates."""
    return all(
        damping is None or damping.absent
        for load in mechanism.loads
        for damping in (getattr(load, "damping", None),)
    )


def _spectra(system: System, solution: Solution) -> dict[str, PowerSpectrum]:
    interval = float(solution.data.time[1] - solution.data.time[0])
    found = {}
    for dim, names in free_names(system).items():
        rates = solution.data[PAIRS[dim][1]]
        for name in names:
            found[name] = power_spectrum(rates.sel({dim: name}).to_numpy(), interval)
    return found


def _rotation(system: System, solution: Solution) -> dict[str, Rotation]:
    found, time = {}, solution.data.time.to_numpy()
    for dim, names in free_names(system).items():
        if dim != "slider":
            values = solution.data[PAIRS[dim][0]]
            for name in names:
                found[name] = classify_angle(*refined(time, values.sel({dim: name}).to_numpy()))
    return found


def _contact(solution: Solution) -> tuple[Contact, ...]:
    data = solution.data
    if "clearance_force" not in data:
        return ()
    time = data.time.to_numpy()
    return tuple(
        contact_check(str(name), time, data.clearance_force.sel(clearance=name).to_numpy())
        for name in data.clearance.to_numpy()
    )
