"""Make the map of touches and exponents of docs/contact_published.md.

python docs/figures_contact_map.py                        # 100 × 100 points: 15 minutes
python docs/figures_contact_map.py --points 40            # fewer
python docs/figures_contact_map.py --store contact.map    # goes on where it was interrupted
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np
import xarray as xr
from figures import STATIC, write_small, write_table
from figures_contact_published import LAWS, mechanism
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

import linkages
from linkages.plots.chaos.diagrams import draw_touches, indicator_map
from linkages.plots.layout import panels, with_bar
from linkages.plots.style import styled

SPEEDS, SIZES = "500rpm:6000rpm", "0.01mm:0.5mm"
PERIODS, SKIP = 60, 30
"""Revolutions that count, and those before them."""

LAW = "constant dissipation, 0.5 s/m"
BOUNDS = (0.0, 0.1, 0.2, 0.5)
"""Of the rows of the table, in millimetres."""


def computed(points: int, store: Path | None) -> xr.Dataset:
    """Touches and the largest exponent over speed and size."""
    return linkages.chaos_map(
        mechanism("0.5 mm", LAWS[LAW]),
        f"drives.crank.speed={SPEEDS}:{points}",
        f"clearances.gap.size={SIZES}:{points}",
        periods=PERIODS,
        skip=SKIP,
        rtol=1e-8,
        store=store,
    )


@styled
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


def table(data: xr.Dataset) -> str:
    """What is found over ranges of the size."""
    lines = [
        "| radial clearance | points | never loses contact | chaotic "
        "| most touches per revolution |",
        "|--:|--:|--:|--:|--:|",
    ]
    sizes, touches = data[data.attrs["y"]].to_numpy(), data.touches.sel(touch="gap").to_numpy()
    known = np.isfinite(data.indicator.to_numpy())
    for low, high in pairwise(BOUNDS):
        rows = ((sizes > low) & (sizes <= high * (1 + 1e-9)))[:, None] & known
        share = [float(where[rows].mean()) for where in (touches == 0, data.sign.to_numpy() > 0)]
        most = np.nanmax(np.where(rows, touches, 0.0))
        lines.append(
            f"| {low:g} to {high:g} mm | {rows.sum()} | {share[0]:.0%} | {share[1]:.0%} "
            f"| {most:.0f} |"
        )
    return "\n".join([*lines, ""])


def main() -> None:
    """Write figure and table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=100, help="along either axis")
    parser.add_argument("--store", type=Path, help="folder that keeps what is done")
    given = parser.parse_args()
    data = computed(given.points, given.store)
    write_small(figure(data), STATIC / "contact-map.png", colours=None)
    write_table("contact-map", table(data))


if __name__ == "__main__":
    main()
