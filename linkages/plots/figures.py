"""All figures by name, and writing them to files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.plots.mechanism import drawing, traces
from linkages.plots.motion import clearance_orbit
from linkages.plots.motion import phase_diagrams as phase
from linkages.plots.motion.phase_diagrams import POLAR, polar_figure
from linkages.plots.motion.time_figures import FORCE, drawable, time_figure
from linkages.plots.style import fitted, note_missing_glyphs, style
from linkages.reading.output_files import replaced
from linkages.solution.series import AT_JOINTS, REACTION, available
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

FigureFunction = Callable[["xr.Dataset", Mechanism], Figure | None]

FIGURES: Mapping[str, FigureFunction] = {
    "mechanism": drawing.figure,
    "traces": traces.figure,
    **{name: time_figure(name) for name in VARIABLES if drawable(name)},
    FORCE: time_figure(FORCE),
    "clearance_orbit": clearance_orbit.orbit_figure,
    "clearance_state": clearance_orbit.state_figure,
    "phase": phase.figure,
    **{f"{name}_polar": polar_figure(name) for name in POLAR},
}

OF_ALL = (
    "mechanism",
    "traces",
    "slider_position",
    "slider_velocity",
    "slider_acceleration",
    "slider_position_error",
    "slider_velocity_error",
    "slider_acceleration_error",
    "drive_effort",
    "drive_force",
    "rotary_actuator_angle",
    "rotary_actuator_speed",
    "linear_actuator_position",
    "linear_actuator_velocity",
    "actuator_power",
    "load_force",
    "load_torque",
    "clearance_force",
    "clearance_orbit",
    "clearance_state",
    "phase",
)
"""Figures of every motion that has something to show in them."""

PICTURES = ("mechanism", "traces")
"""Figures of the outputs that a solution has, at its own samples."""

WITHOUT_SLIDERS = ("bar_angle", "bar_speed", "transmission_angle")
"""Figures besides, where no slider tells how the mechanism moves."""


def figures_of(solution: Solution, asked: Sequence[str] | str | None = None) -> list[str]:
    """Names of the figures that are worth drawing: few, or those of outputs that were asked for."""
    if asked is not None and asked != "all":
        own = [name for output in asked for name in (output, f"{output}_polar")]
        others = [n for n in OF_ALL if {*asked} & {*FIGURE_OUTPUTS.get(n, ())} or n in PICTURES]
        return [name for name in FIGURES if name in {*own, *others}]
    chosen = {*OF_ALL}
    if not any(body.kind == "slider" for body in solution.mechanism.bodies.values()):
        chosen |= {*WITHOUT_SLIDERS} & {*available(solution.system)}
    return [name for name in FIGURES if name in chosen]


def dense_data(solution: Solution, names: Iterable[str]) -> xr.Dataset:
    """What figures over time draw, at samples that show all that the motion does."""
    drawn = list(names)
    wanted = [FIGURE_OUTPUTS.get(name, (name.removesuffix("_polar"),)) for name in drawn]
    needed = dict.fromkeys(name for group in wanted for name in group)
    others = {name for name in available(solution.system) if not VARIABLES[name].whole}
    have = {*map(str, solution.data.data_vars)} | others & {*drawn}
    return solution.dense([name for name in needed if name in have])


FIGURE_OUTPUTS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(PICTURES, ()),
    "phase": phase.OUTPUTS,
    FORCE: ("drive_effort",),
    REACTION: AT_JOINTS,
    f"{REACTION}_polar": AT_JOINTS,
    "clearance_orbit": clearance_orbit.SHOWN,
    "clearance_state": clearance_orbit.SHOWN,
}
"""Figure → outputs that it shows over time, of those that are not called like it."""

LINE, MARGIN = 0.21, 0.1
"""Height of a remark above a figure, and what is left free beside it, in inches."""

REMARK = "#5A5A5A"

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
    """Write the figures that the data allow, each whole or not at all.

    Parameters
    ----------
    data
        A solution's data, cut short or not.
    mechanism
        Whose data they are.
    folder
        Made if it does not exist.
    format
        ``"png"``, ``"pdf"`` or ``"svg"``.
    names
        Of `FIGURES`; `OF_ALL` if not given.
    dense
        Data for curves over time, if others than `data`.
    remark
        As `write_figure` takes it.

    Returns
    -------
    list of Path
        The files written, in the order of `names`. The same data give the same bytes.

    Raises
    ------
    ValueError
        For an unknown format or name; nothing is written then.
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
    `remark`: a line above the figure, such as in what the mechanism differs from its file; the
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
    """Write a line above a figure, and return the box of both in inches."""
    width, height = figure.get_size_inches()
    left = min((ax.get_position().x0 for ax in figure.axes), default=0.0)
    room = width * (1.0 - left) - MARGIN
    place = (left, 1.0 + MARGIN / 2.0 / height)
    figure.text(*place, fitted(remark, room, 8.0), fontsize=8, color=REMARK)
    return Bbox.from_bounds(0.0, 0.0, width, height + LINE)
