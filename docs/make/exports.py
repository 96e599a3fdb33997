"""Figures of the page on exports: units in FMPy beside the motion by this package."""

from __future__ import annotations

import contextlib
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.plots.panels import panels
from linkages.plots.style import line_style
from make.registry import DOCS, makes

PAGE = DOCS / "exports.md"
PARALLELOGRAM = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0]}
bars:
  a: {joints: [O, A], length: 0.5, mass: 1}
  b: {joints: [A, B], length: 1, mass: 1}
  c: {joints: [C, B], length: 0.5, mass: 1}
free: {a: {angle: 60 deg, speed: -9}}
assembly: {B: [1.25, 0.4]}
"""
STOP = 60.0
"""Where the cart bounces, in mm."""


def computed() -> dict[str, object]:
    """What the examples of the page compute."""
    text, names = PAGE.read_text(encoding="utf-8"), {}
    for name, definition in re.findall(r"```yaml\n# (\w+.yaml)\n(.*?)```", text, re.DOTALL):
        Path(name).write_text(definition, encoding="utf-8")
        given = re.findall(rf"export {name} --to fmu (.*)\n", text)[0].split()
        command = [sys.executable, "-m", "linkages", "export", name, "--to", "fmu", *given]
        subprocess.run(command, check=True)
    for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        if "simulate_fmu" in code or "pushed" in code:
            exec(code, names)
    mechanism, times = linkages.loads(PARALLELOGRAM), np.linspace(0.0, 1.0, 201)
    linkages.export(mechanism, "fmu", "bars", name="parallelogram")
    names["bars"] = names["simulate_fmu"](
        "bars/parallelogram.fmu", fmi_type="ModelExchange", stop_time=1.0, output_interval=0.01,
        relative_tolerance=1e-9, record_events=False, output=["a.angle", "b.angle", "c.angle"],
    )  # fmt: skip
    names["parallel"] = linkages.simulate(mechanism, times=times).data.bar_angle
    return names


@makes("exports-fmu.png", "exports-units.png")
def both() -> tuple[Figure, Figure]:
    """The pushed cart, and units with inputs and change points."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        found = computed()
    return pushed(found), units(found)


def pushed(found: dict[str, object]) -> Figure:
    """A cart that a unit pushes, in both kinds of units."""
    figure, (axes,) = panels(1, 1, 1.9)
    times = found["solution"].data.time.values
    axes.axvspan(0.2, 0.5, color="0.92", linewidth=0)
    axes.text(0.35, 46, "4 N", ha="center", color="0.35")
    for stop in (-STOP, STOP):
        axes.axhline(stop, color="0.6", linewidth=0.8)
    axes.plot(times, 1e3 * found["expected"], label="linkages", **line_style(0))
    for (kind, table), mark, first in zip(found["table"].items(), "ox", (0, 2), strict=True):
        name = {"CoSimulation": "co-simulation", "ModelExchange": "model exchange"}[kind]
        rows = slice(first, None, 5)
        axes.plot(
            table["time"][rows], 1e3 * table["cart.position"][rows], mark, color="black",
            markersize=4, fillstyle="none", label=f"FMPy, {name}",
        )  # fmt: skip
    axes.set(xlim=(0, 2), ylim=(-75, 75), xlabel="time [s]", ylabel="position of the cart [mm]")
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", ncols=3, frameon=False)
    return figure


def units(found: dict[str, object]) -> Figure:
    """A drive that an input accelerates, and change points in model exchange."""
    figure, (left, right) = panels(1, 2, 2.0)
    table, bars, data = found["run_up"], found["bars"], found["parallel"]
    left.plot(table["time"], table["crank.effort"], **line_style(0))
    left.set(xlim=(0, 1), xlabel="time [s]", ylabel="effort of the crank [N m]")
    left.axvspan(0.0, 0.5, color="0.92", linewidth=0)
    left.text(0.25, 0.92, "80 rad/s²", ha="center", color="0.35", transform=left.transAxes)
    for number, bar in enumerate("ab"):
        exact = np.degrees(data.sel(bar=bar).values)
        right.plot(data.time.values, exact, label=f"{bar}, linkages", **line_style(number))
        right.plot(
            bars["time"][::4], np.degrees(bars[f"{bar}.angle"][::4]), "ox"[number], color="black",
            markersize=4, fillstyle="none", label=f"{bar}, FMPy",
        )  # fmt: skip
    right.set(xlim=(0, 1), ylim=(-850, 90), xlabel="time [s]", ylabel="angle of a bar [°]")
    right.legend(frameon=False, ncols=2, loc="lower left", columnspacing=1.0)
    return figure
