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
from figures import ROOT, STATIC, machine, write_table
from figures_benchmark import rounded
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from linkages.plots.figures import write_figure
from linkages.plots.style import BLACK, line_style, panels, styled

NUMBERS = STATIC / "chains.json"
TICKS = (2, 5, 10, 20, 50, 100, 200)
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
    """Time of an evaluation, and of compiling, against the number of links, all logarithmic."""
    found, (left, right) = panels(1, 2, 2.9)
    links = np.array([row["links"] for row in rows])
    slope, offset = line(rows)
    at = np.geomspace(0.8 * links.min(), 1.25 * links.max())
    left.loglog(at, 1e9 * (offset + slope * at), color=BLACK, linewidth=0.8)
    left.loglog(links, [1e9 * row["evaluation"] for row in rows], "o", **_mark(0))
    left.set_ylabel("time of one evaluation [ns]")
    left.annotate(
        f"{1e9 * slope:.0f} ns per link",
        (20, 1e9 * (offset + slope * 20)),
        (10, -10),
        textcoords="offset points",
    )
    right.loglog(links, [row["compiling"] for row in rows], "o", **_mark(1))
    right.set_ylabel("time to compile [s]")
    for axes in (left, right):
        axes.set_xlabel("number of links")
        axes.set_xlim(at[0], at[-1])
        for axis, ticks in ((axes.xaxis, TICKS), (axes.yaxis, axes.get_yticks())):
            axis.set_major_locator(FixedLocator(list(ticks)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
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
    write_table("chains", table(content))


if __name__ == "__main__":
    main()
