"""Figures of a motion by name, and writing figures to files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.mechanism import drawing, traces
from linkages.plots.motion import clearance_orbit
from linkages.plots.motion import phase_diagrams as phase
from linkages.plots.motion.compared import resolved
from linkages.plots.motion.time_figures import FORCE, POLAR, drawable, polar_of, time_figure
from linkages.plots.style import TEXT, filled, note_missing_glyphs, style
from linkages.reading.output_files import replaced
from linkages.solution.series import AT_JOINTS, REACTION, available
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

FigureFunction = Callable[["xr.Dataset", Mechanism], Figure | None]


class Drawn(NamedTuple):
    """A figure of a motion: what makes it, and the outputs over time that it shows."""

    make: FigureFunction
    outputs: tuple[str, ...]


def _over_time(name: str, *outputs: str) -> Drawn:
    return Drawn(time_figure(name), outputs or (name,))


DRAWN: Mapping[str, Drawn] = {
    "mechanism": Drawn(drawing.figure, ()),
    "traces": Drawn(traces.figure, ()),
    **{name: _over_time(name) for name in VARIABLES if drawable(name)},
    FORCE: _over_time(FORCE, "drive_effort"),
    REACTION: _over_time(REACTION, *AT_JOINTS),
    "clearance_orbit": Drawn(clearance_orbit.orbit_figure, clearance_orbit.SHOWN),
    "clearance_state": Drawn(clearance_orbit.state_figure, clearance_orbit.SHOWN),
    "phase": Drawn(phase.figure, phase.OUTPUTS),
    **{
        f"{name}_polar": Drawn(polar_of(name), AT_JOINTS if name == REACTION else (name,))
        for name in POLAR
    },
}
"""Every figure of a motion; charts, files and reports take them from here."""

FIGURES: Mapping[str, FigureFunction] = {name: drawn.make for name, drawn in DRAWN.items()}

OF_ALL = (
    "mechanism", "traces", "slider_position", "slider_velocity", "slider_acceleration",
    "slider_position_error", "slider_velocity_error", "slider_acceleration_error",
    "drive_effort", "drive_force", "rotary_actuator_angle", "rotary_actuator_speed",
    "linear_actuator_position", "linear_actuator_velocity", "actuator_power",
    "load_force", "load_torque", "clearance_force", "clearance_orbit", "clearance_state", "phase",
)  # fmt: skip
"""Figures of every motion that has something to show in them."""

PICTURES = tuple(name for name, drawn in DRAWN.items() if not drawn.outputs)
"""Figures of the outputs that a solution has, at its own samples."""

WITHOUT_SLIDERS = ("bar_angle", "bar_speed", "transmission_angle")
"""Figures besides, where no slider tells how the mechanism moves."""


def figures_of(solution: Solution, asked: Sequence[str] | str | None = None) -> list[str]:
    """Names of the figures that are worth drawing: few, or those of outputs that were asked for."""
    if asked is not None and asked != "all":
        own = {name for output in asked for name in (output, f"{output}_polar")} | {*PICTURES}
        own |= {name for name in OF_ALL if {*asked} & {*DRAWN[name].outputs}}
        return [name for name in FIGURES if name in own]
    chosen = {*OF_ALL}
    if not any(body.kind == "slider" for body in solution.mechanism.bodies.values()):
        chosen |= {*WITHOUT_SLIDERS} & {*available(solution.system)}
    return [name for name in FIGURES if name in chosen]


def dense_data(solution: Solution, names: Iterable[str]) -> xr.Dataset:
    """What figures over time draw, at samples that show all that the motion does."""
    drawn = list(names)
    needed = dict.fromkeys(output for name in drawn for output in DRAWN[name].outputs)
    known = {*map(str, solution.data.data_vars), *drawn}
    return resolved(solution, [name for name in needed if name in known])


MARGIN = 0.1  # inches beside a remark above a figure

# Dates and versions would make files of the same figure differ.
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": None},
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Creator": None, "Date": None},
}


def save_figures(
    data: xr.Dataset,
    mechanism: Mechanism,
    folder: Path,
    format: str = "png",  # noqa: A002
    names: Iterable[str] | None = None,
    dense: xr.Dataset | None = None,
    remark: str = "",
) -> list[Path]:
    """Write the figures that the data allow, each whole or not at all; returns the files.

    `names`: of `FIGURES`; `OF_ALL` if not given. `dense`: data for curves over time, if others than
    `data`. The same data give the same bytes; ValueError for an unknown format or name.
    """
    wanted = list(OF_ALL) if names is None else list(names)
    _check("format", [format], _METADATA)
    _check("figure", wanted, FIGURES)
    written = []
    for name in wanted:
        chosen = data if dense is None or name in PICTURES else dense
        figure = FIGURES[name](chosen, mechanism)
        if figure is not None:
            written.append(write_figure(figure, folder / f"{name}.{format}", remark))
    return written


def _check(what: str, found: list[str], known: Iterable[str]) -> None:
    unknown = [name for name in found if name not in known]
    if unknown:
        raise ValueError(f"unknown {what} {unknown[0]!r}; expected one of: {', '.join(known)}")


def write_figure(figure: Figure, path: Path, remark: str = "") -> Path:
    """Write one figure; a file of that name is replaced only when the new one is complete.

    `figure`: what to write.
    `path`: ends in ``.png``, ``.pdf`` or ``.svg``.
    `remark`: a text above the figure, such as in what the mechanism differs from its file; the
    picture becomes higher by it.
    """
    kind = path.suffix.lstrip(".")
    # A tenth more bytes than the best compression, in a third of its time.
    options: dict[str, Any] = {"pil_kwargs": {"compress_level": 3}} if kind == "png" else {}
    with replaced(path) as temporary, style():
        if remark:
            options["bbox_inches"] = _under(figure, remark)
        note_missing_glyphs(figure)
        figure.savefig(temporary, format=kind, metadata=_METADATA[kind], **options)
    return path


def _under(figure: Figure, remark: str) -> Bbox:
    """Write a text above a figure, and return the box of both in inches."""
    width, height = figure.get_size_inches()
    text = filled(remark, width - 2 * MARGIN)
    y = 1.0 + 0.5 * MARGIN / height
    figure.text(MARGIN / width, y, text, color="#5A5A5A").set_in_layout(False)
    lines = 1 + text.count("\n")
    return Bbox.from_bounds(0.0, 0.0, width, height + MARGIN + lines * 1.2 * TEXT / 72.0)
