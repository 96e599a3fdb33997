"""Make the figures of the pages on points on paths, measures and duties of motors.

python docs/figures_inverse.py
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from make.accuracy import STATIC

DOCS = Path(__file__).parents[1]
FIGURES = {
    "inverse-traces": ("inverse-kinematics", "simulate palletiser.yaml", "traces"),
    "inverse-torques": ("inverse-kinematics", "simulate palletiser.yaml", "drive_effort"),
    "inverse-workspace": ("inverse-kinematics", "workspace palletiser.yaml", "workspace"),
    "inverse-five-bar": ("inverse-kinematics", "workspace five-bar", "workspace"),
    "measures-energy": (
        "measures", "plot press.yaml",
        "plot_cumulative-crank.effort-crank.speed-_cumulative-crank.speed-mean-crank.effort-",
    ),
    "duty": ("duty", "duty slider-crank", "duty"),
}  # fmt: skip
"""Figure → page, the command there that makes it, and its name among the files of that."""


def main() -> None:
    """Write all figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for figure, (page, begins, picture) in FIGURES.items():
            text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
            for file, content in re.findall(r"```yaml\n# (\S+\.yaml)\n(.*?)```", text, re.S):
                (folder / file).write_text(content, encoding="utf-8")
            command = next(
                line for line in re.findall(r"^\$ python -m linkages (.*)$", text, re.M)
                if line.startswith(begins)
            )  # fmt: skip
            run = [sys.executable, "-m", "linkages", *shlex.split(command), "--out", figure]
            subprocess.run(run, check=True, cwd=folder)
            image = Image.open(folder / figure / f"{picture}.png").convert("RGB")
            image.quantize(64).save(STATIC / f"{figure}.png", optimize=True)


if __name__ == "__main__":
    main()
