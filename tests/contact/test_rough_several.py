"""Several rigid contacts with Coulomb's friction: shared impacts, and blocks that slip and hold."""

import re
from collections import Counter

import numpy as np
import pytest
from scipy.optimize import brentq
from shared_definitions import turning_engine
from shared_impacts import impact
from tangent_differences import check

import linkages
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.run import RunOptions
from linkages.solution.many import march_many
from linkages.solution.march import March
from linkages.solution.motion import Motion

SIDES = ((-1, 1), (1, 1), (-1, -1), (1, -1))

BLOCK = """
joints: {{O: [0, 0]}}
sliders: {{block: {{joint: B, through: O, mass: 0.5, inertia: {inertia}}}}}
clearances:
  gap: {{slider: block, size: 1 mm, length: 100 mm, height: {height}, contact: restitution,
        restitution: {restitution}, friction: {friction}, impact: {impact}}}
free: {{block: {{position: 0, speed: 0}}}}
"""


def placed(height, touching):
    """Offset and tilt of a block of which the rear upper corner touches, or it and another one."""
    if touching == "flat":
        return 1e-3, 0.0, [0, 1]

    def above(tilt):
        return 0.05 * np.sin(tilt) + 0.5 * height * (np.cos(tilt) - 1) - 1e-3

    if touching == "one":
        return -above(0.01), -0.01, [0]
    return 0.0, brentq(above, 0.0, 0.1, xtol=1e-16), [1, 2]


@pytest.mark.slow_except("one")
@pytest.mark.parametrize("touches", ["flat", "diagonal", "one"])
def test_random_impacts_of_corners_against_all_cases(touches):
    """Of one corner by the same law where that is asked for."""
    impact_law = "moreau" if touches == "one" else "newton"
    random, seen = np.random.default_rng(3), Counter()
    for restitution, friction, height in (
        (0.5, 0.1, 0.05), (1.0, 0.3, 0.1), (1e-12, 0.3, 0.05), (1.0, 0.5, 0.05)
    ):  # fmt: skip
        inertia = 10 ** random.uniform(-4.2, -2.8)
        system = System(linkages.loads(BLOCK.format(**locals() | {"impact": impact_law})))
        names = list(system.model.topology.free)
        order = np.array([names.index(name) for name in ("block", "gap.offset", "gap.tilt")])
        offset, tilt, touching = placed(height, touches)
        turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
        places = [np.array(SIDES[k]) * [0.05, 0.5 * height] for k in touching]
        arms = [turn @ place for place in places]
        sides = [SIDES[k][1] for k in touching]
        rows = zip(sides, arms, strict=True)
        normals = np.array([side * np.array([0, 1, r[0]]) for side, r in rows])
        tangents = np.array([[1, 0, -r[1]] for r in arms])
        velocities = random.uniform(-1, 1, (40, 3)) * [1, 1, 10]
        velocities *= np.where((velocities @ normals.T).max(axis=1) < 0.01, -1.0, 1.0)[:, None]
        own = (velocities @ normals.T).argmax(axis=1)
        state = np.zeros((6, 40))
        state[order] = np.array([[0.0], [offset], [tilt]])
        state[3 + order] = velocities.T
        contacts = [system.model.walls.contacts[k] for k in touching]
        found = [system.evaluate(c.rates_behind, np.zeros(40), state)[order] for c in contacts]
        for k, velocity in enumerate(velocities):
            expected, how = impact(
                np.array([0.5, 0.5, inertia]), normals, tangents, np.full(len(arms), friction),
                np.full(len(arms), restitution), velocity,
            )  # fmt: skip
            # closing leaves 1e-12 m/s; the inertia has a condition of 1e4
            np.testing.assert_allclose(found[own[k]][:, k], expected, rtol=0, atol=1e-9)
            seen[how] += 1
    assert seen["whole"] > 100
    assert touches != "flat" or seen["limited"] > 0


PUSHED = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders:
  block: {joint: B, through: O, mass: 0.5, inertia: 1e-3}
clearances:
  gap: {slider: block, size: 1 mm, length: 100 mm, height: 40 mm, contact: restitution,
        restitution: 0.5, friction: 0.2, offset: -1 mm}
