"""One verdict on a mechanism's motion, with its evidence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.chaos import evidence as gathering
from linkages.chaos.certificate import certificate, certified
from linkages.chaos.contact import contact_of
from linkages.chaos.exponents import Exponents, UnfinishedExponentsError
from linkages.chaos.findings import ChaosReport
from linkages.chaos.free_states import require_free
from linkages.chaos.judge import Course, Judgement, judge
from linkages.chaos.lyapunov import labelled_exponents, samples_needed
from linkages.chaos.section import section_settings
from linkages.chaos.stretch import Evidence
from linkages.chaos.tangents import LinkageTangents
from linkages.chaos.unfinished import UnfinishedError
from linkages.chaos.verdict import FEWEST_PERIODS
from linkages.components.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted
from linkages.kernel.system import System
from linkages.solution.arguments import whole_number
from linkages.solution.motion import Settings
from linkages.solution.solution import IncompleteError
from linkages.solvers.integrate import LEAST_RTOL
from linkages.solvers.methods import METHODS

Floats = NDArray[np.float64]

if TYPE_CHECKING:
    import xarray as xr

TIGHTER = 0.1
"""Factor on the tolerance under which a verdict must not change."""


def chaos(
    mechanism: Mechanism,
    *,
    periods: int = 300,
    skip: int | None = None,
    method: str | None = None,
    rtol: float | None = None,
    watch: Callable[[float], None] | None = None,
) -> ChaosReport:
    """Say whether a motion comes to rest, is periodic, quasi-periodic or chaotic.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    periods
        Length of the stretch that is judged, at least 200: in common periods of the drives or,
        where there is none, in mean returns to a section where the motion comes back.
    skip
        Periods before it is judged. If not given, the transient of a motion with friction is
        skipped as far as it is found; without friction there is none.
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
    periods = whole_number("periods", periods)
    skip = None if skip is None else whole_number("skip", skip)
    system = System(mechanism)
    require_free(system)
    if periods < FEWEST_PERIODS:
        raise ValueError(f"a verdict needs at least {FEWEST_PERIODS} periods, found {periods}")
    if skip is not None and skip < 0:
        raise ValueError(f"expected skip >= 0, found {skip}")
    settings = section_settings(mechanism, method, rtol)
    kept: dict[str, xr.Dataset] = {}
    try:
        return _report(system, settings, periods, skip, watch, kept)
    except Interrupted as error:
        kept = _of_last(mechanism, error) | kept
        raise Interrupted(str(error), time=error.time, kept=kept) from None
    except KeyboardInterrupt:
        raise Interrupted("interrupted between two computations", kept=kept) from None
    except ComputationError as error:
        kept = _last(mechanism, error) | kept
        if not kept:
            raise
        raise UnfinishedError(str(error), kept, time=error.time) from None


