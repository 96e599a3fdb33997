"""Every figure by name, drawn into given axes or into a figure of its own.

Each function returns the matplotlib axes that it drew into: more can be drawn there, and
``chart.figure.savefig("name.pdf")`` writes them. Nothing uses pyplot; in a notebook, show
``chart.figure``. Every output that has a figure over time has a function of its name.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol

import numpy as np
from matplotlib.axes import Axes

from linkages.kernel.outputs import VARIABLES
from linkages.plots.chaos import chaos_figures, diagrams, orbit_figures, period_figures
from linkages.plots.chaos.section_figures import draw_section
from linkages.plots.mechanism import drawing
from linkages.plots.mechanism import traces as paths
from linkages.plots.mechanism.plane_view import picture
from linkages.plots.mechanism.pose import pose_at
from linkages.plots.motion import clearance_orbit as orbits
from linkages.plots.motion import equilibrium_figures, overlay, time_figures, wear_figures
from linkages.plots.motion import phase_diagrams as phase
from linkages.plots.motion.compared import compared, told_apart
from linkages.plots.motion.compared import vectors as compared_vectors
from linkages.plots.style import SINGLE, panels, set_title, styled
from linkages.solution.series import (
    AT_JOINTS,
    REACTION,
    available,
)
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

    from linkages.components.mechanisms.mechanism import Mechanism

    Source = Solution | xr.Dataset
    Sources = Source | Sequence[Source] | Mapping[str, Source]

P = ParamSpec("P")

__all__: list[str] = []

USUAL = {
    "ax": "Where to draw; axes of a new figure if not given.",
    "data": "As the function named above returns it.",
    "solution": "Whose motion it is.",
    "source": "A solution, or its data.",
    "sources": (
        "Solutions or their data, several of them by what tells them apart. Those of a list are "
        "called by what their definitions differ in."
    ),
}
"""What parameters of charts are that say nothing else of themselves."""


def chart(function: Callable[P, Axes]) -> Callable[P, Axes]:
    """Register a function of this module, which draws in the style of the project.

    Lines such as ```name`: its meaning`` in its docstring become the section on parameters.
    """
    __all__.append(function.__name__)
    text, *own = re.split(r"\n(?=`\w+`: )", inspect.cleandoc(function.__doc__ or ""))
    known = USUAL | dict(entry[1:].split("`: ", 1) for entry in own)
    entries = [
        f"{name}\n    {' '.join(known[name].split())}"
        for name in inspect.signature(function).parameters
    ]
    function.__doc__ = "\n".join([text.rstrip(), "", "Parameters", "----------", *entries])
    return styled(function)


class OverTime(Protocol):
    """Draws a variable over time."""

    def __call__(self, source: Source, ax: Axes | None = None) -> Axes:
        """Into given axes, or into a figure of its own."""


def __getattr__(name: str) -> OverTime:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _of_output(name)


@cache
def _of_output(name: str) -> OverTime:
    """The function that draws an output over time."""
    draw: Any = _of_drives if name in ("drive_effort", time_figures.FORCE) else over_time

    def over(source: Source, ax: Axes | None = None) -> Axes:
        return draw(source, name, ax)

    words = VARIABLES[name].long_name if name in VARIABLES else "driving force"
    parameters = "".join(f"    {key}\n        {USUAL[key]}\n" for key in ("source", "ax"))
    over.__doc__ = (
        f"{words.capitalize()} over time.\n\n    Parameters\n    ----------\n{parameters}"
    )
    over.__name__ = over.__qualname__ = name
    return over


def _axes(ax: Axes | None) -> Axes:
    """Axes to draw a diagram into: those of a new figure if none are given."""
    return panels(1, 1, SINGLE)[1][0] if ax is None else ax


@chart
def mechanism(
    solution: Solution, ax: Axes | None = None, *, time: float = 0.0, dimensions: bool = False
) -> Axes:
    """The mechanism at the sample nearest to a time in seconds, with all names.

    `time`: In seconds.
    `dimensions`: Whether to write lengths of bars, of sides of plates and of the ground's frame,
    and to mark centres of mass.
    """
    data = _required(solution.data, "joint_position")
    index = int(np.argmin(np.abs(np.asarray(data["time"], dtype=float) - time)))
    pose = pose_at(data, solution.mechanism, index)
    ax = ax or picture(drawing.reach(pose, dimensions=dimensions))[1]
    return drawing.draw_pose(ax, pose, dimensions=dimensions)


@chart
def traces(solution: Solution, ax: Axes | None = None) -> Axes:
    """The paths of all moving joints over the mechanism where it starts."""
    data = _required(solution.data, "joint_position")
    ax = ax or picture(drawing.framed(data, solution.mechanism)[1])[1]
    return paths.draw(ax, data, solution.mechanism)


@chart
def over_time(source: Source, variable: str, ax: Axes | None = None) -> Axes:
    """Any output over time, a line for each element; of vectors their sizes.

    Of a solution what is not among its outputs is computed, but for those that follow from a whole
    motion. A series that swings faster than lines can show gets an envelope, and in a figure of its
    own a panel with a detail.

    `variable`: Name of the output.
    `ax`: Where to draw; axes of a new figure if not given: those of its first panel.
    """
    data = _at_joints(source, variable)
    heading = str(data.attrs.get("name", ""))
    if ax is None:
        return time_figures.draw_page(data, variable, heading)
    return time_figures.draw(ax, data, variable, heading)


@chart
def polar(source: Source, variable: str, name: str | None = None, ax: Axes | None = None) -> Axes:
    """The tip of a vector, such as the reaction of a joint: of the element named, or the first.

    `variable`: ``"joint_reaction"``, ``"shaking_force"`` or another output with components x and y.
    `name`: The joint; ``"ground"`` of the shaking force.
    """
    data = _at_joints(source, variable)
    if "axis" not in data[variable].dims:
        raise ValueError(f"{variable} has no direction; expected an output with components x and y")
    chosen = _chosen(name, overlay.moving_vectors(data, variable), f"element of {variable}")
    return overlay.draw_vectors(_axes(ax), overlay.tips(data, variable, chosen))


@chart
def clearance_orbit(source: Source, name: str | None = None, ax: Axes | None = None) -> Axes:
    """The way of a pin in its hole, where contact may open: of the clearance named, or the first.

    `name`: The clearance.
    """
    data = _resolved(source, orbits.SHOWN)
    chosen = _chosen(name, orbits.holes(data), "clearance whose contact may open")
    return orbits.draw_orbit(_axes(ax), data.sel(clearance=chosen), chosen)


@chart
def clearance_state(source: Source, ax: Axes | None = None) -> Axes:
    """Free flight, impacts and following contact over time, where contact may open."""
    data = _required(_resolved(source, orbits.SHOWN), "clearance_state")
    return orbits.draw_states(ax or orbits.state_page(data), data, str(data.attrs.get("name", "")))


def _of_drives(solution: Any, variable: str, ax: Axes | None) -> Axes:
    _required(solution.data, "drive_effort")
    data = _resolved(solution, ["drive_effort"])
    return over_time(time_figures.efforts(data, solution.mechanism, variable), variable, ax)


@chart
def phase_diagram(solution: Solution, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Rate against value of a free coordinate: of the one named, or the first.

    `name`: The free coordinate.
    """
    data = solution.data
    result = {c.name: c for c in phase.coordinates(data, solution.mechanism)}
    return phase.draw(_axes(ax), data, result[_chosen(name, result)], solution.mechanism.name)


