"""The page's tables, from the evidence that `parts` keeps in paper.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from make.registry import table
from make.reproduction.judgements import percent, read_verdicts
from make.reproduction.maxima import torque_ratio
from make.reproduction.reported import PRINTED, REPORTED, STARTS
from make.reproduction.steps import StepError, first_wrong
from make.reproduction.verdicts import Verdict

Evidence = Mapping[str, Any]

RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def power(value: float) -> str:
    """A number with one digit and a power of ten."""
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit}·10{str(int(exponent)).translate(RAISED)}"


def place(rank: float) -> str:
    """Rank of a number among those from all initial conditions."""
    if rank in (0.0, 1.0):
        return "below all" if rank == 0.0 else "above all"
    return f"{percent(rank)} are smaller"


def numbers_table(evidence: Evidence) -> str:
    """The paper's five maxima beside ours and the band of all initial conditions."""
    own = evidence["own"]
    rows = []
    for i, quantity in enumerate(REPORTED):
        ours = [
            f"{quantity.shown(own[name]['values'][i])} at {own[name]['times'][i]:.3f}\u00a0s"
            for name in STARTS
        ]
        low, high = (quantity.shown(bound) for bound in evidence["band"][i])
        rows.append(
            [
                f"{quantity.words} ({quantity.units})",
                f"{quantity.shown(quantity.value)} at {quantity.time:.3f}\u00a0s",
                *ours,
                f"{low} – {high}",
                place(evidence["ranks"][i]),
            ]
        )
    heads = ["maximum", "paper", *STARTS, "all initial conditions", "rank of the paper's value"]
    return table(heads, rows) + "\n" + numbers_words(evidence)


def numbers_words(evidence: Evidence) -> str:
    """Beside the table: the nearest initial condition and the ratio of the torques."""
    near, (low, high) = evidence["nearest"], evidence["ratio"]
    values = ", ".join(
        f"{quantity.shown(value)} {quantity.units}"
        for quantity, value in zip(REPORTED, near["values"], strict=True)
    )
    first, fourth, angle = (f"{value:g}°".replace("-", "−") for value in near["start"])
    printed = evidence["as_printed"]
    changed = "; ".join(
        f"{quantity.words} {quantity.shown(new)} instead of {quantity.shown(old)} {quantity.units}"
        for quantity, old, new in zip(
            REPORTED, evidence["own"]["librating"]["values"], printed["values"], strict=True
        )
    )
    return (
        f"All {evidence['starts']} initial conditions: θ1 and θ4 in steps of "
        f"{evidence['steps'][0]}°, α in steps of {evidence['steps'][1]}°, at rest in the "
        "clearance.\n\n"
        f"- No initial condition meets all five. The nearest of the grid (θ1 = {first}, "
        f"θ4 = {fourth}, α = {angle}) gives {values}; its worst maximum deviates by a factor of "
        f"{near['factor']:.2f}.\n"
        f"- In the paper the torque of crank 1 is {float(torque_ratio(PRINTED)):.2f} times that of "
        f"crank 4. Over all initial conditions this ratio is {low:.2f} to {high:.2f}.\n"
        f"- With the kinetic energy of Eq. 3 as printed (misprint 1 below) the librating initial "
        f"condition gives: {changed}. The paper's position error is then also "
        f"{place(printed['ranks'][0])} ({printed['starts']} initial conditions).\n"
    )


def judgement_table(parts: Mapping[str, Evidence]) -> str:
    """All claims by their letters."""
    found = sorted(
        (one for part in parts.values() for one in part.get("judgements", [])),
        key=lambda one: one["letter"],
    )
    rows = [
        [f"({one['letter']})", one["claim"], f"**{one['grade']}**", one["evidence"]]
        for one in found
    ]
    return table(["", "claim", "judgement", "evidence"], rows, texts=4)


def verdict_tables(evidence: Evidence) -> str:
    """Verdict with the largest exponent, and the share of time without contact."""
    rows = read_verdicts(evidence["rows"])
    angles = list(dict.fromkeys(row.angle for row in rows))
    sizes = sorted({row.size for row in rows})
    by_point = {(row.size, row.angle): row for row in rows}

    def matrix(cell) -> str:
        heads = ["r (mm)", *(f"α = {angle:g}°".replace("-", "−") for angle in angles)]
        lines = [
            [f"{1e3 * size:g}", *(cell(by_point[size, angle]) for angle in angles)]
            for size in sizes
        ]
        return table(heads, lines)

    first = (
        f"Verdict over {evidence['periods']} periods, and the largest Lyapunov exponent in 1/s:\n\n"
    )
    second = "Share of time in which a real journal would leave its bearing:\n\n"
    return f"{first}{matrix(_verdict_cell)}\n{second}{matrix(lambda row: percent(row.lost))}"


def _verdict_cell(row: Verdict) -> str:
    words = f"**{row.verdict}**" if row.verdict == "chaotic" else row.verdict
    return f"{words} {row.exponent:.2f}\u00a0±\u00a0{row.error:.2f}"


def speeds_words(evidence: Evidence) -> str:
    """Verdicts of the librating initial condition at other speeds."""
    found = [
        f"at {speed / np.pi:.2g}π rad/s the verdict is {_verdict_cell(Verdict(**row))} 1/s, "
        f"{percent(row['lost'])} of the time without contact"
        for speed, row in evidence["verdicts"]
    ]
    return f"For the librating initial condition (r = 0.15 mm) {'; '.join(found)}.\n"


def steps_table(evidence: Evidence) -> str:
    """Correct digits of α̇ at 1 s for every step, and the steps at which digits go wrong."""
    studies = {
        name: [StepError(*row) for row in rows] for name, rows in evidence["studies"].items()
    }
    steps = [row.step for row in next(iter(studies.values()))]
    rows = [
        [
            f"{1e6 * step:g}",
            *(f"{power(rows[i].error)}, {rows[i].digits}" for rows in studies.values()),
            *(q.shown(v) for q, v in zip(REPORTED[2:], evidence["values"][i][2:], strict=True)),
        ]
        for i, step in enumerate(steps)
    ]
    heads = ["step (µs)", *(f"{name}: relative error, digits" for name in studies)]
    heads += [f"{quantity.words} ({quantity.units})" for quantity in REPORTED[2:]]
    lines = []
    for name, found in studies.items():
        ends = [f"{1e6 * first_wrong(found, digit):g} µs" for digit in (1, 3)]
        lines.append(
            f"- {name.capitalize()}: of these steps, {ends[0]} is the shortest with a wrong first "
            f"digit at 1 s, and {ends[1]} the shortest with a wrong third digit. Two other methods "
            f"at rtol 1e-13 differ by {power(evidence['converged'][name])}."
        )
    return table(heads, rows) + "\n" + "\n".join(lines) + "\n"


def band(values: np.ndarray) -> list[list[float]]:
    """Least and greatest of every column."""
    return np.stack([values.min(axis=0), values.max(axis=0)], axis=1).tolist()
