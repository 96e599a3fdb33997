"""Blocks in guides: closed forms, balances, limits, symmetry."""

from itertools import pairwise

import numpy as np
import pytest

import linkages
from linkages.components.contributed.contact_laws import contact_laws
from linkages.components.contributed.normal_forces import restitution_reached

THROWN = """
gravity: [0, -9.81]
sliders: {block: {joint: B, through: [0.1, 0.2], angle: 30 deg, mass: 0.4, inertia: 3e-4}}
clearances:
  play: {slider: block, size: 2 mm, length: 60 mm, height: 40 mm, contact: hertz, stiffness: 1e8,
         offset: -0.5 mm, rate: 50 mm/s, angle: -1 deg, speed: 1.5}
free: {block: {position: 0.05, speed: 2}}
"""
ENGINE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 153 mm, mass: 0.038, inertia: 7.4e-5}
  rod: {joints: [A, B], length: 306 mm, mass: 0.038, inertia: 5.9e-4}
sliders: {piston: {joint: B, through: O, mass: 0.076, inertia: 2.7e-6}}
clearances:
  play: {slider: piston, size: 1 mm, length: 100 mm, height: 50 mm, contact: flores,
         stiffness: 1e8 N/m^1.5, restitution: 0.6, friction: 0.1, slip: 50 mm/s}
drives: {crank: {angle: 0.4, speed: 40 rad/s}}
assembly: {B: [0.45, 0]}
"""
LEVER = """
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.12, 0.01]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.4, center: 0.02}
  lever: {joints: [D, E], length: 0.3, mass: 0.5, inertia: 0.004}
sliders:
  block: {joint: A, on: lever, angle: 0.05, through: [0.01, 0.02], mass: 0.3, inertia: 1e-4}
clearances:
  play: {slider: block, size: 0.3 mm, length: 50 mm, height: 30 mm, contact: kelvin-voigt,
         stiffness: 1e7, damping: 100, friction: 0.1, slip: 10 mm/s}
