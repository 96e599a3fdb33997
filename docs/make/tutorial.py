"""Make the figures of the tutorial, of the how-tos and of python.md from the examples on them.

python docs/figures_tutorial.py
"""

from __future__ import annotations

import contextlib
import re
import tempfile
from pathlib import Path
from typing import Any

import linkages
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.plots.chaos.diagrams import bifurcation_figure
from linkages.plots.figures import write_figure
from linkages.plots.motion import phase_diagrams as phase
from linkages.plots.study_figures import fit_figure
from linkages.sweeps.axes import parse_range
from make.accuracy import ROOT, STATIC, write_small


def last_definition(page: str) -> Mechanism:
    """The mechanism that a page ends with."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    blocks = re.findall(r"^```yaml\n(# [\w-]+\.yaml.*?)^```$", text, re.MULTILINE | re.DOTALL)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "engine.yaml"
        file.write_text(blocks[-1], encoding="utf-8")
        return linkages.load(file)


def tutorial() -> None:
    """The first five turns, and 801 speeds after 300 turns at each."""
    mechanism = last_definition("tutorial.md")
    figure = phase.figure(linkages.simulate(mechanism).data, mechanism)
    assert figure is not None
    write_small(figure, STATIC / "tutorial-phase.png", colours=256)
    speeds = parse_range("drives.crank.speed=500rpm:1000rpm:801")
    data = linkages.bifurcation(mechanism, speeds, periods=60, skip=300)
    # contact is lost at every speed, so that hatching would cover the whole picture
    figure = bifurcation_figure(data.drop_vars("contact_lost"))
    assert figure is not None
    write_small(figure, STATIC / "tutorial-bifurcation.png", colours=256)


def run_page(page: str) -> dict[str, Any]:
    """Names after all Python of a page, run in the folder where it leaves its files."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    code = "\n".join(re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    namespace: dict[str, Any] = {}
    exec(compile(code, page, "exec", dont_inherit=True), namespace)
    return namespace


def fit() -> None:
    """The measurements that the page on measured curves makes, and the motion that fits them."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        run_page("howto/measured-curve.md")
        pendulum = linkages.load("pendulum", set={"dampers": [{"joint": "O", "damping": 0.02}]})
        vary, sigma = ["dampers[0].damping=0.001:0.1"], {"rod.angle": 0.02}
        found = linkages.fit(pendulum, "measured.csv", vary, sigma=sigma)
    write_small(fit_figure(found.data), STATIC / "howto-fit.png")


def charts() -> None:
    """The picture that the page on Python draws."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        namespace = run_page("python.md")
    write_figure(namespace["figure"], STATIC / "python-charts.svg")


if __name__ == "__main__":
    tutorial()
    charts()
    fit()
