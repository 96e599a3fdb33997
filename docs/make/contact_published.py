"""A published slider-crank with contact, and the impact map of a shipped one."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.plots.chaos.chaos_figures import impact_map_figure
from linkages.plots.motion.clearance_orbit import SHOWN, clearance_orbit
from linkages.plots.panels import panels
from linkages.plots.style import PALETTE
from make.registry import definition, makes, table

PERIOD, TRANSIENT, REVOLUTIONS = 0.012, 80, 400
HEIGHT = 1.5  # inches, of a panel over time
SIZES = ("0.5 mm", "0.2 mm", "0.1 mm", "0.05 mm")
LAWS = {
    "Lankarani–Nikravesh, 0.9": {},
    "constant dissipation, 0.5 s/m": {
        "contact": "hunt-crossley-constant",
        "dissipation": 0.5,
        "restitution": None,
        "least_rate": None,
    },
}


def mechanism(size: str, law: dict[str, object]) -> linkages.Mechanism:
    """The one of the page with another clearance."""
    found = definition("contact_published.md", "slider-crank-contact.yaml")
    gap = {**found.definition.content["clearances"]["gap"], **law, "size": size}
    kept = {key: value for key, value in gap.items() if value is not None}
    return found.with_values({"clearances.gap": kept})


def row(name: str, size: str, law: dict[str, object]) -> tuple[str, ...]:
    """Means behind the transient, and the largest exponent."""
    found = mechanism(size, law)
    times = np.linspace(TRANSIENT, TRANSIENT + REVOLUTIONS, 200 * REVOLUTIONS + 1) * PERIOD
    solution = linkages.simulate(
        found,
        times=np.concatenate([[0.0], times]),
        rtol=1e-9,
        events={"gap.indentation=0": "up"},
        outputs=["clearance_indentation", "clearance_indentation_rate", "clearance_force"],
    )
    data = solution.data.isel(time=slice(1, None))
    touches = solution.events["gap.indentation=0"]
    rates = touches.clearance_indentation_rate[touches.time > TRANSIENT * PERIOD, 0].to_numpy()
    free = float((data.clearance_indentation < 0).mean())
    exponents = linkages.lyapunov(found, periods=REVOLUTIONS, skip=TRANSIENT, count=1)
    exponent = float(exponents.exponent.max()) * PERIOD
    rate = f"{rates.mean():.2f} m/s" if len(rates) else "–"
    return (
        size,
        name,
        f"{len(rates) / REVOLUTIONS:.1f}",
        f"{free:.0%}",
        rate,
        f"{round(exponent, 1) + 0.0:+.1f}",
    )


@makes("contact-published")
def cases() -> str:
    """One line for each clearance and law."""
    heads = ("radial clearance", "law", "touches per revolution", "in flight",
             "mean speed of a touch", "largest Lyapunov exponent per revolution")  # fmt: skip
    return table(heads, (row(name, s, law) for name, law in LAWS.items() for s in SIZES), 2)


@makes("contact-published.png")
def figure() -> Figure:
    """Two revolutions: acceleration and torque over time, and the orbit of the journal."""
    found = mechanism("0.5 mm", {})
    data = linkages.simulate(
        found,
        end=2 * PERIOD,
        samples=8001,
        rtol=1e-11,
        outputs=["slider_acceleration", "drive_effort", *SHOWN],
    ).data
    drawn, (above, orbit, below, empty) = panels(2, 2, HEIGHT, widths=(0.6, 0.4))
    empty.remove()
    orbit.remove()
    orbit = drawn.add_subplot(orbit.get_gridspec()[:, 1])
    axes = above, below
    time = 1e3 * data.time
    for panel, values, label in (
        (axes[0], 1e-3 * data.slider_acceleration[:, 0], "slider acceleration\n[10³ m/s²]"),
        (axes[1], data.drive_effort[:, 0], "crank torque [N·m]"),
    ):
        panel.plot(time, values, linewidth=0.6, color=PALETTE[0])
        panel.set_xlim(0.0, 2e3 * PERIOD)
        panel.set_ylabel(label)
    axes[-1].set_xlabel("time [ms]")
    clearance_orbit(data, "gap", orbit)
    return drawn


@makes("contact-touches.png")
def touch_map() -> Figure | None:
    """Rates and directions of touches over the phase."""
    shipped = linkages.load("slider-crank-contact")
    options = {"section": "gap.touch", "periods": 3000, "skip": 100, "end": 6.0}
    return impact_map_figure(linkages.poincare(shipped, **options, rtol=1e-8))
