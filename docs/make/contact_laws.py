"""The figure of laws of contact and friction."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import linkages
from linkages.components.contributed.friction_laws import friction_coefficient, friction_laws
from linkages.plots.panels import labelled, legend_above, panels
from linkages.plots.style import BLACK, GREY, line_style
from make.registry import makes

BALL = """
gravity: [0, 0]
joints: {{O: [0, 0]}}
bars: {{ball: {{joints: [O, A], length: 1, center: 0, mass: 1, inertia: 1}}}}
clearances:
  gap: {{joint: O, bar: ball, size: 1 mm, stiffness: 1e9 N/m^1.5, {law},
        offset: [0.99 mm, 0], rate: [0.1, 0]}}
free: {{ball: {{angle: 0, speed: 0}}}}
simulate: {{end: 2 ms, samples: 4001, rtol: 1e-12}}
"""
"""A body of 1 kg that hits the wall of its bearing with 0.1 m/s."""

LAWS = {
    "Hertz": "contact: hertz",
    "Hunt–Crossley": "contact: hunt-crossley-constant, dissipation: 5",
    "Lankarani–Nikravesh": "contact: lankarani-nikravesh, restitution: 0.5",
    "Flores": "contact: flores, restitution: 0.5",
    "exact": "contact: exact, restitution: 0.5",
}
FRICTION = {
    "coulomb": "Coulomb",
    "threlfall": "Threlfall",
    "bengisu-akay": "Bengisu–Akay",
    "brown-mcphee": "Brown–McPhee",
    "ambrosio": "Ambrósio",
}
"""Name of a law → its authors."""
COEFFICIENTS = {
    "friction": 0.1,
    "static": 0.16,
    "slip": 6e-3,
    "least_slip": 2e-3,
    "stribeck_speed": 9e-3,
}
SLIPS = np.concatenate([np.linspace(-25e-3, -1e-6, 400), np.linspace(1e-6, 25e-3, 400)])


@makes("contact-laws.svg")
def figure() -> Figure:
    """Normal force against indentation in an impact, and friction against slip."""
    drawn, (left, right) = panels(1, 2, 2.7)
    for index, (name, law) in enumerate(LAWS.items()):
        draw_impact(left, law, label=name, **line_style(index))
    left.set_xlabel("indentation [µm]")
    left.set_ylabel("normal force [N]")
    left.set_xlim(0.0, 52.0)
    left.set_ylim(0.0)
    legend_above(left, labelled(left.lines), "One impact of 1 kg at 0.1 m/s")
    names = ["coulomb", *(name for name in friction_laws() if name != "coulomb")]
    for index, name in enumerate(names):
        look = {"color": BLACK, "linewidth": 0.8} if name == "coulomb" else line_style(index - 1)
        right.plot(
            1e3 * SLIPS,
            [friction(name, slip) for slip in SLIPS],
            label=FRICTION.get(name, name),
            **look,
        )
    legend_above(right, labelled(right.lines), "Friction laws")
    right.axvline(0.0, color=GREY, linewidth=0.5, zorder=0.5)
    right.set_xlabel("slip velocity [mm/s]")
    right.set_ylabel("friction coefficient")
    right.set_xlim(-25.0, 25.0)
    return drawn


def draw_impact(ax: Axes, law: str, **look: object) -> None:
    """Force over indentation while the body touches."""
    mechanism = linkages.loads(BALL.format(law=law))
    data = linkages.simulate(mechanism, outputs=["clearance_force", "clearance_indentation"]).data
    depth, force = (1e6 * data.clearance_indentation[:, 0], data.clearance_force[:, 0])
    touching = np.flatnonzero((depth > 0.0).to_numpy())
    shown = slice(touching[0], touching[-1] + 1)
    ax.plot(depth[shown], force[shown], **look)


def friction(name: str, slip: float) -> float:
    """Force of friction along the slip over the normal force, positive for positive slip."""
    from time_functions import jet  # of the tests

    law = friction_laws()[name]
    given = {key: COEFFICIENTS[key] for key in ("friction", *law.needs, *law.takes)}
    return -float(jet(friction_coefficient(name, given, ()), 0.0, lambda _: slip)[0])
