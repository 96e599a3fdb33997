"""The figure and the table on the worn engine of README.md."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import linkages
from linkages.plots.panels import labelled, legend_above, panels
from linkages.plots.style import PALETTE
from make.registry import definition, makes, table

CONTACT = {
    "joint": "A",
    "bar": "rod",
    "contact": "hunt-crossley-constant",
    "stiffness": "2e9 N/m^1.5",
    "dissipation": "1.5 s/m",
}
SIZES = (0.05, 0.1, 0.2)
"""In millimetres."""

CASES = {
    "60 rpm, 200 N": (60.0, 200.0),
    "600 rpm, 20 N": (600.0, 20.0),
}
"""Name → speed of the crank in rpm, force on the piston in newtons."""

TRANSIENT, REVOLUTIONS = 20, 20
VERDICT_PERIODS = 300


def mechanism(size: float, case: str) -> linkages.Mechanism:
    """The engine of the README with contact."""
    speed, force = CASES[case]
    return definition("../README.md", "engine.yaml").with_values(
        {
            "clearances.gap": {**CONTACT, "size": f"{size} mm"},
            "drives.crank.speed": f"{speed} rpm",
            "loads[0].force": -force,
        }
    )


def solved(size: float, case: str, revolutions: int, each: int) -> linkages.Solution:
    """Some revolutions behind the transient."""
    period = 60.0 / CASES[case][0]
    times = period * (TRANSIENT + np.linspace(0, revolutions, revolutions * each + 1))
    return linkages.simulate(
        mechanism(size, case),
        times=np.concatenate([[0.0], times]),
        rtol=1e-9,
        events={"gap.touch": "up"},
        outputs=["slider_position_error", "clearance_force", "clearance_indentation"],
    )


def behind(solution: linkages.Solution) -> xr.Dataset:
    """What is judged: all but the start."""
    return solution.data.isel(time=slice(1, None))


def row(size: float, case: str) -> tuple[str, ...]:
    """The verdict on a case, and what its contact does."""
    period = 60.0 / CASES[case][0]
    solution = solved(size, case, REVOLUTIONS, 2000)
    data = behind(solution)
    touched = (solution.events["gap.touch"].time > TRANSIENT * period).sum()
    report = linkages.verdict(mechanism(size, case), periods=VERDICT_PERIODS)
    value, error = (float(report.exponents[name][0]) for name in ("exponent", "error"))
    digits = max(0, int(np.ceil(-np.log10(error))))
    return (
        case, f"{size:g} mm", f"{float(touched) / REVOLUTIONS:.1f}",
        f"{float((data.clearance_indentation < 0).mean()):.0%}",
        f"{float(data.clearance_force.max()):.0f} N",
        f"{value:.{digits}f} ± {error:.{digits}f} 1/s", f"**{report.verdict}**",
    )  # fmt: skip


@makes("contact-worn")
def cases() -> str:
    """One line for each case and size."""
    heads = ("engine", "radial clearance", "touches per revolution", "in flight", "largest force",
             "largest Lyapunov exponent", "verdict")  # fmt: skip
    return table(heads, (row(size, case) for case in CASES for size in SIZES))


@makes("contact-worn.png")
def figure() -> Figure:
    """One revolution of all sizes: deviation of the piston, force in the gap."""
    drawn, axes = panels(2, 2, 2.1)
    for above, case in zip((axes[:2], axes[2:]), CASES, strict=True):
        forces: list[np.ndarray] = []
        for index, size in enumerate(SIZES):
            data = behind(solved(size, case, 1, 4000))
            turn = 360 * np.linspace(0, 1, data.sizes["time"])
            style = {"color": PALETTE[index], "linewidth": 0.9, "zorder": 4 - index}
            above[0].plot(turn, 1e6 * data.slider_position_error[:, 0], **style, label=f"{size} mm")
            force = data.clearance_force[:, 0].to_numpy()
            above[1].plot(turn, force, **style)
            forces.append(force)
        above[0].set_ylabel("position error of the piston [µm]")
        above[1].set_ylabel("clearance force [N]")
        legend_above(above[0], labelled(above[0].lines), f"{case}, radial clearance")
        apart = max(np.abs(force - forces[0]).max() for force in forces)
        if apart < 1e-3 * np.abs(forces[0]).max():
            above[1].set_title("the three curves coincide")
        for ax in above:
            ax.set_xlim(0, 360)
            ax.set_xticks(range(0, 361, 90))
    for ax in axes[2:]:
        ax.set_xlabel("crank angle [°]")
    return drawn
