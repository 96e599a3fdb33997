"""One verdict on a mechanism's motion, with its evidence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.certificate import certificate, certified
from linkages.chaos.growth.exponents import Exponents
from linkages.chaos.growth.lyapunov import labelled_exponents
from linkages.chaos.growth.systems import part_of
from linkages.chaos.growth.tangents import LinkageTangents
from linkages.chaos.sections.contact import contact_of, force_of
from linkages.chaos.sections.free_states import require_free
from linkages.chaos.verdicts import evidence as gathering
from linkages.chaos.verdicts.findings import ChaosReport
from linkages.chaos.verdicts.judge import Course, Judgement, judge
from linkages.chaos.verdicts.stretch import Evidence
from linkages.chaos.verdicts.verdict import FEWEST_PERIODS
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted, UnfinishedError
from linkages.kernel.system import System
from linkages.options.exponents import VerdictKeywords, VerdictOptions
from linkages.options.option import OptionError
from linkages.options.run import RunOptions
from linkages.options.signature import takes
from linkages.solution.moving.horizon import horizon_between
from linkages.solution.options import options_of
from linkages.solution.solution import Solution
from linkages.solvers.integration import LEAST_RTOL
from linkages.solvers.methods.named import METHODS

Floats = NDArray[np.float64]

if TYPE_CHECKING:
    import xarray as xr

TIGHTER = 0.1
"""Factor on the tolerance under which a verdict must not change."""


@takes(VerdictOptions)
def verdict(
    mechanism: Mechanism,
    *,
    watch: Callable[[float], None] | None = None,
    **options: Unpack[VerdictKeywords],
) -> ChaosReport:
    """Say whether a motion comes to rest, is periodic, quasi-periodic or chaotic.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    watch
        Called now and then with the fraction done.
    options
        As `VerdictOptions` describes them.

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
    asked = options_of(VerdictOptions, mechanism, options)
    if asked.periods < FEWEST_PERIODS:
        message = f"a verdict needs at least {FEWEST_PERIODS} periods, found {asked.periods}"
        raise OptionError("periods", message)
    system = System(mechanism)
    require_free(system)
    kept: dict[str, xr.Dataset] = {}
    try:
        return _report(system, asked, watch, kept)
    except (UnfinishedError, Interrupted) as error:
        raise type(error)(
            str(error), kept=_left(mechanism, error) | kept, time=error.time
        ) from None
    except KeyboardInterrupt:
        raise Interrupted("interrupted between two computations", kept=kept) from None
    except ComputationError as error:
        if not kept:
            raise
        raise UnfinishedError(str(error), kept, time=error.time) from None


def _report(
    system: System,
    options: VerdictOptions,
    watch: Callable[[float], None] | None,
    kept: dict[str, xr.Dataset],
) -> ChaosReport:
    """Judge, put what is there into `kept`, and look at the motion over time."""
    mechanism, tight = system.mechanism, tightened(options)
    periods = options.periods
    section = gathering.section_for(system, options, periods)
    conservative = gathering.conservative(mechanism)

    solutions: list[Solution] = []

    def keep(found: Evidence, end: LinkageTangents) -> None:
        kept["chaos_exponents"] = labelled_exponents(mechanism, found.exponents)
        kept["chaos_section"] = gathering.labelled_section(system, section, found)
        solutions.append(gathering.followed(end, options, periods))
        kept["chaos_motion"] = solutions[0].data

    def points(at: LinkageTangents, smaller: bool) -> tuple[Floats, Floats]:
        return section.points(system, at.here, tight if smaller else options, periods)

    course = Course(
        period=section.period,
        periods=periods,
        skip=options.skip,
        dissipative=not conservative,
        section=points if section.text else None,
        others=section.others,
        driven=partial(gathering.driven, mechanism),
        tolerance=gathering.alike(system, section.period, options),
        observed=len(system.topology.free),
        certified=_certified,
    )
    found = judge(
        LinkageTangents(
            system,
            system.layout.directions,
            options,
            parts=gathering.PER_PERIOD // course.parts,
        ),
        course,
        lambda start: start.starting(tight),
        watches=(part_of(watch, 0, 1, 2), part_of(watch, 1, 1, 2)),
        keep=keep,
    )
    (solution,) = solutions
    horizon = None
    if _smaller(tight, options):
        again = gathering.kept(found.end_again, periods)
        horizon = horizon_between(system, options, solution.motion, again)
    force = force_of(solution)
    contact = contact_of(solution, force)
    verdict, reasons = certified(
        *_confirmed(found, options, tight), found.evidence.exponents.certificate
    )
    if conservative:
        reasons.append(
            "Nothing dissipates: there is no attractor, and the verdict is about this initial "
            "state; others may move otherwise."
        )
    reasons += [one.sentence for one in contact if one.sentence]
    judged, exponents = found.evidence, found.again.exponents
    rotation = gathering.rotation_of(system, solution)
    names = system.topology.free
    return ChaosReport(
        name=mechanism.name,
        source=mechanism.file_name,
        verdict=verdict,
        reasons=tuple(reasons),
        conservative=conservative,
        exponents=kept["chaos_exponents"],
        power=judged.power,
        zero_one=dict(zip(names, judged.tests, strict=False)),
        spectra=gathering.spectra_of(system, solution),
        section=kept["chaos_section"],
        rotation=rotation,
        dimension=gathering.dimension_of(judged),
        period=judged.period,
        curves=judged.curves,
        horizon=horizon,
        contact=contact,
        tighter={
            "how": _how(tight),
            "verdict": found.verdict_again,
            "exponent": exponents.largest[0],
            "error": exponents.largest[1],
        },
        run={
            "method": solution.motion.method,
            "how": _how(options),
            "period": section.period,
            "other_periods": list(section.others),
            "periods": periods,
            "skip": found.skipped,
            "skipped": found.how_skipped,
        },
        force=force,
        notes=solution.notes,
        certificate=judged.exponents.certificate,
        rates=gathering.rates_of(system, solution, rotation),
        phases=judged.phases,
    )


def _certified(tangents: LinkageTangents, exponents: Exponents) -> Exponents:
    """Exponents with what is known of them along the motion of these tangents."""
    return replace(exponents, certificate=certificate(tangents, exponents, 0))


def _confirmed(
    found: Judgement[LinkageTangents], run: RunOptions, tight: RunOptions
) -> tuple[str, list[str]]:
    """The verdict if the run with a smaller error gives the same, and the reasons."""
    reasons = list(found.reasons)
    if not _smaller(tight, run):
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


def tightened(run: RunOptions) -> RunOptions:
    """Options that make errors ten times smaller, as far as there are such."""
    if run.step is None:
        atol = None if run.atol is None else TIGHTER * run.atol
        return replace(run, rtol=max(TIGHTER * run.rtol, LEAST_RTOL), atol=atol)
    return replace(run, step=run.step * TIGHTER ** (1 / METHODS[run.method].order))


def _smaller(tight: RunOptions, run: RunOptions) -> bool:
    """Whether errors are smaller with one than with the other."""
    return (tight.rtol, tight.step) != (run.rtol, run.step)


def _how(run: RunOptions) -> str:
    return f"rtol {run.rtol:g}" if run.step is None else f"step {run.step:.3g} s"


def _left(mechanism: Mechanism, error: UnfinishedError | Interrupted) -> dict[str, xr.Dataset]:
    """What the analysis leaves that ended early."""
    return {
        f"chaos_{name}": labelled_exponents(mechanism, result)
        if isinstance(result, Exponents)
        else result
        for name, result in error.kept.items()
    }
