"""``animate``: a moving picture of a mechanism."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import ceil, copysign
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from linkages.cli.loading import mechanism_from, require_folder
from linkages.cli.published import published
from linkages.cli.terminal import console, number, print_json, print_notes, progress
from linkages.errors import ComputationError, InputError, Problem
from linkages.kernel.system import System
from linkages.solution.requests import requested
from linkages.solution.simulate import simulate
from linkages.solution.solution import IncompleteError, Solution

if TYPE_CHECKING:
    from linkages.components.mechanism import Mechanism
    from linkages.plots.film import Film

SHOWN = ("joint_position", "bar_angle", "slider_position", "clearance_force", "clearance_angle")
"""What a picture needs, and what says how fast it moves; nothing else is computed."""

SMOOTH = 720
"""Samples that a trace has at least: more than frames, for it is one line."""

MOST_SAMPLES = 200_000
"""More are computed only if frames need them."""

_SIZE = re.compile(r"(\d+)\s*[x×]\s*(\d+)")


@dataclass(frozen=True, kw_only=True)
class Options:
    """How to animate, as on the command line.

    Parameters
    ----------
    format
        ``"gif"`` or ``"mp4"``.
    start, duration, slow, fps, dpi
        As `linkages.animate` takes them.
    size
        Width and height in pixels, such as ``"800x600"``.
    """

    format: str
    start: float
    duration: float | None
    slow: float | None
    fps: float
    size: str | None
    dpi: float


def run_animate(
    file: str, assignments: Sequence[str], out: Path | None, json: bool, options: Options
) -> int:
    """Simulate a file and animate the motion; returns the exit code."""
    from linkages.plots.animation import animate, check_arguments
    from linkages.plots.pace import too_fast

    mechanism = mechanism_from(file, assignments)
    folder = Path("results") / Path(file).stem if out is None else out
    require_folder(folder)
    with _refusing(file):
        size = _size_of(options.size)
        check_arguments(options.format, options.fps, size, options.dpi)
        film = _film_of(mechanism, options)
    with progress(f"simulating {escape(mechanism.name)}", shown=not json) as watch, _refusing(file):
        solution, failure = _motion(mechanism, film, watch)
    if failure is not None:
        film = _cut(film, solution, failure)
    name = f"animation.{options.format}"
    with (
        published("animate", folder, mechanism, vars(options), complete=failure is None) as run,
        progress(f"drawing {name}", not json, "of all frames") as watch,
        _refusing(file),
    ):
        animate(
            solution, run.folder / name, start=film.start, duration=film.frames * abs(film.step),
            slow=film.slow, fps=film.fps, size=size, dpi=options.dpi, watch=watch,
        )  # fmt: skip
    note = too_fast(solution, film)
    notes = [*solution.notes, *([note] if note else [])]
    _report(solution, film, run.files[0], notes, failure, json)
    return 0 if failure is None else 1


@contextmanager
def _refusing(file: str) -> Iterator[None]:
    """Arguments that make no sense are refused by a ValueError: that is wrong input."""
    try:
        yield
    except ValueError as error:
        raise InputError(file, [Problem(message=str(error))]) from None


def _size_of(text: str | None) -> tuple[int, int] | None:
    match = _SIZE.fullmatch(text.strip().lower()) if text is not None else None
    if text is not None and match is None:
        raise ValueError(f"--size must be WIDTHxHEIGHT in pixels, such as 800x600, found {text!r}")
    return None if match is None else (int(match[1]), int(match[2]))


def _film_of(mechanism: Mechanism, options: Options) -> Film:
    """What is to be shown; a duration may reach beyond the end that the file says."""
    from linkages.plots.film import film_of

    end = mechanism.simulation.end
    if options.duration is not None:
        end = options.start + copysign(options.duration, end)
    return film_of(
        end, start=options.start, duration=options.duration, slow=options.slow, fps=options.fps
    )


def _motion(mechanism: Mechanism, film: Film, watch: Any) -> tuple[Solution, str | None]:
    """The motion up to the end of the film, and why it ended before.

    Every frame falls on a sample if the film starts at a multiple of its step, as it mostly does.
    """
    last = abs(film.start / film.step) + film.frames
    parts = max(1, min(ceil(SMOOTH / film.frames), int(MOST_SAMPLES / last)))
    possible = requested(System(mechanism), "all")
    outputs = [name for name in SHOWN if name in possible]
    end, samples = film.start + film.frames * film.step, round(last * parts) + 1
    try:
        return simulate(
            mechanism, end=end, samples=max(2, samples), outputs=outputs, watch=watch
        ), None  # fmt: skip
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


def _report(
    solution: Solution,
    film: Film,
    path: Path,
    notes: Sequence[str],
    failure: str | None,
    json: bool,
) -> None:
    if json:
        print_json(_content(solution, film, path, notes, failure))
        return
    screen = console()
    last = number(float(film.times[-1]))
    frames = f"{film.frames} frame{'s' * (film.frames > 1)}"
    screen.print(
        f"[bold]{escape(solution.mechanism.name)}[/bold]: {frames} from t = "
        f"{number(film.start)} s to {last} s, {number(film.fps)} per second, {film.pace}"
    )
    print_notes(notes, screen)
    screen.print(f"{path}, {number(film.seconds)} s", markup=False, soft_wrap=True)
    if failure is not None:
        print(f"stopped {failure}", file=sys.stderr)


def _content(
    solution: Solution, film: Film, path: Path, notes: Sequence[str], failure: str | None
) -> dict[str, Any]:
    return {
        "mechanism": solution.mechanism.name,
        "completed": failure is None,
        "stopped": None
        if failure is None
        else {"time": solution.motion.stop_time, "reason": failure},
        "start": film.start,
        "last": float(film.times[-1]),
        "frames": film.frames,
        "fps": film.fps,
        "slow": film.slow,
        "seconds": film.seconds,
        "bytes": path.stat().st_size,
        "notes": list(notes),
        "files": [str(path)],
    }
