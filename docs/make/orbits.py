"""Make the figures of the page on orbits and branches; takes five minutes.

python docs/figures_orbits.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from make.accuracy import STATIC

ENGINE = "idling-engine"


def made(folder: Path, *arguments: str) -> None:
    """Run a command whose files go into a folder."""
    command = [sys.executable, "-m", "linkages", *arguments, "--out", str(folder)]
    subprocess.run(command, check=True)


def tiled(paths: list[Path], columns: int) -> Image.Image:
    """Pictures side by side on white, each as large as the largest."""
    pictures = [Image.open(path).convert("RGB") for path in paths]
    width = max(picture.width for picture in pictures)
    height = max(picture.height for picture in pictures)
    rows = -(-len(pictures) // columns)
    result = Image.new("RGB", (columns * width, rows * height), "white")
    for k, picture in enumerate(pictures):
        result.paste(picture, (k % columns * width, k // columns * height))
    return result


def main() -> None:
    """Write all figures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made(folder / "orbit", "orbit", ENGINE)
        names = ("orbit", "orbit_multipliers", "orbit_time", "orbit_positions")
        tiles = tiled([folder / "orbit" / f"{name}.png" for name in names], 2)
        small = tiles.resize((tiles.width // 2, tiles.height // 2), Image.Resampling.LANCZOS)
        small.quantize(64).save(STATIC / "orbits-engine.png", optimize=True)
        made(
            folder / "branches", "follow", ENGINE, "--vary", "loads[0].force=-20.8N:-18.2N",
            "--switch", "--longest", "2",
        )  # fmt: skip
        made(
            folder / "grazing", "follow", "impact-oscillator", "--set", "parameters.w=1.2",
            "--vary", "parameters.A=0.1:1",
        )  # fmt: skip
        side = "=-0.1mm:0.1mm:120"
        made(
            folder / "basins", "basins", ENGINE, "--set", "loads[0].force=-21 N", "--draws", "400",
            "--x", f"clearances.gap.offset[0]{side}", "--y", f"clearances.gap.offset[1]{side}",
        )  # fmt: skip
        files = {"branches": "follow", "grazing": "follow", "basins": "basins"}
        for name, file in files.items():
            picture = Image.open(folder / name / f"{file}.png").convert("RGB")
            picture.quantize(64).save(STATIC / f"orbits-{name}.png", optimize=True)


if __name__ == "__main__":
    main()
