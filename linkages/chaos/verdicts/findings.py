"""A verdict on a motion with all that it rests on."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

from linkages.chaos.growth.invariants import Invariant
from linkages.chaos.sections.contact import LinkForce
from linkages.chaos.series.closed_curves import ClosedCurves
from linkages.chaos.series.dimension import CorrelationDimension
from linkages.chaos.series.phase_curves import PhaseCurve
from linkages.chaos.series.rotation import Rotation
from linkages.chaos.series.spectrum import PowerSpectrum
from linkages.solution.moving.horizon import Horizon

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
                    "kind": str(found.kind),
                    "rate": found.rate,
                    "error": found.rate_error,
                }
                for name, found in self.rotation.items()
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
