"""Controllers, windings, Maxwell elements and bristles, where the motion is known."""

from __future__ import annotations

import numpy as np

from make.verdicts.known import Known, of_definition

LINEAR = "linear: eigenvalues"
OTHER = "other code, SciPy, with tangents"

WHEEL = """\
joints: {{O: [0, 0]}}
bars: {{wheel: {{points: {{O: [0, 0], P: [0.1, 0]}}, mass: 4, center: [0, 0], inertia: 0.02}}}}
{effort}
free: {{wheel: {{angle: 0.3}}}}
simulate: {{end: 1}}
"""

BLOCK = """\
joints: {{O: [0, 0]}}
sliders: {{m: {{joint: P, through: O, mass: 1}}}}
{elements}
free: {{m: {{position: 0.1, speed: 0}}}}
simulate: {{end: 5}}
"""


def motor(voltage: str, more: str = "") -> str:
    effort = (
        f'motors: {{h: {{bar: wheel, voltage: "{voltage}", torque_constant: 0.5 N m/A, '
        f"resistance: 2 ohm, inductance: 0.05 H}}}}\n{more}"
    )
    return WHEEL.format(effort=effort)


def speed_control(setpoint: str) -> str:
    effort = (
        f'controllers: {{pace: {{bar: wheel, of: wheel.speed, setpoint: "{setpoint}", '
        "proportional: 0.1, integral: 0.5}}"
    )
    return WHEEL.format(effort=effort)


def position_control(setpoint: str) -> str:
    elements = (
        f'controllers: {{c: {{slider: m, of: m.position, setpoint: "{setpoint}", '
        "proportional: 4, integral: 2, derivative: 1.5}}"
    )
    return BLOCK.format(elements=elements)


def maxwell(force: str, *elements: tuple[float, float]) -> str:
    """A mass under a force, and Maxwell elements of a stiffness and a damping."""
    found = ", ".join(f"{{slider: m, stiffness: {k}, damping: {d}}}" for k, d in elements)
    load = f'loads: [{{slider: m, force: "{force}"}}]'
    return BLOCK.format(elements=f"{load}\nmaxwell: [{found}]")


def bristles(force: str) -> str:
    """A mass on a spring of 1 N/m with LuGre friction."""
    friction = "{slider: m, force: 0.4, bristle_stiffness: 20, bristle_damping: 2}"
    load = f'loads: [{{slider: m, force: "-m.position{force}"}}]'
    return BLOCK.format(elements=f"{load}\nfriction: [{friction}]")


def rates(*polynomial: float) -> tuple[float, ...]:
    """Real parts of the roots, the largest first."""
    return tuple(sorted(np.roots(polynomial).real.tolist(), reverse=True))


def _systems() -> list[Known]:
    # J ω' = k i, L i' = U - k ω - R i with J = 0.02, k = 0.5, L = 0.05, R = 2
    winding = rates(1, 40, 250)
    # and a spring of 0.5 N m/rad
    sprung = rates(1, 40, 250 + 25, 25 * 40)
    zener = rates(1, 5 / 2, 1 + 5, 5 / 2)
    # x'' = -x - 5 s - 3 r, s' = v - 2.5 s, r' = v - 0.3 r
    double = _spectrum([[0, 1, 0, 0], [-1, 0, -5, -3], [0, 1, -2.5, 0], [0, 1, 0, -0.3]])
    turning = "turns at a constant mean rate, 12 rad/s against"
    spring = "springs: [{bar: wheel, stiffness: 0.5}]"
    duffing = "{force}*cos(t) + m.position - m.position**3 - 0.15*m.velocity"
    found = [
        ("Motor with inductance, 5 rad/s", "periodic", 5, f"{LINEAR}; {turning} 5",
         motor("6 + 3*sin(5*t)"), (0.0, *winding)),
        ("Motor with inductance, 4 rad/s", "periodic", 1, f"{LINEAR}; {turning} 4",
         motor("6 + 3*sin(4*t)"), (0.0, *winding)),
        ("Motor with inductance, √13 rad/s", "quasi-periodic", None, f"{LINEAR}; {turning} √13",
         motor("6 + 3*sin(sqrt(13)*t)"), (0.0, *winding)),
        ("Motor with inductance, constant voltage", "periodic", 1, f"{LINEAR}; constant speed",
         motor("6"), (0.0, *winding)),
        ("Motor with inductance, and a spring", "periodic", 1, LINEAR,
         motor("3*sin(5*t)", spring), sprung),
        ("Motor with inductance, short-circuited, and a spring", "at rest", None, LINEAR,
         motor("0*t", spring), sprung),
        ("PI control of a speed", "periodic", 1, f"{LINEAR}; constant speed",
         speed_control("20"), (0.0, *rates(0.02, 0.1, 0.5))),
        ("PI control of a speed that reverses", "periodic", 1, LINEAR,
         speed_control("20*sin(3*t)"), (0.0, *rates(0.02, 0.1, 0.5))),
        ("PID control of a position", "at rest", None, LINEAR, position_control("0.3"),
         rates(1, 1.5, 4, 2)),
        ("PID control that follows a sine", "periodic", 1, LINEAR,
         position_control("0.1*sin(2*t)"), rates(1, 1.5, 4, 2)),
        ("Standard linear solid, free", "at rest", None, LINEAR,
         maxwell("-m.position", (5, 2)), zener),
        ("Standard linear solid, driven", "periodic", 1, LINEAR,
         maxwell("cos(1.7*t) - m.position", (5, 2)), zener),
        ("Two Maxwell elements, driven", "periodic", 1, LINEAR,
         maxwell("cos(1.7*t) - m.position", (5, 2), (3, 10)), double),
        ("Duffing with a Maxwell element, force 0.5", "periodic", 1, OTHER,
         maxwell(duffing.format(force=0.5), (0.2, 0.1)), (-0.107974, -0.107974, -1.934052)),
        ("Duffing with a Maxwell element, force 0.35", "chaotic", None, OTHER,
         maxwell(duffing.format(force=0.35), (0.2, 0.1)), (0.1633, -0.4040, -1.9093), 0.02),
        ("LuGre friction, free", "at rest", None, "energy falls to a line of equilibria",
         bristles(""), None),
        ("LuGre friction, force 1", "periodic", 1, OTHER, bristles(" + cos(0.5*t)"),
         (-0.01477983, -0.38704243, -20.66108)),
        ("LuGre friction, force 0.3, creeping", "periodic", 1, OTHER, bristles(" + 0.3*cos(0.5*t)"),
         (-0.02498084, -1.1035, -1.1035)),
        ("LuGre friction, force 0.6", "periodic", 1, OTHER, bristles(" + 0.6*cos(0.8*t)"),
         (-0.18822938, -0.18822938, -24.928774)),
    ]  # fmt: skip
    return [of_definition(*one) for one in found]


def _spectrum(matrix: list[list[float]]) -> tuple[float, ...]:
    return tuple(sorted(np.linalg.eigvals(np.array(matrix)).real.tolist(), reverse=True))


INTERNAL = _systems()