drives: {crank: {angle: 1.0, speed: 30}}
assembly: {E: [-0.15, 0.1]}
"""


def test_block_flies_freely_between_its_walls():
    """Constant speeds along the guide and of the angle, and a parabola across it."""
    times = np.linspace(0.0, 0.02, 5)  # the first corner touches after 29 ms
    outputs = ["slider_position", "offset_position", "tilt_angle", "clearance_indentation"]
    data = linkages.simulate(linkages.loads(THROWN), times=times, outputs=outputs).data
    along, across = -9.81 * np.array([np.sin(np.pi / 6), np.cos(np.pi / 6)])
    offset = -0.5e-3 + 0.05 * times + 0.5 * across * times**2
    angle = np.deg2rad(-1.0) + 1.5 * times
    # polynomials of degree 2 are integrated without error
    np.testing.assert_allclose(data.slider_position[:, 0], 0.05 + 2 * times + along * times**2 / 2,
                               rtol=1e-12)  # fmt: skip
    np.testing.assert_allclose(data.offset_position[:, 0], offset, atol=1e-14)
    np.testing.assert_allclose(data.tilt_angle[:, 0], angle, atol=1e-13)
    corners = {"play.corner1": (-1, 1), "play.corner2": (1, 1),
               "play.corner3": (-1, -1), "play.corner4": (1, -1)}  # fmt: skip
    for name, (x, y) in corners.items():
        reach = 0.03 * x * np.sin(angle) + 0.02 * y * np.cos(angle)
        expected = y * (offset + reach) - 0.022
        assert expected.max() < 0.0
        found = data.clearance_indentation.sel(clearance=name)
        np.testing.assert_allclose(found, expected, atol=1e-14)


@pytest.mark.parametrize("stiffness", [1e10, 1e13])
def test_one_corner_hits_its_wall(stiffness):
    """Impulse (1 + e) d'/(1/m + x²/J) at a lever x: the block leaves with −e d' at that corner.

    The block turns within the impact, by d'·duration/x in relative terms ~ K^-0.4: 3e-5 and 2e-6.
    """
    law = {"contact": "exact", "restitution": 0.5, "stiffness": stiffness}
    play = {"slider": "block", "size": "2 mm", "length": "60 mm", "height": "40 mm"}
    start = {"angle": 0.01, "rate": 0.8, "speed": 0.0}
    mechanism = linkages.loads(THROWN).with_values(
        {"gravity": [0, 0], "clearances.play": play | law | start}
    )
    outputs = ["offset_rate", "tilt_speed"]
    solution = linkages.simulate(mechanism, end=0.0026, samples=27, rtol=1e-11, outputs=outputs)
    last, sin, cos = solution.data.isel(time=-1), np.sin(0.01), np.cos(0.01)
    lever = 0.03 * cos - 0.02 * sin  # corner2 is in front, at the upper wall
    impulse = 1.5 * 0.8 / (1 / 0.4 + lever**2 / 3e-4)
    tolerance = 2.0 * (1e10 / stiffness) ** 0.4 * 1e-3
    assert float(last.offset_rate[0]) == pytest.approx(0.8 - impulse / 0.4, abs=tolerance)
    turned = -impulse * lever / 3e-4
    assert float(last.tilt_speed[0]) == pytest.approx(turned, rel=tolerance)
    left = float(last.offset_rate[0]) + lever * float(last.tilt_speed[0])
    assert left == pytest.approx(-0.4, abs=tolerance)
    assert restitution_reached(contact_laws()["exact"].restitution(0.5)) == pytest.approx(0.5)


@pytest.mark.parametrize("text", [ENGINE, LEVER], ids=["ground", "bar"])
def test_energy_balance(text):
    """What drives and weight give is moving, stored in walls, or lost; 1e-9 at 1e-10."""
    data = linkages.simulate(
        linkages.loads(text), end=0.1, samples=401, rtol=1e-10, outputs="all"
    ).data
    scale = float(np.abs(data.kinetic_energy).max())
    assert float(data.clearance_force.max()) > 0.0
    assert float(np.abs(data.clearance_friction_loss).max()) > 0.0
    assert np.abs(data.energy_residual).max() < 1e-9 * scale


def test_newton_and_euler_of_block_and_lever():
    """Reactions and contact forces accelerate the block; the lever feels the opposite forces."""
    outputs = [f"joint_{what}" for what in ("position", "acceleration", "reaction")]
    outputs += ["clearance_force", "clearance_friction", "bar_angle", "bar_acceleration",
                "tilt_angle", "clearance_acceleration", "clearance_state"]  # fmt: skip
    data = linkages.simulate(linkages.loads(LEVER), end=0.1, samples=101, outputs=outputs).data
    angle = data.bar_angle.sel(bar="lever").to_numpy() + 0.05
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    force, friction = (data[f"clearance_{k}"].to_numpy() for k in ("force", "friction"))
    assert (force > 0).any(axis=0).sum() >= 2
    sides = np.array([1.0, 1.0, -1.0, -1.0])
    pushed = friction.sum(axis=1)[:, None] * along - (force @ sides)[:, None] * across
    gravity = np.array([0.0, -9.81])
    at_a = data.joint_reaction.sel(joint="A").to_numpy()  # of the crank, on the block
    moved = data.joint_acceleration.sel(joint="A").to_numpy()
    largest = np.abs(force).max()
    np.testing.assert_allclose(at_a + pushed + 0.3 * gravity, 0.3 * moved, atol=1e-9 * largest)
    at_d = data.joint_reaction.sel(joint="D").to_numpy()
    centre = 0.5 * data.joint_acceleration.sel(joint="E").to_numpy()
    np.testing.assert_allclose(at_d - pushed + 0.5 * gravity, 0.5 * centre, atol=1e-9 * largest)
    turn = data.tilt_angle.sel(tilt="play.tilt").to_numpy()
    x, y = np.array([-1, 1, -1, 1]) * 0.025, sides * 0.015
    arm_x = np.outer(np.cos(turn), x) - np.outer(np.sin(turn), y)
    arm_y = np.outer(np.sin(turn), x) + np.outer(np.cos(turn), y)
    moment = (-arm_x * force * sides - arm_y * friction).sum(axis=1)
    spin = data.clearance_acceleration.sel(clearance="play.corner1")
    spin = spin + data.bar_acceleration.sel(bar="lever")
    np.testing.assert_allclose(moment, 1e-4 * spin.to_numpy(), atol=1e-9 * largest)


def test_mirrored_engine_moves_as_in_a_mirror():
    """Weight, crank and friction turned over: upper corners do what lower ones did."""
    outputs = ["clearance_indentation", "offset_position", "tilt_angle"]
    one = linkages.loads(ENGINE)
    other = one.with_values({
        "gravity": [0, 9.81], "drives.crank.angle": -0.4, "drives.crank.speed": -40.0,
    })  # fmt: skip
    first, second = (
        linkages.simulate(m, end=0.03, samples=31, outputs=outputs).data for m in (one, other)
    )
    depth, mirrored = first.clearance_indentation, second.clearance_indentation
    assert float(depth.max()) > 0.0
    np.testing.assert_allclose(depth[:, [2, 3, 0, 1]], mirrored, atol=1e-12)
    np.testing.assert_allclose(first.tilt_angle, -second.tilt_angle, atol=1e-10)


def test_small_play_tends_to_the_ideal_slider():
    """The position is off by what the joint is off the axis, at most (size + d) tan(rod angle)."""
    found = []
    for size in (1e-3, 1e-4, 1e-5):
        values = {"clearances.play.size": size, "clearances.play.dissipation": 2.0,
                  "clearances.play.contact": "hunt-crossley-constant",
                  "clearances.play.stiffness": 1e11,
                  "clearances.play.restitution": None}  # fmt: skip
        mechanism = linkages.loads(ENGINE).with_values(values)
        data = linkages.simulate(mechanism, end=0.1, samples=201, outputs="all").data
        off = float(np.abs(data.slider_position_error).max())
        assert off <= 0.6 * (size + max(0.0, float(data.clearance_indentation.max())))
        found.append(off)
    assert found[0] > 5 * found[1] > 25 * found[2]


@pytest.mark.slow
def test_loaded_and_damped_block_slides_on_its_wall():
    """A slow engine whose weight holds the block down: an ideal slider on an axis that is lower.

    It is lower by the size and by the indentation of two corners; how these share the load does
    not matter to first order, as F^(2/3) is nearly straight over the share.
    """
    engine = linkages.loads(ENGINE).with_values({
        "drives.crank.speed": 0.5, "gravity": [0, -500.0], "clearances.play.friction": 0.0,
        "clearances.play.offset": "-1 mm", "clearances.play.restitution": None,
        "clearances.play.contact": "hunt-crossley-constant",
        "clearances.play.dissipation": 50.0, "clearances.play.stiffness": 1e10,
    })  # fmt: skip
    outputs = ["slider_position", "clearance_indentation", "offset_position"]
    data = linkages.simulate(engine, end=3.0, samples=61, outputs=outputs).data.isel(
        time=slice(5, None)
    )
    depth = data.clearance_indentation.to_numpy()[:, 2:]
    assert (depth > 0).all()
    lower = -1e-3 - depth.mean(axis=1).mean()
    ideal = engine.ideal().with_values({"sliders.piston.through": [0.0, lower]})
    expected = linkages.simulate(ideal, times=data.time.to_numpy(), outputs=["slider_position"])
    off = np.abs(data.slider_position - expected.data.slider_position.to_numpy()).max()
    assert float(off) < depth.max()  # the play itself is three decades larger
    assert depth.max() < 1e-5


PUBLISHED = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 153 mm, mass: 0.038, inertia: 7.4e-5}
  rod: {joints: [A, B], length: 306 mm, mass: 0.038, inertia: 5.9e-4}
sliders: {slider: {joint: B, through: O, mass: 0.076, inertia: 2.7e-6}}
clearances:
  play: {slider: slider, size: 1 mm, length: 100 mm, height: 50 mm,
         contact: exact, restitution: 0.4, stiffness: 1e9 N/m^1.5, friction: 0.01, slip: 10 mm/s}
free: {crank: {angle: 0, speed: 150 rad/s}}
assembly: {B: [0.459, 0]}
"""


