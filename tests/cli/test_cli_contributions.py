"""What `check` says of components, in words."""

import pytest

import linkages
from linkages.cli.verbs.contribution_rows import loads, relations

MECHANISM = """
joints: {O: [0, 0], H: [0, 1]}
bars: {arm: {joints: [O, P], length: 0.5, mass: 1}}
sliders: {cart: {joint: C, through: O, mass: 2}}
free: {arm: {angle: 0.5, speed: 0}KNOWN}
"""


def rows(text, read=loads, known=", cart: {position: 0.1}"):
    found = read(linkages.loads(MECHANISM.replace("KNOWN", known) + text))
    return [(row["kind"], row["on"], row["value"]) for row in found]


@pytest.mark.parametrize(
    ("text", "row"),
    [
        (
            "loads: [{joint: P, on: arm, force: [1, 0]}]",
            ("force", "joint P, turning with arm", "[1 N, 0 N]"),
        ),
        ("loads: [{between: [H, P], force: 3}]", ("force", "joints H and P", "3 N")),
        (
            "springs: [{slider: cart, stiffness: 9, position: 3 cm}]",
            ("spring", "cart in its guide", "9 N/m, position 0.03 m"),
        ),
        (
            "springs: [{between: [H, P], force: 9, damping: 2}]",
            ("constant-force spring", "joints H and P", "force 9 N, damping 2 N s/m"),
        ),
        (
            "motors: {m: {bar: arm, stall_torque: 2, no_load_speed: 30, gear_ratio: 5}}",
            ("motor", "arm", "gear ratio 5, stall torque 2 N m, no load speed 30 rad/s"),
        ),
        (
            "cylinders: {c: {between: [H, P], bore: 0.1, pressure: '1e5*(1 + sin(20*t))'}}",
            ("cylinder", "joints H and P", "bore 0.1 m, pressure 0 to 200000 Pa until t = 1 s"),
        ),
        (
            "stops: [{slider: cart, upper: 0.3, stiffness: 1e4}]",
            ("stop", "cart in its guide", "stiffness 10000 N/m, upper 0.3 m"),
        ),
        (
            "friction: [{joint: O, torque: 0.2}]",
            ("friction", "arm", "torque 0.2 N m"),
        ),
    ],
)
def test_loads_in_words(text, row):
    assert rows(text) == [row]


@pytest.mark.parametrize(
    ("text", "row"),
    [
        (
            "racks: [{slider: cart, bar: arm, radius: -0.1}]",
            ("rack", "arm and cart", "cart moves -0.1 m per radian of arm"),
        ),
        (
            "cams: [{slider: cart, bar: arm, angles: [0, 2, 4, 360 deg], lifts: [0, 1, 1, 0]}]",
            ("cam", "arm and cart", "cart is lifted by 0 to 1.14286 m"),
        ),
    ],
)
def test_relations_in_words(text, row):
    (found,) = rows(text, relations, known="")
    assert found[:2] == row[:2]
    assert found[2].startswith(row[2].split("0 to")[0])
