"""Commands of one motion or several: ``animate``, ``view``, ``phase`` and ``plot``."""

from __future__ import annotations

import re
import shlex
import webbrowser
from collections.abc import Iterator, Sequence
from inspect import signature
from itertools import product
from math import copysign
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.cli.requests import (
    File,
    Request,
    as_far_as_possible,
    each_read,
    how_far,
    mechanism_from,
)
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Problem
from linkages.kernel.system import System
from linkages.opened import ENDING
from linkages.opened import open as opened
from linkages.options.option import OptionError
from linkages.options.run import SimulationOptions
from linkages.reading.wording import listed
from linkages.reports.report import Notes, Part, Report, Table, Unbroken, headed, number
from linkages.solution.measuring import outputs_with
from linkages.solution.run_options import options_of
from linkages.solution.series import (
    TIME,
    example_series,
    find_series,
    requested,
    system_series,
    with_sizes,
)
from linkages.solution.simulate import simulate
from linkages.solution.solution import IncompleteError, Solution

if TYPE_CHECKING:
    from linkages.plots.motion.compared import Compared


FEWEST_SAMPLES = 10_001
"""A curve through fewer points shows corners where a clearance turns fast."""


def file_name(*parts: str) -> str:
    """A name for files that show some series."""
    return "_".join(re.sub(r"[^\w.]+", "-", part) for part in parts)


def run_phase(
    request: Request,
    x: Sequence[str],
    y: Sequence[str],
    wrap: bool,
    skip: float,
    samples: int | None,
) -> int:
    """Simulate, and draw one series against another; returns the exit code."""
    for flag, names in (("--x", x), ("--y", y)):
        if len(names) > 1:
            several = listed(list(names), "and")
            message = f"expected one series, found {several}; `plot` draws several"
            raise InputError(flag, [Problem(message=message)])
    mechanism, name = request.mechanism, file_name("phase", x[0], y[0])
    with request.computing("phase diagram of") as watch:
        known = with_sizes(system_series(System(mechanism)))
        pair = [find_series(known, text) for text in (x[0], y[0])]
        asked = options_of(SimulationOptions, mechanism, request.given)
        if not 0 <= skip < asked.end:
            message = f"skip must be from 0 to below {asked.end:g} s, found {skip:g}"
            raise OptionError("skip", message)
        wanted = max(FEWEST_SAMPLES, asked.samples) if samples is None else samples
        pair = [series for series in pair if series.variable != TIME]
        outputs = list(dict.fromkeys(series.variable for series in pair))
        given = {**request.given, "samples": wanted, "outputs": outputs}
        solution, failure, interrupted = as_far_as_possible(mechanism, watch=watch, **given)
    data = solution.data.sel(time=slice(skip, None))
    if not data.sizes["time"]:
        raise ComputationError(f"stopped {failure}", time=solution.motion.stop_time)
    columns = {"time (s)": data["time"].to_numpy()}
    for series in pair:
        head = headed(series.name, data[series.variable].attrs["units"])
        columns[head] = series.of(data).to_numpy()

    def figures() -> Iterator[File]:
        from linkages.plots.motion.overlay import pair_figure

        yield name, pair_figure(data, x[0], y[0], wrap=wrap)

    rows = [
        {"name": head, "least": float(np.min(values)), "greatest": float(np.max(values))}
        for head, values in columns.items()
    ]
    report = Report(
        name=mechanism.name,
        summary="phase diagram",
        parts=[Table.of("Ranges", rows, "name: series", "least", "greatest", numbers=2)],
        data={"mechanism": mechanism.name, "stopped": failure, "series": rows},
    )
    options = {**solution.options, **request.own, "samples": wanted}
    return request.publish(
        report, [(name, data), (name, columns)], figures, options, name=name, failure=failure,
        interrupted=interrupted,
    )  # fmt: skip


MOST = 12
"""Motions in one figure: more can not be told apart."""


