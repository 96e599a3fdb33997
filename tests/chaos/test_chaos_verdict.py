"""Verdicts on mechanisms: transients, rest, one run, and its confirmation."""

import pytest

import linkages
from linkages.chaos.report import chaos
from linkages.components.definition import from_document
from linkages.reading.document import parse
from linkages.reading.overrides import apply

# the pendulum of docs/chaos.md (Baker and Gollub, Chaotic Dynamics, with their g = 1.15)
PENDULUM = """\
name: Driven pendulum
gravity: [0, -1]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
dampers: [{joint: O, damping: 0.5}]
loads: [{bar: arm, torque: "1.15*cos(2*t/3)"}]
free: {arm: {angle: -1.2, speed: 0}}
simulate: {end: 10, rtol: 1e-8}
"""

FIVE_BAR = """\
name: Five-bar
gravity: [0, -9.81]
joints: {O1: [0, 0], O2: [0.5, 0]}
bars:
  a: {joints: [O1, A], length: 0.2, mass: 1}
  b: {joints: [A, C], length: 0.5, mass: 1}
  c: {joints: [B, C], length: 0.5, mass: 1}
  d: {joints: [O2, B], length: 0.2, mass: 1}
dampers: [{joint: O1, damping: 0.2}, {joint: O2, damping: 0.2}]
loads: [{bar: a, torque: "AMPLITUDE*cos(2*pi*t)"}]
free: {a: {angle: -90 deg}, d: {angle: -80 deg}}
assembly: {C: [0.25, -0.5]}
simulate: {end: 1, rtol: 1e-8}
"""

DOUBLE_PENDULUM = """\
name: Driven damped double pendulum
joints: {O: [0, 0]}
bars:
  upper: {joints: [O, A], length: 1, mass: 1}
  lower: {joints: [A, B], length: 1, mass: 1}
gravity: [0, -9.81]
free: {upper: {angle: -80 deg}, lower: {angle: -85 deg}}
dampers: [{joint: O, damping: 1}, {joint: A, damping: 1}]
loads: [{bar: upper, torque: "AMPLITUDE*cos(2*pi*t)"}]
simulate: {end: 1, rtol: 1e-8}
"""


def mechanism(text: str, amplitude: float = 1.0, **changes: object) -> linkages.Mechanism:
    document = parse(text.replace("AMPLITUDE", repr(amplitude)), "m.yaml")
    return from_document(apply(document, changes))


def pendulum(damping: float, **changes: object) -> linkages.Mechanism:
    return mechanism(PENDULUM, **{"dampers[0].damping": damping, **changes})


DAMPED = {
    "driven 0.8": lambda: pendulum(0.8),
    "driven 2": lambda: pendulum(2.0),
    "overdamped": lambda: pendulum(4.0),
    "double pendulum 0.3": lambda: mechanism(DOUBLE_PENDULUM, 0.3),
    "double pendulum 1": lambda: mechanism(DOUBLE_PENDULUM, 1.0),
    "five-bar 0.5": lambda: mechanism(FIVE_BAR, 0.5),
    "five-bar 1.2": lambda: mechanism(FIVE_BAR, 1.2),
}
"""Small oscillations about a stable equilibrium, forced and damped: they repeat every period."""


@pytest.mark.parametrize("skip", [None, 0])
@pytest.mark.parametrize("case", DAMPED)
def test_damped_motions_are_periodic(case, skip):
    report = chaos(DAMPED[case](), periods=200, skip=skip)
    assert (report.verdict, report.period) == ("periodic", 1), report.reasons
    assert report.tighter["verdict"] == "periodic"
    assert report.run["skip"] == (100 if skip is None else 0)


@pytest.mark.parametrize("skip", [None, 0])
def test_a_pendulum_that_nothing_drives_comes_to_rest(skip):
    damped = {"dampers": "[{joint: O, damping: 0.1}]"}
    report = chaos(linkages.load("pendulum", set=damped), periods=200, skip=skip)
    assert report.verdict == "at rest", report.reasons
    if skip is None:
        assert report.run["skip"] >= 100
        assert report.rotation[next(iter(report.rotation))].kind == "resting"
