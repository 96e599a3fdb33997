"""Systems with known answers, judged with and without skipping and at two tolerances; tables."""

from __future__ import annotations

import json
import math
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

from linkages.reading.wording import to_error
from make.registry import PAGES, STATIC, kept, makes, makes_each, table
from make.verdicts.flows import FLOWS
from make.verdicts.friction import FRICTION
from make.verdicts.impacts import IMPACTS
from make.verdicts.internal import INTERNAL
from make.verdicts.known import LOST, Answer, Known
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

KEPT = "verdicts.json"
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
    """A system as it was judged once."""

    known: Known  # what it is
    skip: int | None  # how it was judged
    rtol: float
    answer: Answer  # what was found

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


Task = tuple[int, int | None, float]
"""Number of a system, periods that are skipped, and tolerance."""


def tasks(some: Sequence[Known]) -> list[Task]:
    """What is judged of some systems; where nothing dissipates both ways to skip are one."""
    return [
        (index, skip, rtol)
        for index, known in enumerate(systems())
        if known in some
        for skip in SKIPS
        for rtol in TOLERANCES
        if known.dissipative or skip is None
    ]


def found(task: Task) -> Answer:
    """The answer of one judgement; systems themselves do not go from process to process."""
    index, skip, rtol = task
    case = judged(systems()[index], skip, rtol)
    print(f"{case.mark}|{case.measured}|{case.known.name}|{skip}|{rtol:g}|{case.answer}")
    return case.answer


def answers_of(rows: list[dict[str, Any]]) -> dict[Task, Answer]:
    """Answers that are kept, of systems that are still in the table."""
    index = {known.name: position for position, known in enumerate(systems())}
    return {
        (index[row["system"]], row["skip"], row["rtol"]): Answer(
            row["verdict"],
            row["period"],
            tuple(LOST if one is None else one for one in row["exponents"]),
            tuple(row["errors"]),
        )
        for row in rows
        if row["system"] in index
    }


def cases_of(answers: dict[Task, Answer]) -> list[Case]:
    """All systems whose answers are complete."""
    missing = {task[0] for task in tasks(systems()) if task not in answers}
    return [
        Case(known, skip, rtol, answers[index, skip if known.dissipative else None, rtol])
        for index, known in enumerate(systems())
        if index not in missing
        for skip in SKIPS
        for rtol in TOLERANCES
    ]


@makes_each({(f"verdicts-{heading.replace(' ', '-')}",): (heading,) for heading in CLASSES})
def of_class(heading: str) -> str:
    """Judge the systems of a class, keep what is found, and list it."""
    some = CLASSES[heading]
    with get_context("spawn").Pool(os.cpu_count()) as pool:
        answers = dict(zip(tasks(some), pool.map(found, tasks(some), chunksize=1), strict=True))
    with PAGES:
        cases = cases_of(answers_of(kept(KEPT)) | answers)
        lines = ",\n".join(json.dumps(plain(case), ensure_ascii=False) for case in cases)
        (STATIC / KEPT).write_text(f"[\n{lines}\n]\n", encoding="utf-8")
    return listed([case for case in cases if case.known in some])


def plain(case: Case) -> dict[str, object]:
    """A case as it is kept."""
    return {
        "system": case.known.name,
        "known": case.known.expected,
        "skip": case.skip,
        "rtol": case.rtol,
        "verdict": case.answer.verdict,
        "period": case.answer.period,
        "exponents": [one if math.isfinite(one) else None for one in case.answer.exponents],
        "errors": case.answer.errors,
        "mark": case.mark,
        "measured": case.measured,
    }


@makes(
    "verdicts-shares", "verdicts-by-class", "verdicts-confusion", "verdicts-exponents", numbers=KEPT
)
def summaries(rows: list[dict[str, Any]]) -> tuple[str, ...]:
    """What is kept of all classes, in total."""
    cases = cases_of(answers_of(rows))
    tight = [case for case in cases if (case.skip, case.rtol) == (None, TOLERANCES[-1])]
    return shares(cases), by_class(cases), confusion(cases), exponents(tight)


def listed(cases: Sequence[Case]) -> str:
    """A row for each system: how it is known, and how often it is judged right."""
    rows: dict[tuple[str, str, str], list[Case]] = {}
    for case in cases:
        known = case.known
        rows.setdefault((known.name, known.expected, known.source), []).append(case)
    lines = []
    for (name, expected, source), found in rows.items():
        marks = [
            " / ".join(_shown(case) for case in found if (case.skip is None) == (skip is None))
            for skip in SKIPS
        ]
        lines.append((name, expected, source, *marks))
    heads = "system", "known as", "source", "skipped as found", "nothing skipped"
    return table(heads, lines, 5)


def _shown(case: Case) -> str:
    if case.mark == "wrong":
        return f"**wrong: {case.answer.verdict} {case.answer.period or ''}**"
    return case.mark


def confusion(cases: Sequence[Case]) -> str:
    """Known verdicts against those found, with shares."""
    heads = (*VERDICTS, "undecided")
    counts = Counter((case.known.verdict, case.answer.verdict) for case in cases)
    lines = [(known, *(counts[known, found] or "·" for found in heads)) for known in VERDICTS]
    return table(("known \\ found", *heads), lines, 6)


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
    lines = []
    for heading, some in rows.items():
        if not some:
            continue
        marks = Counter(case.mark for case in some)
        cells = [
            f"{marks[m]} ({marks[m] / len(some):.0%})" for m in ("right", "undecided", "wrong")
        ]
        lines.append((heading, len(some), *cells))
    return table((head, "judged", "right", "undecided", "wrong"), lines, 5)


def exponents(cases: Sequence[Case]) -> str:
    """Known Lyapunov exponents beside those found."""
    lines = []
    for case in cases:
        known, answer = case.known, case.answer
        if known.exponents is None:
            continue
        found = ", ".join(map(_number, answer.exponents, answer.errors))
        differs = "" if case.measured else "**differs:** "
        expected = ", ".join(map(_number, known.exponents))
        lines.append((known.name, expected, f"{differs}{found}"))
    return table(("system", "known (1/s)", "found (1/s)"), lines, 3)


def _number(value: float, error: float = 0.0) -> str:
    """A number, with its error if it has one; what is round-off is 0."""
    if math.isinf(value):
        return "−∞"
    if abs(value) + error < ROUND_OFF:
        return "0"
    text = " ± ".join(to_error(value, error)) if error else f"{value:.4g}"
    return text.replace("-", "−")
