"""Figures and tables of the page on long runs: what a method adds or takes away."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

import linkages
from linkages.plots.panels import panels
from linkages.plots.style import BLACK, GREY, PALE, line_style
from make.accuracy import SETTINGS, logarithmic
from make.registry import makes, table

HELD = {"drives.crank1.speed": 0.0, "drives.crank4.speed": 0.0}
DRIFT_END = 100.0
DRIFTS: list[tuple[str, dict[str, float]]] = [
    ("dop853", {"rtol": 1e-10}),
    ("tsit5", {"rtol": 1e-10}),
    ("vern9", {"rtol": 1e-10}),
    ("radau", {"rtol": 1e-6}),
    ("rk4", {"step": 1e-4}),
    ("rk4", {"step": 1e-5}),
    ("gauss8", {"step": 5e-4}),
    ("gauss8", {"step": 1e-4}),
]
CLOSURE_STEP, CLOSURE_END, CLOSURE_SAMPLES = 1e-5, 100.0, 100_001
APART = 0.052  # of the height: between labels beside lines
SIZES = [10.0**k for k in range(-9, -1)]
DAMPING_STEPS = [5e-4, 1e-4, 2.5e-5]
PERIOD, PERIODS, PER_PERIOD = 2.0, 50, 2000
Drift = tuple[str, np.ndarray, np.ndarray, int]
"""Method and setting, times, energy gained, evaluations."""


def drifts() -> tuple[list[Drift], float]:
    """Energy gained over time by each method; the energy of the libration in joules.

    The drives of the nine-bar are held: its clearance link librates, and nothing adds energy.
    """
    mechanism = linkages.load("ninebar", set=HELD)
    found: list[Drift] = []
    swing = 0.0
    for method, values in DRIFTS:
        solution = linkages.simulate(
            mechanism,
            end=DRIFT_END,
            samples=20_001,
            method=method,
            outputs=["kinetic_energy", "potential_energy"],
            **values,
        )
        data = solution.data
        energy = (data.kinetic_energy + data.potential_energy).to_numpy()
        swing = max(swing, float(data.kinetic_energy.max()))
        ((key, value),) = values.items()
        label, evaluations = f"{method}, {key}={value:g}", solution.motion.cost["evaluations"]
        found.append((label, data.time.to_numpy(), energy - energy[0], evaluations))
    return found, swing


def drift_figure(found: list[Drift], swing: float) -> Figure:
    """Largest error of the energy so far over time, both logarithmic."""
    figure, (axes,) = panels(1, 1, 3.4)
    methods = list(dict.fromkeys(label.split(",")[0] for label, *_ in found))
    drawn: set[str] = set()
    ends: list[tuple[float, float, str, str]] = []
    for label, time, energy, _ in found:
        method = label.split(",")[0]
        index = methods.index(method)
        largest = np.maximum.accumulate(np.abs(energy)) / swing
        # as many points in every decade, after the first swings
        places = np.unique(np.searchsorted(time, np.geomspace(0.05, time[-1], 300)))
        # the second setting of a method has the same line with dots
        look = {"marker": "o", "markersize": 3.5, "markevery": 25} if method in drawn else {}
        axes.loglog(time[places], largest[places], **line_style(index), **look)
        drawn.add(method)
        ends.append((time[-1], largest[-1], in_words(label), line_style(index)["color"]))
    logarithmic(axes)
    axes.set_xlim(0.04, DRIFT_END)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("largest energy error so far\nover the energy of the libration")
    axes.set_title("Nine-bar with its drives held")
    label_ends(axes, ends)
    return figure


def in_words(label: str) -> str:
    """A method and its setting as figures have them."""
    method, values = label.split(", ")
    key, value = values.split("=")
    return f"{method}, {SETTINGS[key](float(value))}"


def label_ends(axes: Axes, ends: list[tuple[float, float, str, str]]) -> None:
    """Write x, y, text and colour of each line beside it, in the margin and one below the other."""
    heights = np.log10([end[1] for end in ends])
    low, high = np.log10(axes.get_ylim())
    places = (heights - low) / (high - low)
    order = np.argsort(places)
    while (np.diff(places[order]) < 0.999 * APART).any():
        for lower, upper in pairwise(order):
            push = max(0.0, APART - (places[upper] - places[lower])) / 2
            places[[lower, upper]] += -push, push
    for (x, y, text, colour), place in zip(ends, places, strict=True):
        axes.annotate(
            text,
            (x, y),
            xytext=(1.04, place),
            textcoords="axes fraction",
            color=colour,
            fontsize=8,
            va="center",
            arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.5, "relpos": (0, 0.5)},
        )


@makes("energy-drift.svg", "energy-drift")
def energy_drift() -> tuple[Figure, str]:
    """The figure; what is left of the energy at the end, and what the run costs."""
    found, swing = drifts()
    lines = []
    for label, time, energy, evaluations in found:
        method, values = label.split(", ")
        trend = np.polyfit(time, energy, 1)[0] / swing
        cost = f"{evaluations / DRIFT_END:,.0f}"
        ends = f"{energy[-1] / swing:+.1e}", f"{trend:+.1e}"
        lines.append((f"`{method}`, `{values}`", f"{DRIFT_END:g} s", cost, *ends))
    heads = ("method", "simulated", "evaluations per simulated second", "energy error at the end",
             "trend per second")  # fmt: skip
    note = f"Errors in units of the energy of the libration, {1e3 * swing:.3g} mJ."
    return drift_figure(found, swing), f"{table(heads, lines)}\n{note}\n"


def closures() -> tuple[np.ndarray, np.ndarray, int]:
    """Times and closure errors of a long run with RK4, and its number of steps."""
    solution = linkages.simulate(
        linkages.load("ninebar"),
        end=CLOSURE_END,
        samples=CLOSURE_SAMPLES,
        method="rk4",
        step=CLOSURE_STEP,
        outputs=["closure_residual"],
    )
    data = solution.data
    return data.time.to_numpy(), data.closure_residual.to_numpy(), solution.motion.cost["steps"]


def closure_figure(time: np.ndarray, residual: np.ndarray) -> Figure:
    """Largest error in every second, and how often each size occurs."""
    figure, (left, right) = panels(1, 2, 2.5)
    unit = 1e-16
    seconds = residual[1:].reshape(round(time[-1]), -1).max(axis=1)
    left.step(np.arange(len(seconds)), seconds / unit, where="post", color=line_style(0)["color"])
    left.set_ylim(0, 1.35 * seconds.max() / unit)
    left.set_xlim(0, time[-1])
    left.set_xlabel("time [s]")
    left.set_ylabel("closure error [10⁻¹⁶ m]")
    left.set_title("Maximum per 1-s window")
    digit = 2.0**-53 / unit  # residuals are whole numbers of halves of it
    edges = digit * (np.arange(round(residual.max() / unit / digit) + 2) - 0.5)
    right.hist(
        residual / unit,
        bins=edges,
        weights=np.full(len(residual), 100 / len(residual)),
        color=line_style(0)["color"],
        edgecolor="white",
        linewidth=0.5,
    )
    right.set_xlabel("closure error [10⁻¹⁶ m]")
    right.set_ylabel("samples [%]")
    right.set_title("Relative frequency")
    right.yaxis.set_major_locator(MaxNLocator(6))
    return figure


@makes("closure-residual.svg", "closure-residual")
def constraint_error() -> tuple[Figure, str]:
    """The figure, and the largest error of all."""
    time, residual, steps = closures()
    return closure_figure(time, residual), (
        f"Largest closure error at {len(residual):,} samples of {steps:,} steps: "
        f"{residual.max():.1e} m.\n"
    )


def frequencies() -> np.ndarray:
    """Libration frequency in Hz for every radial clearance, with the drives held."""
    found = []
    for size in SIZES:
        data = linkages.simulate(
            linkages.load("ninebar", set={**HELD, "clearances.r1.size": size}),
            end=16.0 * math.sqrt(size),
            samples=4001,
            method="vern9",
            outputs=["clearance_speed"],
        ).data
        time, speed = data.time.to_numpy(), data.clearance_speed.to_numpy()[:, 0]
        before = np.flatnonzero(np.diff(np.sign(speed)) != 0)[1:]
        share = speed[before] / (speed[before] - speed[before + 1])
        turning = time[before] + share * np.diff(time)[before]
        found.append((len(turning) - 1) / 2 / (turning[-1] - turning[0]))
    return np.array(found)


def frequency_figure(frequency: np.ndarray) -> Figure:
    """Frequency against radial clearance with the fitted line."""
    figure, (axes,) = panels(1, 1, 2.8)
    slope, offset = frequency_fit(frequency)
    sizes = np.array([SIZES[0] / 2, SIZES[-1] * 2])
    axes.loglog(sizes, 10**offset * sizes**slope, color=BLACK, linewidth=0.8)
    axes.loglog(SIZES, frequency, "o", markersize=5, color=line_style(0)["color"])
    axes.annotate(
        f"slope {slope:.4f}".replace("-", "−"),
        (1e-6, 10**offset * 1e-6**slope),
        (12, 8),
        textcoords="offset points",
    )
    logarithmic(axes)
    axes.set_xlabel("radial clearance [m]")
    axes.set_ylabel("libration frequency [Hz]")
    axes.set_title("Nine-bar with its drives held")
    return figure


def frequency_fit(frequency: np.ndarray) -> np.ndarray:
    """Slope and offset on both log scales, from the sizes below a millimetre."""
    small = np.array(SIZES) < 0.9e-3
    return np.polyfit(np.log10(SIZES)[small], np.log10(frequency[small]), 1)


@makes("libration-frequency.svg", "libration-frequency")
def libration() -> tuple[Figure, str]:
    """The figure, its numbers, and the deviation of each from the line."""
    frequency = frequencies()
    slope, offset = frequency_fit(frequency)
    line = 10 ** (offset + slope * np.log10(SIZES))
    lines = [
        (f"{size:.0e}", f"{value:.6g}", f"{value / fitted - 1:+.0e}")
        for size, value, fitted in zip(SIZES, frequency, line, strict=True)
    ]
    heads = "radial clearance (m)", "frequency (Hz)", "deviation from the line"
    note = f"Fitted to clearances below 1 mm: frequency in proportion to r^{slope:.6f}."
    return frequency_figure(frequency), f"{table(heads, lines, 0)}\n{note}\n"


def amplitudes() -> dict[str, tuple[np.ndarray, float | None]]:
    """Run → largest speed of the clearance in each period, and the horizon in seconds."""
    runs: dict[str, dict] = {
        f"rk4, step={step:g}": {"method": "rk4", "step": step} for step in DAMPING_STEPS
    }
    runs["vern9, rtol=1e-10"] = {"method": "vern9"}
    found = {}
    for label, values in runs.items():
        solution = linkages.simulate(
            linkages.load("ninebar"),
            end=PERIOD * PERIODS,
            samples=PER_PERIOD * PERIODS + 1,
            outputs=["clearance_speed"],
            **values,
        )
        speed = np.abs(solution.data.clearance_speed.to_numpy()[1:, 0])
        horizon = solution.horizon
        until = None if horizon is None or horizon.whole else horizon.time
        found[label] = (speed.reshape(PERIODS, -1).max(axis=1), until)
    return found


def damping_figure(found: dict[str, tuple[np.ndarray, float | None]]) -> Figure:
    """Amplitude over time."""
    figure, (axes,) = panels(1, 1, 2.9)
    time = PERIOD * (np.arange(PERIODS) + 0.5)
    for index, (label, (amplitude, _)) in enumerate(found.items()):
        reference = {"color": PALE, "linewidth": 5.0, "zorder": 1.5}
        look = line_style(index) if label.startswith("rk4") else reference
        axes.plot(time, amplitude, label=in_words(label), **look)
    axes.set_xlim(0, PERIOD * PERIODS)
    axes.set_ylim(0, 340)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("largest clearance speed per period [rad/s]")
    axes.legend(loc="upper right", bbox_to_anchor=(1.0, 0.8))
    axes.set_title("Nine-bar, driven")
    return figure


@makes("coarse-rk4.svg", "coarse-rk4")
def damping() -> tuple[Figure, str]:
    """The figure, first and last amplitude, and what the program says of each run."""
    found, lines = amplitudes(), []
    for label, (amplitude, until) in found.items():
        method, values = label.split(", ")
        end = "throughout" if until is None else f"{until:.3g} s"
        ends = (f"{amplitude[k]:.1f}" for k in (0, -1))
        lines.append((f"`{method}`, `{values}`", *ends, end))
    heads = "run", "first period (rad/s)", "last period (rad/s)", "predictable until"
    return damping_figure(found), table(heads, lines)
