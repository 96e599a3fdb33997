"""Mechanisms whose motion is known."""

from __future__ import annotations

import math

import linkages
from make.verdicts.known import Known, of_definition, of_mechanism

BAKER = "G. L. Baker, J. P. Gollub, Chaotic Dynamics, 2nd ed. (1996), q = 2, ω = 2/3"
TAYLOR = "J. R. Taylor, Classical Mechanics (2005), chapter 12"
LINEAR = "linear oscillations, damped and forced"

CONSERVATIVE = (
    "Pendulum, free",
    "Pendulum, free, rotating",
    "Double pendulum, small",
    "Double pendulum, large",
    "Slider-crank, free",
)

PENDULUM = """\
name: Driven pendulum
gravity: [0, -{gravity!r}]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 1}}}}
masses: {{P: 1 kg}}
dampers: [{{joint: O, damping: {damping!r}}}]
loads: [{{bar: arm, torque: "{torque!r}*cos({frequency!r}*t)"}}]
free: {{arm: {{angle: {angle!r}, speed: {speed!r}}}}}
simulate: {{end: 10}}
"""

DOUBLE = """\
name: Double pendulum
joints: {{O: [0, 0]}}
bars:
  upper: {{joints: [O, A], length: 1, mass: 1}}
  lower: {{joints: [A, B], length: 1, mass: 1}}
gravity: [0, -9.81]
free: {{upper: {{angle: {upper} deg}}, lower: {{angle: {lower} deg}}}}
dampers: [{{joint: O, damping: {damping}}}, {{joint: A, damping: {damping}}}]
{loads}
simulate: {{end: 2}}
"""

FIVE_BAR = """\
name: Five-bar
gravity: [0, -9.81]
joints: {{O1: [0, 0], O2: [0.5, 0]}}
bars:
  a: {{joints: [O1, A], length: 0.2, mass: 1}}
  b: {{joints: [A, C], length: 0.5, mass: 1}}
  c: {{joints: [B, C], length: 0.5, mass: 1}}
  d: {{joints: [O2, B], length: 0.2, mass: 1}}
dampers: [{{joint: O1, damping: {damping}}}, {{joint: O2, damping: {damping}}}]
{loads}
free: {{a: {{angle: -90 deg}}, d: {{angle: -80 deg}}}}
assembly: {{C: [0.25, -0.5]}}
simulate: {{end: 2}}
"""

PENDULUM_CRANK = """\
name: Slider-crank whose crank is free
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 0.1, mass: 1}}
  rod: {{joints: [A, B], length: 0.3, mass: 1}}
sliders: {{piston: {{joint: B, through: O, mass: 0.5}}}}
dampers: [{{joint: O, damping: {damping}}}]
{loads}
free: {{crank: {{angle: {angle} deg}}}}
simulate: {{end: 2}}
"""


def gollub(torque: float) -> str:
    """In units of the natural frequency; q = 2 is a damping of 0.5."""
    return PENDULUM.format(
        gravity=1.0, damping=0.5, torque=torque, frequency=2 / 3, angle=-1.2, speed=0.0
    )


def taylor(strength: float, start: float = -math.pi / 2) -> str:
    """ω = 2π, ω₀ = 1.5 ω, β = ω₀/4; start from the vertical."""
    natural = 3 * math.pi
    return PENDULUM.format(
        gravity=natural**2,
        damping=natural / 2,
        torque=strength * natural**2,
        frequency=2 * math.pi,
        angle=start - math.pi / 2,
        speed=0.0,
    )


def pendulum(damping: float, speed: float = 0.0) -> str:
    text = PENDULUM.format(
        gravity=9.81, damping=damping, torque=0.0, frequency=1.0, angle=-0.5, speed=speed
    )
    return "\n".join(line for line in text.splitlines() if "loads" not in line)


def forced(amplitude: float, body: str) -> str:
    return f'loads: [{{bar: {body}, torque: "{amplitude}*cos(2*pi*t)"}}]'


def double(upper: float, lower: float, damping: float = 0.0, amplitude: float = 0.0) -> str:
    loads = forced(amplitude, "upper") if amplitude else ""
    return DOUBLE.format(upper=upper, lower=lower, damping=damping, loads=loads)


