"""Every figure by name, drawn into given axes or into a figure of its own.

Each function returns the matplotlib axes that it drew into: more can be drawn there, and
``chart.figure.savefig("name.pdf")`` writes them. Nothing uses pyplot; in a notebook, show
``chart.figure``. Every output that has a figure over time has a function of its name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from matplotlib.axes import Axes

from linkages.kernel.outputs import VARIABLES
from linkages.plots.chaos.chaos_figures import exponents as exponents
from linkages.plots.chaos.chaos_figures import section as section
from linkages.plots.chaos.diagrams import bifurcation as bifurcation
from linkages.plots.chaos.diagrams import indicator_map as indicator_map
from linkages.plots.chaos.diagrams import period_map as period_map
from linkages.plots.chaos.diagrams import rotation_map as rotation_map
from linkages.plots.chaos.orbit_figures import branches as branches
from linkages.plots.chaos.orbit_figures import multipliers as multipliers
from linkages.plots.chaos.orbit_figures import orbit as orbit
from linkages.plots.mechanism import drawing
from linkages.plots.mechanism import traces as paths
from linkages.plots.mechanism.plane_view import picture
from linkages.plots.mechanism.pose import pose_at
from linkages.plots.motion import overlay, time_figures
from linkages.plots.motion.clearance_orbit import clearance_orbit as clearance_orbit
from linkages.plots.motion.clearance_orbit import clearance_state as clearance_state
from linkages.plots.motion.compared import compared, data_of, resolved, told_apart, with_samples
from linkages.plots.motion.compared import vectors as compared_vectors
from linkages.plots.motion.equilibrium_figures import bode as bode
from linkages.plots.motion.equilibrium_figures import equilibria as equilibria
from linkages.plots.motion.overlay import pair as pair
from linkages.plots.motion.phase_diagrams import phase_diagram as phase_diagram
from linkages.plots.motion.wear_figures import life as life
from linkages.plots.motion.wear_figures import wear as wear
from linkages.plots.motion.wear_figures import wear_depth as wear_depth
from linkages.plots.motion.wear_figures import wear_profile as wear_profile
from linkages.plots.panels import CHARTS, axes_for, chart, described, named
from linkages.plots.style import name_of
from linkages.solution.series import AT_JOINTS, REACTION
from linkages.solution.solution import Solution

if TYPE_CHECKING:
    import xarray as xr

    Source = Solution | xr.Dataset
    Sources = Source | Sequence[Source] | Mapping[str, Source]


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
    over.__doc__ = f"{words.capitalize()} over time."
    over.__name__ = over.__qualname__ = name
    return described(over)


@chart
def mechanism(
    solution: Solution, ax: Axes | None = None, *, time: float = 0.0, dimensions: bool = False
) -> Axes:
    """The mechanism at the sample nearest to a time in seconds, with all names.

    `time`: In seconds.
    `dimensions`: Whether to write lengths of bars, of sides of plates and of the ground's frame,
    and to mark centres of mass.
    """
    data = with_samples(solution.data, "joint_position")
    index = int(np.argmin(np.abs(np.asarray(data["time"], dtype=float) - time)))
    pose = pose_at(data, solution.mechanism, index)
    ax = ax or picture(drawing.reach(pose, dimensions=dimensions))[1]
    return drawing.draw_pose(ax, pose, dimensions=dimensions)


@chart
def traces(solution: Solution, ax: Axes | None = None) -> Axes:
    """The paths of all moving joints over the mechanism where it starts."""
    data = with_samples(solution.data, "joint_position")
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
    heading = name_of(data)
    if ax is None:
        return overlay.draw_page(time_figures.groups_of(data, variable, heading))
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
    chosen = named(name, time_figures.moving_vectors(data, variable), f"element of {variable}")
    return overlay.draw_vectors(axes_for(ax), time_figures.tips(data, variable, chosen))


def _of_drives(solution: Any, variable: str, ax: Axes | None) -> Axes:
    with_samples(solution.data, "drive_effort")
    data = resolved(solution, ["drive_effort"])
    return over_time(time_figures.efforts(data, solution.mechanism, variable), variable, ax)


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
    return overlay.draw_vectors(axes_for(ax), result)


__all__: list[str] = [*CHARTS, *filter(time_figures.drawable, VARIABLES), time_figures.FORCE]


def _at_joints(source: Source, variable: str) -> xr.Dataset:
    """Data of a variable; reactions of joints with those of several bodies there."""
    data = resolved(source, AT_JOINTS if variable == REACTION else [variable])
    return time_figures.at_pins(with_samples(data, variable), variable=variable)


def _called(sources: Sources) -> Mapping[str, Source]:
    """What tells sources apart → each of them."""
    given: Any = sources
    if isinstance(sources, Solution) or hasattr(sources, "data_vars"):
        return {name_of(data_of(given)): given}
    if isinstance(sources, Mapping):
        return dict(given)
    several = list(given)
    mechanisms = [one.mechanism if isinstance(one, Solution) else None for one in several]
    return dict(zip(told_apart(mechanisms), several, strict=True))
