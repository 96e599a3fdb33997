"""``simulate``: motion, files, figures and a table of maxima."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from linkages.cli.requests import Request, as_far_as_possible, how_far
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.kernel.outputs import VARIABLES
from linkages.reports.report import Notes, Part, Report, Table, Unbroken, number
from linkages.reports.tables import (
    ENDS,
    LATE,
    LOADS,
    OPEN,
    is_late,
    marked_ends,
    require_table,
    save_table,
)
from linkages.solution.solution import Horizon, Solution, cost_factor
from linkages.solvers.job import AUTO

DEAREST = 3.0
"""Runs are verified unasked if that makes them no more than this many times as expensive."""

NOT_LOOKED_AT = "the motion is too long to be searched between samples: the value may be larger"

SUMMARY = (
    "slider_position_error",
    "slider_velocity_error",
    "slider_acceleration_error",
    "drive_effort",
    "rotary_actuator_angle",
    "rotary_actuator_speed",
    "rotary_actuator_acceleration",
    "linear_actuator_position",
    "linear_actuator_velocity",
    "linear_actuator_acceleration",
    "actuator_power",
    "dexterity",
    "load_force",
    "load_torque",
    "slider_position",
    "slider_velocity",
    "slider_acceleration",
    "clearance_speed",
    "clearance_force",
    "energy_residual",
    "closure_residual",
)
"""What the table of maxima shows, in its order, unless outputs were asked for; loads that vary."""

WITHOUT_SLIDERS = ("bar_speed", "bar_acceleration")
"""What it shows besides where no slider tells how the mechanism moves."""


def run_simulate(
    request: Request,
    outputs: str | None,
    verify: bool | None,
    measure: Sequence[str] | None,
    units: str | None,
    table: str,
    reports: Sequence[str] | None,
    curve: Sequence[str] | None,
) -> int:
    """Simulate a file and save everything; returns the exit code."""
    names = None if outputs is None else "all" if outputs == "all" else outputs.split(",")
    with _errors_of_table():
        require_table(table, units or ())
    with request.computing("simulating") as watch:
        computed: Sequence[str] | None = names
        if reports or table != "csv":
            computed = _with_loads(request.mechanism, names, curve or ())
        if measure:
            from linkages.solution.measuring import with_measured

            computed = with_measured(request.mechanism, computed, measure)
        given = {**request.given, "outputs": computed, "watch": watch}
        solution, failure, interrupted = as_far_as_possible(request.mechanism, **given)
        measured: list[dict[str, Any]] = []
        if measure:
            from linkages.solution.measuring import measured_rows

            measured = measured_rows(solution, measure)
        doubtful = _doubtful(solution, measured) if measured else []
    horizon = None
    if not interrupted:  # whoever interrupts wants no second run
        try:
            horizon = _horizon(solution, verify)
        except KeyboardInterrupt:
            failure, interrupted = "interrupted before the predictability horizon was known", True
    rows = shown_maxima(solution, names)
    for row in solution.maxima:  # not known without a horizon
        late = is_late(row["time"], solution.arrays.attrs.get("horizon"))
        row["beyond_horizon"] = None if horizon is None else late
    notes = [*solution.notes, *_warnings(solution)]
    complete = failure is None
    asked = {"units": units or (), "measures": measure or (), "curves": curve or ()}
    with request.publishing(solution.options, complete=complete, interrupted=interrupted) as place:
        written = solution.save(place.folder)
        if units is not None or table != "csv":
            written[1].unlink()
            with _errors_of_table():
                save_table(solution, place.folder / f"simulate.{table}", **asked)
        for ending in reports or ():
            from linkages.reports.sheets import save_report

            save_report(solution, place.folder / f"report.{ending}", **asked)
        if request.figures:
            from linkages.plots.figures import dense_data, figures_of, save_figures

            drawn = figures_of(solution, names)
            save_figures(
                solution.data, solution.mechanism, place.folder, request.format, drawn,
                dense_data(solution, drawn), request.differences,
            )  # fmt: skip

    parts = _parts(solution, horizon, rows)
    if measured:
        parts.append(Table.of("Measures", measured, "measure", "value", "units: unit"))
    notes += doubtful
    parts.append(Notes([*notes, *(row["reason"] for row in measured if row["reason"])]))
    report = Report(
        name=solution.mechanism.name,
        summary=_how(solution),
        parts=parts,
        data={
            **how_far(solution, failure),
            "samples": len(solution.time),
            "method": solution.motion.method or None,
            "reason": solution.motion.reason or None,
            "cost": solution.motion.cost,
            "horizon": None if horizon is None else asdict(horizon),
            "maxima": solution.maxima,
            "measures": measured,
            "notes": notes,
        },
    )
    return request.report(report, place.files, failure=failure)


def _with_loads(
    mechanism: Mechanism, names: Sequence[str] | str | None, curves: Sequence[str]
) -> Sequence[str] | None:
    """Outputs with the loads that reports and workbooks list, and those of curves."""
    if names == "all":
        return names
    from linkages.kernel.system import System
    from linkages.solution.measuring import outputs_with
    from linkages.solution.series import requested

    system = System(mechanism)
    possible = {*requested(system, "all")}
    loads = [name for name in LOADS if name in possible]
    try:
        drawn = outputs_with(system, curves)
    except ValueError as error:
        raise InputError("--curve", [Problem(message=str(error))]) from None
    return list(dict.fromkeys([*requested(system, names), *loads, *drawn]))


@contextmanager
def _errors_of_table() -> Iterator[None]:
    try:
        yield
    except (ValueError, ImportError) as error:
        raise InputError("--table", [Problem(message=str(error))]) from None


def _doubtful(solution: Solution, rows: Sequence[dict[str, Any]]) -> list[str]:
    """What is doubtful about the values of measures."""
    from linkages.solution.measuring import doubts

    return [note for row in rows if row["value"] is not None
            for note in doubts(solution, row["measure"])]  # fmt: skip


def _horizon(solution: Solution, verify: bool | None) -> Horizon | None:
    """Until when the solution holds, noted in its data for figures and files."""
    if verify is None:
        cheap = solution.settings.run.step is None and bool(solution.motion.method)
        verify = cheap and cost_factor(solution.motion.method) < DEAREST
    if not verify:
        return None
    horizon = solution.horizon
    if horizon is not None and not horizon.whole:
        solution.arrays.attrs["horizon"] = horizon.time
    return horizon


def shown_maxima(
    solution: Solution, asked: Sequence[str] | str | None = None
) -> list[dict[str, Any]]:
    """Rows of the table: of the outputs asked for, else of a choice."""
    kinds = {body.kind for body in solution.mechanism.bodies.values()}
    summary = SUMMARY if "slider" in kinds else (*WITHOUT_SLIDERS, *SUMMARY)
    if asked is None:
        chosen: Sequence[str] = summary
    elif asked == "all":
        chosen = list(dict.fromkeys([*summary, *VARIABLES]))
    else:
        chosen = [asked] if isinstance(asked, str) else asked
    rows = [row for name in chosen for row in solution.maxima if row["variable"] == name]
    return rows if asked else [*_turned(solution, rows), *filter(partial(_varies, solution), rows)]


def _turned(solution: Solution, shown: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Speeds of bars that motors turn, which no drive prescribes, unless they are shown."""
    if any(component.section == "motors" for component in solution.mechanism.components):
        for row in solution.maxima:
            free = row["element"] in solution.system.topology.free
            if row["variable"] == "bar_speed" and free and row not in shown:
                yield row


