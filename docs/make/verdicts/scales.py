"""Motions of micrometres and nanometres beside metres, where both are known."""

from __future__ import annotations

from collections.abc import Sequence

from make.verdicts.impacts import EXACT, TUFILLARO, one_impact
from make.verdicts.known import Known, of_definition
from make.verdicts.resting import hanging

SCALED = "scaled, beside a linear oscillation; Duffing oscillator of this list"
ALONG = "Duffing oscillator of this list in a frame that turns"

TWO = """\
joints: {{O: [0, 0], Q: [0, 1]}}
sliders: {{a: {{joint: A, through: O, mass: 1}}, b: {{joint: B, through: Q, mass: 1}}}}
{stops}
loads:
  - {{slider: a, force: "{large}"}}
  - {{slider: b, force: "{small}"}}
free: {{a: {{position: 1, speed: 0}}, b: {{position: {position!r}, speed: {speed!r}}}}}
simulate: {{end: 5}}
"""

ON_CRANK = """\
joints: {{O: [0, 0]}}
bars: {{crank: {{joints: [O, A], length: 1, mass: 1}}}}
sliders: {{b: {{joint: B, on: crank, through: O, mass: 1}}}}
loads: [{{slider: b, force: "{force}"}}]
drives: {{crank: {{angle: 0, speed: 1.2}}}}
free: {{b: {{position: {position!r}, speed: 0}}}}
"""

ROD = """\
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{rod: {{joints: [O, P], length: 1, mass: 2}}}}
clearances: {{gap: {{joint: O, bar: rod, size: {size}, angle: -90 deg}}}}
dampers: [{{bars: [ground, rod], damping: 2}}]
loads: [{{bar: rod, torque: "{torque!r}*cos(20*t)"}}]
free: {{rod: {{angle: -90 deg}}}}
"""


def duffing(size: float, force: float, name: str = "b", added: str = "") -> str:
    """Force of the Duffing oscillator whose coordinate is so many metres where it was 1."""
    x, v = f"{name}.position", f"{name}.velocity"
    return f"{x} - {x}**3/{size!r}**2 - 0.3*{v} + {force * size!r}*cos(1.2*t){added}"


def beside(size: float, force: float) -> str:
    large = "cos(1.2*t) - a.position - 0.3*a.velocity"
    return TWO.format(large=large, small=duffing(size, force), stops="", position=size, speed=0.0)


def on_crank(size: float, force: float) -> str:
    """The same on a crank of one metre: the force makes up for the centrifugal one."""
    return ON_CRANK.format(force=duffing(size, force, added=" - 1.44*b.position"), position=size)


def bouncing(strength: float) -> str:
    """A ball that bounces by micrometres at 1 kHz beside an oscillation of centimetres."""
    large = "1e6*cos(2000*pi*t) - 1e6*a.position - 3000*a.velocity"
    return TWO.format(
        large=large, small=f"9.81*({strength!r}*sin(2000*pi*t) - 1)",
        stops="stops: [{slider: b, lower: 0, restitution: 0.5, least_rate: 1e-9}]",
        position=1e-7, speed=0.003,
    )  # fmt: skip


def _systems() -> list[Known]:
    linear, chaos = (-0.15, -0.15), (0.1068, -0.4068)
    both = ((0.28, "periodic", 2, linear, 0.0), (0.5, "chaotic", None, chaos, 0.02))
    found = [
        *[
            (f"Duffing of {text} beside 1 m, force {force:g}", verdict, period, SCALED,
             beside(size, force), _sorted(exponents, linear), within)
            for text, size in (
                ("1 mm", 1e-3), ("1 µm", 1e-6), ("100 nm", 1e-7), ("10 nm", 1e-8), ("1 nm", 1e-9)
            )
            for force, verdict, period, exponents, within in both
        ],
        ("Duffing of 1 µm beside 1 m, force 0.29", "periodic", 4, SCALED, beside(1e-6, 0.29),
         _sorted((-0.03579418, -0.26420582), linear)),
        ("Duffing of 1 µm beside 1 m, force 0.37", "periodic", 5, SCALED, beside(1e-6, 0.37),
         _sorted((-0.05298912, -0.24701088), linear)),
        *[
            (f"Duffing of {text} on a crank of 1 m, force {force:g}", verdict, period, ALONG,
             on_crank(size, force), exponents, within)
            for text, size in (("1 µm", 1e-6), ("10 nm", 1e-8))
            for force, verdict, period, exponents, within in both
        ],
        *[
            (f"Ball that bounces by micrometres beside centimetres, Γ = {strength:g}", verdict,
             period, source, bouncing(strength),
             exponents and _sorted([100 * one for one in exponents], (-381.966, -2618.034)))
            for strength, verdict, period, source, exponents in (
                (1.2, "periodic", 1, TUFILLARO, one_impact(1.2)),
                (1.55, "periodic", 2, EXACT, (-2.53868688, -11.32425673)),
                (1.75, "chaotic", None, EXACT, None),
            )
        ],
        *[
            (f"Clearance of {text} at a rod of 1 m", "periodic", 1,
             "linearised: eigenvalues", ROD.format(size=text, torque=torque),
             hanging(1.0, size, 2.0))
            for text, size, torque in (("1 mm", 1e-3, 0.02), ("0.1 mm", 1e-4, 0.002))
        ],
    ]  # fmt: skip
    return [of_definition(*one) for one in found]


def _sorted(*parts: Sequence[float]) -> tuple[float, ...]:
    return tuple(sorted((one for part in parts for one in part), reverse=True))


SCALES = _systems()
