"""Systems whose attractors are known."""

from shared_definitions import IMPACTS

import linkages

PENDULUM = """\
name: Pendulum with constant torque
gravity: [1, 0]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1, center: 1, inertia: 0}}
loads: [{bar: rod, torque: 0.5 - 0.1*rod.speed}]
free: {rod: {angle: 0, speed: 0}}
simulate: {end: 100, rtol: 1e-9}
"""


OSCILLATOR = """\
name: Oscillator
parameters: {F: 0.2, w: 1}
joints: {{O: [0, 0]}}
sliders: {{block: {{joint: B, through: O, mass: 1}}}}
loads: [{{slider: block, force: "{force}"}}]
free: {{block: {{position: 0, speed: 0}}}}
simulate: {{end: {end}, rtol: 1e-9}}
"""

X, V = "free.block.position", "free.block.speed"
ANGLE, SPEED = "free.rod.angle", "free.rod.speed"


def pendulum():
    return linkages.loads(PENDULUM)


def impacts(**values):
    return linkages.loads(IMPACTS, set={f"parameters.{k}": v for k, v in values.items()})


def oscillator(force, end=20):
    """One of mass 1 under a force."""
    text = OSCILLATOR.replace("{F: 0.2, w: 1}", "{{F: 0.2, w: 1}}")
    force = force.replace("x", "block.position").replace("v", "block.speed")
    if "F" not in force:
        text = text.replace("parameters: {{F: 0.2, w: 1}}\n", "")
    return linkages.loads(text.format(force=force, end=end))


def duffing():
    """Five cycles coexist."""
    return oscillator("0.2*cos(t) - x**3 - 0.08*v")
