"""Make the figures and tables of docs/reproduction.md.

    python docs/figures_paper.py                   # everything (15 minutes, and the verdicts)
    python docs/figures_paper.py motion steps      # some parts: numbers motion verdicts sizes
                                                   # speeds steps
    python docs/figures_paper.py tables            # tables from the evidence that there is

Measured numbers are kept in docs/_static/paper.json, from which the tables are made; both are
committed. Chaotic motions depend on round-off beyond their horizon: their points differ between
machines, and only their statistics agree.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any

from make.accuracy import STATIC, write_table
from make.benchmark import rounded
from make.reproduction import parts, tables

KEPT = STATIC / "paper.json"
PARTS: dict[str, Callable[[], dict[str, Any]]] = {
    "numbers": parts.numbers,
    "motion": parts.motion,
    "verdicts": parts.judged,
    "sizes": parts.sizes,
    "speeds": parts.speeds,
    "steps": parts.steps,
}

TABLES: dict[str, Callable[[dict[str, Any]], str]] = {
    "numbers": tables.numbers_table,
    "verdicts": tables.verdict_tables,
    "speeds": tables.speeds_words,
    "steps": tables.steps_table,
}


def main() -> None:
    """Measure the parts that are named, all of them by default, and write the tables."""
    for name in sys.argv[1:] or list(PARTS):
        if name != "tables":
            keep(name, PARTS[name]())
    for name, text in tables_of(kept_evidence()).items():
        write_table(f"paper-{name}", text)


def kept_evidence() -> dict[str, Any]:
    """What was measured."""
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}


def keep(name: str, measured: dict[str, Any]) -> None:
    """Put the evidence of one part beside that of the others."""
    evidence = {**kept_evidence(), name: deep(measured)}
    KEPT.write_text(json.dumps(evidence, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def tables_of(evidence: dict[str, Any]) -> dict[str, str]:
    """Name → table, as far as there is evidence."""
    found = {name: make(evidence[name]) for name, make in TABLES.items() if name in evidence}
    return {**found, "judgements": tables.judgement_table(evidence)}


def deep(value: Any) -> Any:
    """Numbers with a few digits, throughout."""
    if isinstance(value, list | tuple):
        return [deep(part) for part in value]
    if isinstance(value, dict):
        return {key: deep(part) for key, part in value.items()}
    return rounded(value)


if __name__ == "__main__":
    main()