free: {block: {position: 0, speed: 0}}
loads: [{slider: block, force: "10*t"}]
"""


@pytest.mark.slow
def test_a_block_that_rests_on_two_corners_breaks_away_as_one():
    """It holds to μ m g of both corners, whatever share each has."""
    data = linkages.simulate(
        linkages.loads(PUSHED), end=0.4, samples=401, outputs="all", rtol=1e-11
    ).data
    weight, time = 0.5 * 9.81, data.time.to_numpy()
    away = 0.2 * weight / 10
    since = np.clip(time - away, 0.0, None)
    # m x″ = 10 (t − t₀), a parabola that steps do not err on
    np.testing.assert_allclose(data.slider_position[:, 0], 10 * since**3 / 3, atol=1e-12)
    force, friction = data.clearance_force[:, 2:], data.clearance_friction[:, 2:]
    np.testing.assert_allclose(force.sum("clearance"), weight, rtol=1e-9)
    np.testing.assert_allclose(
        friction.sum("clearance"), -np.minimum(10 * time, 0.2 * weight), atol=1e-9
    )
    # friction at the bottom of a block of 40 mm tips it: moments about its middle
    tipped = 0.05 * (force[:, 1] - force[:, 0])
    np.testing.assert_allclose(tipped, -0.02 * friction.sum("clearance"), atol=1e-9)
    assert float((abs(friction) - 0.2 * force).max()) < 1e-9


DRAWER = """
joints: {O: [0, 0]}
sliders:
  drawer: {joint: B, through: O, mass: 0.5, inertia: 1e-3}
  handle: {joint: H, on: drawer, angle: 90 deg, mass: 0.001}
clearances:
  gap: {slider: drawer, size: 1 mm, length: 100 mm, height: 40 mm, contact: restitution,
        restitution: 0.5, friction: 0.2, offset: 0 mm, angle: TILT}
free: {drawer: {position: 0, speed: 0}}
drives: {handle: {position: AWAY, speed: 0}}
loads: [{joint: H, force: ["10*t", 0]}]
"""
"""A force that pulls away from the middle presses two corners at opposite walls."""


@pytest.mark.slow
@pytest.mark.parametrize("away", [0.2, 0.3])
def test_a_drawer_holds_where_it_is_pulled_too_far_from_its_middle(away):
    """Both corners press with F d/L: it moves where 2 μ d/L < 1, by a share of every force."""
    _, tilt, _ = placed(0.04, "diagonal")
    text = DRAWER.replace("TILT", f"{-tilt!r} rad").replace("AWAY", f"{away}")
    data = linkages.simulate(linkages.loads(text), end=0.4, samples=41, outputs="all").data
    position, time = data.slider_position[:, 0].to_numpy(), data.time.to_numpy()
    if 2 * 0.2 * away / 0.1 > 1:
        assert np.abs(position).max() < 1e-12
        return
    turn = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    upper, handle = turn @ [-0.05, 0.02], turn @ [0.0, away]
    # along, and about the middle; both corners press alike: unknown force and acceleration
    matrix = [[2 * 0.2, 0.501], [-2 * upper[0], 0.001 * handle[1]]]
    force, pace = np.linalg.solve(matrix, [10.0, 10.0 * handle[1]])
    np.testing.assert_allclose(position, pace * time**3 / 6, atol=1e-11)
    np.testing.assert_allclose(data.clearance_force[:, 0], force * time, atol=1e-9)


ENGINE = turning_engine("""\
clearances:
  CLEARANCES
