"""Make the figures of the page on regular and chaotic motion; takes half an hour.

python docs/figures_chaos.py
"""

from __future__ import annotations

import re

import xarray as xr
from figures import ROOT, STATIC, write_small

import linkages
from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.chaos.chaos_figures import Zoom, exponents, section_figure
from linkages.plots.chaos.diagrams import bifurcation_figure, map_figure
from linkages.plots.motion.overlay import pair_figure
from linkages.reading.document import parse
from linkages.reading.overrides import apply
from linkages.sweeps.axes import parse_range

DAMPING = "dampers[0].damping"


def driven(**changes: object) -> Mechanism:
    """The pendulum that the page begins with."""
    text = (ROOT / "docs" / "chaos.md").read_text(encoding="utf-8")
    block = re.search(r"^```yaml\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert block is not None
    return from_document(apply(parse(block.group(1), "driven.yaml"), changes))


LAYERS = Zoom(-160, -70, 2.04, 2.19), Zoom(-112, -100, 2.158, 2.18)
"""Parts of the strange attractor, the second within the first."""


def attractor() -> None:
    """A hundred thousand points of the strange attractor."""
    figure = section_figure(linkages.poincare(driven(), periods=100_000, skip=100), LAYERS)
    assert figure is not None
    write_small(figure, STATIC / "chaos-section.png")


def portrait() -> None:
    """The chaotic motion in its phase plane, after the transient."""
    outputs = ["bar_angle", "bar_speed"]
    data = linkages.simulate(driven(), end=400, samples=10_001, outputs=outputs).data
    figure = pair_figure(data.sel(time=slice(200, None)), "arm.angle", "arm.speed")
    assert figure is not None
    write_small(figure, STATIC / "chaos-phase.png", colours=256)


def settling() -> None:
    """Exponents of the chaotic motion."""
    figure = exponents(linkages.lyapunov(driven(), periods=400, skip=50)).figure
    assert figure is not None
    write_small(figure, STATIC / "chaos-exponents.png")


def diagram() -> None:
    """Period doubling down to chaos, both ways, with the largest exponent."""
    parts = [
        linkages.bifurcation(
            driven(),
            parse_range(f"{DAMPING}=0.45:0.8:841"),
            periods=100,
            skip=200,
            start=start,
            exponent=True,
        ).assign_coords(start=[start])
        for start in ("forward", "backward")
    ]
    figure = bifurcation_figure(xr.concat(parts, "start", data_vars="all"))
    assert figure is not None
    write_small(figure, STATIC / "chaos-bifurcation.png")


def plane() -> None:
    """Where the pendulum is chaotic, over its damping and gravity."""
    damping = parse_range(f"{DAMPING}=0.4:0.8:300")
    gravity = parse_range("gravity[1]=-1.5:-0.7:300")
    figure = map_figure(linkages.chaos_map(driven(), damping, gravity, periods=60, skip=60))
    assert figure is not None
    write_small(figure, STATIC / "chaos-map.png", colours=None)


if __name__ == "__main__":
    portrait()
    attractor()
    settling()
    diagram()
    plane()
