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
from linkages.plots.chaos import bifurcations, exponents, maps, sections
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


def attractor() -> None:
    """Five thousand points of the strange attractor."""
    figure = sections.figure(linkages.poincare(driven(), periods=5000, skip=100))
    assert figure is not None
    write_small(figure, STATIC / "chaos-section.png")


def settling() -> None:
    """Exponents of the chaotic motion."""
    figure = exponents.figure(linkages.lyapunov(driven(), periods=400, skip=50))
    assert figure is not None
    write_small(figure, STATIC / "chaos-exponents.png")


def diagram() -> None:
    """Period doubling down to chaos, both ways, with the largest exponent."""
    parts = [
        linkages.bifurcation(
            driven(),
            parse_range(f"{DAMPING}=0.45:0.8:281"),
            periods=60,
            skip=200,
            start=start,
            exponent=True,
        ).assign_coords(start=[start])
        for start in ("forward", "backward")
    ]
    figure = bifurcations.figure(xr.concat(parts, "start", data_vars="all"))
    assert figure is not None
    write_small(figure, STATIC / "chaos-bifurcation.png")


def plane() -> None:
    """Which initial states of the nine-bar's clearance are chaotic."""
    mechanism = linkages.load(
        "ninebar", set={"drives.crank1.angle": "15 deg", "drives.crank4.angle": "150 deg"}
    )
    angles = parse_range("clearances.r1.angle=-180deg:180deg:200")
    speeds = parse_range("clearances.r1.speed=-600:600:200")
    figure = maps.figure(linkages.chaos_map(mechanism, angles, speeds, indicator="fli", periods=10))
    assert figure is not None
    write_small(figure, STATIC / "chaos-map.png", colours=256)


if __name__ == "__main__":
    attractor()
    settling()
    diagram()
    plane()
