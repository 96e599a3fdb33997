"""Bodies at rest on stops, walls and dry guides beside others, whose motion is known."""

from __future__ import annotations

import numpy as np

from make.verdicts.known import LOST, Known, of_definition

LINEAR = "lies still beside a linear oscillation"
DUFFING = "lies still beside a Duffing oscillator of this list"
OTHER = "lies still beside a motion known from other code, SciPy, with tangents"

BESIDE = """\
gravity: [0, -9.81]
joints: {{O: [0, 0], Q: [1, 0]}}
sliders:
  ball: {{joint: P, through: O, angle: 90 deg, mass: 1}}
  m: {{joint: R, through: Q, mass: 1}}
{holding}
loads: [{{slider: m, force: "{force}"}}]
free: {{ball: {{position: {position}, speed: 0}}, m: {{position: 0.8, speed: 0.5}}}}
simulate: {{end: 6}}
"""

ARM = """\
gravity: [0, -9.81]
joints: {O: [0, 0], Q: [1, 0]}
sliders: {ball: {joint: P, through: O, angle: 90 deg, mass: 1}}
bars: {arm: {joints: [Q, R], length: 1}}
masses: {R: 1 kg}
dampers: [{joint: Q, damping: 0.5}]
loads: [{bar: arm, torque: "9.81*1.5*cos(2*t)"}]
stops: [{slider: ball, lower: 0, restitution: 0.5}]
free: {ball: {position: 0.1, speed: 0}, arm: {angle: -1.2}}
"""

ROD = """\
gravity: [0, -9.81]
joints: {{O: [0, 0], Q: [1, 0]}}
bars: {{rod: {{joints: [O, P], length: 0.5, mass: 2}}}}
{beside}
clearances: {{gap: {{joint: O, bar: rod, size: 1 mm, contact: restitution, restitution: 0.8}}}}
dampers: [{{bars: [ground, rod], damping: 0.05}}]
free: {{rod: {{angle: -95 deg}}{free}}}
simulate: {{end: 2}}
"""


def beside(force: str, holding: str, position: float = 0.1) -> str:
    """A ball in a vertical guide, and a mass in a horizontal one under a force."""
    return BESIDE.format(force=force, holding=holding, position=position)


def rod(force: str = "") -> str:
    if not force:
        return ROD.format(beside="", free="")
    text = f"""\
sliders: {{m: {{joint: R, through: Q, mass: 1}}}}
loads: [{{slider: m, force: "{force}"}}]"""
    return ROD.format(beside=text, free=", m: {position: 0.8, speed: 0.5}")


def hanging(length: float, clearance: float, damping: float) -> tuple[float, ...]:
    """Exponents of a rod of 2 kg that hangs in its bearing, linearised.

    Coordinates are the angles of the rod, which is damped, and of the contact in the bearing.
    """
    m, g, a, c = 2.0, 9.81, length / 2, clearance
    mass = np.array([[4 / 3 * m * a * a, m * c * a], [m * c * a, m * c * c]])
    stiffness = np.diag([m * g * a, m * g * c])
    matrix = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, np.diag([damping, 0.0]))],
        ]
    )
    return tuple(sorted(np.linalg.eigvals(matrix).real.tolist(), reverse=True))


def _systems() -> list[Known]:
    rigid = "stops: [{slider: ball, lower: 0, restitution: 0.5}]"
    compliant = "stops: [{slider: ball, lower: 0, stiffness: 100, damping: 2}]"
    rope = "stops: [{between: [O, P], upper: 1, restitution: 0}]"
    dry = "friction: [{slider: ball, force: 20}]"
    linear = "cos(1.3*t) - m.position - 0.1*m.velocity"
    free = "-m.position - 0.1*m.velocity"
    duffing = "{force}*cos(1.2*t) + m.position - m.position**3 - 0.3*m.velocity"
    cycle = "0.1*cos(1.3*t) - m.position + 0.2*(1 - m.position**2)*m.velocity"
    both = "- {slider: %s, lower: %s, restitution: 0.5}"
    balls = beside("-9.81", "stops:\n" + "\n".join(both % (n, "0") for n in ("ball", "m")))
    half, rolling = (-0.05, -0.05), hanging(0.5, 1e-3, 0.05)
    wells, chaos = (-0.05298912, -0.24701088), (0.1068, -0.4068)
    found = [
        ("Ball on a rigid stop, beside a driven oscillator", "periodic", 1, LINEAR,
         beside(linear, rigid), (*half, LOST, LOST)),
        ("Ball on a rigid stop from the beginning, beside a driven oscillator", "periodic", 1,
         LINEAR, beside(linear, rigid, 0.0), (*half, LOST, LOST)),
        ("Ball on a rigid stop, beside a damped oscillator", "at rest", None, LINEAR,
         beside(free, rigid), (*half, LOST, LOST)),
        ("Ball on a rigid stop, beside Duffing, force 0.28", "periodic", 2, DUFFING,
         beside(duffing.format(force=0.28), rigid), (-0.15, -0.15, LOST, LOST)),
        ("Ball on a rigid stop, beside Duffing, force 0.37", "periodic", 5, DUFFING,
         beside(duffing.format(force=0.37), rigid), (*wells, LOST, LOST)),
        ("Ball on a rigid stop, beside Duffing, force 0.5", "chaotic", None, DUFFING,
         beside(duffing.format(force=0.5), rigid), (*chaos, LOST, LOST), 0.02),
        ("Ball on a rigid stop, beside a driven van der Pol oscillator", "quasi-periodic", None,
         "averaging, as above", beside(cycle, rigid), (0.0, -0.1989, LOST, LOST), 0.001),
        ("Ball on a rigid stop, beside a driven pendulum", "periodic", 1, OTHER, ARM,
         (-0.25, -0.25, LOST, LOST)),
        ("Two balls on rigid stops", "at rest", None, "energy falls", balls,
         (LOST, LOST, LOST, LOST)),
        ("Ball on a compliant stop, beside a driven oscillator", "periodic", 1, LINEAR,
         beside(linear, compliant), (*half, -1.0, -1.0)),
        ("Ball on a compliant stop, beside Duffing, force 0.5", "chaotic", None, DUFFING,
         beside(duffing.format(force=0.5), compliant), (*chaos, -1.0, -1.0), 0.02),
        ("Ball on a taut rope, beside a driven oscillator", "periodic", 1, LINEAR,
         beside(linear, rope, -0.9), (*half, LOST, LOST)),
        ("Ball stuck in a dry guide, beside a driven oscillator", "periodic", 1, LINEAR,
         beside(linear, dry), (0.0, *half, LOST)),
        ("Ball stuck in a dry guide, beside Duffing, force 0.5", "chaotic", None, DUFFING,
         beside(duffing.format(force=0.5), dry), (chaos[0], 0.0, chaos[1], LOST), 0.02),
        ("Rod on the wall of its bearing", "at rest", None, "linearised: eigenvalues", rod(),
         (*rolling, LOST, LOST)),
        ("Rod on the wall of its bearing, beside a driven oscillator", "periodic", 1,
         "linearised: eigenvalues", rod(linear), (*half, *rolling, LOST, LOST)),
    ]  # fmt: skip
    return [of_definition(*one) for one in found]


RESTING = _systems()
