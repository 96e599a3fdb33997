"""The figure and the table on the route to chaos of a published slider-crank with contact."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from scipy.optimize import brentq

import linkages
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.run import RunOptions
from linkages.plots.panels import panels
from linkages.plots.style import BLACK
from make.contact_published import LAWS, mechanism
from make.registry import DOCS, makes, table

Floats = NDArray[np.float64]

COLUMNS = 420
SIDES = ("left", "right")
DOTS = {"color": BLACK, "markersize": 1.3, "alpha": 0.35, "mew": 0}

PERIOD = 0.012
SIZE = "clearances.gap.size"
FEIGENBAUM = 4.669202
FIRST, STEP = 0.1200e-3, 1e-6
"""Where the cascade is entered from above, and how it is first walked along, in metres."""

LONGEST = 64
"""Revolutions of the longest orbit whose doubling is located."""

RUN = RunOptions(rtol=1e-12, max_steps=10**9)
NEAR = 1e-8
"""Metres beside an orbit that has doubled at which its successor is looked for."""

ROUTE = mechanism("0.1 mm", LAWS["constant dissipation, 0.5 s/m"])


class Orbits:
    """Periodic orbits of the slider-crank at crank angle 0, by Newton's method on their points."""

    def __init__(self) -> None:
        self._varying = Varying(ROUTE)

    def system(self, size: float, point: Floats | None = None) -> System:
        """The mechanism with a clearance of so many metres, from a point on."""
        found = self._varying.at({SIZE: size})
        return found if point is None else found.at(0.0, point)

    def turned(self, size: float, point: Floats | None, revolutions: int) -> Floats:
        """Where the pin is so many revolutions later."""
        system = self.system(size, point)
        tangents = LinkageTangents(system, 1, RUN)
        for _ in tangents.grow(revolutions, PERIOD):
            pass
        return tangents.state

    def closed(self, size: float, point: Floats, revolutions: int) -> tuple[Floats, Floats]:
        """The orbit of so many revolutions near a point, and its multipliers."""
        for _ in range(12):
            tangents = LinkageTangents(self.system(size, point), 4, RUN)
            tangents.tangents = np.eye(4)
            tangents.advance(revolutions * PERIOD)
            monodromy = tangents.tangents
            change = np.linalg.solve(monodromy - np.eye(4), point - tangents.state)
            point = point + change
            if np.abs(change[:2]).max() < 1e-14:
                break
        return point, np.linalg.eigvals(monodromy)

    def beyond(self, size: float, point: Floats, revolutions: int) -> tuple[float, Floats]:
        """How far the least multiplier is above −1, where an orbit doubles its period."""
        point, multipliers = self.closed(size, point, revolutions)
        return float(multipliers.real.min()) + 1.0, point


def doublings() -> Iterator[tuple[int, float]]:
    """Revolutions of an orbit and the size at which they double, the first one first."""
    orbits, size, step, revolutions = Orbits(), FIRST, STEP, 1
    point = orbits.turned(size, None, 400)
    found: list[float] = []
    while revolutions <= LONGEST:
        above, here = size, point
        value, point = orbits.beyond(size, point, revolutions)
        while value > 0.0:
            above, here, size = size, point, size - step
            value, point = orbits.beyond(size, point, revolutions)
        near = here

        def function(place: float, near: Floats = near, number: int = revolutions) -> float:
            return orbits.beyond(place, near, number)[0]

        found.append(float(brentq(function, size, above, xtol=1e-16)))
        yield revolutions, found[-1]
        apart = (found[-2] - found[-1]) / FEIGENBAUM if len(found) > 1 else 0.3 * STEP
        size, step = found[-1] - 0.4 * apart, 0.1 * apart
        aside = orbits.closed(size, here, revolutions)[0] + [NEAR, 0.0, 0.0, 0.0]
        revolutions *= 2
        point = orbits.turned(size, aside, 200 * revolutions)


@makes("contact-route")
def cascade() -> str:
    """Sizes at which the period doubles, and the ratios of what lies between them."""
    found, lines = list(doublings()), []
    sizes = [size for _, size in found]
    for number, (revolutions, size) in enumerate(found):
        ratio = "" if number < 2 else f"{_ratio(sizes[number - 2 : number + 1]):.3f}"
        lines.append((f"{revolutions} → {2 * revolutions}", f"{1e3 * size:.8f} mm", ratio))
    return table(("revolutions", "doubled below", "ratio"), lines, 0)


def known() -> list[tuple[int, float]]:
    """Periods that double, and sizes in metres, that the table on the page gives."""
    page = (DOCS / "contact_published.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) → \d+ \| ([\d.]+) mm \|", page, re.MULTILINE)
    return [(int(count), 1e-3 * float(size)) for count, size in rows]


def _ratio(sizes: list[float]) -> float:
    first, middle, last = sizes
    return (first - middle) / (middle - last)


@makes("contact-route.png")
def figure() -> Figure:
    """Poincaré section points over the clearance: the whole range, and the cascade."""
    drawn, axes = panels(2, 1, 2.4)
    found = known()
    for ax, (first, end, count, skip), small in (
        (axes[0], (0.04e-3, 0.25e-3, COLUMNS, 150), False),
        (axes[1], (0.1183e-3, 0.1200e-3, COLUMNS, 300), True),
    ):
        sizes = np.linspace(first, end, count)
        data = linkages.bifurcation(
            ROUTE, {SIZE: sizes}, periods=40, skip=skip, start="backward", rtol=1e-9
        )
        places = data["offset_position"].sel(offset="gap.y")[0].to_numpy()
        over = np.repeat(1e3 * sizes[:, None], places.shape[1], axis=1)
        ax.plot(over.ravel(), 1e6 * places.ravel(), "o", **DOTS)
        ax.set_xlim(1e3 * first, 1e3 * end)
        ax.xaxis.set_major_locator(MaxNLocator(6, prune="upper"))
        ax.set_ylabel("journal offset y\nat crank angle 0 [µm]")
        if small:
            for count, size in (*found[:3], found[-1]):
                final = size == found[-1][1]
                look = {"color": "0.6", "linewidth": 0.8, "linestyle": "--" if final else "-"}
                ax.axvline(1e3 * size, zorder=0.5, **look)
                words = f"{'period ' if count == 1 else ''}{count} → {2 * count}"
                place = 1e3 * size, 1.015  # the last two are close to each other
                ax.text(*place, words, transform=ax.get_xaxis_transform(), ha=SIDES[final])
        ax.set_xlabel("radial clearance [mm]")
    return drawn
