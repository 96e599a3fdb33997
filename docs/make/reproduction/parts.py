"""Figures and tables of the page: each part measures, draws its figures and keeps its evidence.

The evidence is in docs/_static/paper.json, from which tables are made. Chaotic motions depend on
round-off beyond their horizon: their points differ between machines, and only their statistics
agree.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from make.registry import PAGES, keep_numbers, kept, makes, rounded
from make.reproduction import judgements, motion_figures, number_figures, sweep_figures, tables
from make.reproduction.maxima import Maxima, grid, maxima, nearest, ranks, scan, torque_ratio
from make.reproduction.misprints import energy_as_printed
from make.reproduction.reported import (
    SIZE,
    SIZE_RANGE,
    SIZES,
    SPEED_RANGE,
    SPEEDS,
    STARTS,
    press,
)
from make.reproduction.spreads import (
    INERTIA,
    SLOW,
    PowerLaw,
    mean_law,
    over_sizes,
    over_speeds,
    own_starts,
    size_laws,
    speed_laws,
    spread,
    start_angles,
)
from make.reproduction.steps import STEPS, converged, study
from make.reproduction.verdicts import verdict, verdicts

GRID = (15, 45)
COARSE_GRID = (60, 60)
VERDICT_SIZES = (1e-5, 5e-5, 1.5e-4, 2.5e-4, 5e-4)
LIBRATING = -36.7
VERDICT_ANGLES = (LIBRATING, 0.0, 90.0, 135.0, 180.0)
VERDICT_PERIODS = 300
POINTS = 1000
DIAGRAM = (800, 50)
LAW, SPEED_LAW = (10, 50), (33, 60)
"""Values and periods."""
ALL_AROUND = 60
CLEARANCE_LABEL, SPEED_LABEL = "radial clearance r1 [mm]", "crank speed ω/π [rad/s]"


TABLES: dict[str, Callable[[dict[str, Any]], str]] = {
    "numbers": tables.numbers_table,
    "speeds": tables.speeds_words,
    "steps": tables.steps_table,
}
"""Of parts that draw; verdicts are a table alone."""

KEPT = "paper.json"


def put(part: str, **evidence: Any) -> None:
    """Keep the evidence of one part beside that of the others."""
    with PAGES:
        keep_numbers(KEPT, {**kept(KEPT), part: evidence})


@makes(*(f"paper-{name}" for name in TABLES), "paper-judgements", numbers=KEPT)
def of_evidence(evidence: dict[str, Any]) -> tuple[str, ...]:
    """Tables that are made of what parts have kept."""
    found = (make(evidence[name]) for name, make in TABLES.items())
    return *found, tables.judgement_table(evidence)


def of(found: Maxima) -> dict[str, Any]:
    """Maxima from one initial condition as plain data."""
    return {"values": found.values.tolist(), "times": found.times.tolist()}


@makes("paper-maxima.svg")
def numbers() -> Figure:
    """The five maxima of the paper among those from all initial conditions."""
    starts, coarse = grid(*GRID), grid(*COARSE_GRID)
    found, own = scan(press(), starts), {name: maxima(press(name)) for name in STARTS}
    ratio = torque_ratio(found.values)
    columns = np.column_stack([found.values, ratio])
    quantiles = np.percentile(columns, np.arange(101), axis=0)
    index, factor = nearest(found)
    changed = press(changes=energy_as_printed(press()))
    variant = scan(changed, coarse)
    put(
        "numbers",
        starts=len(starts),
        steps=list(GRID),
        band=tables.band(found.values),
        quantiles=quantiles.tolist(),
        ranks=ranks(found).tolist(),
        own={name: of(one) for name, one in own.items()},
        nearest={
            "start": list(starts[index]),
            "values": found.values[index].tolist(),
            "factor": factor,
        },
        ratio=[float(ratio.min()), float(ratio.max())],
        as_printed={
            "values": maxima(changed).values.tolist(),
            "ranks": ranks(variant).tolist(),
            "starts": len(coarse),
        },
        judgements=plain(judgements.of_maxima(found)),
    )
    return number_figures.maxima_figure(quantiles, own["librating"].values)


def plain(found: list[judgements.Judgement]) -> list[dict[str, str]]:
    """Judgements as plain data."""
    return [asdict(one) for one in found]


@makes(
    *(f"paper-slider-{name}.png" for name in STARTS),
    "paper-torques.png",
    "paper-phase.png",
    "paper-section.png",
    colours=256,
)
def motion() -> tuple[Figure, ...]:
    """Figures 3–11."""
    runs = motion_figures.runs()
    put("motion")
    return (
        *(motion_figures.slider_figure(data, name) for name, data in runs.items()),
        motion_figures.torque_figure(runs),
        motion_figures.phase_figure(),
        motion_figures.section_figure(),
    )


@makes("paper-verdicts")
def judged() -> str:
    """Regular or chaotic."""
    points = [(size, angle) for size in VERDICT_SIZES for angle in VERDICT_ANGLES]
    rows = verdicts(points, VERDICT_PERIODS)
    evidence = {
        "periods": VERDICT_PERIODS,
        "rows": [row.to_dict() for row in rows],
        "judgements": plain(judgements.of_verdicts(rows)),
    }
    put("verdicts", **evidence)
    return tables.verdict_tables(rounded(evidence))


def law_data(law: PowerLaw) -> list[float]:
    """A power law as plain data."""
    return [law.exponent, law.error]


@makes("paper-sections-size.png", "paper-size.png", "paper-law-size.svg", colours=256)
def sizes() -> tuple[Figure, ...]:
    """Figures 12 and 13, and the power law of the spread over r."""
    portraits = over_sizes(SIZES, own_starts(), POINTS)
    diagram = over_sizes(np.linspace(*SIZE_RANGE, DIAGRAM[0]), own_starts(), DIAGRAM[1])
    initial = start_angles(ALL_AROUND)
    data = over_sizes(np.geomspace(*SIZE_RANGE, LAW[0]), initial, LAW[1])
    r, found = data[SIZE].to_numpy(), spread(data)
    law, losses = size_laws(r, found)
    claims = plain(judgements.of_sizes(losses, law))
    put("sizes", law=law_data(law), losses=losses, judgements=claims)
    fitted = (mean_law(1e3 * r, found), np.full(len(r), True), "common slope")
    return (
        sweep_figures.portraits_figure(portraits, [f"r = {1e3 * r:g} mm" for r in SIZES]),
        sweep_figures.diagram_figure(diagram, 1e3 * diagram[SIZE].to_numpy(), CLEARANCE_LABEL),
        sweep_figures.law_figure(1e3 * r, data, CLEARANCE_LABEL, [fitted], names(initial)),
    )


def speed_text(speed: float) -> str:
    """A speed in units of π rad/s."""
    factor = speed / np.pi
    return "π rad/s" if factor == 1 else f"{factor:g}π rad/s"


def names(initial: list[dict[str, object]]) -> list[str]:
    """Names of initial conditions in a legend."""
    return [str(value).replace(" deg", "°") for start in initial for value in start.values()]


@makes("paper-sections-speed.png", "paper-speed.png", "paper-law-speed.svg", colours=256)
def speeds() -> tuple[Figure, ...]:
    """Figures 14 and 15, and the power laws of the spread over ω."""
    portraits = over_speeds(SPEEDS, own_starts(), POINTS)
    diagram = over_speeds(np.linspace(*SPEED_RANGE, DIAGRAM[0]), own_starts(), DIAGRAM[1])
    x = diagram["drives.crank4.speed"].to_numpy() / np.pi
    initial = start_angles(ALL_AROUND)
    data = over_speeds(np.pi * np.geomspace(0.05, 40, SPEED_LAW[0]), initial, SPEED_LAW[1])
    w, found = data["drives.crank4.speed"].to_numpy(), spread(data)
    slow, fast, gained = speed_laws(w, found)
    laws = [
        (mean_law(w[part] / np.pi, found[:, part]), part, name)
        for part, name in ((w <= SLOW, "common slope, slow"), (w >= INERTIA, "common slope, fast"))
    ]
    put(
        "speeds",
        slow=law_data(slow),
        fast=law_data(fast),
        gains=gained,
        verdicts=[
            [speed, verdict(1.5e-4, LIBRATING, VERDICT_PERIODS, speed=speed).to_dict()]
            for speed in SPEEDS[2:]
        ],
        judgements=plain(judgements.of_speeds(gained, slow, fast)),
    )
    return (
        sweep_figures.portraits_figure(portraits, [f"ω = {speed_text(w)}" for w in SPEEDS]),
        sweep_figures.diagram_figure(diagram, x, SPEED_LABEL),
        sweep_figures.law_figure(w / np.pi, data, SPEED_LABEL, laws, names(initial)),
    )


@makes("paper-steps.svg")
def steps() -> Figure:
    """RK4 at several steps."""
    studies = {name: study(name) for name in STARTS}
    put(
        "steps",
        studies={name: [[row.step, row.error] for row in rows] for name, rows in studies.items()},
        converged={name: converged(name)[1] for name in STARTS},
        values=[maxima(press(), method="rk4", step=step).values.tolist() for step in STEPS],
    )
    return number_figures.steps_figure(studies)
