"""Mechanisms whose wear is known in closed form."""

import math

import linkages

ROTOR = """
name: Rotor on a worn pin
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{rotor: {{joints: [O, P], length: 0.1, mass: {mass}, center: 0, inertia: 1e-3}}}}
drives: {{rotor: {{angle: 0, speed: {speed}}}}}
clearances:
  gap: {{joint: O, bar: rotor, size: 0.1 mm, pin_radius: 10 mm, width: 20 mm,
        wear: {{{wear}}}, {law}}}
"""
MASS, SPEED, RADIUS, SIZE, WIDTH, STIFFNESS = 2.0, 200.0, 0.01, 1e-4, 0.02, 1e9
WEIGHT = MASS * 9.81
LINK = "angle: -90 deg"


def depth(force):
    """Indentation under a force."""
    return (force / STIFFNESS) ** (2 / 3)


def resting(friction):
    """The contact of a rotor that rests on its pin while it turns: it climbs by atan μ."""
    angle = math.atan(friction)
    reach = SIZE + depth(WEIGHT * math.cos(angle))
    x, y = reach * math.sin(angle), -reach * math.cos(angle)
    law = f"contact: hunt-crossley-constant, stiffness: {STIFFNESS}, dissipation: 1, "
    if friction:
        law += f"friction: {friction}, friction_law: coulomb, "
    return law + f"offset: [{x!r}, {y!r}]"


def rotor(law=None, *, wear="bearing: {wear_rate: 1e-13}", mass=MASS, speed=SPEED):
    """A rotor whose hole rests on a pin of the ground."""
    law = resting(0.0) if law is None else law
    return linkages.loads(ROTOR.format(law=law, wear=wear, mass=mass, speed=speed))


BLOCK = """
gravity: [0, -9.81]
joints: {{G: [0, 0]}}
sliders: {{block: {{joint: B, through: G, angle: 0, mass: 2, inertia: 1e-3}}}}
drives: {{block: {{law: "0.05*sin(20*t)"}}}}
clearances:
  play: {{slider: block, size: 0.1 mm, length: 40 mm, height: 30 mm, width: 20 mm,
         contact: hunt-crossley-constant, stiffness: 1e9, dissipation: 1, offset: {offset!r},
         wear: {{block: {{wear_rate: 1e-14}}, guide: {{wear_rate: 3e-14}}}}}}
"""


def block():
    """A block that slides to and fro on the lower wall of its guide."""
    return linkages.loads(BLOCK.format(offset=-(SIZE + depth(0.5 * WEIGHT))))
