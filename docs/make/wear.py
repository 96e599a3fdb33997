"""Make the figures and the table of the page on wear.

python docs/figures_wear.py             # minutes
python docs/figures_wear.py --figures   # the figures alone
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

import linkages
from make.accuracy import STATIC, write_table
from make.contact_route import ROUTE

PAGE = Path(__file__).parents[1] / "wear.md"
FIGURES = {
    "pump": ("worn", "wear"),
    "depth": ("worn", "wear_depth"),
    "profile": ("profile", "wear_profile"),
    "life": ("life", "life"),
}
"""Name → folder and picture of the commands of the page."""

WORN = {
    "friction": 0.1,
    "friction_law": "coulomb",
    "width": "20 mm",
    "wear": {"bearing": {"wear_rate": "1e-7 mm^3/(N m)"}},
}


def figures() -> None:
    """Run the commands of the page, and keep their pictures."""
    page = PAGE.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in re.findall(r"```yaml\n# (\S+\.yaml)\n(.*?)```", page, re.DOTALL):
            (folder / file).write_text(text, encoding="utf-8")
        for line in re.findall(r"^\$ python -m (linkages wear .*)$", page, re.MULTILINE):
            words = [text.strip('"') for text in re.findall(r'"[^"]*"|\S+', line)]
            subprocess.run([sys.executable, "-m", *words], check=True, cwd=folder)
        for figure, (place, picture) in FIGURES.items():
            image = Image.open(folder / place / f"{picture}.png").convert("RGB")
            image.quantize(64).save(STATIC / f"wear-{figure}.png", optimize=True)


def table() -> str:
    """Cost and errors of the slider-crank."""
    gap = ROUTE.definition.content["clearances"]["gap"]
    mechanism = ROUTE.with_values({"clearances.gap": {**gap, **WORN}})
    heads = "revolutions | jumps | computed | processor time | size | error | half the jumps"
    lines = [f"| {heads} |", "|--:|--:|--:|--:|--:|--:|--:|"]
    for power in (6, 8):
        begun = time.process_time()
        data = linkages.wear(mechanism, revolutions=10**power, rtol=1e-9)
        taken = time.process_time() - begun
        half = linkages.wear(mechanism, revolutions=10**power, rtol=1e-9, confirm=True)
        end, moved = data.isel(jump=-1, clearance=0), float(half.attrs["difference"][0])
        lines.append(
            f"| 10{'⁶' if power == 6 else '⁸'} | {data.sizes['jump'] - 1} "
            f"| {data.attrs['computed']} | {taken:.0f} s | {1e3 * float(end['size']):.5f} mm "
            f"| {1e6 * float(end['error']):.2g} µm | {1e6 * moved:.2g} µm |"
        )
    return "\n".join([*lines, ""])


def main() -> None:
    """Write all."""
    figures()
    if "--figures" not in sys.argv:
        write_table("wear-cost", table())


if __name__ == "__main__":
    main()
