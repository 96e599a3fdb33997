"""``animate``: an animation of a mechanism."""

from __future__ import annotations

import re
from math import copysign
from typing import Any

from linkages.cli.requests import Request, how_far
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.reports.report import Notes, Part, Report, Unbroken, number
from linkages.solution.series import requested
from linkages.solution.simulate import simulate
from linkages.solution.solution import IncompleteError, Solution

FEWEST_SAMPLES = 721
"""Of the motion from which the pace is found; frames are computed at their own times."""

_SIZE = re.compile(r"(\d+)\s*[x×]\s*(\d+)")


def run(
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
    given = {**request.given, "end": end, "samples": FEWEST_SAMPLES}
    try:
        return simulate(request.mechanism, outputs=outputs, watch=watch, **given), None
    except IncompleteError as error:
        return error.solution, str(error)


def _left(solution: Solution, start: float, failure: str) -> float:
    """How much of a film there is of a motion that ended early, in seconds of the motion.

    Raises
    ------
    ComputationError
        If there is nothing to show.
    """
    time = solution.data["time"].to_numpy()
    if len(time) < 2 or abs(float(time[-1])) <= abs(start):
        raise ComputationError(f"nothing to animate: {failure}", time=None)
    return abs(float(time[-1]) - start)
