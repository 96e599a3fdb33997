"""Impacts and stops whose motion is known."""

from __future__ import annotations

import math

from make.verdicts.known import LOST, Known, of_definition

TUFILLARO = "closed form; N. B. Tufillaro et al., An Experimental Approach to Nonlinear Dynamics"
EXACT = "exact map from impact to impact"
EVENTS = "event-driven, with saltation matrices"
SHAW = "closed form and saltation; S. W. Shaw, P. J. Holmes, J. Sound Vib. 90 (1983) 129"
FALLS = "energy falls"

OSCILLATOR = """\
joints: {{O: [0, 0]}}
sliders: {{m: {{joint: P, through: O, mass: 1}}}}
loads: [{{slider: m, force: "{force}"}}]
stops: [{{slider: m, {stop}}}]
free: {{m: {{position: {position!r}, speed: {speed!r}}}}}
"""

FALLING = """\
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
sliders: {{m: {{joint: P, through: O, angle: 90 deg, mass: 1}}}}
stops: [{{slider: m, lower: 0, restitution: {restitution}}}]
free: {{m: {{position: 0.1, speed: 0}}}}
simulate: {{end: 2}}
"""

ARM = """\
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 1}}}}
masses: {{P: 1 kg}}
stops: [{{bars: [ground, arm], lower: -80 deg, restitution: {restitution}}}]
{loads}
free: {{arm: {{angle: -30 deg}}}}
simulate: {{end: 2}}
"""

BETWEEN_WALLS = """\
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
stops: [{slider: m, lower: -1, upper: 1, restitution: 1}]
free: {m: {position: 0.1, speed: 0.7}}
simulate: {end: 3}
"""

FOUR_BAR = """\
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.3, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  coupler: {joints: [A, B], length: 0.3, mass: 1}
  rocker: {joints: [D, B], length: 0.2, mass: 1}
stops: [{bars: [ground, rocker], upper: 150 deg, restitution: 0.6}]
dampers: [{joint: O, damping: 0.02}]
free: {crank: {angle: 60 deg}}
assembly: {B: left}
simulate: {end: 2}
"""

BILLIARD = """\
gravity: [0, {gravity}]
joints: {{O: [0, 0]}}
bars: {{rod: {{joints: [O, P], length: 0.1, mass: 1, inertia: 0.01, center: 0}}}}
clearances:
  gap: {{joint: O, bar: rod, size: 10 mm, contact: restitution, restitution: 1,
        offset: [{offset}, 0], rate: [0.05, 0.02], least_rate: 1e-6}}
free: {{rod: {{angle: 0}}}}
simulate: {{end: 1}}
"""


def bouncing(strength: float, restitution: float = 0.5, speed: float = 0.3) -> str:
    """A ball on a table that oscillates with an acceleration of so many g, seen from the table."""
    force = f"9.81*({strength!r}*sin(20*pi*t) - 1)"
    stop = f"lower: 0, restitution: {restitution}"
    return OSCILLATOR.format(force=force, stop=stop, position=0.001, speed=speed)


def impacting(
    frequency: float,
    damping: float,
    wall: float,
    position: float = 0.2,
    speed: float = 0.1,
    restitution: float = 0.8,
) -> str:
    """x'' + damping x' + x = cos(frequency t), x ≥ wall."""
    force = f"cos({frequency!r}*t) - {damping!r}*m.velocity - m.position"
    stop = f"lower: {wall!r}, restitution: {restitution}"
    return OSCILLATOR.format(force=force, stop=stop, position=position, speed=speed)


def pair(restitution: float, wall: float) -> str:
    """x'' = cos t between two walls."""
    stop = f"lower: {-wall!r}, upper: {wall!r}, restitution: {restitution}"
    return OSCILLATOR.format(force="cos(t)", stop=stop, position=0.0, speed=0.3)


def bilinear(frequency: float, stiffness: float, damping: float) -> str:
    """x'' + damping x' + x = cos(frequency t), and a compliant stop at x = 0."""
    force = f"cos({frequency!r}*t) - {damping!r}*m.velocity - m.position"
    stop = f"lower: 0, stiffness: {stiffness!r}"
    return OSCILLATOR.format(force=force, stop=stop, position=0.5, speed=0.0)


def arm(restitution: float, torque: str = "") -> str:
    loads = f'loads: [{{bar: arm, torque: "{torque}"}}]' if torque else ""
    return ARM.format(restitution=restitution, loads=loads)


def one_impact(strength: float, restitution: float = 0.5) -> tuple[float, float]:
    """Exponents of the ball that bounces once a period.

    With out- and inbound speeds ± gT/2 against the table the tangent map of the phase and the
    speed has the determinant e² and the trace 1 + e² - (1 + e)² Γ sin φ.
    """
    e, period = restitution, 0.1
    cosine = math.pi * (1 - e) / ((1 + e) * strength)
    trace = 1 + e**2 - (1 + e) ** 2 * strength * math.sqrt(1 - cosine**2)
    root = complex(trace**2 / 4 - e**2) ** 0.5
    high, low = (math.log(abs(trace / 2 + sign * root)) / period for sign in (-1, 1))
    return max(high, low), min(high, low)


def damped(damping: float, impacts: float, period: float, restitution: float) -> tuple[float, ...]:
    """Both exponents of an oscillator whose multipliers are a complex pair: half of their sum."""
    half = -damping / 2 + impacts * math.log(restitution) / period
    return half, half


