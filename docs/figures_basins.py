"""Make the figures of docs/basins.md from the definitions on that page.

python docs/figures_basins.py    # about three minutes
"""

from __future__ import annotations

import re

from figures import ROOT, STATIC, write_small

import linkages
from linkages.plots.chaos.attractor_figures import basin_figure, hysteresis_figure

PAGE = (ROOT / "docs/basins.md").read_text(encoding="utf-8")
PLANES = {
    "pendulum-torque": ("free.rod.angle=-150deg:210deg:200", "free.rod.speed=-10:10:200"),
    "impacts": ("free.block.position=-3:1:200", "free.block.speed=-3:3:200"),
}
VARIED, STARTS = "parameters.A=0.1:0.6:101", 40
BOX = ["free.block.position=-3:1:2", "free.block.speed=-3:3:2"]


def definition(name: str) -> linkages.Mechanism:
    """A definition of the page."""
    found = re.search(rf"```yaml\n(# {name}\.yaml\n.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return linkages.loads(found[1])


if __name__ == "__main__":
    for name, plane in PLANES.items():
        figure = basin_figure(linkages.basins(definition(name), *plane))
        write_small(figure, STATIC / f"basins-{name}.png", None)
    diagram = linkages.attractor_diagram(
        definition("impacts"), VARIED, starts=STARTS, within=BOX, seed=0
    )
    write_small(hysteresis_figure(diagram), STATIC / "basins-hysteresis.png", None)