def _varies(solution: Solution, row: dict[str, Any]) -> bool:
    """Whether a row is worth its place unasked: not constant loads, nor speeds of offsets."""
    if row["variable"] == "clearance_speed":  # of an offset, the direction turns at any speed
        return str(row["element"]) in solution.mechanism.bodies
    if row["variable"] not in ("load_force", "load_torque"):
        return True
    (_, dim), values, _ = solution.arrays.variables[row["variable"]]
    column = solution.arrays.coordinates[dim][1].tolist().index(row["element"])
    return bool(np.ptp(values[:, column]))


def _warnings(solution: Solution) -> list[str]:
    """What a reader of the table must know: pins out of their holes."""
    from linkages.chaos.contact_log import contact_of

    return [check.sentence for check in contact_of(solution) if check.sentence]


def _parts(
    solution: Solution, horizon: Horizon | None, rows: Sequence[dict[str, Any]]
) -> list[Part]:
    """Least and largest values, and until when they can be believed."""
    until = solution.arrays.attrs.get("horizon")
    cells = [
        [row["long_name"], row["element"], *marked_ends(row, until), row["units"]] for row in rows
    ]
    parts: list[Part] = [Table("Least and largest values", ENDS, cells, numbers=5)] if cells else []
    marks = "".join(cell[2] + cell[4] for cell in cells)
    if until is not None and LATE in marks:
        parts.append(
            Unbroken(
                f"{LATE} later than t = {number(until)} s, to which the motion is predictable: "
                "qualitatively correct only, another run gives another value"
            )
        )
    if OPEN in marks:
        parts.append(Unbroken(f"{OPEN} {NOT_LOOKED_AT}"))
    if solution.settings.run.method == AUTO and solution.motion.reason:
        parts.append(f"{solution.motion.method} was picked: {solution.motion.reason}")
    return parts if horizon is None else [*parts, _believable(horizon)]


def _believable(horizon: Horizon) -> str:
    if not math.isfinite(horizon.error):
        return "not predictable at all: a more accurate run diverges before the second sample"
    error = f"{horizon.error:.1e} of its amplitude"
    if horizon.whole:
        return f"predictable throughout: error of the free motion at most {error}"
    return (
        f"predictable to t = {number(horizon.time)} s: later fewer than three digits of the free "
        f"motion are correct (error up to {error})"
    )


def _how(solution: Solution) -> str:
    time = solution.time
    span = f"{len(time)} samples to t = {number(float(time[-1]))} s" if len(time) else "no samples"
    if not solution.motion.method:
        driven = solution.system.topology.driven
        why = "all coordinates driven" if driven else "a structure, which cannot move"
        return f"{span}, {why}, nothing integrated"
    run, cost = solution.settings.run, solution.motion.cost
    if run.step is not None:
        how = f"{solution.motion.method}, step {number(run.step)} s"
    else:
        how = f"{solution.motion.method}, rtol {run.rtol:g}, {cost['rejected']} rejected"
    return f"{span}, {how}, {cost['steps']} steps, {cost['evaluations']} evaluations"