def test_published_crank_starts_with_its_velocities():
    """Flores, Leine and Glocker (2010): 150, -75 and 0 rad/s, a block at rest in mid-guide."""
    outputs = ["bar_speed", "tilt_speed", "offset_rate"]
    data = linkages.simulate(linkages.loads(PUBLISHED), times=[0.0, 1e-6], outputs=outputs).data
    np.testing.assert_allclose(data.bar_speed[0], [150.0, -75.0], rtol=1e-14)
    np.testing.assert_allclose([data.tilt_speed[0, 0], data.offset_rate[0, 0]], 0.0, atol=1e-12)


@pytest.mark.slow
def test_published_crank_tends_to_rigid_walls():
    """Offsets tend to those of rigid corners like K^-0.4, for impacts last so long.

    Until 20 ms: a flat landing, bounces, and following the upper wall. Both without friction.
    """
    times = np.linspace(0.0, 0.02, 101)

    def offset(values):
        mechanism = linkages.loads(PUBLISHED).with_values(
            {"clearances.play.friction": 0.0, "clearances.play.slip": None, **values}
        )
        outputs = ["offset_position", "energy_residual", "kinetic_energy"]
        data = linkages.simulate(mechanism, times=times, rtol=1e-11, outputs=outputs).data
        balance = np.abs(data.energy_residual).max() / data.kinetic_energy[0]
        assert float(balance) < 1e-9
        return data.offset_position

    rigid = offset({"clearances.play.contact": "restitution", "clearances.play.stiffness": None})
    off = [float(np.abs(offset({"clearances.play.stiffness": k}) - rigid).max())
           for k in (1e9, 1e11, 1e13)]  # fmt: skip
    for stiff, stiffer in pairwise(off):
        assert stiff / stiffer == pytest.approx(100**0.4, rel=0.06)
    assert off[0] < 1e-4
