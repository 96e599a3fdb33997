"""Make the tables of docs/verdicts.md.

    python docs/figures_verdicts.py                   # hours
    python docs/figures_verdicts.py maps "dry friction"   # these classes; others stay as they are

Judges every system with a known answer, with and without skipping, at two tolerances.
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Sequence
from multiprocessing import get_context
from pathlib import Path

from make.accuracy import write_table
from make.verdicts.known import LOST, Answer
from make.verdicts.table import (
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

DATA = Path(__file__).parents[1] / "_static" / "verdicts.json"
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


def main(classes: Sequence[str]) -> None:
    """Judge the systems of some classes; what is found is kept after each class."""
    answers = {} if set(classes) == set(CLASSES) else kept()
    with get_context("spawn").Pool(os.cpu_count()) as pool:
        for heading in classes:
            tasks = [task for task in TASKS if SYSTEMS[task[0]] in CLASSES[heading]]
            answers |= zip(tasks, pool.map(found, tasks, chunksize=1), strict=True)
            write(answers)


def kept() -> dict[tuple[int, int | None, float], Answer]:
    """Answers that were found before, of systems that are still in the table."""
    index = {known.name: position for position, known in enumerate(SYSTEMS)}
    found = {
        (index[row["system"]], row["skip"], row["rtol"]): Answer(
            row["verdict"],
            row["period"],
            tuple(LOST if one is None else one for one in row["exponents"]),
            tuple(row["errors"]),
        )
        for row in json.loads(DATA.read_text(encoding="utf-8"))
        if row["system"] in index
    }
    return {task: found[task] for task in TASKS if task in found}


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
    tight = [case for case in cases if (case.skip, case.rtol) == (None, TOLERANCES[-1])]
    write_table("verdicts-exponents", exponents(tight))
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
            "exponents": [one if math.isfinite(one) else None for one in case.answer.exponents],
            "errors": case.answer.errors,
            "mark": case.mark,
            "measured": case.measured,
        }
        for case in cases
    ]
    lines = ",\n".join(json.dumps(row, ensure_ascii=False) for row in rows)
    DATA.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:] or list(CLASSES))
