"""The paper's qualitative claims, each judged from measured evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from make.reproduction.maxima import Maxima
from make.reproduction.spreads import PowerLaw
from make.reproduction.verdicts import Verdict


class Grade(StrEnum):
    """How a claim fares."""

    HOLDS = "holds"
    SOMETIMES = "holds for some initial conditions"
    FAILS = "does not hold"


@dataclass(frozen=True)
class Judgement:
    """A claim of the paper, by its letter on the page."""

    letter: str
    claim: str
    grade: Grade
    evidence: str


ALMOST_ALL = 0.95
"""Share of initial conditions from which on a claim holds; it fails up to the rest of it."""

UNAFFECTED, STRONG = 0.01, 0.1
"""Shares of the ideal mechanism's values: a deviation below the first is nearly none, one above the
second is strong."""

OFTEN = 20
"""A torque oscillates if it has so many times the extrema of that of the ideal mechanism."""

SMALLEST = 5e-5
"""Clearances up to this size, in m, are small ones: 0.05 mm is the least of the paper's Fig. 12."""


GROWN = 1.2
"""Ratio of spreads from which on the spread has grown: they scatter by a tenth."""


def graded(share: float) -> Grade:
    """Grade by the share of initial conditions for which a claim is true."""
    if share >= ALMOST_ALL:
        return Grade.HOLDS
    return Grade.SOMETIMES if share > 1 - ALMOST_ALL else Grade.FAILS


def percent(share: float) -> str:
    """A share, with a decimal where it is not a plain one."""
    return f"{100 * share:.3g} %"


def of_maxima(found: Maxima) -> list[Judgement]:
    """(a) and (b), from the scan of all initial conditions."""
    slight, strong = found.position < UNAFFECTED, found.acceleration > STRONG
    oscillating = (found.turns > OFTEN) & (found.torque > STRONG)
    return [
        Judgement(
            "a",
            "The position of the slider is nearly unaffected, its acceleration strongly",
            graded(float((slight & strong).mean())),
            f"Over {len(slight)} initial conditions the maximum position error is at most "
            f"{percent(found.position.max())} of the stroke. The maximum acceleration error is "
            f"{found.acceleration.min():.2g} to {found.acceleration.max():.3g} times the largest "
            f"ideal acceleration, and above {percent(STRONG)} of it for {percent(strong.mean())} "
            "of initial conditions.",
        ),
        Judgement(
            "b",
            "The driving torques oscillate",
            graded(float(oscillating.mean())),
            f"For every initial condition the torque of crank 1 has at least "
            f"{found.turns.min():.0f} times as many extrema as without clearance; for "
            f"{percent((found.torque > STRONG).mean())} it deviates from the ideal torque by more "
            f"than {percent(STRONG)} of the peak.",
        ),
    ]


def _share(rows: Sequence[Verdict], true: Sequence[bool]) -> tuple[float, str]:
    return float(np.mean(true)), f"{sum(true)} of {len(rows)} motions"


def of_verdicts(rows: Sequence[Verdict]) -> list[Judgement]:
    """(c), (d), (e) and (h), from verdicts over radial clearances and initial conditions."""
    open_share, open_words = _share(rows, [row.period is None for row in rows])
    scattered, scattered_words = _share(rows, [row.verdict == "chaotic" for row in rows])
    small = [row for row in rows if row.size <= SMALLEST]
    little, little_words = _share(small, [row.verdict == "chaotic" for row in small])
    everywhere = [
        any(row.verdict == "chaotic" for row in rows if row.size == size)
        for size in sorted({row.size for row in rows})
    ]
    curved = sum(row.curves > 0 and row.verdict != "chaotic" for row in rows)
    regular = sum(row.verdict in ("periodic", "quasi-periodic") for row in rows)
    undecided = len(rows) - regular - sum(row.verdict == "chaotic" for row in rows)
    return [
        Judgement(
            "c",
            "The phase diagram is not closed",
            graded(open_share),
            f"{open_words} do not repeat over the computed time. That is no evidence of chaos: "
            "a quasi-periodic motion does not repeat either.",
        ),
        Judgement(
            "d",
            "The points of the section are scattered",
            graded(scattered),
            f"{scattered_words} are chaotic, {regular} quasi-periodic, {undecided} undecided. For "
            f"{curved} of those not chaotic, the section points lie on closed curves.",
        ),
        Judgement(
            "e",
            "Chaos for every clearance from 0.01 to 0.5 mm",
            graded(scattered) if all(everywhere) else Grade.FAILS,
            f"Of {len(everywhere)} radial clearances, {sum(everywhere)} have chaotic and "
            f"{_sizes_with_regular(rows)} have regular motions: the initial condition decides.",
        ),
        Judgement(
            "h",
            "Even a small clearance leads to chaos",
            graded(little),
            f"Up to {1e3 * SMALLEST:g} mm, {little_words} are chaotic.",
        ),
    ]


def _sizes_with_regular(rows: Sequence[Verdict]) -> int:
    return len({row.size for row in rows if row.verdict in ("periodic", "quasi-periodic")})


def of_sizes(losses: Sequence[float], together: PowerLaw) -> list[Judgement]:
    """(f), from each initial condition's loss in spread over the clearance, and a power law."""
    shrunk = [loss > GROWN for loss in losses]
    met = "as expected (−1/2)" if together.agrees(-0.5) else "not −1/2 as expected"
    return [
        Judgement(
            "f",
            "The spread of α̇ falls as the clearance grows",
            graded(float(np.mean(shrunk))),
            f"It falls for {sum(shrunk)} of {len(losses)} initial conditions, in the mean as r to "
            f"the power {together}, {met}.",
        )
    ]


def of_speeds(gains: Sequence[float], slow: PowerLaw, fast: PowerLaw) -> list[Judgement]:
    """(g), from each initial condition's gain in spread over the speed, and two power laws."""
    grown = [gain > GROWN for gain in gains]
    flat = "as expected (0)" if slow.agrees(0.0) else "not 0 as expected"
    linear = "as expected (+1)" if fast.agrees(1.0) else "towards the expected +1"
    return [
        Judgement(
            "g",
            "The spread of α̇ grows with speed",
            graded(float(np.mean(grown))),
            f"Between both ends of the paper's range it grows by more than {percent(GROWN - 1)} "
            f"for {sum(grown)} of {len(gains)} initial conditions. Where weight makes up the joint "
            f"force it goes as ω to the power {slow}, {flat}; where inertia does, to the power "
            f"{fast}, {linear}.",
        )
    ]


def read_verdicts(rows: Sequence[Mapping[str, Any]]) -> list[Verdict]:
    """Verdicts that were kept as plain data."""
    return [Verdict(**row) for row in rows]
