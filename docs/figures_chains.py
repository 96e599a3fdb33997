"""Make the figure and the table of the section "Chains of dyads" of docs/benchmark.md.

python docs/figures_chains.py              # from the numbers in docs/_static/chains.json
python docs/figures_chains.py --measure    # measure first (minutes; keep the machine idle)
"""

from __future__ import annotations

import datetime
import json
import subprocess
import sys

import numpy as np
from figures import ROOT, STATIC, machine
from figures_benchmark import rounded
from figures_stability import write
from matplotlib.figure import Figure

from linkages.plots.figures import write_figure
from linkages.plots.style import BLACK, line_style, panels, styled

NUMBERS = STATIC / "chains.json"
BENCHMARK = ROOT / "tests" / "benchmarks" / "chains.py"


def measure() -> None:
    """Run the benchmark and keep its numbers with the machine and the date."""
    command = [sys.executable, str(BENCHMARK), "--json"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    keep(json.loads(output))


def keep(rows: list[dict]) -> None:
    """Write numbers, one size a line."""
    head = {"machine": machine(), "date": f"{datetime.date.today():%Y-%m-%d}"}
    text = json.dumps(head, indent=1, ensure_ascii=False).removesuffix("\n}")
    lines = ",\n".join("  " + json.dumps(rounded(row)) for row in rows)
    NUMBERS.write_text(f'{text},\n "rows": [\n{lines}\n ]\n}}\n', encoding="utf-8")


def line(rows: list[dict]) -> tuple[float, float]:
    """Slope and offset of the times in seconds, all sizes with the same relative weight."""
    links, seconds = (np.array([row[key] for row in rows]) for key in ("links", "evaluation"))
    slope, offset = np.polyfit(links, seconds, 1, w=1.0 / seconds)
    return float(slope), float(offset)


@styled
def figure(rows: list[dict]) -> Figure:
    """Time of an evaluation, and of compiling, against the number of links."""
    found, (left, right) = panels(1, 2, 2.9)
    links = np.array([row["links"] for row in rows])
    slope, offset = line(rows)
    at = np.array([0.0, 1.04 * links.max()])
    left.plot(at, 1e6 * (offset + slope * at), color=BLACK, linewidth=0.8)
    left.plot(links, [1e6 * row["evaluation"] for row in rows], "o", **_mark(0))
    left.set_ylabel("time of one evaluation [µs]")
    left.annotate(
        f"{1e9 * slope:.1f} ns per link",
        (0.5 * at[1], 1e6 * (offset + slope * 0.5 * at[1])),
        (-10, 8),
        textcoords="offset points",
        ha="right",
    )
    right.plot(links, [row["compiling"] for row in rows], "o", **_mark(1))
    right.set_ylabel("time to compile, once per topology [s]")
    for axes in (left, right):
        axes.set_xlabel("links")
        axes.set_xlim(0, at[1])
        axes.set_ylim(0, None)
    return found


def _mark(index: int) -> dict:
    return {"markersize": 5, "color": line_style(index)["color"]}


def table(content: dict) -> str:
    """The same numbers, with operations and how far each time is from the line."""
    rows = content["rows"]
    slope, offset = line(rows)
    lines = [
        "| links | operations | one evaluation | off the line | equations | compiling |",
        "|--:|--:|--:|--:|--:|--:|",
    ]
    lines += [
        f"| {row['links']} | {row['operations']:.0f} | {1e9 * row['evaluation']:.0f} ns "
        f"| {row['evaluation'] / (offset + slope * row['links']) - 1:+.0%} "
        f"| {row['equations']:.2f} s | {row['compiling']:.1f} s |"
        for row in rows
    ]
    note = f"Measured on {content['date']}: {content['machine']}."
    return "\n".join([*lines, "", note, ""])


def main() -> None:
    """Write all files."""
    if "--measure" in sys.argv:
        measure()
    content = json.loads(NUMBERS.read_text(encoding="utf-8"))
    write_figure(figure(content["rows"]), STATIC / "chains.svg")
    write("chains.md", table(content))


if __name__ == "__main__":
    main()
