"""The map of touches and exponents of a published slider-crank."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

import linkages
from linkages.plots.chaos.diagrams import draw_touches, indicator_map
from linkages.plots.panels import panels, with_bar
from make.contact_published import LAWS, mechanism
from make.registry import makes, table

SPEEDS, SIZES = "drives.crank.speed=500rpm:6000rpm:100", "clearances.gap.size=0.01mm:0.5mm:100"
PERIODS, SKIP = 60, 30
"""Revolutions that count, and those before them."""

LAW = "constant dissipation, 0.5 s/m"
BOUNDS = (0.0, 0.1, 0.2, 0.5)
"""Of the rows of the table, in millimetres."""


@makes("contact-map.png", "contact-map", colours=None)
def both() -> tuple[Figure, str]:
    """Touches and the largest exponent over speed and size."""
    published = mechanism("0.5 mm", LAWS[LAW])
    data = linkages.chaos_map(published, SPEEDS, SIZES, periods=PERIODS, skip=SKIP, rtol=1e-8)
    return figure(data), ranges(data)


def figure(data: xr.Dataset) -> Figure:
    """Both, side by side, each beside its colour bar."""
    drawn, axes = panels(1, 2, 3.0)
    draw_touches(axes[0], data, "gap")
    with_bar(axes[0], "touches per revolution", ticks=LogLocator(), format="%g")
    indicator_map(data, axes[1])
    for ax in axes:
        ax.set_xlabel("crank speed [rpm]")
    axes[0].set_ylabel("radial clearance [mm]")
    axes[1].set_ylabel("")
    return drawn


def ranges(data: xr.Dataset) -> str:
    """What is found over ranges of the size."""
    sizes, touches = data[data.attrs["y"]].to_numpy(), data.touches.sel(touch="gap").to_numpy()
    known = np.isfinite(data.indicator.to_numpy())
    lines = []
    for low, high in pairwise(BOUNDS):
        rows = ((sizes > low) & (sizes <= high * (1 + 1e-9)))[:, None] & known
        never, chaotic = (
            f"{where[rows].mean():.0%}" for where in (touches == 0, data.sign.to_numpy() > 0)
        )
        most = np.nanmax(np.where(rows, touches, 0.0))
        lines.append((f"{low:g} to {high:g} mm", rows.sum(), never, chaotic, f"{most:.0f}"))
    heads = "points", "never loses contact", "chaotic", "most touches per revolution"
    return table(("radial clearance", *heads), lines, 0)
