"""A verdict on a mechanism's motion, with its evidence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos import evidence as gathering
from linkages.chaos.contact_log import LinkForce, contact_of, force_of
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.exponents import Exponents, Invariant, part_of
from linkages.chaos.free_states import require_free
from linkages.chaos.indicators import CorrelationDimension, PowerSpectrum
from linkages.chaos.judge import FEWEST_PERIODS, Course, Judgement, judge
from linkages.chaos.lyapunov import certificate, certified, labelled_exponents
from linkages.chaos.periods import Rotation
from linkages.chaos.stretch import Evidence
from linkages.chaos.tori import ClosedCurves, PhaseCurve
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted, UnfinishedError
from linkages.kernel.system import System
from linkages.options.analysis_options import VerdictKeywords, VerdictOptions
from linkages.options.option import OptionError, takes
from linkages.options.run import RunOptions
from linkages.solution.run_options import options_of
from linkages.solution.solution import Horizon, Solution, horizon_between
from linkages.solvers.integration import LEAST_RTOL, METHODS

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False, repr=False)
class ChaosReport:
    """A verdict and what it rests on.

    Parameters
    ----------
    name, source
        The mechanism.
    verdict
        ``"at rest"``, ``"periodic"``, ``"quasi-periodic"``, ``"chaotic"`` or ``"undecided"``.
    reasons
        Sentences that lead to it.
    conservative
        Whether nothing dissipates: there is no attractor then, and the verdict is about this
        initial state.
    exponents
        As `linkages.lyapunov` returns them.
    power
        Of time, with which tangents grew while time last doubled; −∞ if contacts left none.
    zero_one
        Free coordinate → growth of the 0–1 test and its spread.
    spectra
        Free coordinate → power spectrum of its rate.
    section
        As `linkages.poincare` returns it.
    rotation
        Free angle → what it does.
    dimension
        Correlation dimension of the section (of the motion, less one); None for fewer than 500
        points.
    period
        Section points until the motion repeats at the end; None if it does not.
    curves
        Whether section points lie on closed curves.
    horizon
        Until when the simulated motion has correct digits.
    contact
        Per clearance, whether journal and bearing stay in contact.
    tighter
        ``how`` and ``verdict`` of the repetition with a tenth of the error, and the largest
        ``exponent`` with its ``error``.
    run
        How it was computed: ``method``, ``how`` accurately, ``period`` in seconds, ``periods``,
        ``skip``: those before, and ``skipped``: why so many.
    force
        Clearance forces over time (time, clearance); None without clearances.
    certificate
        What is known of the exponents otherwise, and whether it holds.
    rates
        Free coordinate → its mean rate, and the unit of that.
    phases
        How section points depend on the phase of each drive that has no period in common with the
        section.
    """

    name: str
    source: str
    verdict: str
    reasons: tuple[str, ...]
    conservative: bool
    exponents: xr.Dataset
    power: float
    zero_one: dict[str, tuple[float, float]]
    spectra: dict[str, PowerSpectrum]
    section: xr.Dataset
    rotation: dict[str, Rotation]
    dimension: CorrelationDimension | None
    period: int | None
    curves: ClosedCurves | None
    horizon: Horizon | None
    contact: tuple[LinkForce, ...]
    tighter: dict[str, Any]
    run: dict[str, Any]
    force: xr.DataArray | None = None
    notes: tuple[str, ...] = field(default=())
    certificate: tuple[Invariant, ...] = ()
    rates: dict[str, tuple[float, str]] = field(default_factory=dict)
    phases: tuple[PhaseCurve, ...] = ()

    def __repr__(self) -> str:
        return f"ChaosReport({self.name!r}: {self.verdict})"

    def _repr_html_(self) -> str:
        """What notebooks show: the verdict and its reasons."""
        reasons = "".join(f"<li>{escape(reason)}</li>" for reason in self.reasons)
        return f"<h4>{escape(self.name)}: {escape(self.verdict)}</h4>\n<ul>{reasons}</ul>"

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
            "lost": int(exponents.attrs["lost"]),
            "power": self.power,
            "certificate": [invariant.to_dict() for invariant in self.certificate],
            "zero_one": {n: {"growth": k, "spread": s} for n, (k, s) in self.zero_one.items()},
            "lines": {
                name: {
                    "frequencies": [float(f) for f in spectrum.lines],
                    "share": spectrum.line_share,
                }
                for name, spectrum in self.spectra.items()
            },
            "rotation": {
                name: {
                    "kind": str(item.kind),
                    "rate": item.rate,
                    "error": item.rate_error,
                }
                for name, item in self.rotation.items()
            },
            "mean_rates": {n: {"value": v, "units": u} for n, (v, u) in self.rates.items()},
            "dimension": None
            if self.dimension is None
            else {
                "value": self.dimension.value,
                "error": self.dimension.error,
                "doubt": self.dimension.doubt or None,
            },
            "period": self.period,
            "phases": [asdict(curve) for curve in self.phases],
            "closed_curves": None if self.curves is None else self.curves.count,
            "horizon": None
            if self.horizon is None
            else {"time": self.horizon.time, "whole": self.horizon.whole},
            "contact": [asdict(contact) for contact in self.contact],
            "tighter": self.tighter,
            "run": self.run,
            "notes": list(self.notes),
        }


Floats = NDArray[np.float64]


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
    result = judge(
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
        again = gathering.kept(result.end_again, periods)
        horizon = horizon_between(system, options, solution.motion, again)
    force = force_of(solution)
    contact = contact_of(solution)
    verdict, reasons = certified(
        *_confirmed(result, options, tight), result.evidence.exponents.certificate
    )
    if conservative:
        reasons.append(
            "Nothing dissipates: there is no attractor, and the verdict is about this initial "
            "state; others may move otherwise."
        )
    reasons += [one.sentence for one in contact if one.sentence]
    judged, exponents = result.evidence, result.again.exponents
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
            "verdict": result.verdict_again,
            "exponent": exponents.largest[0],
            "error": exponents.largest[1],
        },
        run={
            "method": solution.motion.method,
            "how": _how(options),
            "period": section.period,
            "other_periods": list(section.others),
            "periods": periods,
            "skip": result.skipped,
            "skipped": result.how_skipped,
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
        f"chaos_{name}": labelled_exponents(mechanism, item)
        if isinstance(item, Exponents)
        else item
        for name, item in error.kept.items()
    }
