"""SI units of the numbers of a definition file, by path."""

import pytest

from linkages.components.mechanisms.registry import unit_at
from linkages.reading.document import parse

DOCUMENT = parse(
    """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  arm: {joints: [O, P], length: 1, mass: 2, inertia: 3, center: [0, 1]}
  plate: {points: {A: [0, 1]}}
sliders: {s: {joint: P}}
clearances: {r: {joint: P, bar: arm, size: 1 mm}}
masses: {P: 1 kg}
dampers: [{joint: O, damping: 0.5}, {slider: s, damping: 1}]
springs: [{between: [O, B], stiffness: 4530, length: 0.08}, {bar: a, stiffness: 3}]
loads:
  - {bar: arm, torque: "2*t"}
  - {bar: arm, torque: {harmonic: {amplitude: 1, frequency: 2}}}
  - {joint: P, force: [3, {table: {times: [0, 1, 2], values: [1, 2, 3]}}]}
  - {slider: s, force: {rise: cycloidal, from: 1, to: 2, duration: 3}}
free: {arm: {angle: -1.2, speed: 0}, s: {position: 1, speed: 2}}
drives: {a: {angle: 1, speed: 3}, s: {speed: 4}}
simulate: {end: 1, samples: 3, rtol: 1e-9}
""",
    "units.yaml",
)


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        ("gravity[1]", "m/s^2"),
        ("joints.O[0]", "m"),
        ("bars.arm.length", "m"),
        ("bars.arm.mass", "kg"),
        ("bars.arm.inertia", "kg m^2"),
        ("clearances.r.size", "m"),
        ("clearances.r.angle", "rad"),
        ("clearances.r.speed", "rad/s"),
        ("masses.P", "kg"),
        ("dampers[0].damping", "N m s/rad"),
        ("dampers[1].damping", "N s/m"),
        ("springs[0].stiffness", "N/m"),
        ("springs[1].stiffness", "N m/rad"),
        ("free.arm.speed", "rad/s"),
        ("free.s.speed", "m/s"),
        ("drives.a.speed", "rad/s"),
        ("drives.s.speed", "m/s"),
        ("simulate.end", "s"),
        ("loads[0].torque", "N m"),
        ("loads[1].torque.harmonic.amplitude", "N m"),
        ("loads[1].torque.harmonic.frequency", "1/s"),
        ("loads[1].torque.harmonic.phase", "rad"),
        ("loads[2].force[0]", "N"),
        ("loads[2].force[1].table.times[2]", "s"),
        ("loads[2].force[1].table.values[2]", "N"),
        ("loads[3].force.from", "N"),
        ("loads[3].force.duration", "s"),
        ("bars.plate.points.A[1]", "m"),
    ],
)
def test_units(path, unit):
    assert unit_at(DOCUMENT, path) == unit


@pytest.mark.parametrize(
    "path",
    ["simulate.rtol", "loads[0].torque.t", "bars.arm.nothing", "nothing.at.all", "", "gravity[7]",
     "loads[9].torque", "bars", "bars.arm", "drives", "joints.O[0].x"],
)  # fmt: skip
def test_where_there_is_none(path):
    """Pure numbers, formulas from within, and paths that lead nowhere."""
    assert unit_at(DOCUMENT, path) == ""
