"""Work against error: time of a run over its error, both on logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from linkages.benchmark.work_precision import Point
from linkages.plots.style import TOP, legend_above, line_style, panels, styled

HEIGHT, LEGEND = 3.4, 0.5
MARKERS = "osD^vP*X"
RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def draw(ax: Axes, points: Sequence[Point], heading: str = "") -> Axes:
    """Draw a line per method; a method is better the further it lies to the lower left.

    Parameters
    ----------
    ax
        Where to draw.
    points
        Runs; those without an error are left out, and so are those that are slower than another
        run of the same method and not more accurate.
    heading
        Title.
    """
    for index, method in enumerate(dict.fromkeys(point.method for point in points)):
        front = _front([p for p in points if p.method == method])
        ax.loglog(
            [error for error, _ in front],
            [seconds for _, seconds in front],
            marker=MARKERS[index % len(MARKERS)],
            markersize=4,
            label=method,
            **line_style(index),
        )
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(LogLocator(numticks=9))
        axis.set_major_formatter(
            lambda value, _: f"10{str(round(math.log10(value))).translate(RAISED)}"
        )
        axis.set_minor_formatter(NullFormatter())
    ax.set_xlabel("error at the end [rad or m]")
    ax.set_ylabel("time of a run [s]")
    ax.legend(**legend_above(heading), ncols=4)
    return ax


def _front(points: Sequence[Point]) -> list[tuple[float, float]]:
    """Errors and seconds of the runs that no other run beats in both, least accurate first."""
    runs = sorted((p.seconds, p.error) for p in points if p.error)
    front: list[tuple[float, float]] = []
    for seconds, error in runs:
        if not front or error < front[-1][0]:
            front.append((error, seconds))
    return front


@styled
def figure(points: Sequence[Point], heading: str = "") -> Figure:
    """The figure of `draw`, with room for its legend."""
    found, (ax,) = panels(1, 1, HEIGHT, TOP + LEGEND)
    draw(ax, points, heading)
    return found