drives: {crank: {angle: 0.3, speed: 600 rpm}}
""")
LAW = "contact: restitution, restitution: 0.5"
PINS = f"""one: {{joint: A, bar: rod, size: 0.1 mm, {LAW}, pin_radius: 10 mm, friction: MU}}
  two: {{joint: B, bar: rod, size: 0.1 mm, {LAW}, pin_radius: 8 mm, friction: MU}}"""
GUIDE = f"play: {{slider: piston, size: 0.1 mm, length: 50 mm, height: 30 mm, {LAW}, friction: MU}}"
BOTH = GUIDE + "\n  " + PINS.splitlines()[0]


def engine(clearances, friction):
    return ENGINE.replace("CLEARANCES", clearances).replace("MU", str(friction))


@pytest.mark.slow_except("pins")
@pytest.mark.parametrize(
    ("clearances", "slips"),
    [(PINS, True), (GUIDE, True), (BOTH, False)],
    ids=["pins", "guide", "both"],
)
def test_energy_and_forces_of_an_engine(clearances, slips):
    mechanism = linkages.loads(engine(clearances, 0.2))
    solution = linkages.simulate(mechanism, end=0.1, samples=501, outputs="all")
    data, changes = solution.data, solution.motion.changes
    assert sum(changes[k].rises.sum() for k in changes if k.endswith("touch")) > 10
    assert any(changes[k].count for k in changes if k.endswith("slip")) == slips
    energy = float(abs(data.kinetic_energy + data.potential_energy).max())
    # a few thousand steps at 1e-10
    assert float(abs(data.energy_residual).max()) < 1e-9 * energy
    assert (np.diff(data.impact_loss.sum("contact")) >= -1e-12 * energy).all()
    force = data.clearance_force
    assert float(force.min()) > -1e-9 * float(force.max())
    off = abs(data.clearance_friction) - 0.2 * force
    assert float(off.max()) < 1e-9 * float(force.max())
    assert float(data.clearance_indentation.max()) < 1e-7 * 1e-4


@pytest.mark.slow
def test_little_friction_is_none():
    """The limit μ → 0 is of first order in μ, by impacts by turns and at one time."""
    data = [
        linkages.simulate(linkages.loads(engine(PINS, friction)), end=0.02, samples=41).data
        for friction in (0, 1e-9)
    ]
    np.testing.assert_allclose(data[0].joint_position, data[1].joint_position, rtol=0, atol=1e-10)


@pytest.mark.slow
def test_a_mirrored_engine_moves_as_in_a_mirror():
    """Corners carry in an order, which is another one at the other wall."""
    one = linkages.loads(engine(GUIDE, 0.1))
    other = one.with_values({
        "gravity": [0, 9.81], "drives.crank.angle": -0.3, "drives.crank.speed": -20 * np.pi,
    })  # fmt: skip
    first, second = (
        linkages.simulate(m, end=0.03, samples=31, outputs="all", rtol=1e-11).data
        for m in (one, other)
    )
    np.testing.assert_allclose(first.tilt_angle, -second.tilt_angle, atol=1e-10)
    np.testing.assert_allclose(
        first.clearance_force[:, [2, 3, 0, 1]], second.clearance_force, atol=1e-4
    )


@pytest.mark.slow
@pytest.mark.parametrize("clearances", [PINS, GUIDE], ids=["pins", "guide"])
def test_motions_side_by_side_are_those_alone(clearances):
    """Shared impacts, slips that change and hold: each lane waits for its own."""
    path = f"clearances.{clearances.split(':')[0]}.friction"
    varying = Varying(linkages.loads(engine(clearances, 0.2)))
    along = varying.along([{path: friction} for friction in (0.05, 0.1, 0.2, 0.3)])
    marches = [
        [March(along.system(k), RunOptions(rtol=1e-9)) for k in range(len(along))] for _ in range(2)
    ]
    times = np.linspace(0.0, 0.03, 11)
    for found, march in zip(march_many(marches[0], times), marches[1], strict=True):
        alone = march.advance(times)
        assert isinstance(found, Motion)
        assert found.cost == alone.cost
        for one, other in zip(found.pieces, alone.pieces, strict=True):
            assert np.array_equal(one.state, other.state)


PAIR = """
gravity: [0, -9.81]
joints: {O: [0, 0], Q: [1, 0]}
bars:
  left: {joints: [O, L], length: 0.1, mass: 0.5, center: 0.05, inertia: 4e-4}
  right: {joints: [Q, R], length: 0.1, mass: 0.3, center: 0.04, inertia: 3e-4}
free: {left: {angle: -1.2, speed: 1}, right: {angle: -2, speed: -2}}
clearances:
  one: {joint: O, bar: left, size: 1 mm, contact: restitution, restitution: 0.5, pin_radius: 9 mm,
        friction: 0.2, offset: [2e-4, -3e-4], rate: [0.02, 0.05]}
  two: {joint: Q, bar: right, size: 1 mm, contact: restitution, restitution: 0.3, pin_radius: 9 mm,
        friction: 0.4, offset: [0, -3e-4]}
