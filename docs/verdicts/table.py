"""The table of systems with known answers, as it is judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from verdicts.flows import FLOWS
from verdicts.known import Known
from verdicts.maps import MAPS
from verdicts.mechanisms import MECHANISMS

TOLERANCES = (1e-7, 1e-9)
SKIPS = (None, 0)
VERDICTS = ("at rest", "periodic", "quasi-periodic", "chaotic")


@dataclass(frozen=True)
class Case:
    """A system as it was judged once.

    Parameters
    ----------
    known
        What it is.
    skip, rtol
        How it was judged.
    verdict, period
        The answer; the period is None for all but periodic motions.
    """

    known: Known
    skip: int | None
    rtol: float
    verdict: str
    period: int | None

    @property
    def mark(self) -> str:
        """Right, undecided or wrong; a wrong period is wrong."""
        if self.verdict == "undecided":
            return "undecided"
        same = self.known.period in (None, self.period)
        return "right" if self.verdict == self.known.verdict and same else "wrong"


def systems() -> list[Known]:
    """All of them."""
    return [*MAPS, *FLOWS, *MECHANISMS]


def judged(known: Known, skip: int | None, rtol: float) -> Case:
    """One system, judged once."""
    return Case(known, skip, rtol, *known.judged(skip, rtol))


def listed(cases: Sequence[Case]) -> str:
    """A row for each system: how it is known, and how often it is judged right."""
    rows: dict[tuple[str, str, str, str], list[Case]] = {}
    for case in cases:
        known = case.known
        rows.setdefault((known.kind, known.name, known.expected, known.source), []).append(case)
    lines = [
        "| system | known as | source | skipped as found | nothing skipped |",
        "|---" * 5 + "|",
    ]
    for (_, name, expected, source), found in rows.items():
        marks = [
            " / ".join(_shown(case) for case in found if (case.skip is None) == (skip is None))
            for skip in SKIPS
        ]
        lines.append(f"| {name} | {expected} | {source} | {' | '.join(marks)} |")
    return "\n".join(lines) + "\n"


def _shown(case: Case) -> str:
    if case.mark == "wrong":
        return f"**wrong: {case.verdict} {case.period or ''}**"
    return case.mark


def confusion(cases: Sequence[Case]) -> str:
    """Known verdicts against those found, with shares."""
    heads = (*VERDICTS, "undecided")
    counts = Counter((case.known.verdict, case.verdict) for case in cases)
    lines = ["| known \\ found | " + " | ".join(heads) + " |", "|---" * 6 + "|"]
    for known in VERDICTS:
        cells = [str(counts[known, found] or "·") for found in heads]
        lines.append(f"| {known} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def shares(cases: Sequence[Case]) -> str:
    """How many are right, undecided and wrong, with and without skipping."""
    lines = ["| | judged | right | undecided | wrong |", "|---" * 5 + "|"]
    for skip, heading in ((None, "skipped as found"), (0, "nothing skipped")):
        some = [case for case in cases if case.skip == skip]
        marks = Counter(case.mark for case in some)
        cells = [
            f"{marks[m]} ({marks[m] / len(some):.0%})" for m in ("right", "undecided", "wrong")
        ]
        lines.append(f"| {heading} | {len(some)} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"
