"""SI units of the numbers of a definition file, by path."""

import pytest

from linkages.components.units import unit_at
from linkages.reading.document import parse

DOCUMENT = parse(
    """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1, mass: 2, inertia: 3, center: [0, 1]}}
sliders: {s: {joint: P}}
clearances: {r: {joint: P, bar: arm, size: 1 mm}}
masses: {P: 1 kg}
dampers: [{joint: O, damping: 0.5}, {slider: s, damping: 1}]
springs: [{between: [O, B], stiffness: 4530, length: 0.08}, {bar: a, stiffness: 3}]
loads: [{bar: arm, torque: "2*t"}]
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
    ],
)
def test_units(path, unit):
    assert unit_at(DOCUMENT, path) == unit


@pytest.mark.parametrize(
    "path",
    ["simulate.rtol", "loads[0].torque", "bars.arm.nothing", "nothing.at.all", "", "gravity[7]",
     "loads[9].torque", "bars", "bars.arm", "drives", "joints.O[0].x"],
)  # fmt: skip
def test_where_there_is_none(path):
    """Pure numbers, laws of time, and paths that lead nowhere."""
    assert unit_at(DOCUMENT, path) == ""
