"""Make figures and tables of the sections on chains of docs/benchmark.md.

python docs/figures_chains.py              # from the numbers in docs/_static/chains.json
python docs/figures_chains.py --measure    # measure first (minutes; keep the machine idle)
python docs/figures_chains.py --measure-free    # only chains of free bars, and `check`
"""

from __future__ import annotations

import datetime
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from figures import ROOT, STATIC, machine, write_table
from figures_benchmark import rounded
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from linkages.plots.figures import write_figure
from linkages.plots.layout import panels
from linkages.plots.style import BLACK, line_style, styled

NUMBERS = STATIC / "chains.json"
FREE_NUMBERS = STATIC / "free_chains.json"
TICKS = (2, 5, 10, 20, 50, 100, 200)
BENCHMARK = ROOT / "tests" / "benchmarks" / "chains.py"


def measure() -> None:
    """Run the benchmark and keep its numbers with the machine and the date."""
    keep(_measured(), NUMBERS)
    keep([*_measured("--free"), *_measured("--check")], FREE_NUMBERS)


def _measured(*what: str) -> list[dict]:
    command = [sys.executable, str(BENCHMARK), "--json", *what]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def keep(rows: list[dict], numbers: Path) -> None:
    """Write numbers, one size a line."""
    head = {"machine": machine(), "date": f"{datetime.date.today():%Y-%m-%d}"}
    text = json.dumps(head, indent=1, ensure_ascii=False).removesuffix("\n}")
    lines = ",\n".join("  " + json.dumps(rounded(row)) for row in rows)
    numbers.write_text(f'{text},\n "rows": [\n{lines}\n ]\n}}\n', encoding="utf-8")


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


@styled
def free_figure(rows: list[dict]) -> Figure:
    """Time to the first sample of chains of free bars, and time to check bars."""
    found, (left, right) = panels(1, 2, 2.9)
    free = [row for row in rows if "first" in row]
    checked = [row for row in rows if "dyads" in row]
    left.loglog([row["bars"] for row in free], [row["first"] for row in free], "o-", **_mark(0))
    left.set_ylabel("time to the first sample [s]")
    for index, (key, label) in enumerate((("dyads", "chain of dyads"), ("driven", "driven bars"))):
        bars = [row["bars"] for row in checked]
        right.loglog(bars, [row[key] for row in checked], "os"[index] + "-", **_mark(index))
        right.lines[-1].set_label(label)
    right.set_ylabel("time of check [s]")
    right.legend()
    for axes, own in ((left, free), (right, checked)):
        axes.set_xlabel("number of bars")
        axes.xaxis.set_major_locator(FixedLocator([row["bars"] for row in own]))
        axes.yaxis.set_major_locator(FixedLocator([0.2, 0.5, 1, 2, 5, 10]))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
    return found


def free_table(content: dict) -> str:
    """Terms, times and memory of chains of free bars, then times of `check`."""
    free = [row for row in content["rows"] if "first" in row]
    checked = [row for row in content["rows"] if "dyads" in row]
    lines = ["| free bars | terms | first sample | one evaluation per bar | memory |"]
    lines += ["|--:|--:|--:|--:|--:|"]
    lines += [
        f"| {row['bars']} | {row['terms']} | {row['first']:.1f} s "
        f"| {1e9 * row['evaluation'] / row['bars']:.0f} ns | {row['memory']:.0f} MB |"
        for row in free
    ]
    lines += ["", "| bars | `check` of a chain of dyads | of driven bars |", "|--:|--:|--:|"]
    lines += [f"| {r['bars']} | {r['dyads']:.1f} s | {r['driven']:.1f} s |" for r in checked]
    note = f"Measured on {content['date']}: {content['machine']}; times of the processor."
    return "\n".join([*lines, "", note, ""])


def main() -> None:
    """Write all files."""
    if "--measure" in sys.argv:
        measure()
    if "--measure-free" in sys.argv:
        keep([*_measured("--free"), *_measured("--check")], FREE_NUMBERS)
    content = json.loads(FREE_NUMBERS.read_text(encoding="utf-8"))
    write_figure(free_figure(content["rows"]), STATIC / "free_chains.svg")
    write_table("free-chains", free_table(content))
    content = json.loads(NUMBERS.read_text(encoding="utf-8"))
    write_figure(figure(content["rows"]), STATIC / "chains.svg")
    write_table("chains", table(content))


if __name__ == "__main__":
    main()