def _systems() -> list[Known]:
    amplitude = 1 / math.hypot(1 - 1.3**2, 0.1 * 1.3)
    turn = 2 * math.pi
    found = [
        *[
            (f"Ball on a table, e = 0.5, Γ = {strength:g}", verdict, period, source,
             bouncing(strength), exponents, within)
            for strength, verdict, period, source, exponents, within in (
                (0.9, "at rest", None, "no acceleration lifts it", (LOST, LOST), 0.0),
                (1.2, "periodic", 1, TUFILLARO, one_impact(1.2), 0.0),
                (1.5, "periodic", 1, TUFILLARO, one_impact(1.5), 0.0),
                (1.55, "periodic", 2, EXACT, (-2.53868688, -11.32425673), 0.0),
                (1.7, "periodic", 8, EXACT, (-4.22489647, -9.63804714), 0.0),
                (1.75, "chaotic", None, EXACT, (3.742, -17.605), 0.1),
            )
        ],
        ("Ball on a table, e = 0.2, Γ = 1.1", "periodic", 1, "bounces end before the next lift-off",
         bouncing(1.1, 0.2), (LOST, LOST), 0.0),
        ("Ball on a table, e = 0, Γ = 1.8", "periodic", 1,
         "closed form; A. Mehta, J. M. Luck, Phys. Rev. Lett. 65 (1990) 393",
         bouncing(1.8, 0.0), (LOST, LOST), 0.0),
        *[
            (f"Impact oscillator, wall at 0, ω = {frequency:g}", "periodic", period, SHAW,
             impacting(frequency, 0.04, 0.0), damped(0.04, impacts, turn / frequency, 0.8), 0.0)
            for frequency, period, impacts in (
                (2.2, 1, 1.0), (2.6, 3, 1.0), (3.0, 2, 1.0), (4.2, 2, 0.5), (6.0, 3, 1 / 3)
            )
        ],
        ("Impact oscillator, wall at 0, ω = 2.8, undamped", "chaotic", None, EVENTS,
         impacting(2.8, 0.0, 0.0), (0.1411, -0.3516), 0.004),
        ("Impact oscillator, wall at 0.97 of the amplitude", "periodic", 1, SHAW,
         impacting(1.3, 0.1, -0.97 * amplitude), damped(0.1, 1.0, turn / 1.3, 0.8), 0.0),
        ("Impact oscillator, wall at 1.01 of the amplitude", "periodic", 1,
         "closed form without impacts",
         impacting(1.3, 0.1, -1.01 * amplitude, -0.69 * amplitude**2, 0.169 * amplitude**2),
         damped(0.1, 0.0, 1.0, 0.8), 0.0),
        ("Mass between two walls, e = 0.6, driven", "periodic", 1,
         "closed form; C. N. Bapat et al., J. Sound Vib. 87 (1983) 19",
         pair(0.6, 2.0), damped(0.0, 2.0, turn, 0.6), 0.0),
        ("Mass between two walls, e = 0.5, driven", "periodic", 1, EVENTS,
         pair(0.5, 1.0), (-0.1026794, -0.3385918), 0.0),
        *[
            (f"Oscillator with a compliant stop, ω = {frequency:g}", verdict, period,
             "linear on both sides; " + EVENTS, bilinear(frequency, stiffness, 0.1), exponents,
             within)
            for frequency, stiffness, verdict, period, exponents, within in (
                (1.5, 20.0, "periodic", 1, (-0.05, -0.05), 0.0),
                (2.5, 20.0, "periodic", 2, (-0.05, -0.05), 0.0),
                (4.0, 20.0, "periodic", 5, (-0.05, -0.05), 0.0),
                (5.0, 50.0, "periodic", 3, (-0.05, -0.05), 0.0),
                (2.8, 100.0, "chaotic", None, (0.1534, -0.2534), 0.02),
            )
        ],
        ("Ball, e = 0.7", "at rest", None, FALLS, FALLING.format(restitution=0.7), (LOST, LOST),
         0.0),
        ("Ball, e = 1", "periodic", 1, "one degree of freedom, energy constant",
         FALLING.format(restitution=1), (0.0, 0.0), 0.0),
        ("Mass between two elastic walls", "periodic", 1, "constant speed", BETWEEN_WALLS,
         (0.0, 0.0), 0.0),
        ("Pendulum and stop, e = 1", "periodic", 1, "one degree of freedom, energy constant",
         arm(1), (0.0, 0.0), 0.0),
        ("Pendulum and stop, e = 0.6", "at rest", None, FALLS, arm(0.6), (LOST, LOST), 0.0),
        ("Four-bar and stop", "at rest", None, FALLS, FOUR_BAR, None, 0.0),
        ("Journal in an elastic bearing, no gravity", "quasi-periodic", None,
         "circular billiard: rotation by an irrational angle",
         BILLIARD.format(gravity=0, offset=4e-3), (0.0,) * 6, 0.0),
        ("Journal in an elastic bearing, along a diameter", "periodic", 2, "circular billiard",
         BILLIARD.format(gravity=0, offset=0), (0.0,) * 6, 0.0),
        ("Journal in an elastic bearing, gravity", "chaotic", None,
         "exact parabolas, 60000 bounces with tangents", BILLIARD.format(gravity=-0.5, offset=0),
         (3.573, 0.0, 0.0, 0.0, 0.0, -3.573), 0.1),
    ]  # fmt: skip
    conservative = (
        "Ball, e = 1", "Mass between two elastic walls", "Pendulum and stop, e = 1",
        "Journal in an elastic bearing, no gravity",
        "Journal in an elastic bearing, along a diameter", "Journal in an elastic bearing, gravity",
    )  # fmt: skip
    return [of_definition(*one, dissipative=one[0] not in conservative) for one in found]


IMPACTS = _systems()