def five_bar(damping: float, amplitude: float) -> str:
    return FIVE_BAR.format(damping=damping, loads=forced(amplitude, "a") if amplitude else "")


def crank(damping: float, amplitude: float, angle: float = -60.0) -> str:
    loads = forced(amplitude, "crank") if amplitude else ""
    return PENDULUM_CRANK.format(damping=damping, loads=loads, angle=angle)


def ninebar(angle: float, verdict: str) -> Known:
    """The press without loss, from an angle of its clearance in degrees."""
    start = {
        "drives.crank1.angle": "15 deg",
        "drives.crank4.angle": "150 deg",
        "clearances.r1.angle": f"{angle:g} deg",
    }
    judged = of_mechanism(lambda: linkages.load("ninebar", set=start))
    source = "docs/reproduction.md, with another code"
    return Known(f"Nine-bar, clearance from {angle:g}°", verdict, None, source, judged, False)


def _pendulums() -> list[Known]:
    found = [
        (f"Pendulum, driven, g = {g:g}", verdict, period, BAKER, gollub(g))
        for g, verdict, period in (
            (0.9, "periodic", 1), (1.07, "periodic", 2), (1.15, "chaotic", None),
            (1.35, "periodic", 1), (1.45, "periodic", 2), (1.47, "periodic", 4),
            (1.5, "chaotic", None),
        )
    ]  # fmt: skip
    found += [
        (f"Pendulum, driven, γ = {g:g}", verdict, period, TAYLOR, taylor(g))
        for g, verdict, period in (
            (0.9, "periodic", 1), (1.06, "periodic", 1), (1.073, "periodic", 2),
            (1.081, "periodic", 4), (1.0826, "periodic", 8), (1.105, "chaotic", None),
            (1.5, "chaotic", None),
        )
    ]  # fmt: skip
    return _known(
        [
            *found,
            ("Pendulum, driven, γ = 1.077, from 0°", "periodic", 3, TAYLOR,
             taylor(1.077, 0.0)),
            ("Pendulum, free", "periodic", 1, "elliptic functions", pendulum(0.0)),
            ("Pendulum, free, rotating", "periodic", 1, "elliptic functions",
             pendulum(0.0, 9.0)),
            ("Pendulum, damped", "at rest", None, "energy falls", pendulum(0.5)),
            ("Pendulum, overdamped", "at rest", None, "energy falls", pendulum(20.0)),
        ]
    )  # fmt: skip


def _linkages() -> list[Known]:
    modes = "two linear modes, frequencies incommensurate"
    falls = "energy falls"
    return _known(
        [
            ("Double pendulum, small", "quasi-periodic", None, modes, double(-89, -88.5)),
            ("Double pendulum, large", "chaotic", None,
             "T. Shinbrot et al., Am. J. Phys. 60 (1992) 491", double(60, 80)),
            ("Double pendulum, damped", "at rest", None, falls, double(-60, -30, 0.5)),
            ("Double pendulum, damped, driven weakly", "periodic", 1, LINEAR,
             double(-80, -85, 1.0, 0.5)),
            ("Five-bar, damped, driven weakly", "periodic", 1, LINEAR, five_bar(0.2, 0.5)),
            ("Five-bar, damped", "at rest", None, falls, five_bar(0.2, 0.0)),
            ("Slider-crank, free", "periodic", 1, "one degree of freedom, energy constant",
             crank(0.0, 0.0)),
            ("Slider-crank, damped", "at rest", None, falls, crank(0.2, 0.0)),
            ("Slider-crank, damped, driven weakly", "periodic", 1, LINEAR, crank(0.2, 0.1)),
        ]
    )  # fmt: skip


def _known(found) -> list[Known]:  # type: ignore[no-untyped-def]
    return [of_definition(*one, dissipative=one[0] not in CONSERVATIVE) for one in found]


MECHANISMS = [
    *_pendulums(),
    *_linkages(),
    ninebar(0, "quasi-periodic"),
    ninebar(90, "chaotic"),
]
