"""Make the tables of docs/verdicts.md.

    python docs/figures_verdicts.py

Judges every system with a known answer, with and without skipping, at two tolerances.
"""

from __future__ import annotations

import json
import os
from multiprocessing import get_context
from pathlib import Path

from figures import write_table
from verdicts.known import Answer
from verdicts.table import (
    CLASSES,
    SKIPS,
    TOLERANCES,
    Case,
    by_class,
    confusion,
    exponents,
    judged,
    listed,
    shares,
    systems,
)

STATIC = Path(__file__).parent / "_static"
SYSTEMS = systems()
TASKS = [
    (index, skip, rtol)
    for index, known in enumerate(SYSTEMS)
    for skip in SKIPS
    for rtol in TOLERANCES
    if known.dissipative or skip is None
]


def found(task: tuple[int, int | None, float]) -> Answer:
    """The answer of one judgement; systems themselves do not go from process to process."""
    index, skip, rtol = task
    case = judged(SYSTEMS[index], skip, rtol)
    print(
        f"{case.mark}|{case.measured}|{case.known.name}|{skip}|{rtol:g}|{case.answer}", flush=True
    )
    return case.answer


def main() -> None:
    with get_context("spawn").Pool(os.cpu_count()) as pool:
        answers = dict(zip(TASKS, pool.map(found, TASKS, chunksize=1), strict=True))
    write(answers)


def write(answers: dict[tuple[int, int | None, float], Answer]) -> None:
    """Tables and data; where nothing dissipates both ways to skip are one judgement."""
    missing = {SYSTEMS[task[0]].name for task in TASKS if task not in answers}
    cases = [
        Case(known, skip, rtol, answers[index, skip if known.dissipative else None, rtol])
        for index, known in enumerate(SYSTEMS)
        if known.name not in missing
        for skip in SKIPS
        for rtol in TOLERANCES
    ]
    for text in (shares, by_class, confusion):
        write_table(f"verdicts-{text.__name__.replace('_', '-')}", text(cases))
    kept = [case for case in cases if (case.skip, case.rtol) == (None, TOLERANCES[-1])]
    write_table("verdicts-exponents", exponents(kept))
    for heading, some in CLASSES.items():
        rows = listed([case for case in cases if case.known in some])
        write_table(f"verdicts-{heading.replace(' ', '-')}", rows)
    rows = [
        {
            "system": case.known.name,
            "known": case.known.expected,
            "skip": case.skip,
            "rtol": case.rtol,
            "verdict": case.answer.verdict,
            "period": case.answer.period,
            "mark": case.mark,
            "measured": case.measured,
        }
        for case in cases
    ]
    text = json.dumps(rows, indent=1, ensure_ascii=False)
    (STATIC / "verdicts.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
