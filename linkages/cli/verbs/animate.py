"""``animate``: a moving picture of a mechanism."""

from __future__ import annotations

import re
from math import ceil, copysign
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import Request
from linkages.cli.simulated import how_far
from linkages.cli.terminal import number, print_notes
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.solution.simulate import simulate
from linkages.solution.solution import IncompleteError, Solution
from linkages.solution.values.requests import requested

if TYPE_CHECKING:
    from linkages.plots.films.film import Film

SHOWN = ("joint_position", "bar_angle", "slider_position", "clearance_force", "clearance_angle")
"""What a picture needs, and what says how fast it moves; nothing else is computed."""

SMOOTH = 720
"""Samples that a trace has at least: more than frames, for it is one line."""

MOST_SAMPLES = 200_000
"""More are computed only if frames need them."""

_SIZE = re.compile(r"(\d+)\s*[x×]\s*(\d+)")


def run(
    request: Request,
    form: str,
    start: float,
    duration: float | None,
    slow: float | None,
    fps: float,
    size: str | None,
    dpi: float,
) -> int:
    """Simulate a file and animate the motion, as `linkages.animate` does; returns the exit code."""
    from linkages.plots.films.animation import animate, check_arguments
    from linkages.plots.films.film import film_of
    from linkages.plots.films.pace import too_fast

    mechanism, name = request.mechanism, f"animation.{form}"
    with request.computing("simulating") as watch:
        pixels = _size_of(size)
        check_arguments(form, fps, pixels, dpi)
        end = mechanism.simulation.end  # a duration may reach beyond it
        if duration is not None:
            end = start + copysign(duration, end)
        film = film_of(end, start=start, duration=duration, slow=slow, fps=fps)
        solution, failure = _motion(request, film, watch)
    if failure is not None:
        film = _cut(film, solution, failure)
    with (
        request.publishing(complete=failure is None) as place,
        request.computing(f"drawing {name} of", "of all frames") as watch,
    ):
        animate(
            solution, place.folder / name, start=film.start, duration=film.frames * abs(film.step),
            slow=film.slow, fps=film.fps, size=pixels, dpi=dpi, watch=watch,
        )  # fmt: skip
    note = too_fast(solution, film)
    notes = [*solution.notes, *([note] if note else [])]

    def show(screen: Console) -> None:
        frames = f"{film.frames} frame{'s' * (film.frames > 1)}"
        screen.print(
            f"[bold]{escape(mechanism.name)}[/bold]: {frames} from t = {number(film.start)} s to "
            f"{number(film.times[-1])} s, {number(film.fps)} per second, {film.pace}"
        )
        print_notes(notes, screen)
        screen.print(f"{path}, {number(film.seconds)} s", markup=False, soft_wrap=True)

    (path,) = place.files
    content = {
        **how_far(solution, failure),
        "start": film.start,
        "last": float(film.times[-1]),
        "frames": film.frames,
        "fps": film.fps,
        "slow": film.slow,
        "seconds": film.seconds,
        "bytes": path.stat().st_size,
        "notes": notes,
    }
    return request.report(content, place.files, show, failure=failure, listed=False)


def _size_of(text: str | None) -> tuple[int, int] | None:
    match = _SIZE.fullmatch(text.strip().lower()) if text is not None else None
    if text is not None and match is None:
        raise ValueError(f"--size must be WIDTHxHEIGHT in pixels, such as 800x600, found {text!r}")
    return None if match is None else (int(match[1]), int(match[2]))


def _motion(request: Request, film: Film, watch: Any) -> tuple[Solution, str | None]:
    """The motion up to the end of the film, and why it ended before.

    Every frame falls on a sample if the film starts at a multiple of its step, as it mostly does.
    """
    last = abs(film.start / film.step) + film.frames
    parts = max(1, min(ceil(SMOOTH / film.frames), int(MOST_SAMPLES / last)))
    possible = requested(System(request.mechanism), "all")
    outputs = [name for name in SHOWN if name in possible]
    given = {
        **request.given,
        "end": film.start + film.frames * film.step,
        "samples": max(2, round(last * parts) + 1),
    }
    try:
        return simulate(request.mechanism, outputs=outputs, watch=watch, **given), None
    except IncompleteError as error:
        return error.solution, str(error)


def _cut(film: Film, solution: Solution, failure: str) -> Film:
    """The part of a film that there are samples of.

    Raises
    ------
    ComputationError
        If there is nothing to show.
    """
    from dataclasses import replace

    time = solution.data["time"].to_numpy()
    shown = abs(float(time[-1]) - film.start) if len(time) > 1 else 0.0
    if len(time) < 2 or abs(float(time[-1])) <= abs(film.start):
        raise ComputationError(f"nothing to animate: {failure}", time=None)
    return replace(film, frames=max(1, int(shown / abs(film.step))))