@chart
def pair(source: Source, x: str, y: str, ax: Axes | None = None, *, wrap: bool = True) -> Axes:
    """One output against another, such as ``"r1.angle"`` and ``"slider9.velocity"``.

    `x`: Name of a series: an element and a quantity, or an output that has no elements.
    `y`: Another one.
    `wrap`: Whether angles are taken within half a turn either way.
    """
    return overlay.draw_pair(_axes(ax), _data(source), x, y, wrap)


@chart
def plot(
    sources: Sources, y: str | Sequence[str], against: str = "time", ax: Axes | None = None, *,
    difference: bool = False, wrap: bool = False,
) -> Axes:  # fmt: skip
    """Any series of one motion or of several, over time or over any other series.

    `y`: What to draw: names such as ``"rocker.angle"``, ``"P.velocity"`` for the magnitude of a
    vector, ``"P.x velocity"``, ``"kinetic_energy"``.
    `against`: What to draw it over, such as ``"crank.angle"``.
    `ax`: Where to draw series of one unit; axes of a new figure if not given, with a panel for each
    unit, of which those of the first are returned.
    `difference`: Whether to draw what the others differ in from the first motion.
    `wrap`: Whether angles to the right are taken within half a turn either way.
    """
    names = [y] if isinstance(y, str) else [*y]
    result = compared(_called(sources), names, against, difference=difference)
    if ax is None:
        return overlay.figure(result, wrap=wrap).axes[0]
    return overlay.draw(ax, result, wrap=wrap)