def _report(
    system: System,
    settings: Settings,
    periods: int,
    skip: int | None,
    watch: Callable[[float], None] | None,
    kept: dict[str, xr.Dataset],
) -> ChaosReport:
    """Judge, put what is there into `kept`, and look at the motion over time."""
    mechanism, tight, parts = system.mechanism, tightened(settings), _Parts(watch, 3)
    section = gathering.section_for(system, settings, periods)
    conservative = gathering.conservative(mechanism)

    def keep(found: Evidence) -> None:
        kept["chaos_exponents"] = labelled_exponents(mechanism, found.exponents)
        kept["chaos_section"] = gathering.labelled_section(system, section, found)

    def points(at: LinkageTangents, smaller: bool) -> tuple[Floats, Floats]:
        return section.points(at.here, tight if smaller else settings, periods)

    course = Course(
        period=section.period,
        periods=periods,
        skip=skip,
        dissipative=not conservative,
        section=points if section.text else None,
        tolerance=gathering.alike(system, section.period, settings.rtol),
        observed=len(system.topology.free),
        certified=_certified,
    )
    samples = samples_needed(system, periods * course.parts)
    found = judge(
        _tangents(system, settings, samples),
        course,
        lambda start: _tangents(start.here, tight),
        watches=(parts.of(0), parts.of(1)),
        keep=keep,
    )
    solution = gathering.followed(found.start.here, settings, section.period, periods, parts.of(2))
    contact = contact_of(solution.data)
    verdict, reasons = certified(
        *_confirmed(found, settings, tight), found.evidence.exponents.certificate
    )
    if conservative:
        reasons.append(
            "Nothing dissipates: there is no attractor, and the verdict is about this initial "
            "state; others may move otherwise."
        )
    reasons += [one.sentence for one in contact if one.sentence]
    judged, exponents = found.evidence, found.again.exponents
    names = system.topology.free
    return ChaosReport(
        name=mechanism.name,
        source=mechanism.source,
        verdict=verdict,
        reasons=tuple(reasons),
        conservative=conservative,
        exponents=kept["chaos_exponents"],
        zero_one=dict(zip(names, judged.tests, strict=False)),
        spectra=gathering.spectra_of(system, solution),
        section=kept["chaos_section"],
        rotation=gathering.rotation_of(system, solution),
        dimension=gathering.dimension_of(judged),
        period=judged.period,
        curves=judged.curves,
        horizon=solution.horizon,
        contact=contact,
        tighter={
            "how": _how(tight),
            "verdict": found.verdict_again,
            "exponent": float(exponents.values[0]),
            "error": float(exponents.errors[0]),
        },
        run={
            "method": solution.motion.method,
            "how": _how(settings),
            "period": section.period,
            "periods": periods,
            "skip": found.skipped,
            "skipped": found.how_skipped,
        },
        force=solution.data.get("clearance_force"),
        notes=solution.notes,
        certificate=judged.exponents.certificate,
    )


def _tangents(system: System, settings: Settings, samples: int = 0) -> LinkageTangents:
    """A system with a whole set of tangents, which keeps so many samples of each advance."""
    return LinkageTangents(
        system,
        2 * len(system.topology.free),
        settings.method,
        settings.rtol,
        settings.atol,
        settings.step,
        settings.max_steps,
        samples,
    )


def _certified(tangents: LinkageTangents, exponents: Exponents) -> Exponents:
    """Exponents with what is known of them along the motion of these tangents."""
    return replace(exponents, certificate=certificate(tangents, exponents, 0))


def _confirmed(
    found: Judgement[LinkageTangents], settings: Settings, tight: Settings
) -> tuple[str, list[str]]:
    """The verdict if the run with a smaller error gives the same, and the reasons."""
    reasons = list(found.reasons)
    if (tight.rtol, tight.step) == (settings.rtol, settings.step):
        return "undecided", [
            *reasons, "No smaller error can be asked for, so nothing confirms this."
        ]  # fmt: skip
    if found.verdict_again == found.verdict:
        return found.verdict, [*reasons, f"The verdict is the same at {_how(tight)}."]
    return "undecided", [
        *reasons,
        f"At {_how(tight)} the verdict would be {found.verdict_again!r}: it changes with the step "
        "size, so it is none.",
    ]


def tightened(settings: Settings) -> Settings:
    """Settings that make errors ten times smaller, as far as there are such."""
    if settings.step is None:
        atol = None if settings.atol is None else TIGHTER * settings.atol
        return replace(settings, rtol=max(TIGHTER * settings.rtol, LEAST_RTOL), atol=atol)
    return replace(settings, step=settings.step * TIGHTER ** (1 / METHODS[settings.method].order))


def _how(settings: Settings) -> str:
    return f"rtol {settings.rtol:g}" if settings.step is None else f"step {settings.step:.3g} s"


def _last(mechanism: Mechanism, error: ComputationError) -> dict[str, xr.Dataset]:
    """What the analysis that ended early leaves."""
    if isinstance(error, UnfinishedExponentsError):
        return {"chaos_exponents": labelled_exponents(mechanism, error.exponents)}
    if isinstance(error, UnfinishedError):
        return {f"chaos_{name}": data for name, data in error.kept.items()}
    if isinstance(error, IncompleteError):
        return {"chaos_motion": error.solution.data}
    return {}


def _of_last(mechanism: Mechanism, error: Interrupted) -> dict[str, xr.Dataset]:
    """What the analysis that was interrupted leaves."""
    found = {}
    for name, result in error.kept.items():
        if not isinstance(result, Exponents):
            found[f"chaos_{name}"] = result
        else:
            found["chaos_exponents"] = labelled_exponents(mechanism, result)
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
