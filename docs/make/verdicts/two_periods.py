"""Drives and loads without a common period, where the motion is known."""

from __future__ import annotations

import math

from make.verdicts.known import Known, of_definition

TORUS = "closed form: as many phases as frequencies"
ROMEIRAS = "F. J. Romeiras, E. Ott, Phys. Rev. A 35 (1987) 4404"
OTHER = "other code, SciPy, with tangents"
GOLDEN = (math.sqrt(5) - 1) / 2

BLOCK = """\
joints: {{O: [0, 0]}}
sliders: {{m: {{joint: P, through: O, mass: 1}}}}
loads: [{{slider: m, force: "{force}"}}]
free: {{m: {{position: 0.1, speed: 0}}}}
simulate: {{end: 6}}
"""

CRANKS = """\
joints: {{O: [0, 0], Q: [1, 0]}}
bars: {{a: {{joints: [O, A], length: 0.05}}, b: {{joints: [Q, B], length: 0.05}}}}
sliders: {{m: {{joint: P, through: [0.5, 0.3], mass: 1}}}}
springs: [{{between: [A, P], stiffness: 20, length: 0}},
          {{between: [B, P], stiffness: 20, length: 0}}]
loads: [{{slider: m, force: "-m.velocity{force}"}}]
{driven}
free: {{m: {{position: 0.1, speed: 0}}}}
simulate: {{end: 1}}
"""

PENDULUM = """\
gravity: [0, -3]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 1}}}}
masses: {{P: 1 kg}}
dampers: [{{joint: O, damping: 3}}]
loads: [{{bar: arm, torque: "3*({mean!r} + {amplitude!r}*(cos({golden!r}*t) + cos(t)))"}}]
free: {{arm: {{angle: -1.2}}}}
simulate: {{end: 6}}
"""

TWO_BLOCKS = """\
joints: {{O: [0, 0], Q: [0, 1]}}
sliders: {{a: {{joint: A, through: O, mass: 1}}, b: {{joint: B, through: Q, mass: 1}}}}
springs: [{{slider: a, stiffness: 1}}, {{slider: b, stiffness: {stiffness}}}]
{loads}
free: {{a: {{position: 1, speed: 0}}, b: {{position: 0.7, speed: 0}}}}
simulate: {{end: 6}}
"""


def block(force: str) -> str:
    return BLOCK.format(force=force)


def cranks(driven: str, force: str = "") -> str:
    """Two cranks pull a damped mass with linear springs."""
    return CRANKS.format(driven=driven, force=force)


def pendulum(mean: float, amplitude: float) -> str:
    """φ''/p + φ' + sin φ = K + V (cos ω t + cos t) with p = 3 and ω the golden mean."""
    return PENDULUM.format(mean=mean, amplitude=amplitude, golden=GOLDEN)


def _systems() -> list[Known]:
    speeds = "drives: {{a: {{angle: 0, speed: 60 rpm}}, b: {{angle: 1, speed: {} rpm}}}}"
    geared = (
        f"gears: [{{bars: [a, b], ratio: {-GOLDEN!r}}}]\ndrives: {{a: {{angle: 0, speed: 60 rpm}}}}"
    )
    single = "drives: {a: {angle: 0, speed: 60 rpm}, b: {angle: 0, speed: 0}}"
    damped = "-m.position - 0.1*m.velocity"
    half, pulled = (-0.05, -0.05), (-0.5, -0.5)
    quasi = ("quasi-periodic", None, TORUS)
    cubic = "{} - 0.15*m.velocity + m.position - m.position**3"
    found = [
        ("Oscillator, frequencies 1 and √2", *quasi,
         block(f"{damped} + cos(t) + cos(sqrt(2)*t)"), half),
        ("Oscillator, frequencies 1 and golden", *quasi,
         block(f"{damped} + cos(t) + cos({GOLDEN!r}*t)"), half),
        ("Oscillator, frequencies 1, √2 and √3", *quasi,
         block(f"{damped} + cos(t) + cos(sqrt(2)*t) + cos(sqrt(3)*t)"), half),
        ("Oscillator, product of frequencies 1 and √2", *quasi,
         block(f"{damped} + cos(t)*cos(sqrt(2)*t)"), half),
        ("Oscillator, frequencies 2 and 3", "periodic", 1, "closed form: common period",
         block(f"{damped} + cos(2*t) + cos(3*t)"), half),
        ("Two cranks, 60 and 97.0820393 rpm", *quasi, cranks(speeds.format(97.0820393)), pulled),
        ("Two cranks, 60 and 60.01 rpm", *quasi, cranks(speeds.format(60.01)), pulled),
        ("Two cranks, 60 and 90 rpm", "periodic", 1, "closed form: common period",
         cranks(speeds.format(90)), pulled),
        ("Two cranks, gear of golden ratio", *quasi, cranks(geared), pulled),
        ("Crank at 60 rpm, force at √2 Hz", *quasi, cranks(single, " + cos(2*pi*sqrt(2)*t)"),
         pulled),
        ("Pendulum, two golden torques, swings", "quasi-periodic", None, OTHER,
         pendulum(0.2, 0.2), (-1.484, -1.516), 0.002),
        ("Pendulum, two golden torques, strange nonchaotic", "quasi-periodic", None, ROMEIRAS,
         pendulum(1.33, 0.55), (-0.158, -2.842), 0.01),
        ("Two-well Duffing, frequencies 1 and golden", "chaotic", None, OTHER,
         block(cubic.format(f"0.3*cos(t) + 0.2*cos({GOLDEN!r}*t)")), (0.0165, -0.1665), 0.01),
        ("One well of Duffing, frequencies 1 and golden", "quasi-periodic", None, OTHER,
         block(cubic.format(f"0.02*cos(t) + 0.02*cos({GOLDEN!r}*t)")), (-0.075, -0.075)),
        ("Two oscillators, frequencies 1 and √2, free", *quasi,
         TWO_BLOCKS.format(stiffness=2, loads=""), (0.0, 0.0, 0.0, 0.0)),
        ("Two oscillators, frequencies 1 and golden, free", *quasi,
         TWO_BLOCKS.format(stiffness=GOLDEN**2, loads=""), (0.0, 0.0, 0.0, 0.0)),
        ("Undamped oscillator, frequencies √2 and √3", *quasi,
         block("-m.position + cos(sqrt(2)*t) + cos(sqrt(3)*t)"), (0.0, 0.0)),
    ]  # fmt: skip
    conservative = (
        "Two oscillators, frequencies 1 and √2, free",
        "Two oscillators, frequencies 1 and golden, free",
        "Undamped oscillator, frequencies √2 and √3",
    )
    return [of_definition(*one, dissipative=one[0] not in conservative) for one in found]


TWO_PERIODS = _systems()
