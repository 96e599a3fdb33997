"""Figures of the pages on states, sampled controllers and stops that pull."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

import linkages
from linkages.plots.panels import panels
from linkages.plots.style import GREY
from make.registry import definition, definition_text, makes


@makes("state-boom.svg")
def boom() -> Figure:
    """Pressure and angle while a valve is open, and behind."""
    data = linkages.simulate(definition("components/state.md", "boom.yaml"), samples=3001).data
    figure, (upper, lower) = panels(2, 1, 1.6)
    time = data.time
    upper.plot(time, data.internal_state[:, 0] / 1e5)
    upper.set_ylabel("pressure [bar]")
    lower.plot(time, np.degrees(data.bar_angle.sel(bar="boom")))
    lower.set_ylabel("angle [°]")
    lower.set_xlabel("time [s]")
    return figure


@makes("state-sampled.svg")
def sampled() -> Figure:
    """Position and held force of a cart, beside the continuous controller."""
    text = definition_text("components/state.md", "sampled.yaml")
    continuous = text.replace(
        "next: sum.value + h*(0.4 - cart.position), period: h", "rate: 0.4 - cart.position"
    )
    law = "10*(0.4 - cart.position) + 20*sum.value"
    continuous = continuous.replace(f"  force: {{next: {law}, period: h}}\n", "")
    continuous = continuous.replace("force.value", law)
    held, other = (linkages.simulate(linkages.loads(one), samples=2001).data
                   for one in (text, continuous))  # fmt: skip
    figure, (upper, lower) = panels(2, 1, 1.6)
    upper.plot(held.time, held.slider_position[:, 0], label="digital")
    upper.plot(other.time, other.slider_position[:, 0], "--", color=GREY, label="continuous")
    upper.set_ylabel("position [m]")
    upper.legend()
    force = held.internal_state.sel(internal="states.force")
    lower.plot(held.time, force)
    force = 10 * (0.4 - other.slider_position[:, 0]) + 20 * other.internal_state[:, 0]
    lower.plot(other.time, force, "--", color=GREY)
    lower.set_ylabel("force [N]")
    lower.set_xlabel("time [s]")
    return figure


SIGNS = {"stop_force": 1.0, "spring_force": -1.0}
"""Of outputs: those of springs are positive where these push forward."""
PULLING = "stiffness: 4000, damping: 40, pulls: true"
HELD = """
joints: {O: [0, 0]}
sliders: {block: {joint: P, through: O, mass: 2}}
stops: [{slider: block, upper: 0, LAW, adhesion: 7 N}]
loads: [{slider: block, force: 8 - 20*t}]
free: {block: {position: -10 mm}}
"""
"""A block that flies to a stop, and is pulled off it."""


@makes("stop-adhesion.svg")
def adhesion() -> Figure:
    """Position and force of a stop that adhesion holds: rigid, and as a spring."""
    figure, (upper, lower) = panels(2, 1, 1.6)
    laws = {"restitution": "restitution: 0", "stiffness, pulls": PULLING}
    for (name, law), style in zip(laws.items(), ("-", "--"), strict=True):
        mechanism = linkages.loads(HELD.replace("LAW", law))
        wanted = ["slider_position", "stop_force" if "rest" in law else "spring_force"]
        data = linkages.simulate(mechanism, end=0.9, samples=1801, outputs=wanted).data
        upper.plot(data.time, 1e3 * data.slider_position[:, 0], style, label=name)
        lower.plot(data.time, SIGNS[wanted[1]] * data[wanted[1]][:, 0], style)
    upper.set_ylabel("position [mm]")
    upper.set_ylim(-12, 8)
    upper.legend()
    lower.set_ylabel("force of the stop [N]")
    lower.set_xlabel("time [s]")
    return figure
