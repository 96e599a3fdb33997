"""All figures by name, and writing them to files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.mechanism import drawing, traces
from linkages.plots.motion import clearance_orbit, phase
from linkages.plots.motion.time_figures import time_figure
from linkages.plots.style import fitted, style
from linkages.reading.replacing import replaced

if TYPE_CHECKING:
    import xarray as xr

FigureFunction = Callable[["xr.Dataset", Mechanism], Figure | None]

FIGURES: Mapping[str, FigureFunction] = {
    "mechanism": drawing.figure,
    "traces": traces.figure,
    "slider_displacement": time_figure("slider_position"),
    "slider_velocity": time_figure("slider_velocity"),
    "slider_acceleration": time_figure("slider_acceleration"),
    "slider_displacement_error": time_figure("slider_position_error"),
    "slider_velocity_error": time_figure("slider_velocity_error"),
    "slider_acceleration_error": time_figure("slider_acceleration_error"),
    "drive_effort": time_figure("drive_effort"),
    "drive_force": time_figure("drive_force"),
    "load_force": time_figure("load_force"),
    "load_torque": time_figure("load_torque"),
    "clearance_force": time_figure("clearance_force"),
    "clearance_orbit": clearance_orbit.orbit_figure,
    "clearance_state": clearance_orbit.state_figure,
    "phase": phase.figure,
}

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
        Of `FIGURES`; all of them if not given.
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
    wanted = list(FIGURES) if names is None else list(names)
    _check("format", [format], _METADATA)
    _check("figure", wanted, FIGURES)
    written = []
    for name in wanted:
        over_time = FIGURES[name] not in (drawing.figure, traces.figure, phase.figure)
        chosen = dense if dense is not None and over_time else data
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

    Parameters
    ----------
    figure
        What to write.
    path
        Ends in ``.png``, ``.pdf`` or ``.svg``.
    remark
        A line above the figure, such as in what the mechanism differs from its file; the picture
        becomes higher by it.
    """
    kind = path.suffix.lstrip(".")
    # A tenth more bytes than the best compression, in a third of its time.
    options: dict[str, Any] = {"pil_kwargs": {"compress_level": 3}} if kind == "png" else {}
    with replaced(path) as temporary, style():
        if remark:
            options["bbox_inches"] = _under(figure, remark)
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
