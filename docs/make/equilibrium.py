"""Make the figures of the page on rest and vibration.

python docs/figures_equilibrium.py
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from make.accuracy import STATIC

PAGE = Path(__file__).parents[1] / "equilibrium.md"
FIGURES = {
    "truss": ("truss.yaml", "equilibria"),
    "toggle": ("toggle.yaml", "equilibria"),
    "modes": ("double-pendulum", "modes"),
}


def main() -> None:
    """Write all figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in re.findall(r"```yaml\n# (\S+\.yaml)\n(.*?)```", PAGE.read_text(), re.S):
            (folder / file).write_text(text)
        for figure, (file, picture) in FIGURES.items():
            command = [sys.executable, "-m", "linkages", "equilibrium", file, "--out", figure]
            subprocess.run(command, check=True, cwd=folder)
            image = Image.open(folder / figure / f"{picture}.png").convert("RGB")
            image.quantize(64).save(STATIC / f"equilibrium-{figure}.png", optimize=True)


if __name__ == "__main__":
    main()
