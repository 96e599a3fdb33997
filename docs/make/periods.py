"""Isoperiodic planes of the impact oscillator, of a slider-crank with contact and of the press."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from scipy.linalg import expm
from scipy.optimize import brentq

import linkages
from linkages.plots.chaos.diagrams import period_map
from linkages.sweeps.axes import parse_axis
from make.contact_route import ROUTE
from make.registry import definition, makes, makes_each

POINTS = 400

DAMPING, RESTITUTION = 0.1, 0.8
"""Of the impact oscillator, whose mass, stiffness and distance from the stop are 1."""

TIP = 0.75
"""Frequency above which the doubling is that of motions that graze nowhere else."""

JOINT = {
    "joint": "C", "bar": "link3", "size": "0.15 mm", "contact": "hunt-crossley-constant",
    "stiffness": "1e9 N/m^1.5", "dissipation": "5 s/m", "pin_radius": "10 mm",
}  # fmt: skip
"""The joint r1 of the nine-bar press, with contact."""

Floats = np.ndarray


def gain(frequency: float) -> complex:
    """Complex amplitude of the response without a stop to a force of amplitude 1."""
    return 1.0 / complex(1.0 - frequency**2, DAMPING * frequency)


def grazing(frequency: float) -> float:
    """Amplitude at which the motion without impacts touches the stop."""
    return 1.0 / abs(gain(frequency))


def doubling(frequency: float) -> float:
    """Amplitude at which the motion with one impact in one period doubles its period."""

    def multipliers(amplitude: float) -> float:
        trace, determinant = _monodromy(frequency, amplitude)
        return 1.0 + trace + determinant

    return float(brentq(multipliers, grazing(frequency) + 1e-9, 2.0, xtol=1e-14))


def _monodromy(frequency: float, amplitude: float) -> tuple[float, float]:
    """Trace and determinant of the motion with one impact in one period.

    The response r to the force has a period, so that a free oscillation y = x − r leads from behind
    an impact to the next one: exp(J T) (1 − r, −e v − r′) = (1 − r, v − r′). This is linear in
    (1 − r, r′) and the rate v; r² + (r′/ω)² is known.
    """
    length = 2 * np.pi / frequency
    free = expm(length * np.array([[0.0, 1.0], [-1.0, -DAMPING]]))
    right = np.array([RESTITUTION * free[0, 1], 1.0 + RESTITUTION * free[1, 1]])
    ahead, rate = np.linalg.solve(free - np.eye(2), right)  # (1 − r)/v and −r′/v
    size = amplitude * abs(gain(frequency))
    square, linear, constant = ahead**2 + (rate / frequency) ** 2, -2 * ahead, 1.0 - size**2
    speed = (-linear + np.sqrt(linear**2 - 4 * square * constant)) / (2 * square)
    force = ((1.0 - ahead * speed + 1j * rate * speed / frequency) / gain(frequency)).real
    before, after = force - DAMPING * speed - 1.0, force + DAMPING * RESTITUTION * speed - 1.0
    lower = (after + RESTITUTION * before) / speed
    saltation = np.array([[-RESTITUTION, 0.0], [lower, -RESTITUTION]])
    whole = saltation @ free
    return float(np.trace(whole)), float(np.linalg.det(whole))


def curves() -> dict[str, tuple[Floats, Floats]]:
    """Loci in the plane of amplitude and frequency, in closed form."""
    whole, part = np.linspace(0.4, 1.6, 400), np.linspace(TIP, 0.994, 120)
    return {
        "grazing": (np.array([*map(grazing, whole)]), whole),
        "doubling": (np.array([*map(doubling, part)]), part),
    }


@makes("chaos-periods.png")
def oscillator_plane() -> Figure:
    """Amplitude and frequency of the force."""
    data = linkages.chaos_map(
        definition("chaos.md", "oscillator.yaml"),
        f"parameters.A=0.05:1:{POINTS}",
        f"parameters.w=0.5:1.5:{POINTS}",
        indicator="period",
        periods=200,
        refine=8,
    )
    return period_map(data, curves=curves()).figure


def loci(
    mechanism: linkages.Mechanism, size: str, starts: dict[str, str], second: list[str]
) -> list[xr.Dataset]:
    """Loci over clearance and speed of labelled points, of the branch through each clearance."""
    return [
        linkages.follow(
            mechanism.with_values({size.partition("=")[0]: start}),
            [size], periods=1, points=120, locus=label, other=second,
        )
        for start, labels in starts.items()
        for label in labels.split()
    ]  # fmt: skip


@makes("contact-periods.png")
def slider_crank_plane() -> Figure:
    """Speed and clearance of the contact slider-crank."""
    mechanism = ROUTE.with_values({"name": "Slider-crank with contact"})
    sizes, speeds = "clearances.gap.size=0.05mm:0.2mm", "drives.crank.speed=4000rpm:6000rpm"
    starts = {"0.08 mm": "F1", "0.089 mm": "F1 PD1", "0.12 mm": "F1 PD1", "0.145 mm": "F1 PD1"}
    data = linkages.chaos_map(
        mechanism,
        f"{speeds}:{POINTS}",
        f"{sizes}:{POINTS}",
        indicator="period",
        refine=16,
        rtol=1e-10,
    )
    found = loci(mechanism, sizes, starts, [speeds])
    return period_map(data, curves=found).figure


PRESS = {
    "press-periods": ((60, 120), "0.05mm:0.5mm", 8, {}),
    "press-island": ((99.7, 100.2), "0.196mm:0.202mm", 4, {"0.197 mm": "PD1"}),
}
"""Speeds in rpm, clearances, refinement and starts of loci: the whole plane, and a part of it."""


@makes_each({(f"{name}.png",): (name,) for name in PRESS})
def press_plane(name: str) -> Figure:
    """Speed and clearance of the nine-bar press with contact in the joint r1."""
    mechanism = linkages.load("ninebar", set={"clearances.r1": JOINT})
    (slow, fast), size, refine, starts = PRESS[name]
    speeds = [f"drives.crank4.speed={slow}rpm:{fast}rpm",
              f"drives.crank1.speed={-slow}rpm:{-fast}rpm"]  # fmt: skip
    sizes, count = f"clearances.r1.size={size}", 160
    data = linkages.chaos_map(
        mechanism,
        parse_axis(",".join(f"{speed}:{count}" for speed in speeds)),
        f"{sizes}:{count}",
        indicator="period",
        refine=refine,
        rtol=1e-9,
    )
    own = {"drives.crank4.speed": "100 rpm", "drives.crank1.speed": "-100 rpm"}
    found = loci(mechanism.with_values(own), sizes, starts, speeds)
    return period_map(data, curves=found).figure
