"""Several rigid contacts in one mechanism: alone, pressed together, and opened by each other."""

import numpy as np
import pytest
from shared_definitions import turning_engine

import linkages

TWO = """
gravity: [0, -9.81]
joints: {O: [0, 0], Q: [1, 0]}
sliders:
  left: {joint: L, through: O, angle: 90 deg, mass: 0.3}
  right: {joint: R, through: Q, angle: 90 deg, mass: 2}
free: {left: {position: 1, speed: 0}, right: {position: 0.4, speed: 1}}
stops:
  - {slider: left, lower: 0, restitution: 0.7}
  - {slider: right, lower: 0, restitution: 0.5}
"""


def test_contacts_that_do_not_meet_do_not_matter():
    both = linkages.simulate(linkages.loads(TWO), end=3.0, samples=61).data.slider_position
    for name, other, index in (("left", "right", 0), ("right", "left", 1)):
        lines = [
            line for line in TWO.splitlines()
            if f"{other}:" not in line.split("{")[0] and f"slider: {other}" not in line
        ]  # fmt: skip
        start = TWO.split("free: {")[1].split("\n")[0].rstrip("}").split("}, ")[index]
        text = "\n".join(line for line in lines if not line.startswith("free"))
        alone = linkages.loads(f"{text}\nfree: {{{start.rstrip('}')}}}}}\n")
        found = linkages.simulate(alone, end=3.0, samples=61).data.slider_position
        # parabolas, which steps do not matter for, and rest at a default tolerance of 1e-10
        np.testing.assert_allclose(both.sel(slider=name), found.sel(slider=name), atol=1e-9)


# A block on a cart that hits a wall: pressed against the front of the cart, or against its back.
CART = """
joints: {O: [0, 0]}
sliders:
  cart: {joint: C, through: O, mass: 2}
  block: {joint: B, on: cart, mass: 0.5}
free: {cart: {position: 0, speed: 1}, block: {position: 0, speed: 0}}
loads: [{joint: B, force: [PUSH, 0]}]
stops:
  - {slider: cart, upper: 0.1, restitution: 0.6}
  - {slider: block, lower: LOWER, upper: UPPER, restitution: 0.3}
"""


def crashed(push, lower, upper):
    text = CART.replace("PUSH", push).replace("LOWER", lower).replace("UPPER", upper)
    solution = linkages.simulate(linkages.loads(text), end=0.1002, samples=3, outputs="all")
    return solution.data.isel(time=-1)


@pytest.mark.parametrize("push", ["0.001", "10"])
def test_a_closed_contact_takes_its_impulse(push):
    """A block at the front of a cart is thrown back with it: (1 + e) m v goes through it."""
    data = crashed(push, "-1", "0")
    push = float(push)
    speed = np.sqrt(1 + 2 * push / 2.5 * 0.1)
    velocity = data.slider_velocity.to_numpy()
    late = 0.1002 - (speed - 1) / (push / 2.5)
    assert velocity[0] == pytest.approx(-0.6 * speed + push / 2.5 * late, rel=1e-9)
    assert abs(velocity[1]) < 1e-11
    lost = 0.5 * 2.5 * (1 - 0.6**2) * speed**2
    by_contact = dict(zip(data.contact.to_numpy().tolist(), data.impact_loss.values, strict=True))
    # both press with their impulses; only the wall's moves against a rate
    assert by_contact["stops[0].upper"] == pytest.approx(lost, rel=1e-9)
    assert by_contact["stops[1].upper"] == pytest.approx(0.0, abs=1e-11)
    assert data.stop_force.to_numpy()[1:] == pytest.approx([0.0, 0.8 * push])


def test_a_closed_contact_opens_where_it_would_have_to_pull():
    """A block at the back of a cart goes on when the cart is thrown back."""
    data = crashed("-0.001", "0", "1")
    assert data.slider_velocity.to_numpy() == pytest.approx([-0.6, 1.6], rel=1e-3)
    assert data.stop_force.to_numpy() == pytest.approx([0.0, 0.0, 0.0])


ENGINE = turning_engine("""\
clearances:
  CLEARANCES
drives: {crank: {angle: 0, speed: 600 rpm}}
""")
LAW = "contact: restitution, restitution: 0.5"
PINS = f"""gap: {{joint: A, bar: rod, size: 0.1 mm, {LAW}}}
  end: {{joint: B, bar: rod, size: 0.1 mm, {LAW}}}"""