@chart
def vectors(sources: Sources, name: str, ax: Axes | None = None) -> Axes:
    """A vector of one motion or of several in a polar diagram.

    `name`: The vector, such as ``"M.reaction"``.
    """
    (result,) = compared_vectors(_called(sources), [name])
    return overlay.draw_vectors(_axes(ax), result)


@chart
def section(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Points of `linkages.poincare`: of the free coordinate named, or the first.

    `name`: The free coordinate.
    """
    return draw_section(_axes(ax), data, _free(data, name), str(data.attrs.get("name", "")))


@chart
def exponents(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """How the exponents of `linkages.lyapunov` settle over time."""
    ax = ax or chaos_figures.exponent_page(data)
    return chaos_figures.draw_exponents(ax, data, str(data.attrs.get("name", "")))


@chart
def bifurcation(
    data: xr.Dataset, name: str | None = None, ax: Axes | None = None, *, rates: bool = False
) -> Axes:
    """Points of `linkages.bifurcation` over the parameter: of the coordinate named, or the first.

    `name`: The free coordinate.
    `rates`: Whether to draw its rate instead of its value.
    """
    ax = diagrams.draw_bifurcation(_axes(ax), data, _free(data, name), rates=rates)
    diagrams.show_parameter(ax, data)
    set_title(ax, str(data.attrs.get("name", "")))
    return ax


@chart
def orbit(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Phase portrait of `linkages.orbit`, of one orbit: of the coordinate named, or the first.

    `data`: As `linkages.orbit` returns it from one start.
    `name`: Of a coordinate, such as ``rod.angle``.
    """
    known = [str(each) for each in data["coordinate"].values[: orbit_figures.coordinates_of(data)]]
    index = known.index(_chosen(name, known, "coordinate"))
    ax = orbit_figures.draw_portrait(_axes(ax), data, index)
    set_title(ax, str(data.attrs.get("name", "")))
    return ax


@chart
def equilibria(data: xr.Dataset, mechanism: Mechanism, ax: Axes | None = None) -> Axes:
    """All positions of rest of `linkages.equilibrium` over each other, stable ones in full colours.

    `mechanism`: What rests there.
    """
    if ax is None:
        return equilibrium_figures.position_figure(data, mechanism).axes[0]
    return equilibrium_figures.draw_equilibria(ax, data, mechanism)


@chart
def bode(data: xr.Dataset, number: int = 1) -> Axes:
    """Frequency response of one of `linkages.equilibrium`, magnitudes above and phases below.

    `number`: Of the equilibrium.
    """
    return equilibrium_figures.bode_figure(data, number).axes[0]


@chart
def wear(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Radial clearances of `linkages.wear` over revolutions, with bands of their errors."""
    return wear_figures.draw_size(_axes(ax), data)


@chart
def wear_depth(
    data: xr.Dataset, name: str | None = None, side: str = "bearing", ax: Axes | None = None
) -> Axes:
    """Depth around a journal or a bearing at the end of `linkages.wear`.

    `name`: The clearance; the first one if not given.
    `side`: ``journal`` or ``bearing``.
    """
    known = [str(each) for each in data["clearance"].values]
    own = data.sel(clearance=_chosen(name, known, "clearance"))
    return wear_figures.draw_depth(_axes(ax), own, side)


@chart
def wear_profile(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """A bearing that wears out of round, over the revolutions of `linkages.wear`.

    `data`: As `linkages.wear` returns it with ``feedback="profile"``.
    `name`: The clearance; the first one if not given.
    """
    if "profile" not in data:
        raise ValueError("bearings stay round here; expected wear with feedback='profile'")
    known = [str(each) for each in data["clearance"].values]
    own = data.sel(clearance=_chosen(name, known, "clearance"))
    return wear_figures.draw_profile(_axes(ax), own)


@chart
def life(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Parts of copies that are worn out, of `linkages.wear_life`, over revolutions."""
    return wear_figures.draw_life(_axes(ax), data)


@chart
def multipliers(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Multipliers of `linkages.orbit`, of one orbit, about the unit circle.

    Where one is far outside of it, magnitudes above 1 have a logarithmic scale.
    """
    return orbit_figures.draw_multipliers(_axes(ax), data)


@chart
def branches(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """Branches of `linkages.follow` over the first parameter: stable solid, unstable dashed.

    `name`: A coordinate or a rate, such as ``rod.angle``, or ``period``; the first coordinate if
    not given. It is drawn at the beginning of the first period of the drives.
    `ax`: Where to draw. A new figure if not given, with the largest multipliers below.
    """
    if ax is None:
        return orbit_figures.branch_figure(data, None, name).axes[0]
    return orbit_figures.draw_branches(ax, data, name)


@chart
def indicator_map(data: xr.Dataset, ax: Axes | None = None) -> Axes:
    """The indicator of `linkages.chaos_map`, with a colour bar."""
    if ax is None:
        return diagrams.page(data).axes[0]
    diagrams.draw_map(ax, data)
    diagrams.with_bar(ax, diagrams.indicator_label(data))
    return ax


@chart
def period_map(
    data: xr.Dataset,
    ax: Axes | None = None,
    *,
    curves: period_figures.Curves | Sequence[xr.Dataset] = (),
) -> Axes:
    """The isoperiodic plane of `linkages.chaos_map` with the indicator ``"period"``.

    `curves`: What is drawn on top: loci of `linkages.follow` over the same parameters, or label → x
    and y along a curve, shape (n,) each, in the units of the coordinates of `data`. Nan ends a part
    of a curve.
    """
    if ax is None:
        return period_figures.period_page(data, curves).axes[0]
    ax.legend(handles=period_figures.draw_periods(ax, data, curves))
    return ax


@chart
def rotation_map(data: xr.Dataset, name: str | None = None, ax: Axes | None = None) -> Axes:
    """What a free angle does at each point of `linkages.chaos_map`: the one named, or the first.

    `name`: The free angle.
    """
    chosen = _chosen(name, [str(n) for n in data["coordinate"].values])
    if ax is None:
        return diagrams.class_page(data, chosen).axes[0]
    return diagrams.draw_classes(ax, data, chosen)


__all__ += [*filter(time_figures.drawable, VARIABLES), time_figures.FORCE]


def _at_joints(source: Source, variable: str) -> xr.Dataset:
    """Data of a variable; reactions of joints with those of several bodies there."""
    data = _resolved(source, AT_JOINTS if variable == REACTION else [variable])
    return time_figures.at_pins(_required(data, variable), variable=variable)


def _resolved(source: Source, variables: Sequence[str]) -> xr.Dataset:
    """Data of some variables; of a solution at samples that show every swing."""
    if not isinstance(source, Solution):
        return _data(source)
    has = {*map(str, source.data.data_vars)}
    has |= {name for name in available(source.system) if not VARIABLES[name].whole}
    return source.dense([name for name in variables if name in has])


def _called(sources: Sources) -> Mapping[str, Source]:
    """What tells sources apart → each of them."""
    given: Any = sources
    if isinstance(sources, Solution) or hasattr(sources, "data_vars"):
        return {str(_data(given).attrs.get("name", "")): given}
    if isinstance(sources, Mapping):
        return dict(given)
    several = list(given)
    mechanisms = [one.mechanism if isinstance(one, Solution) else None for one in several]
    return dict(zip(told_apart(mechanisms), several, strict=True))


def _data(source: Source) -> xr.Dataset:
    result: Any = source
    return result if hasattr(result, "data_vars") else result.data


def _required(data: xr.Dataset, variable: str) -> xr.Dataset:
    if variable not in data or not data[variable].size:
        raise ValueError(f"the data have no {variable}, or no samples of it")
    return data


def _free(data: xr.Dataset, name: str | None) -> phase.Free:
    result = {coordinate.name: coordinate for coordinate in phase.free_coordinates(data)}
    return result[_chosen(name, result)]


def _chosen(
    name: str | None, found: Mapping[str, object] | Sequence[str], what: str = "free coordinate"
) -> str:
    if not found:
        raise ValueError(f"the data have no {what}")
    if name is not None and name not in found:
        raise ValueError(f"unknown {what} {name!r}; expected one of: {', '.join(found)}")
    return next(iter(found)) if name is None else name