def run_plot(
    request: Request,
    others: Sequence[str] | None,
    y: Sequence[str] | None,
    against: str,
    vary: Sequence[str] | None,
    difference: bool,
    polar: bool,
    wrap: bool,
) -> int:
    """Simulate what is asked for, and draw it; returns the exit code."""
    from linkages.plots.motion.compared import compared, told_apart, vectors

    if not y:
        example = example_series(System(request.mechanism))
        message = f"expected what to draw, such as --y {shlex.quote(example)}"
        raise InputError("--y", [Problem(message=message)])
    if polar and (against != TIME or difference):
        flag = "--difference" if difference else "--against"
        message = f"--polar draws y over x of a vector; {flag} does not go with it"
        raise InputError("--polar", [Problem(message=message)])
    files = [request.file, *(others or ())]
    failures, sources = [], []
    with request.computing("plot of") as watch:
        asked = _asked(request, files, vary or ())
        for mechanism, arguments in asked:
            outputs = outputs_with(System(mechanism), [*y, against])
            how = {**arguments, **request.given, "outputs": outputs}
            solution, failure, interrupted = as_far_as_possible(mechanism, watch=watch, **how)
            sources.append(solution)
            failures += [failure] if failure else []
            if interrupted:
                break
        stems = [Path(file).stem for file in files for _ in range(len(asked) // len(files))]
        labels = told_apart([m for m, _ in asked[: len(sources)]], stems[: len(sources)])
        motions: dict[str, Solution] = dict(zip(labels, sources, strict=True))
        result = (
            vectors(motions, y)
            if polar
            else (compared(motions, y, against, difference=difference),)
        )
    over = [f"over-{against}"] if against != TIME else []
    kind = [word for word, wanted in (("polar", polar), ("difference", difference)) if wanted]
    name = file_name("plot", *y, *over, *kind)
    failure = failures[0] if failures else None

    def figures() -> Iterator[File]:
        from linkages.plots.motion import overlay

        yield name, overlay.polar_figure(result) if polar else overlay.figure(result[0], wrap=wrap)

    rows = [
        {
            "name": curve.name, "of": curve.source, "least": curve.least,
            "greatest": curve.greatest, "units": curve.units,
        }
        for one in result
        for curve in one.curves
    ]  # fmt: skip
    report = Report(
        name=request.mechanism.name,
        summary=f"over {against}",
        parts=[Table.of("Ranges", rows, "name: series", "of", "least", "greatest", "units: unit")],
        data={"mechanism": request.mechanism.name, "stopped": failure, "series": rows},
    )
    options = {**sources[0].options, **request.own}
    return request.publish(
        report, [(name, _columns(result))], figures, options, name=name, failure=failure,
        interrupted=interrupted,
    )  # fmt: skip


def _asked(
    request: Request, files: Sequence[str], vary: Sequence[str]
) -> list[tuple[Mechanism, dict[str, Any]]]:
    """What is to be simulated, and with which arguments of saved results."""
    from linkages.sweeps.axes import parse_axis

    axes = each_read("--vary", vary, parse_axis)
    places = [*product(*(range(len(axis)) for axis in axes))]
    if len(places) * len(files) > MOST:
        raise OptionError("vary", f"expected up to {MOST} motions, found {len(places)}")
    result = []
    for file in files:
        mechanism = mechanism_from(file, request.assignments, request.tables_from)
        arguments: dict[str, Any] = {}
        if Path(file).suffix == ENDING:
            saved = opened(file)
            if saved.analysis != "simulate":
                message = f"expected results of simulate, found those of {saved.analysis}"
                raise InputError(file, [Problem(message=message)])
            known = signature(simulate).parameters.keys() - {"events", "outputs"}
            arguments = {n: value for n, value in saved.arguments.items() if n in known}
        for place in places:
            values: dict[str, object] = {}
            for axis, index in zip(axes, place, strict=True):
                values |= axis.at(index)
            result.append((mechanism.with_values(values) if values else mechanism, arguments))
    return result


def _columns(found: Sequence[Compared]) -> dict[str, Any]:
    """Columns of a table: shorter motions have empty cells at the end."""
    columns: dict[str, Any] = {}
    for one in found:
        for curve in one.curves:
            whose = f", {curve.source}" if curve.source else ""
            columns[f"{TIME} (s){whose}"] = curve.time
            if one.across != TIME:
                columns[f"{one.across} ({one.units}){whose}"] = curve.x
            columns[f"{curve.name} ({curve.units}){whose}"] = curve.y
    longest = max(len(column) for column in columns.values())
    return {
        head: np.append(column, np.full(longest - len(column), np.nan))
        for head, column in columns.items()
    }


NAME = "view"
"""Of the file."""


def run_view(request: Request, outputs: str | None, browser: bool) -> int:
    """Simulate a file and write the page, as `linkages.view` does; returns the exit code."""
    from linkages.viewer.content import html
    from linkages.viewer.recorded import wanted

    with request.computing("simulating") as watch:
        names = wanted(System(request.mechanism), outputs)
        solution, failure, interrupted = as_far_as_possible(
            request.mechanism, outputs=names, watch=watch, **request.given
        )
    if not solution.data.sizes["time"]:
        raise ComputationError(f"nothing to show: {failure}", time=None)
    (path,) = request.write(
        [(f"{NAME}.html", html(solution))], solution.options, complete=failure is None,
        interrupted=interrupted,
    )  # fmt: skip
    if browser:
        webbrowser.open(path.absolute().as_uri())
    size, notes = path.stat().st_size, list(solution.notes)
    report = Report(
        name=request.mechanism.name,
        summary=solution.summary,
        parts=[Notes(notes), Unbroken(f"{path}: open it in a browser")],
        data={**how_far(solution, failure), "bytes": size, "notes": notes},
    )
    return request.report(report, [path], failure=failure, listed=False)


FEWEST_IN_FILM = 721
"""Of the motion from which the pace is found; frames are computed at their own times."""

_SIZE = re.compile(r"(\d+)\s*[x×]\s*(\d+)")


def run_animate(
    request: Request,
    form: str,
    start: float,
    duration: float | None,
    size: str | None,
    plot: list[str] | None,
    reactions: list[str] | None,
    **how: Any,
) -> int:
    """Simulate a file and animate the motion, as `linkages.animate` does; returns the exit code."""
    from linkages.plots.films.animation import animate, check_arguments
    from linkages.plots.films.film import film_of, paces, too_fast

    mechanism, name = request.mechanism, f"animation.{form}"
    with request.computing("simulating") as watch:
        pixels = _size_of(size)
        check_arguments(form, how["fps"], pixels, how["dpi"])
        end = mechanism.simulation.end  # a duration may reach beyond it
        if duration is not None:
            end = start + copysign(duration, end)
        film_of(end, start=start, duration=duration, slow=how["slow"], fps=how["fps"])
        solution, failure = _motion(request, end, watch)
    if failure is not None:
        duration = _left(solution, start, failure)
    with (
        request.publishing(complete=failure is None) as place,
        request.computing(f"drawing {name} of", "of all frames") as watch,
    ):
        film = animate(
            solution, place.folder / name, start=start, duration=duration, size=pixels,
            plot=plot or (), reactions=reactions or (), watch=watch, **how,
        )  # fmt: skip
    (path,), note = place.files, too_fast(solution, film)
    notes = [*solution.notes, *([note] if note else [])]
    near = film if film.near is None else film.near
    swings = [pace for pace in paces(solution, film) if pace.name in solution.system.topology.free]
    parts: list[Part] = []
    if swings:
        between = ", ".join(pace.between(film) for pace in swings)
        parts.append(Unbroken(f"between frames: {between}"))
    if film.near is not None:
        span = f"from t = {number(near.start)} s to {number(near.times[-1])} s"
        parts.append(f"enlarged clearances: {span}, {near.pace}")
    report = Report(
        name=mechanism.name,
        summary=f"{film.frames} frame{'s' * (film.frames > 1)} from t = {number(film.start)} s to "
        f"{number(film.times[-1])} s, {number(film.fps)} per second, {film.pace}",
        parts=[*parts, Notes(notes), Unbroken(f"{path}, {number(film.seconds)} s")],
        data={
            **how_far(solution, failure),
            "start": film.start,
            "last": float(film.times[-1]),
            "frames": film.frames,
            "fps": film.fps,
            "slow": film.slow,
            "slow_clearances": near.slow,
            "swings": {pace.name: pace.rate for pace in swings},
            "seconds": film.seconds,
            "bytes": path.stat().st_size,
            "notes": notes,
        },
    )
    return request.report(report, place.files, failure=failure, listed=False)


def _size_of(text: str | None) -> tuple[int, int] | None:
    match = _SIZE.fullmatch(text.strip().lower()) if text is not None else None
    if text is not None and match is None:
        raise ValueError(f"--size must be WIDTHxHEIGHT in pixels, such as 800x600, found {text!r}")
    return None if match is None else (int(match[1]), int(match[2]))


def _motion(request: Request, end: float, watch: Any) -> tuple[Solution, str | None]:
    """The motion up to the end of the film, and why it ended before."""
    from linkages.plots.films.film import SHOWN

    possible = requested(System(request.mechanism), "all")
    outputs = [name for name in SHOWN if name in possible]
    given = {**request.given, "end": end, "samples": FEWEST_IN_FILM}
    try:
        return simulate(request.mechanism, outputs=outputs, watch=watch, **given), None
    except IncompleteError as error:
        return error.solution, str(error)


def _left(solution: Solution, start: float, failure: str) -> float:
    """How much of a film there is of a motion that ended early, in seconds of the motion.

    Raises ComputationError if there is nothing to show.
    """
    time = solution.data["time"].to_numpy()
    if len(time) < 2 or abs(float(time[-1])) <= abs(start):
        raise ComputationError(f"nothing to animate: {failure}", time=None)
    return abs(float(time[-1]) - start)