"""


@pytest.mark.slow
def test_pins_that_do_not_meet_do_not_matter():
    """The path of impulses holds for each: no other contact takes part."""
    both = linkages.simulate(linkages.loads(PAIR), end=0.5, samples=51, rtol=1e-12)
    for own, other, pin, gone in (("left", "right", "one", "two"), ("right", "left", "two", "one")):
        text = re.sub(rf"  {other}: .*\n|  {gone}: .*\n.*\n", "", PAIR)
        text = re.sub(rf"(, )?{other}: {{angle[^}}]*}}(, )?", "", text)
        definition = linkages.loads(text)
        alone = linkages.simulate(definition, end=0.5, samples=51, rtol=1e-12)
        angles = (both.data.bar_angle.sel(bar=own), alone.data.bar_angle.sel(bar=own))
        np.testing.assert_allclose(*angles, atol=1e-9)
        assert both.motion.changes[f"{pin}: touch"].count > 2
        assert both.motion.changes[f"{pin}: slip"].count > 0


@pytest.mark.slow
@pytest.mark.parametrize("end", [0.02, 0.3], ids=["impacts", "rolling"])
def test_tangents_of_two_pins(end):
    check(PAIR, end, 1e-3)


CRANK = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 153 mm, mass: 0.038, inertia: 7.4e-5}
  rod: {joints: [A, B], length: 306 mm, mass: 0.038, inertia: 5.9e-4}
sliders: {slider: {joint: B, through: O, mass: 0.076, inertia: 1.9e-4}}
clearances:
  play: {slider: slider, size: 1 mm, length: 100 mm, height: 50 mm, friction: 0.1,
         restitution: 0.4, angle: 0.5 deg, LAW}
free: {crank: {angle: 0, speed: 150 rad/s}}
assembly: {B: [0.459, 0]}
"""
"""The published crank with a block that lands on one corner after the other."""


def offsets(law):
    mechanism = linkages.loads(CRANK.replace("LAW", law))
    outputs = ["offset_position", "energy_residual", "kinetic_energy"]
    times = np.linspace(0.0, 0.02, 101)
    data = linkages.simulate(mechanism, times=times, rtol=1e-11, outputs=outputs).data
    assert float(abs(data.energy_residual).max()) < 1e-9 * float(data.kinetic_energy[0])
    return data.offset_position


@pytest.mark.slow
def test_stiff_corners_that_rub_tend_to_rigid_ones():
    """Like K^-0.4, for impacts last so long; the block slips at 10 m/s, so smooth friction is full.

    Fifteen impacts, and following the upper wall on both corners.
    """
    rigid = offsets("contact: restitution")
    stiff, stiffer = (
        float(abs(offsets(f"contact: exact, stiffness: {k}, slip: 10 mm/s") - rigid).max())
        for k in (1e11, 1e13)
    )
    assert stiff / stiffer == pytest.approx(100**0.4, rel=0.06)
    assert stiff < 2e-5


THROWN = """
joints: {{O: [0, 0]}}
sliders: {{block: {{joint: B, through: O, mass: 0.5, inertia: 2e-4}}}}
clearances:
  gap: {{slider: block, size: 1 mm, length: 100 mm, height: 20 mm, contact: restitution,
        restitution: {restitution}, friction: {friction}, impact: moreau, rate: -0.3, speed: 3,
        angle: 0.3 deg}}
free: {{block: {{position: 0, speed: 0.5}}}}
simulate: {{end: 0.02, samples: 2001}}
"""


@pytest.mark.slow_except("1.0-0.0")
@pytest.mark.parametrize(("restitution", "friction"), [(1.0, 0.5), (0.5, 0.3), (1.0, 0.0)])
def test_impacts_that_bounce_less_lest_energy_grow_are_counted(restitution, friction):
    """They are those that lose nothing, though there is friction."""
    text = THROWN.format(restitution=restitution, friction=friction)
    solution = linkages.simulate(linkages.loads(text), outputs=["impact_loss", "touches"])
    totals = (solution.data[name].to_numpy().sum(axis=1) for name in ("touches", "impact_loss"))
    touches, loss = totals
    lost = np.diff(loss)[np.diff(touches) > 0]
    kept = int((np.abs(lost) < 1e-12).sum()) if friction else 0
    counted = [int(n.split()[0]) for n in solution.notes if "with all of it energy would" in n]
    assert counted == ([kept] if kept else [])
    assert (kept > 0) == (restitution == 1.0 and friction > 0)
