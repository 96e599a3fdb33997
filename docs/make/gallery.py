"""Film, curves and drawing of each shipped mechanism."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.kernel.system import System
from linkages.plots.films.film import SHOWN
from linkages.plots.motion import overlay
from linkages.plots.motion.compared import compared
from linkages.plots.style import style
from linkages.reading.document import shipped
from linkages.solution.series import find_series, requested, system_series, with_sizes
from linkages.solution.solution import Solution
from make.component_pictures import component, shortened, write_shortened
from make.registry import STATIC, makes_each

PICTURES = STATIC / "gallery"
FPS, DPI = 7.0, 54.0
PANEL = (2.3, 1.55)
"""Width and height of a curve in inches."""

COARSE = {
    "svg.fonttype": "none",
    "font.sans-serif": ["DejaVu Sans", "Verdana"],
    "path.simplify_threshold": 0.3,
    "figure.dpi": 50,
    "xtick.bottom": False,
    "ytick.left": False,
}
"""Texts stay texts, and a line need not be smoother than small pictures show."""

CURVES: dict[str, tuple[str, str, str]] = {
    "andrews": ("K7.angle", "K7.speed", "kinetic_energy"),
    "beam-pump": ("beam.angle", "crank.effort", "load_power"),
    "chebyshev": ("path of P", "P.y position", "arm1.effort"),
    "class-three": ("path of G", "plate.angle", "crank.effort"),
    "contact-slider-crank": ("piston.position error", "gap.force", "crank.effort"),
    "double-pendulum": ("path of Q", "lower.angle", "kinetic_energy"),
    "double-rocker": ("path of P", "jib.speed", "jib.effort"),
    "five-bar": ("path of B", "crank1.effort", "B.reaction"),
    "five-bar-free": ("path of B", "crank2.angle", "crank2.speed over crank2.angle"),
    "four-bar": ("path of P", "rocker.angle over crank.angle", "crank.effort"),
    "hoeken": ("path of P", "P.x velocity", "crank.effort"),
    "idling-engine": ("piston.position error", "gap.force", "crank.effort"),
    "impact-oscillator": ("mass.position", "mass.velocity over mass.position", "kinetic_energy"),
    "jansen": ("path of F", "F.y position", "m.effort"),
    "klann": ("path of G", "G.y position", "crank.effort"),
    "n-four-bar": ("post0.angle", "post0.speed", "kinetic_energy"),
    "ninebar": ("slider9.position", "slider9.position error", "r1.angle"),
    "ninebar-ideal": ("slider9.position", "slider9.acceleration", "crank1.effort"),
    "ninebar-rotating": ("slider9.position error", "r1.speed", "r1.force"),
    "peaucellier": ("path of Q", "Q.y velocity", "crank.effort"),
    "pendulum": ("rod.angle", "rod.speed over rod.angle", "kinetic_energy"),
    "quick-return": ("ram.position", "ram.velocity", "crank.effort"),
    "scotch-yoke": ("yoke.position", "yoke.velocity over yoke.position", "crank.effort"),
    "slider-crank": ("piston.position", "piston.acceleration", "crank.effort"),
    "slider-crank-contact": ("piston.position error", "gap.force", "piston.velocity"),
    "stephenson-six-bar": ("arm.angle over crank.angle", "path of P", "crank.effort"),
    "toggle-press": ("ram.position", "ram.velocity", "crank.effort"),
    "watt-six-bar": ("path of G", "lever.angle over crank.angle", "crank.effort"),
}
"""Mechanism → what tells its motion: series over time or over another one, and paths of joints."""


def turn(solution: linkages.Solution) -> float | None:
    """How long the slowest drive takes to turn once; None for a motion that nothing repeats."""
    topology, time = solution.system.topology, solution.data["time"].to_numpy()
    found = []
    for name in () if topology.free else topology.driven:
        if name not in solution.data["bar"]:
            return None
        angle = solution.data["bar_angle"].sel(bar=name).to_numpy()
        turned = np.abs(angle - angle[0])
        if turned[-1] < 2 * np.pi:
            return None
        found.append(float(np.interp(2 * np.pi, turned, time)))
    return max(found, default=None)


def series_of(curve: str) -> tuple[str, str]:
    """What is drawn, and what it is drawn over."""
    if curve.startswith("path of "):
        joint = curve.removeprefix("path of ")
        return f"{joint}.y position", f"{joint}.x position"
    name, _, over = curve.partition(" over ")
    return name, over or "time"


def outputs_of(system: System, name: str) -> set[str]:
    """The outputs that the curves of a mechanism need."""
    known = with_sizes(system_series(system))
    wanted = {series for curve in CURVES[name] for series in series_of(curve)} - {"time"}
    return {find_series(known, series).variable for series in wanted}


def curves(name: str, solution: Solution) -> Figure:
    """Three curves of a motion beside each other; what is drawn stands above, for want of room."""
    width, height = PANEL
    figure = Figure(figsize=(3 * width, height), layout="constrained")
    for ax, curve in zip(figure.subplots(1, 3), CURVES[name], strict=True):
        series, over = series_of(curve)
        overlay.draw(ax, compared({"": solution}, [series], over))
        label = ax.get_ylabel()
        if curve.startswith("path of "):
            ax.set_xlabel("")
        if "component" in label:  # too long for a panel
            label = f"{curve} {label[label.rindex('[') :]}"
        ax.set_title(label)
        ax.set_ylabel("")
    return figure


def write_curves(name: str, solution: Solution) -> Path:
    """Write the curves of a mechanism."""
    path = PICTURES / f"{name}.svg"
    with style(), matplotlib.rc_context(COARSE):
        curves(name, solution).savefig(path, metadata={"Creator": None, "Date": None})
    text = shortened(path.read_text(encoding="utf-8"), 1)
    # groups need no names here, and texts no turn by zero
    text = re.sub(
        r'(?<=<g) id="[^"]*"(?=>)| transform="rotate\(-0 [^"]*"|^ +', "", text, flags=re.M
    )
    path.write_text(text.replace(" \nL ", "L"), encoding="utf-8")
    return path


@makes_each(
    {
        tuple(f"gallery/{name}{end}" for end in (".webp", ".svg", "-drawing.svg")): (name,)
        for name in shipped()
    }
)
def pictures(name: str) -> tuple[Path, ...]:
    """Write film, curves and drawing of a mechanism."""
    PICTURES.mkdir(exist_ok=True)
    mechanism = linkages.load(name)
    system = System(mechanism)
    possible = requested(system, "all")
    outputs = {output for output in SHOWN if output in possible} | outputs_of(system, name)
    solution = linkages.simulate(mechanism, samples=721, outputs=sorted(outputs), throw=False)
    film = PICTURES / f"{name}.webp"
    linkages.animate(solution, film, duration=turn(solution), fps=FPS, dpi=DPI, bare=True)
    drawing = write_shortened(component(mechanism), PICTURES / f"{name}-drawing.svg")
    return film, write_curves(name, solution), drawing
