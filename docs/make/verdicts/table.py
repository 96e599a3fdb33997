"""The table of systems with known answers, as it is judged."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from linkages.reading.wording import to_error
from make.verdicts.flows import FLOWS
from make.verdicts.friction import FRICTION
from make.verdicts.impacts import IMPACTS
from make.verdicts.internal import INTERNAL
from make.verdicts.known import Answer, Known
from make.verdicts.maps import MAPS
from make.verdicts.mechanisms import MECHANISMS
from make.verdicts.resting import RESTING
from make.verdicts.scales import SCALES
from make.verdicts.two_periods import TWO_PERIODS

CLASSES = {
    "maps": MAPS,
    "flows": FLOWS,
    "mechanisms": MECHANISMS,
    "impacts and stops": IMPACTS,
    "dry friction": FRICTION,
    "internal states": INTERNAL,
    "rest beside motion": RESTING,
    "two periods": TWO_PERIODS,
    "small beside large": SCALES,
}
"""Systems by what is hard about them."""

TOLERANCES = (1e-7, 1e-9)
SKIPS = (None, 0)
VERDICTS = ("at rest", "periodic", "quasi-periodic", "chaotic")

SIGNIFICANT = 4.0
"""Standard errors by which an exponent may differ from a known one."""

PRECISION, ROUND_OFF = 1e-3, 1e-9
"""Part of the largest exponent by which any may differ, as docs/chaos.md has it, and more in 1/s.
"""


@dataclass(frozen=True)
class Case:
    """A system as it was judged once.

    Parameters
    ----------
    known
        What it is.
    skip, rtol
        How it was judged.
    answer
        What was found.
    """

    known: Known
    skip: int | None
    rtol: float
    answer: Answer

    @property
    def mark(self) -> str:
        """Right, undecided or wrong; a wrong period is wrong."""
        if self.answer.verdict == "undecided":
            return "undecided"
        same = self.known.period in (None, self.answer.period)
        return "right" if self.answer.verdict == self.known.verdict and same else "wrong"

    @property
    def measured(self) -> bool | None:
        """Whether exponents agree with known ones within their errors.

        None if none are known, and for those that a transient may be part of.
        """
        known, found = self.known.exponents, self.answer.exponents
        if known is None or (self.skip is not None and self.known.dissipative):
            return None
        if list(map(math.isinf, known)) != list(map(math.isinf, found)):
            return False
        finite = [abs(one) for one in known if math.isfinite(one)]
        within = self.known.within + PRECISION * max(finite, default=0.0) + ROUND_OFF
        return all(
            abs(one - other) <= SIGNIFICANT * error + within
            for one, other, error in zip(known, found, self.answer.errors, strict=True)
            if math.isfinite(one)
        )


def systems() -> list[Known]:
    """All of them."""
    return [known for some in CLASSES.values() for known in some]


def judged(known: Known, skip: int | None, rtol: float) -> Case:
    """One system, judged once."""
    return Case(known, skip, rtol, known.judged(skip, rtol))


def listed(cases: Sequence[Case]) -> str:
    """A row for each system: how it is known, and how often it is judged right."""
    rows: dict[tuple[str, str, str], list[Case]] = {}
    for case in cases:
        known = case.known
        rows.setdefault((known.name, known.expected, known.source), []).append(case)
    lines = [
        "| system | known as | source | skipped as found | nothing skipped |",
        "|---" * 5 + "|",
    ]
    for (name, expected, source), found in rows.items():
        marks = [
            " / ".join(_shown(case) for case in found if (case.skip is None) == (skip is None))
            for skip in SKIPS
        ]
        lines.append(f"| {name} | {expected} | {source} | {' | '.join(marks)} |")
    return "\n".join(lines) + "\n"


def _shown(case: Case) -> str:
    if case.mark == "wrong":
        return f"**wrong: {case.answer.verdict} {case.answer.period or ''}**"
    return case.mark


def confusion(cases: Sequence[Case]) -> str:
    """Known verdicts against those found, with shares."""
    heads = (*VERDICTS, "undecided")
    counts = Counter((case.known.verdict, case.answer.verdict) for case in cases)
    lines = ["| known \\ found | " + " | ".join(heads) + " |", "|---" * 6 + "|"]
    for known in VERDICTS:
        cells = [str(counts[known, found] or "·") for found in heads]
        lines.append(f"| {known} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def shares(cases: Sequence[Case]) -> str:
    """How many are right, undecided and wrong, with and without skipping."""
    rows = {
        heading: [case for case in cases if case.skip == skip]
        for skip, heading in ((None, "skipped as found"), (0, "nothing skipped"))
    }
    return _counted("", rows)


def by_class(cases: Sequence[Case]) -> str:
    """The same for each class of systems."""
    rows = {
        heading: [case for case in cases if case.known in some] for heading, some in CLASSES.items()
    }
    return _counted("class", rows)


def _counted(head: str, rows: dict[str, list[Case]]) -> str:
    lines = [f"| {head} | judged | right | undecided | wrong |", "|---" * 5 + "|"]
    for heading, some in rows.items():
        if not some:
            continue
        marks = Counter(case.mark for case in some)
        cells = [
            f"{marks[m]} ({marks[m] / len(some):.0%})" for m in ("right", "undecided", "wrong")
        ]
        lines.append(f"| {heading} | {len(some)} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def exponents(cases: Sequence[Case]) -> str:
    """Known Lyapunov exponents beside those found."""
    lines = ["| system | known (1/s) | found (1/s) |", "|---" * 3 + "|"]
    for case in cases:
        known, answer = case.known, case.answer
        if known.exponents is None:
            continue
        found = list(map(_number, answer.exponents, answer.errors))
        differs = "" if case.measured else "**differs:** "
        lines.append(
            f"| {known.name} | {', '.join(map(_number, known.exponents))} | "
            f"{differs}{', '.join(found)} |"
        )
    return "\n".join(lines) + "\n"


def _number(value: float, error: float = 0.0) -> str:
    """A number, with its error if it has one; what is round-off is 0."""
    if math.isinf(value):
        return "−∞"
    if abs(value) + error < ROUND_OFF:
        return "0"
    text = " ± ".join(to_error(value, error)) if error else f"{value:.4g}"
    return text.replace("-", "−")
