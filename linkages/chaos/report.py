"""One verdict on a motion, with its evidence: periodic, quasi-periodic, chaotic or undecided."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from linkages.chaos import evidence
from linkages.chaos.certificate import certified
from linkages.chaos.closed_curves import closed_curves
from linkages.chaos.contact import contact_of
from linkages.chaos.evidence import Run
from linkages.chaos.exponents import Exponents, UnfinishedExponentsError
from linkages.chaos.findings import ChaosReport
from linkages.chaos.free_states import require_free
from linkages.chaos.lyapunov import characteristic_period, labelled_exponents, run_exponents
from linkages.chaos.periods import find_period
from linkages.chaos.section import section_settings
from linkages.chaos.unfinished import UnfinishedError
from linkages.chaos.verdict import FEWEST_PERIODS, judged
from linkages.components.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted
from linkages.kernel.system import System
from linkages.solution.motion import Settings
from linkages.solution.solution import IncompleteError
from linkages.solvers.integrate import LEAST_RTOL
from linkages.solvers.methods import METHODS

if TYPE_CHECKING:
    import xarray as xr

TIGHTER = 0.1
"""Factor on the tolerance under which a verdict must not change."""


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
        If the motion cannot go on; an `UnfinishedError` has what there is of the exponents and the
        section.
    Interrupted
        After Ctrl-C, with the same.
    """
    system = System(mechanism)
    require_free(system)
    if periods < FEWEST_PERIODS:
        raise ValueError(f"a verdict needs at least {FEWEST_PERIODS} periods, found {periods}")
    settings = section_settings(mechanism, method, rtol)
    run = Run(system=system, periods=periods, skip=skip, settings=settings)
    kept: dict[str, xr.Dataset] = {}
    try:
        return _judge(run, watch, kept)
    except Interrupted as error:
        kept |= _of_last(run, error)
        raise Interrupted(str(error), time=error.time, kept=kept) from None
    except KeyboardInterrupt:
        raise Interrupted("interrupted between two computations", kept=kept) from None
    except ComputationError as error:
        kept |= _last(run, error)
        if not kept:
            raise
        raise UnfinishedError(str(error), kept, time=error.time) from None


def _judge(
    run: Run, watch: Callable[[float], None] | None, kept: dict[str, xr.Dataset]
) -> ChaosReport:
    """Gather evidence, put what is there into `kept`, and judge."""
    parts, tight = _Parts(watch, 3), tightened(run.settings)
    exponents = _exponents(run, None, run.settings, parts.of(0))
    kept["chaos_exponents"] = labelled_exponents(run.mechanism, exponents)
    section = kept["chaos_section"] = evidence.section_of(run)
    again = _exponents(run, 1, tight, parts.of(1))
    solution = evidence.followed(run, parts.of(2))
    points, angles = evidence.states_of(run.system, section)
    tests = evidence.zero_one_tests(run.system, points, angles)
    period = find_period(points, angles=angles).count if tests else None
    curves = closed_curves(points, angles=angles) if tests and period is None else None
    verdict, reasons = judged(exponents, tests, period, curves, len(points))
    tighter, _ = judged(again, tests, period, curves, len(points))
    how = _how(tight)
    if (tight.rtol, tight.step) == (run.settings.rtol, run.settings.step):
        reasons.append("No smaller error can be asked for, so nothing confirms this.")
        verdict = "undecided"
    elif tighter != verdict:
        reasons.append(
            f"At {how} the verdict would be {tighter!r}: it changes with the step size, so it is "
            "none."
        )
        verdict = "undecided"
    else:
        reasons.append(f"The verdict is the same at {how}.")
    verdict, reasons = certified(verdict, reasons, exponents.certificate)
    conservative = evidence.conservative(run.mechanism)
    if conservative:
        reasons.append(
            "Nothing dissipates: there is no attractor, and the verdict is about this initial "
            "state; others may move otherwise."
        )
    contact = contact_of(solution.data)
    reasons += [found.sentence for found in contact if found.sentence]
    return ChaosReport(
        name=run.mechanism.name,
        source=run.mechanism.source,
        verdict=verdict,
        reasons=tuple(reasons),
        conservative=conservative,
        exponents=kept["chaos_exponents"],
        zero_one=tests,
        spectra=evidence.spectra_of(run.system, solution),
        section=section,
        rotation=evidence.rotation_of(run.system, solution),
        dimension=evidence.dimension_of(points, angles),
        period=period,
        curves=curves,
        horizon=solution.horizon,
        contact=contact,
        tighter={
            "how": how,
            "verdict": tighter,
            "exponent": float(again.values[0]),
            "error": float(again.errors[0]),
        },
        run={
            "method": solution.motion.method,
            "how": _how(run.settings),
            "period": characteristic_period(run.mechanism),
            "periods": run.periods,
            "skip": run.skip,
        },
        force=solution.data.get("clearance_force"),
        notes=solution.notes,
        certificate=exponents.certificate,
    )


def tightened(settings: Settings) -> Settings:
    """Settings that make errors ten times smaller, as far as there are such."""
    if settings.step is None:
        atol = None if settings.atol is None else TIGHTER * settings.atol
        return replace(settings, rtol=max(TIGHTER * settings.rtol, LEAST_RTOL), atol=atol)
    return replace(settings, step=settings.step * TIGHTER ** (1 / METHODS[settings.method].order))


def _how(settings: Settings) -> str:
    return f"rtol {settings.rtol:g}" if settings.step is None else f"step {settings.step:.3g} s"


def _exponents(
    run: Run, count: int | None, settings: Settings, watch: Callable[[float], None] | None
) -> Exponents:
    return run_exponents(
        run.system, settings, periods=run.periods, skip=run.skip, count=count, watch=watch
    )


def _last(run: Run, error: ComputationError) -> dict[str, xr.Dataset]:
    """What the analysis that ended early leaves."""
    if isinstance(error, UnfinishedExponentsError) and len(error.exponents.values) > 1:
        return {"chaos_exponents": labelled_exponents(run.mechanism, error.exponents)}
    if isinstance(error, UnfinishedError):
        return {f"chaos_{name}": data for name, data in error.kept.items()}
    if isinstance(error, IncompleteError):
        return {"chaos_motion": error.solution.data}
    return {}


def _of_last(run: Run, error: Interrupted) -> dict[str, xr.Dataset]:
    """What the analysis that was interrupted leaves."""
    found = {}
    for name, result in error.kept.items():
        if not isinstance(result, Exponents):
            found[f"chaos_{name}"] = result
        elif len(result.values) > 1:
            found["chaos_exponents"] = labelled_exponents(run.mechanism, result)
    if error.solution is not None:
        found["chaos_motion"] = error.solution.data
    return found


class _Parts:
    """Progress of several computations of about equal length."""

    def __init__(self, watch: Callable[[float], None] | None, count: int) -> None:
        self._watch, self._count = watch, count

    def of(self, index: int) -> Callable[[float], None] | None:
        """Progress of one of them."""
        watch, count = self._watch, self._count
        return None if watch is None else lambda done: watch((index + done) / count)
