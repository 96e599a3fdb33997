"""The figure and the table of the press with contact in one joint."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.plots.panels import panels
from linkages.plots.style import BLACK
from make.registry import makes, table

ANGLE = math.radians(-36.7)
"""Where the pin touches its hole at the start, in both models."""

CONTACT = {
    "contact": "hunt-crossley-constant",
    "stiffness": "1e11 N/m^1.5",
    "dissipation": "1 s/m",
}
SIZE = 0.15e-3
SIZES = np.geomspace(0.02e-3, 1e-3, 16)
FACTORS = np.geomspace(0.5, 16, 21)
SPEEDS_SHOWN, SIZES_SHOWN = (0.5, 1, 2, 4, 8, 16), (0.02, 0.05, 0.1, 0.2, 0.5, 1)
TURNS = (1, 3)
"""Of the cranks: the first is left out, the others are judged."""

LINK, OPEN = "massless link", "contact"
SHARES = {LINK: "massless link pulls", OPEN: "contact: free flight"}
BAR = 0.4  # inches, for the colour bar above each panel


def mechanism(kind: str, size: float, factor: float) -> linkages.Mechanism:
    """The press at a multiple of the speeds of the paper."""
    start = (
        {"angle": ANGLE}
        if kind == LINK
        else {**CONTACT, "offset": [size * math.cos(ANGLE), size * math.sin(ANGLE)]}
    )
    gap = {"joint": "C", "bar": "link3", "size": size, **start}
    speeds = {"drives.crank1.speed": -math.pi * factor, "drives.crank4.speed": math.pi * factor}
    return linkages.load("ninebar").with_values({"clearances.r1": gap, **speeds})


def solved(kind: str, size: float, factor: float, samples: int = 20_000) -> linkages.Solution:
    """Two turns of the cranks behind a first one."""
    times = np.linspace(*(2.0 * turns / factor for turns in TURNS), samples)
    names = ["slider_position_error", "drive_effort", "clearance_force"]
    found = mechanism(kind, size, factor)
    return linkages.simulate(
        found,
        times=np.concatenate([[0.0], times]),
        outputs=names if kind == LINK else [*names, "clearance_indentation"],
    )


def apart(kind: str, solution: linkages.Solution) -> float:
    """Share of time in which nothing presses: the link pulls, or the journal flies."""
    data = solution.data.isel(time=slice(1, None))
    values = data.clearance_force if kind == LINK else data.clearance_indentation
    return float((values < 0).mean())


@makes("contact-press")
def comparison() -> str:
    """Both models at several speeds, one beside the other."""
    heads = ("speed", "model", "share of time without pressure", "largest deviation of the slider",
             "torque, crank 1", "force in r1")  # fmt: skip
    lines = []
    for factor in (0.5, 1, 2, 4, 8):
        for kind in (LINK, OPEN):
            solution = solved(kind, SIZE, factor)
            data = abs(solution.data.isel(time=slice(1, None)))
            lines.append((
                f"{factor:g} ×", kind, f"{apart(kind, solution):.1%}",
                f"{1e3 * float(data.slider_position_error.max()):.3f} mm",
                f"{float(data.drive_effort.sel(drive='crank1').max()):.0f} N m",
                f"{float(data.clearance_force.max()):.0f} N",
            ))  # fmt: skip
    return table(heads, lines, 2)


@makes("contact-press.svg")
def shares() -> Figure:
    """Where over clearance and speed contact is lost, in both models."""
    figure, axes = panels(1, 2, 2.9)
    for ax, kind in zip(axes, (LINK, OPEN), strict=True):
        found = np.array(
            [[100 * apart(kind, solved(kind, s, f, 4000)) for f in FACTORS] for s in SIZES]
        )
        mesh = ax.pcolormesh(FACTORS, 1e3 * SIZES, found, cmap="Oranges", vmin=0, vmax=100)
        ax.set(xscale="log", yscale="log", xlabel="crank speed over the published one")
        ax.set_xticks(SPEEDS_SHOWN, map("{:g}".format, SPEEDS_SHOWN))
        ax.set_yticks(SIZES_SHOWN, map("{:g}".format, SIZES_SHOWN))
        ax.minorticks_off()
        ax.grid(visible=False)
        ax.plot(1.0, 1e3 * SIZE, "o", color=BLACK, markersize=4, label="published")
        label = f"{SHARES[kind]} [% of time]"
        figure.colorbar(mesh, ax=ax, label=label, location="top")
    axes[0].set_ylabel("radial clearance [mm]")
    axes[0].legend(loc="lower right")
    return figure
