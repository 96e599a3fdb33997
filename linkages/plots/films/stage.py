"""Frames of an animation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import takewhile
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.films.film import Film
from linkages.plots.films.film_layout import MARGIN, PageLayout, page
from linkages.plots.films.force_arrows import LONGEST, Push, Pushes
from linkages.plots.films.insets import Clock, Enlarged, Inset, decimals, enlarged, moment
from linkages.plots.mechanism import drawing
from linkages.plots.mechanism.annotations import Labels
from linkages.plots.mechanism.drawing import note_gears
from linkages.plots.mechanism.inked_shapes import Inked, points_per_unit
from linkages.plots.mechanism.plane_view import Box, frame, gravity_arrow
from linkages.plots.mechanism.pose import Pose, Poses
from linkages.plots.mechanism.shapes import PIN, Shape, stands_still
from linkages.plots.mechanism.traces import COUPLER, LED, led_joints, moving_joints
from linkages.plots.style import (
    BLACK,
    CLEARANCE,
    axis_scale,
    figure_of,
    line_style,
    scale_of,
    series_words,
    set_title,
    style,
)

if TYPE_CHECKING:
    import xarray as xr

ROOM = 0.08  # of the height, above and below a curve


class Strip:
    """A curve over the time of a film.

    `ax`: where to draw.
    `name`, `series`: of the curve, and its values over ``time``, in SI units.
    `film`: which part is shown.
    """

    def __init__(self, ax: Axes, name: str, series: xr.DataArray, film: Film) -> None:
        time, values = np.asarray(series["time"], float), np.asarray(series, float)
        scale = axis_scale(values, str(series.attrs.get("units", "")))
        self._scale = scale_of(film.times, "s")
        ax.plot(time * self._scale.factor, values * scale.factor, color=line_style(0)["color"])
        ends = np.sort([film.start, film.start + film.frames * film.step]) * self._scale.factor
        ax.set_xlim(*ends)
        ax.margins(y=ROOM)
        ax.set_xlabel(self._scale.label("time"))
        ax.set_ylabel(f"[{scale.units}]" if scale.units else "")
        ax.set_title(series_words(name, str(series.attrs.get("units", ""))))
        self._line = ax.axvline(ends[0], color=CLEARANCE, linewidth=1.2)
        self._line.set_animated(True)

    @property
    def cursor(self) -> Line2D:
        """What moves."""
        return self._line

    def show(self, time: float) -> None:
        """Put the cursor at a time in seconds."""
        x = float(time) * self._scale.factor
        self._line.set_xdata([x, x])


def framed(data: xr.Dataset, mechanism: Mechanism) -> tuple[Poses, Box]:
    """Positions at all samples in pictures of one size, and the part of the plane they sweep."""
    if "joint_position" not in data or not data.sizes["time"]:
        raise ValueError("nothing to animate: the data have no samples of joint_position")
    return drawing.framed(data, mechanism)


def parts(first: Pose, scale: float) -> tuple[list[Shape], list[Shape]]:
    """Shapes of a drawing that stay where they are, and those that move or lie above one that does.

    `first`: the first position, in metres.
    """
    shapes, ground = drawing.under(first, scale), first.mechanism.ground
    still = list(takewhile(lambda shape: stands_still(shape, ground), shapes))
    return still, shapes[len(still) :]


Frame = NDArray[np.uint8]

KEY = (50.0, -21.0)
"""Where the scales of arrows are explained: points from the lower left of the main picture."""

LOOKS = 12  # positions of the mechanism that names keep clear of
AHEAD = 0.45  # opacity of the part of a trace that is still to come


_FRAME = 3.0  # pixels around axes: half a line, and one that sizes that must be even may cut off


class Stage:
    """Draws any sample of a solution as a picture.

    `data`: the samples of the film; with ``joint_position``.
    `mechanism`: what moves.
    `film`: for the times to be written.
    `size`: width and height in pixels; chosen by the mechanism if not given.
    `dpi`: pixels per inch; if not given, texts and symbols grow with the size.
    `names`: whether joints have their names beside them.
    `strips`: names of series, and the series, drawn over time below.
    `pushes`: loads and reactions to draw as long as they are at the time; arrows of loads that rest
    in their symbols are left out then.
    `bare`: whether the mechanism and its clearances are shown alone, without axes and texts.
    Raises ValueError for data without joints, or a size too small for the picture.
    """

    def __init__(
        self, data: xr.Dataset, mechanism: Mechanism, film: Film,
        size: tuple[int, int] | None = None, dpi: float | None = None, *, names: bool = False,
        strips: Sequence[tuple[str, xr.DataArray]] = (), pushes: Sequence[Push] = (),
        bare: bool = False,
    ) -> None:  # fmt: skip
        self._moving, box = framed(data, mechanism)
        self._time = np.asarray(data["time"], dtype=float)
        self._decimals = decimals(abs(film.step))
        result = enlarged(data, mechanism)
        with style():
            layout, dpi = page(box, len(result), len(strips), size, dpi)
            self._canvas = FigureCanvasAgg(Figure(figsize=layout.size, dpi=dpi))
            self._build(self._canvas.figure, layout, box, data, film, result, pushes, names)
            self._strips = [
                Strip(self._canvas.figure.add_axes(place), name, series, film)
                for place, (name, series) in zip(layout.strips, strips, strict=True)
            ]
            self._cut = self._bared() if bare else (slice(None), slice(None))
            self._canvas.draw()
            self._background: Any = self._canvas.copy_from_bbox(self._canvas.figure.bbox)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels, both even: videos need that."""
        width, height = self._canvas.get_width_height()
        rows, columns = self._cut
        wide, high = len(range(width)[columns]), len(range(height)[rows])
        return wide - wide % 2, high - high % 2

    def picture(self, index: int, near: int | None = None) -> Frame:
        """The picture of one sample, shape (height, width, 4); valid until the next one.

        Enlarged clearances show the sample `near`, if that is given.
        """
        with style():
            self._canvas.restore_region(self._background)
            for artist in self._show(index, index if near is None else near):
                artist.draw(self._canvas.get_renderer())
        width, height = self.size
        return np.asarray(self._canvas.buffer_rgba())[self._cut][:height, :width]

    def _bared(self) -> tuple[slice, slice]:
        """Hide axes and texts; rows and columns of pixels in which anything is left."""
        figure = self._canvas.figure
        self._main.set_axis_off()
        for artist in figure.findobj():
            if isinstance(artist, Text) or not artist.get_clip_on():  # what explains scales
                artist.set_visible(False)
        boxes = [ax.bbox for ax in figure.axes]
        left, low, right, high = Bbox.union(boxes).padded(_FRAME).extents
        height = self._canvas.get_width_height()[1]
        return slice(height - round(high), height - round(low)), slice(round(left), round(right))

    def _build(
        self, figure: Figure, layout: PageLayout, box: Box, data: xr.Dataset, film: Film,
        found: list[Enlarged], pushes: Sequence[Push], names: bool,
    ) -> None:  # fmt: skip
        """The background, and the artists that move in every picture."""
        mechanism = self._moving.mechanism
        ax = figure.add_axes(layout.main)
        self._main = ax
        scale = frame(ax, box, mechanism, max(MARGIN, LONGEST / 72.0) if pushes else MARGIN)
        self._factor = scale.factor
        first = self._moving.at(0)
        still, moving = parts(first, points_per_unit(ax) * scale.factor)
        if pushes:
            moving = [shape for shape in moving if shape.look.role != "load"]
        Inked(ax, still, first.scaled(self._factor))
        note_gears(ax, first)
        paths = {n: p * self._factor for n, p in moving_joints(data, mechanism).items()}
        self._draw_traces(ax, paths)
        self._write_still(ax, film)
        self._layer = _layer_over(ax)
        self._drawing = Inked(self._layer, moving, first.scaled(self._factor))
        self._pushes = Pushes(self._layer, pushes, film.samples(self._time))
        self._pushes.draw_key(ax, *KEY)
        self._write_names(ax, paths, list(first.positions) if names else [])
        width = np.ptp(ax.get_xlim()) / self._factor  # of the main picture, in metres
        slow = film.near
        near = None if slow is None else Clock(self._time, slow.pace, slow.step)
        samples = (film if slow is None else slow).samples(self._time)
        self._insets = [
            Inset(panel, own, float(width * panel.bbox.width / ax.bbox.width), samples, near)
            for own, panel in zip(found, map(figure.add_axes, layout.insets), strict=True)
        ]

    def _draw_traces(self, ax: Axes, paths: Mapping[str, NDArray[np.float64]]) -> None:
        """All of every trace in pale; what has been run through is drawn later."""
        led = led_joints(self._moving.mechanism)
        self._runs = []
        for number, (name, path) in enumerate(paths.items()):
            width = LED if name in led else COUPLER
            look = {"color": line_style(number)["color"], "linewidth": width}
            ax.plot(*path.T, alpha=AHEAD, zorder=1.2, **look)
            (line,) = ax.plot([], [], zorder=1.3, **look)
            line.set_animated(True)
            self._runs.append((line, path))

    def _write_names(
        self, ax: Axes, paths: Mapping[str, NDArray[np.float64]], joints: Iterable[str]
    ) -> None:
        """Names of traces, or of joints in the colours of these, clear of all that moves."""
        looks = np.unique(np.linspace(0, len(self._time) - 1, LOOKS).round().astype(int)).tolist()
        poses = [self._moving.at(index).scaled(self._factor) for index in looks]
        labels = Labels(ax, len(looks))
        for look, (index, pose) in enumerate(zip(looks, poses, strict=True)):
            self._drawing.show(pose)
            self._pushes.show(pose, index)
            labels.add([*self._drawing.artists, *self._pushes.artists], look)
        traces = {
            name: (path[np.isfinite(path).all(axis=1)], line.get_color())
            for (line, path), name in zip(self._runs, paths, strict=True)
        }
        named = [joint for joint in joints if "." not in joint]  # as points beside a pin are called
        for name, (finite, colour) in traces.items():
            if len(finite) and name not in named:
                labels.beside_curve(name, finite, color=colour, weight="bold")
        self._names = {
            joint: labels.beside_point(
                joint, [pose.positions.get(joint, (np.nan, np.nan)) for pose in poses], PIN + 2.0,
                color=traces[joint][1] if joint in traces else BLACK, weight="bold", animated=True,
            )
            for joint in named
        }  # fmt: skip
        labels.improve()

    def _write_still(self, ax: Axes, film: Film) -> None:
        """Name, pace and gravity; the time stands where the eye looks for it."""
        mechanism = self._moving.mechanism
        set_title(ax, mechanism.name, "t = 0.000000 s")
        arrow = gravity_arrow(mechanism)
        below: dict[str, Any] = {"fontsize": 8, "color": "0.35", "va": "top"}
        below["transform"] = ax.transAxes
        pace = film.pace if film.near is None else f"mechanism {film.pace}"
        offset = -0.21 / (ax.bbox.height / ax.figure.dpi)
        ax.text(1.0, offset, pace, ha="right", **below)
        ax.text(0.0, offset, f"gravity {arrow}" if arrow else "", ha="left", **below)
        self._clock = ax.set_title("", loc="right", color=BLACK)
        self._clock.set_animated(True)

    def _show(self, index: int, near: int) -> list[Artist]:
        """Everything that moves, as it is at one sample, in the order of drawing."""
        for line, path in self._runs:
            line.set_data(*path[: index + 1].T)
        pose = self._moving.at(index).scaled(self._factor)
        self._drawing.show(pose)
        self._pushes.show(pose, index)
        for joint in self._names.keys() & pose.positions.keys():
            self._names[joint].xy = pose.positions[joint]
        self._clock.set_text(moment(self._time[index], self._decimals))
        for inset in self._insets:
            inset.show(near)
        for strip in self._strips:
            strip.show(self._time[index])
        return [
            *(line for line, _ in self._runs),
            *self._drawing.artists,
            *self._pushes.artists,
            *(name for joint, name in self._names.items() if joint in pose.positions),
            self._clock,
            *(artist for inset in self._insets for artist in inset.artists),
            *(strip.cursor for strip in self._strips),
        ]


def _layer_over(ax: Axes) -> Axes:
    """Empty axes with the same place and limits, which draw nothing by themselves."""
    layer = figure_of(ax).add_axes(ax.get_position().bounds)
    layer.autoscale(False)
    layer.set(xlim=ax.get_xlim(), ylim=ax.get_ylim())
    layer.set_axis_off()
    layer.set_visible(False)
    return layer
