"""Regular or chaotic, for several radial clearances and initial conditions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import linkages
from linkages.chaos.findings import ChaosReport
from linkages.sweeps.running import Executor, Threads
from make.reproduction.reported import ANGLE, SIZE, press, speeds


@dataclass(frozen=True)
class Verdict:
    """Classification of one initial condition by `linkages.verdict`."""

    size: float  # clearance in m and α at t = 0 in degrees
    angle: float
    verdict: str  # periodic, quasi-periodic, chaotic or undecided
    exponent: float  # largest Lyapunov exponent in 1/s
    error: float
    growth: float  # of the 0–1 test
    period: int | None  # section points until the motion repeats; None if it does not
    curves: int  # closed curves on which section points lie; 0 for none
    # share of time in which the force in the clearance link has the wrong sign for contact
    lost: float
    motion: str  # of the link: libration, rotation or both

    def to_dict(self) -> dict[str, object]:
        return asdict(self)


def verdict(
    size: float,
    angle: float,
    periods: int,
    rtol: float | None = None,
    speed: float | None = None,
) -> Verdict:
    """Judge one motion over so many periods, and again at a tenth of the tolerance."""
    turning = {} if speed is None else speeds(speed)
    mechanism = press(changes={SIZE: size, ANGLE: f"{angle:g} deg", **turning})
    return _read(size, angle, linkages.verdict(mechanism, periods=periods, rtol=rtol))


def _read(size: float, angle: float, report: ChaosReport) -> Verdict:
    return Verdict(
        size=size,
        angle=angle,
        verdict=report.verdict,
        exponent=float(report.exponents["exponent"][0]),
        error=float(report.exponents["error"][0]),
        growth=report.zero_one["r1"][0],
        period=report.period,
        curves=0 if report.curves is None else report.curves.count,
        lost=report.contact[0].share_lost,
        motion=str(report.rotation["r1"].kind),
    )


def verdicts(
    points: Sequence[tuple[float, float]],
    periods: int,
    rtol: float | None = None,
    executor: Executor | None = None,
) -> list[Verdict]:
    """The same for many pairs of size and angle."""
    run = (executor or Threads()).run(lambda point: verdict(*point, periods, rtol), points)
    outcomes = sorted(run, key=lambda outcome: outcome.index)
    failed = [outcome.reason for outcome in outcomes if outcome.reason]
    if failed:
        raise linkages.LinkagesError(failed[0])
    return [outcome.value for outcome in outcomes]
