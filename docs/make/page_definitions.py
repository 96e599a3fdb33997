"""Pictures of definitions and of Python that stand on the pages."""

from __future__ import annotations

import contextlib
import io
import re
import tempfile
from typing import Any

from matplotlib.figure import Figure

import linkages
from linkages.plots.chaos.attractor_figures import basin_figure, hysteresis_figure
from linkages.plots.chaos.diagrams import bifurcation_figure
from linkages.plots.figures import FIGURES
from linkages.plots.motion.clearance_orbit import SHOWN, orbit_figure, state_figure
from linkages.plots.study_figures import fit_figure, tolerance_figure
from make.registry import DOCS, definition, makes, makes_each

PLANES = {
    "pendulum-torque": ("free.rod.angle=-150deg:210deg:200", "free.rod.speed=-10:10:200"),
    "impacts": ("free.block.position=-3:1:200", "free.block.speed=-3:3:200"),
}
BOX = ["free.block.position=-3:1:2", "free.block.speed=-3:3:2"]
MEASURE = "max(sqrt(error(P.x position)**2 + error(P.y position)**2))"


@makes_each({(f"basins-{name}.png",): (name,) for name in PLANES}, colours=None)
def basins(name: str) -> Figure:
    """Forty thousand starts of a system of the page on basins."""
    return basin_figure(linkages.basins(definition("basins.md", f"{name}.yaml"), *PLANES[name]))


@makes("basins-hysteresis.png", colours=None)
def hysteresis() -> Figure:
    """Attractors over the amplitude, from many starts."""
    impacts = definition("basins.md", "impacts.yaml")
    varied = "parameters.A=0.1:0.6:101"
    return hysteresis_figure(
        linkages.attractor_diagram(impacts, varied, starts=40, within=BOX, seed=0)
    )


@makes("contact-guides-path.png", "contact-guides-state.svg", colours=256)
def guides() -> tuple[Figure | None, ...]:
    """The block with play: its path, and what touches when."""
    mechanism = definition("contact_guides.md", "slider-crank-play.yaml")
    data = linkages.simulate(mechanism, samples=2001, outputs=list(SHOWN)).data
    return orbit_figure(data, mechanism), state_figure(data, mechanism)


@makes("tolerances.png")
def tolerances() -> Figure | None:
    """The error of the coupler point."""
    jig = definition("tolerances.md", "jig.yaml")
    return tolerance_figure(
        linkages.tolerance(jig, MEASURE, limits=f"{MEASURE} < 0.15 mm"), MEASURE
    )


def engine() -> linkages.Mechanism:
    """The mechanism that the tutorial ends with."""
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```yaml\n(# [\w-]+\.yaml.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return linkages.loads(blocks[-1])


@makes("tutorial-phase.png", colours=256)
def tutorial_phase() -> Figure | None:
    """The first five turns."""
    mechanism = engine()
    return FIGURES["phase"](linkages.simulate(mechanism).data, mechanism)


@makes("tutorial-bifurcation.png", colours=256)
def tutorial_bifurcation() -> Figure | None:
    """801 speeds after 300 turns at each."""
    speeds = "drives.crank.speed=500rpm:1000rpm:801"
    data = linkages.bifurcation(engine(), speeds, periods=60, skip=300)
    # contact is lost at every speed, so that hatching would cover the whole picture
    return bifurcation_figure(data.drop_vars("contact_lost"))


@makes("ninebar-phase.png", colours=24)
def ninebar_phase() -> Figure | None:
    """A figure that `simulate ninebar` writes."""
    solution = linkages.simulate(linkages.load("ninebar"))
    data = solution.dense(["clearance_angle", "clearance_speed"])
    return FIGURES["phase"](data, solution.mechanism)


def run_page(page: str) -> dict[str, Any]:
    """Names after all Python of a page, run in the folder where it leaves its files."""
    text = (DOCS / page).read_text(encoding="utf-8")
    code = "\n".join(re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    namespace: dict[str, Any] = {}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(compile(code, page, "exec", dont_inherit=True), namespace)
    return namespace


@makes("howto-fit.png")
def fit() -> Figure:
    """The measurements that the page on measured curves makes, and the motion that fits them."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        run_page("howto/measured-curve.md")
        pendulum = linkages.load("pendulum", set={"dampers": [{"joint": "O", "damping": 0.02}]})
        vary, sigma = ["dampers[0].damping=0.001:0.1"], {"rod.angle": 0.02}
        return fit_figure(linkages.fit(pendulum, "measured.csv", vary, sigma=sigma).data)


@makes("python-charts.svg")
def charts() -> Figure:
    """The picture that the page on Python draws."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        return run_page("python.md")["figure"]