GUIDE = f"gap: {{slider: piston, size: 0.1 mm, length: 50 mm, height: 30 mm, {LAW}}}"


@pytest.mark.slow_except("pins")
@pytest.mark.parametrize(("clearances", "count"), [(PINS, 2), (GUIDE, 4)], ids=["pins", "guide"])
def test_energy_force_and_depth_in_an_engine(clearances, count):
    mechanism = linkages.loads(ENGINE.replace("CLEARANCES", clearances))
    solution = linkages.simulate(mechanism, end=0.1, samples=501, outputs="all")
    data, changes = solution.data, solution.motion.changes
    touched = [changes[name] for name in changes if name.endswith("touch")]
    assert len(touched) == count
    assert all(found.rises.any() for found in touched)
    energy = float(abs(data.kinetic_energy + data.potential_energy).max())
    # 600 to 1600 steps at 1e-10
    assert float(abs(data.energy_residual).max()) < 1e-9 * energy
    assert float(data.clearance_force.min()) == 0.0
    assert float(data.clearance_indentation.max()) < 1e-8 * 1e-4
    assert (np.diff(data.impact_loss, axis=0) >= -1e-12 * energy).all()


def test_both_closed_pins_are_two_massless_links():
    """Two models with other coordinates and other equations, while both forces press."""
    closed, linked = [], []
    for line, angle in zip(PINS.splitlines(), (170, 10), strict=True):
        x, y = 1e-4 * np.cos(np.deg2rad(angle)), 1e-4 * np.sin(np.deg2rad(angle))
        closed.append(line.replace("size:", f"offset: [{x}, {y}], size:"))
        linked.append(line.replace(LAW, f"angle: {angle} deg"))
    slow = ENGINE.replace("600 rpm", "60 rpm")
    found, link = (
        linkages.simulate(
            linkages.loads(slow.replace("CLEARANCES", "\n".join(text))), end=0.02, outputs="all"
        ).data
        for text in (closed, linked)
    )
    assert (found.clearance_state == 2).all()
    # errors of both at the default tolerance of 1e-10, of 0.18 m and of 200 N
    np.testing.assert_allclose(found.slider_position, link.slider_position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.clearance_force, link.clearance_force, rtol=1e-6)


@pytest.mark.parametrize("inertia", ["1e-4", "2.7e-6"])
def test_a_block_that_lands_flat_bounces_flat(inertia):
    """Both corners hit at one time, and Newton's law holds for both: no bounce turns the block."""
    text = f"""
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
sliders: {{block: {{joint: B, through: O, mass: 0.076, inertia: {inertia}}}}}
clearances:
  gap: {{slider: block, size: 1 mm, length: 100 mm, height: 50 mm, rate: -0.1, {LAW}}}
free: {{block: {{position: 0, speed: 0.5}}}}
"""
    solution = linkages.simulate(linkages.loads(text), end=0.2, samples=201, outputs="all")
    data, changes = solution.data, solution.motion.changes
    # whichever is a round-off ahead hits for both
    touched = [changes[f"gap.corner{k}: touch"] for k in (3, 4)]
    times = np.unique(np.concatenate([found.time for found in touched]).round(9))
    # 1 mm down at 0.1 m/s, and 2 v eⁿ/g from bounce to bounce, until 1 mm/s
    speed = np.sqrt(0.01 + 2e-3 * 9.81)
    flights = 2 * speed / 9.81 * 0.5 ** np.arange(1, len(times))
    first = (speed - 0.1) / 9.81
    assert times == pytest.approx(first + np.cumsum([0.0, *flights]), abs=1e-9)
    assert float(abs(data.tilt_angle).max()) < 1e-12
    force = data.clearance_force.sel(clearance=["gap.corner3", "gap.corner4"])[-1]
    np.testing.assert_allclose(force, 0.5 * 0.076 * 9.81, rtol=1e-8)


def test_of_contacts_that_depend_on_each_other_one_carries():
    """A slider held by two stops at one place: nothing says which of them presses."""
    stops = "  - {slider: left, lower: 0, restitution: 0.7}\n"
    start = TWO.split("  right")[0] + "free: {left: {position: 1, speed: 0}}\nstops:\n"
    found, one = (
        linkages.simulate(linkages.loads(start + count * stops), end=3.0, samples=61).data
        for count in (2, 1)
    )
    np.testing.assert_allclose(found.slider_position, one.slider_position, atol=1e-9)
    np.testing.assert_allclose(found.stop_force.sum("stop"), one.stop_force[:, 0], atol=1e-7)
