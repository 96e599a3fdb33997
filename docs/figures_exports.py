"""Make the figure of the page on exports: a unit in FMPy beside the motion by this package.

python docs/figures_exports.py
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from figures import STATIC, write_small

from linkages.plots.style import line_style, panels, styled

PAGE = Path(__file__).with_name("exports.md")
STOP = 60.0
"""Where the cart bounces, in mm."""


def computed() -> dict[str, object]:
    """What the examples of the page compute."""
    text, names = PAGE.read_text(encoding="utf-8"), {}
    (definition,) = re.findall(r"```yaml\n# cart.yaml\n(.*?)```", text, re.DOTALL)
    Path("cart.yaml").write_text(definition, encoding="utf-8")
    command = [sys.executable, "-m", "linkages", "export", "cart.yaml", "--to", "fmu"]
    subprocess.run([*command, "--out", "units"], check=True)
    for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        if "simulate_fmu" in code or "pushed" in code:
            exec(code, names)
    return names


@styled
def main() -> None:
    """Write the figure."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            found = computed()
        finally:
            os.chdir(before)
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
    axes.set(xlim=(0, 2), ylim=(-75, 75), xlabel="time (s)", ylabel="position of the cart (mm)")
    figure.legend(*axes.get_legend_handles_labels(), loc="upper center", ncols=3, frameon=False)
    write_small(figure, STATIC / "exports-fmu.png")


if __name__ == "__main__":
    main()
