"""Pictures that commands on the pages write, run as they stand there, or with finer ranges."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from make.registry import DOCS, makes, makes_each

FINER = {":20": ":120"}
TILES = "orbit", "orbit_multipliers", "orbit_time", "orbit_positions"
ENERGY = "plot_cumulative-crank.effort-crank.speed-_cumulative-crank.speed-mean-crank.effort-"
COMMANDS: list[tuple[str, str, dict[str, str], dict[str, str]]] = [
    ("duty", "duty slider-crank", {}, {"duty": "duty"}),
    ("equilibrium", "equilibrium truss.yaml", {}, {"equilibrium-truss": "equilibria"}),
    ("equilibrium", "equilibrium toggle.yaml", {}, {"equilibrium-toggle": "equilibria"}),
    ("equilibrium", "equilibrium double-pendulum", {" --film": ""}, {"equilibrium-modes": "modes"}),
    ("inverse-kinematics", "simulate palletiser.yaml", {},
     {"inverse-traces": "traces", "inverse-torques": "drive_effort"}),
    ("inverse-kinematics", "workspace palletiser.yaml", {}, {"inverse-workspace": "workspace"}),
    ("inverse-kinematics", "workspace five-bar", {}, {"inverse-five-bar": "workspace"}),
    ("measures", "plot press.yaml", {}, {"measures-energy": ENERGY}),
    ("orbits", "follow idling-engine", {}, {"orbits-branches": "follow"}),
    ("orbits", "follow impact-oscillator", {"A=0.1:17": "A=0.1:1"}, {"orbits-grazing": "follow"}),
    ("orbits", "basins idling-engine", FINER, {"orbits-basins": "basins"}),
    ("recipes", "fit eighteen.yaml", {}, {"recipes-path": "fit_path_P"}),
    ("wear", "wear pump.yaml --until \"clearances.gap.size = 0.2 mm\" --out worn", {},
     {"wear-pump": "wear", "wear-depth": "wear_depth"}),
    ("wear", "wear pump.yaml --until \"clearances.gap.size = 0.08 mm\"", {},
     {"wear-profile": "wear_profile"}),
    ("wear", "wear pump.yaml --until \"clearances.gap.size = 0.2 mm\" --life", {},
     {"wear-life": "life"}),
]  # fmt: skip
"""Page, how a command of it begins, what is changed, and output → name of its picture."""


@makes_each(
    {
        tuple(f"{name}.png" for name in pictures): (page, begins, changes, [*pictures.values()])
        for page, begins, changes, pictures in COMMANDS
    }
)
def written(page: str, begins: str, changes: dict[str, str], pictures: list[str]) -> tuple:
    """Run a command beside the files of its page; returns some of the pictures that it writes."""
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    commands = re.findall(r"^\$ python -m linkages (.*)$", text, re.MULTILINE)
    command = next(line for line in commands if line.startswith(begins))
    section = text[: text.index(command)].rpartition("\n## ")[2]
    for old, new in changes.items():
        assert old in command
        command = command.replace(old, new)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = re.findall(r"^```yaml\n# (\S+\.yaml)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
        for file, content in files:
            (folder / file).write_text(content, encoding="utf-8")
        for code in re.findall(r"^```python\n(.*?)^```$", section, re.MULTILINE | re.DOTALL):
            if "open(" in code:  # data for the command
                subprocess.run([sys.executable, "-c", code], check=True, cwd=folder)
        run = [sys.executable, "-m", "linkages", *shlex.split(command), "--out", "made"]
        subprocess.run(run, check=True, cwd=folder, stdout=subprocess.DEVNULL)
        opened = (Image.open(folder / "made" / f"{picture}.png") for picture in pictures)
        return tuple(image.convert("RGB") for image in opened)


@makes("orbits-engine.png")
def engine() -> Image.Image:
    """Four figures of an orbit, each with as much room as the largest, at half their size."""
    images = written("orbits", "orbit idling-engine", {}, [*TILES])
    width, height = (max(sizes) for sizes in zip(*(image.size for image in images), strict=True))
    result = Image.new("RGB", (2 * width, 2 * height), "white")
    for k, image in enumerate(images):
        result.paste(image, (k % 2 * width, k // 2 * height))
    return result.resize((width, height), Image.Resampling.LANCZOS)
