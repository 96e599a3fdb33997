"""Welds: bars fixed to each other move as one plate."""

import numpy as np
import pytest
from kernel_motion import difference
from linkage_models import system_of, values

TIMES = np.linspace(0, 1.5, 16)
PLATE = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  coupler: {points: {A: [0, 0], B: [0.9, 0], E: EX}, mass: 3, center: CENTRE, inertia: INERTIA}
  rocker: {joints: [C, B], length: 0.7, mass: 1}
KNOWN
assembly: {B: left}
"""
BARS = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  coupler: {joints: [A, B], length: 0.9, mass: 2, center: 0.45, inertia: 0.1}
  rocker: {joints: [C, B], length: 0.7, mass: 1}
  arm: {joints: [A, E], length: 0.5, mass: 1, center: 0.2, inertia: 0.05}
welds: {A: {bars: [WELDED], angle: ANGLE}}
KNOWN
assembly: {B: left}
"""
ANGLE = 0.7
DRIVEN = "drives: {crank: {angle: 0.4, speed: 2}}"
FREE = "free: {crank: {angle: 0.4, speed: 2}}"
ORDERS = {"arm on coupler": ("coupler, arm", ANGLE), "coupler on arm": ("arm, coupler", -ANGLE)}


def as_plate(known):
    """The same body: its centre of mass and moment of inertia by hand (Steiner)."""
    e = np.exp(1j * ANGLE)
    centre = (2 * 0.45 + 1 * 0.2 * e) / 3
    inertia = 0.1 + 2 * abs(0.45 - centre) ** 2 + 0.05 + abs(0.2 * e - centre) ** 2
    text = PLATE.replace("EX", f"[{0.5 * np.cos(ANGLE)!r}, {0.5 * np.sin(ANGLE)!r}]")
    text = text.replace("CENTRE", f"[{centre.real!r}, {centre.imag!r}]")
    return system_of(clean(text.replace("INERTIA", repr(inertia)).replace("KNOWN", known)))


def as_bars(known, order):
    welded, angle = ORDERS[order]
    text = BARS.replace("WELDED", welded).replace("ANGLE", repr(angle))
    return system_of(text.replace("KNOWN", known))


def clean(text):
    return text.replace("np.float64(", "").replace(")", "")


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize(
    "name", ["joint_position", "joint_velocity", "joint_acceleration", "drive_effort",
             "kinetic_energy", "potential_energy"],
)  # fmt: skip
def test_welded_bars_are_one_plate(order, name):
    plate, bars = as_plate(DRIVEN), as_bars(DRIVEN, order)
    found = values(bars, name, TIMES)
    if name.startswith("joint"):
        assert {*plate.topology.joints} == {*bars.topology.joints}
        places = [bars.topology.joints.index(j) for j in plate.topology.joints]
        found = found.reshape(len(places), 2, -1)[places].reshape(-1, len(TIMES))
    expected = values(plate, name, TIMES)
    scale = max(1.0, np.abs(expected).max())
    assert found == pytest.approx(expected, abs=1e-13 * scale)  # other roundings


@pytest.mark.parametrize("order", ORDERS)
def test_a_free_motion_is_the_same(order):
    plate, bars = as_plate(FREE), as_bars(FREE, order)
    assert plate.topology.free == bars.topology.free == ("crank",)
    for state in ([0.4, 2.0], [1.4, -3.0]):
        (expected,), (found,) = (
            s.evaluate(s.model.free_accelerations, state=np.array(state)[:, None])[:, 0]
            for s in (plate, bars)
        )
        assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("order", ORDERS)
def test_the_angle_between_them_stays(order):
    of = as_bars(DRIVEN, order)
    assert of.topology.mobility == 1
    angles = values(of, "bar_angle", TIMES)
    assert np.exp(1j * (angles[3] - angles[1])) == pytest.approx(np.exp(1j * ANGLE), abs=1e-14)
    speeds = values(of, "bar_speed", TIMES)
    assert np.array_equal(speeds[3], speeds[1])


def test_a_bar_welded_to_the_ground_stands_still():
    of = system_of("""
joints: {O: [0, 0]}
bars:
  post: {joints: [O, P], length: 0.5}
  crank: {joints: [P, Q], length: 0.2}
welds: {O: {bars: [ground, post], angle: 90 deg}}
drives: {crank: {angle: 0, speed: 1}}
""")
    assert of.places()["Q"] == pytest.approx([0.2, 0.5], abs=1e-16)
    assert values(of, "bar_speed", 0.4)[:, 0].tolist() == [0.0, 1.0]
    assert values(of, "bar_angle", 0.4)[0, 0] == pytest.approx(np.pi / 2, abs=0)


def test_chains_of_welds():
    """Each is turned against the one before: a spiral that turns as a whole."""
    of = system_of("""
joints: {O: [0, 0]}
bars:
  one: {joints: [O, A], length: 1}
  two: {joints: [A, B], length: 1}
  three: {joints: [B, C], length: 1}
welds:
  A: {bars: [one, two], angle: 0.3}
  B: {bars: [two, three], angle: 0.4}
drives: {one: {angle: 0.2, speed: 2}}
""")
    expected = sum(np.exp(1j * (0.2 + turned)) for turned in (0.0, 0.3, 0.7))
    assert complex(*of.places()["C"]) == pytest.approx(expected, abs=1e-15)
    step = 1e-3
    slope = difference(lambda h: values(of, "joint_position", h)[-2:, 0], step)
    assert values(of, "joint_velocity")[-2:, 0] == pytest.approx(slope, abs=1e-12)


def test_a_slider_on_a_welded_bar():
    """A guide that turns with the arm that is welded to the crank."""
    of = system_of("""
joints: {O: [0, 0], C: [0.3, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.2}
  arm: {joints: [A, E], length: 0.5}
  link: {joints: [C, B], length: 0.6}
welds: {A: {bars: [crank, arm], angle: 0.5}}
sliders: {block: {joint: B, on: arm, through: A}}
drives: {crank: {angle: 0.2, speed: 3}}
assembly: {B: [0.6, 0.6]}
""")
    (block,) = of.topology.solved_blocks
    assert (block.kind, block.unknowns) == ("RRP", ("link", "block"))
    places = of.places()
    direction = complex(*(places["B"] - places["A"]))
    assert np.angle(direction) == pytest.approx(0.7, abs=1e-14)
    step = 2e-3
    for below, above in (
        ("slider_position", "slider_velocity"),
        ("slider_velocity", "slider_acceleration"),
        ("joint_velocity", "joint_acceleration"),
    ):
        slope = difference(lambda h, n=below: values(of, n, 0.1 + h)[:, 0], step)
        found = values(of, above, 0.1)[:, 0]
        assert found == pytest.approx(slope, abs=1e-10 * max(1.0, np.abs(found).max()))
