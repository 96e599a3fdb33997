"""Dry friction whose motion is known."""

from __future__ import annotations

from make.verdicts.known import LOST, Known, of_definition

STICKS = "map from stick to stick: sticking takes one direction away"
SLIDES = "event-driven, with saltation matrices"
FALLS = "energy falls to a band of equilibria"
HARTOG = "closed form; J. P. Den Hartog, Trans. ASME 53 (1931) 107; saltation matrices"
POPP = "K. Popp, P. Stelter, Phil. Trans. R. Soc. A 332 (1990) 89; " + SLIDES

BLOCK = """\
joints: {{O: [0, 0]}}
sliders: {{m: {{joint: P, through: O, mass: 1}}}}
loads: [{{slider: m, force: "{force}"}}]
{friction}
free: {{m: {{position: {position!r}, speed: {speed!r}}}}}
simulate: {{end: 8}}
"""

PENDULUM = """\
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
friction: [{joint: O, torque: 1}]
free: {arm: {angle: 0}}
simulate: {end: 2}
"""

SLIDER_CRANK = """\
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  rod: {joints: [A, B], length: 0.3, mass: 1}
sliders: {piston: {joint: B, through: O, mass: 0.5}}
friction: [{slider: piston, force: 4 N}]
free: {crank: {angle: -20 deg}}
simulate: {end: 2}
"""


def block(
    force: str, friction: str = "", *, position: float = 0.1, speed: float = 0.0, law: str = ""
) -> str:
    """A mass on a spring of 1 N/m under a force, and dry friction as a component or in a law."""
    component = f"friction: [{{slider: m, {friction}}}]" if friction else ""
    whole = "-m.position" + "".join(f" {more}" for more in (force, law) if more)
    return BLOCK.format(force=whole, friction=component, position=position, speed=speed)


def belt(force: str = "") -> str:
    """A mass on a belt, with friction that falls from 1 N to 0.4 N with the relative speed."""
    relative = "(m.velocity - 0.5)"
    return block(force, law=f"- (0.4 + 0.6*exp(-{relative}**2))*sign{relative}", speed=0.5)


def duffing(force: float, friction: float, damping: float) -> str:
    """x'' + damping x' - x + x³ = force · cos t with Coulomb friction; `block` subtracts x."""
    whole = f"+ {force!r}*cos(t) + 2*m.position - m.position**3 - {damping!r}*m.velocity"
    return block(whole, f"force: {friction!r}")


def _systems() -> list[Known]:
    found = [
        ("Coulomb friction, free", "at rest", None, "closed form: stops at 0.7 after three swings",
         block("", "force: 1", position=5.3), (0.0, LOST)),
        ("Coulomb friction, held", "at rest", None, "the force stays below the friction",
         block("+ 0.5*cos(t)", "force: 0.8"), (0.0, LOST)),
        *[
            (f"Stick–slip, friction {friction:g}, force {force:g}, ω = {frequency:g}",
             "periodic", 1, STICKS,
             block(f"+ {force!r}*cos({frequency!r}*t)", f"force: {friction!r}"), (exponent, LOST))
            for friction, force, frequency, exponent in (
                (0.8, 2.0, 0.25, -0.038120), (1.0, 2.0, 0.25, -0.056467),
                (1.1, 2.0, 0.25, -0.067922), (0.8, 1.2, 0.3, -0.156922),
            )
        ],
        ("Stick–slip, friction in a law", "periodic", 1, STICKS,
         block("+ 2*cos(0.25*t)", law="- 0.8*sign(m.velocity)"), (-0.038120, LOST)),
        ("Stick–slip, static friction 0.9, kinetic 0.5", "periodic", 1, SLIDES,
         block("+ 2*cos(0.4*t)", "force: 0.5, static: 0.9, stribeck_speed: 0.1"),
         (-0.04860216, LOST)),
        ("Friction without sticking, ω = 1.3", "periodic", 1, HARTOG,
         block("+ cos(1.3*t)", "force: 0.3"), (-0.05618818, -0.05618818)),
        ("Friction without sticking, ω = 0.7", "periodic", 1, HARTOG,
         block("+ cos(0.7*t)", "force: 0.2"), (-0.04790106, -0.04790106)),
        ("Friction without sticking, ω = 1.3, in a law", "periodic", 1, HARTOG,
         block("+ cos(1.3*t)", law="- 0.3*sign(m.velocity)"), (-0.05618818, -0.05618818)),
        ("Stribeck friction without sticking", "periodic", 1, SLIDES,
         block("+ 1.5*cos(0.7*t)", "force: 0.5, static: 0.8, stribeck_speed: 0.3",
               law="- 0.1*m.velocity"), (-0.14758552, -0.14758552)),
        ("Mass on a belt, slow", "periodic", 1, "stick–slip limit cycle; " + POPP,
         belt(), (0.0, LOST)),
        ("Mass on a belt, constant friction, damped", "at rest", None,
         "slides all the time: linear",
         block("", law="- 0.4*sign(m.velocity - 3) - 0.1*m.velocity"),
         (-0.05, -0.05)),
        ("Mass on a belt, shaken, ω = 0.9", "periodic", 1, POPP,
         belt("+ 0.3*cos(0.9*t)"), (-0.10093194, LOST)),
        ("Mass on a belt, shaken, ω = 1.3", "periodic", 4, POPP,
         belt("+ 0.5*cos(1.3*t)"), (-0.08724517, LOST)),
        ("Mass on a belt, shaken, ω = 1.7", "periodic", 2, POPP,
         belt("+ cos(1.7*t)"), (-0.0768141, LOST)),
        ("Mass on a belt, shaken, ω = 0.7", "quasi-periodic", None,
         "circle map from stick to stick; " + POPP, belt("+ 0.1*cos(0.7*t)"), (0.0, LOST)),
        ("Two-well Duffing with dry friction, force 0.4", "periodic", 1, SLIDES,
         duffing(0.4, 0.05, 0.15), (-0.079446, -0.079446)),
        ("Two-well Duffing with dry friction, chaotic", "chaotic", None, SLIDES,
         duffing(0.4, 0.1, 0.15), (0.1705, LOST), 0.02),
        ("Pendulum, dry friction in the pivot", "at rest", None, FALLS, PENDULUM, (0.0, LOST)),
        ("Slider-crank, dry friction in the guide", "at rest", None, FALLS, SLIDER_CRANK,
         (0.0, LOST)),
        ("Smoothed friction", "periodic", 1, "other code, SciPy",
         block("+ 2*cos(0.5*t)", "force: 0.8, slip_speed: 0.1"), (-0.08433971, -0.6999458)),
    ]  # fmt: skip
    return [of_definition(*one) for one in found]


FRICTION = _systems()
