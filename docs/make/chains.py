"""Figures and tables on chains, from numbers in docs/_static that are measured apart."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullFormatter

from linkages.plots.panels import panels
from linkages.plots.style import BLACK, line_style
from make.benchmark import benchmark
from make.registry import makes, measured_on, table

TICKS = (2, 5, 10, 20, 50, 100, 200)


@makes("chains.json")
def measured() -> dict:
    """Chains of links with one degree of freedom."""
    return {"rows": benchmark("chains")}


@makes("free_chains.json")
def measured_free() -> dict:
    """Chains of free bars, and ``check``."""
    return {"rows": [*benchmark("chains", "--free"), *benchmark("chains", "--check")]}


def line(rows: list[dict]) -> tuple[float, float]:
    """Slope and offset of the times in seconds, all sizes with the same relative weight."""
    links, seconds = (np.array([row[key] for row in rows]) for key in ("links", "evaluation"))
    slope, offset = np.polyfit(links, seconds, 1, w=1.0 / seconds)
    return float(slope), float(offset)


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


@makes("chains.svg", "chains", numbers="chains.json")
def both(content: dict) -> tuple[Figure, str]:
    """The same numbers, with operations and how far each time is from the line."""
    rows = content["rows"]
    slope, offset = line(rows)
    lines = [
        (
            row["links"], f"{row['operations']:.0f}", f"{1e9 * row['evaluation']:.0f} ns",
            f"{row['evaluation'] / (offset + slope * row['links']) - 1:+.0%}",
            f"{row['equations']:.2f} s", f"{row['compiling']:.1f} s",
        )
        for row in rows
    ]  # fmt: skip
    heads = "links", "operations", "one evaluation", "off the line", "equations", "compiling"
    return figure(rows), f"{table(heads, lines, 0)}\n{measured_on(content)}\n"


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


@makes("free_chains.svg", "free-chains", numbers="free_chains.json")
def free(content: dict) -> tuple[Figure, str]:
    """Terms, times and memory of chains of free bars, then times of ``check``."""
    rows = content["rows"]
    lines = [
        (
            row["bars"], row["terms"], f"{row['first']:.1f} s",
            f"{1e9 * row['evaluation'] / row['bars']:.0f} ns", f"{row['memory']:.0f} MB",
        )
        for row in rows if "first" in row
    ]  # fmt: skip
    heads = "free bars", "terms", "first sample", "one evaluation per bar", "memory"
    checked = [
        (row["bars"], f"{row['dyads']:.1f} s", f"{row['driven']:.1f} s")
        for row in rows
        if "dyads" in row
    ]
    others = table(("bars", "`check` of a chain of dyads", "of driven bars"), checked, 0)
    note = f"{measured_on(content).removesuffix('.')}; times of the processor."
    return free_figure(rows), f"{table(heads, lines, 0)}\n{others}\n{note}\n"
