"""The figures of the page on regular and chaotic motion."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

import linkages
from linkages.plots.chaos.chaos_figures import Zoom, exponents, section_figure
from linkages.plots.chaos.diagrams import bifurcation_figure, map_figure
from linkages.plots.motion.overlay import pair_figure
from make.registry import definition, makes

DAMPING = "dampers[0].damping"


def driven() -> linkages.Mechanism:
    """The pendulum that the page begins with."""
    return definition("chaos.md", "driven.yaml")


LAYERS = Zoom(-160, -70, 2.04, 2.19), Zoom(-112, -100, 2.158, 2.18)
"""Parts of the strange attractor, the second within the first."""


@makes("chaos-section.png")
def attractor() -> Figure | None:
    """A hundred thousand points of the strange attractor."""
    return section_figure(linkages.poincare(driven(), periods=100_000, skip=100), LAYERS)


@makes("chaos-phase.png", colours=256)
def portrait() -> Figure | None:
    """The chaotic motion in its phase plane, after the transient."""
    outputs = ["bar_angle", "bar_speed"]
    data = linkages.simulate(driven(), end=400, samples=10_001, outputs=outputs).data
    return pair_figure(data.sel(time=slice(200, None)), "arm.angle", "arm.speed")


@makes("chaos-exponents.png")
def settling() -> Figure | None:
    """Exponents of the chaotic motion."""
    return exponents(linkages.lyapunov(driven(), periods=400, skip=50)).figure


@makes("chaos-bifurcation.png")
def diagram() -> Figure | None:
    """Period doubling down to chaos, both ways, with the largest exponent."""
    parts = [
        linkages.bifurcation(
            driven(),
            f"{DAMPING}=0.45:0.8:841",
            periods=100,
            skip=200,
            start=start,
            exponent=True,
        ).assign_coords(start=[start])
        for start in ("forward", "backward")
    ]
    return bifurcation_figure(xr.concat(parts, "start", data_vars="all"))


@makes("chaos-map.png", colours=None)
def plane() -> Figure | None:
    """Where the pendulum is chaotic, over its damping and gravity."""
    ranges = f"{DAMPING}=0.4:0.8:300", "gravity[1]=-1.5:-0.7:300"
    return map_figure(linkages.chaos_map(driven(), *ranges, periods=60, skip=60))
