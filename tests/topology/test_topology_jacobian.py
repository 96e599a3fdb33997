"""The closure Jacobian against the positions that the kernel solves for."""

import numpy as np
import pytest
from linkage_files import NAMES, linkage, mechanism

from linkages.components.contributed.terms import axis_label
from linkages.components.mechanisms.definition import loads
from linkages.kernel.system import System
from linkages.topology.assur_groups import Step
from linkages.topology.topology import (
    build_topology,
    closure_jacobian,
    ground_loop,
    numerical_mobility,
)


def signed(topology, loop):
    """A loop as {body: +1 or −1}, vectors counted from a body's first to its last joint."""
    signs = {}
    for sign, way in zip((1, -1), ground_loop(topology, loop), strict=True):
        for step in way:
            points = (*topology.mechanism.bodies[step.body].points,)
            own = axis_label(step.body)
            forward = step.start == own or (step.start, step.end) == points
            signs[step.body] = sign if forward else -sign
    return signs


def test_ground_loops_of_the_nine_bar_are_the_papers_equation_1():
    """Paper Eq. 1, r2 = 0: 1+2 = 5+4+r1+3, 1+2 = 6+7, 6+8 = 9, the frame 5 being the ground."""
    topology = build_topology(linkage("ninebar"))
    equations = [
        {"crank1": 1, "link2": 1, "crank4": -1, "r1": -1, "link3": -1},
        {"crank1": 1, "link2": 1, "rocker6": -1, "link7": -1},
        {"rocker6": 1, "link8": 1, "slider9": -1},
    ]
    for block, equation in zip(topology.solved_blocks, equations, strict=True):
        found = signed(topology, block.loops[0])
        assert found in (equation, {body: -sign for body, sign in equation.items()})


def test_ground_loops_do_not_walk_shared_steps():
    """Both ways to G of a Watt six-bar run over the same coupler: only what differs is left."""
    topology = build_topology(linkage("watt"))
    out, back = ground_loop(topology, topology.solved_blocks[1].loops[0])
    assert not set(out) & set(back)


def vector(step, places):
    return places[step.end] - places[step.start]


def places_at(system, time):
    """Places of all points at a time."""
    joints = system.model.positions.joints
    nodes = [node for place in joints.values() for node in (place.x, place.y)]
    return dict(zip(joints, system.evaluate(nodes, time).reshape(-1, 2), strict=True))


@pytest.mark.parametrize("name", NAMES)
def test_both_ways_lead_to_the_same_place(name):
    system = System(linkage(name))
    places = system.places()
    for block in system.topology.solved_blocks:
        ends = [
            places[way[0].start] + sum(vector(step, places) for step in way)
            for way in ground_loop(system.topology, block.loops[0])
        ]
        # a handful of additions of lengths around 1 m
        assert ends[0] == pytest.approx(ends[1], abs=1e-14)


def unit_lengths(system):
    """By how much `closure_jacobian` has divided each column: the lengths of a body's steps."""
    places = system.places()
    squares = dict.fromkeys(system.mechanism.bodies, 0.0)
    for block in system.topology.solved_blocks:
        for way in ground_loop(system.topology, block.loops[0]):
            for step in way:
                slides = axis_label(step.body) in (step.start, step.end)
                squares[step.body] += 1.0 if slides else np.sum(vector(step, places) ** 2)
    return np.sqrt([*squares.values()])


def coordinates(system, places):
    """Coordinates of all bodies, from places of joints alone."""
    values = []
    for body in system.mechanism.bodies.values():
        if body.guide is not None:
            (joint,) = body.points
            origin = np.array([p.value for p in body.guide.origin])
            values.append((places[joint] - origin) @ system.axes[body.name])
            continue
        first, second = [*body.points][:2]
        (ax, ay), (bx, by) = ([p.value for p in body.points[j]] for j in (first, second))
        x, y = places[second] - places[first]
        values.append(np.arctan2(y, x) - np.arctan2(by - ay, bx - ax))
    return np.array(values)


STEP = 1e-3
WEIGHTS = ((-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12))


def difference(system, places_at):
    """Fourth-order central difference of all coordinates; angles within half a turn."""
    here = coordinates(system, places_at(0.0))
    turned = [
        np.unwrap(np.stack([here, coordinates(system, places_at(k * STEP))]), axis=0)[1]
        for k, _ in WEIGHTS
    ]
    return sum(w * c for (_, w), c in zip(WEIGHTS, turned, strict=True)) / STEP


CASES = [
    (name, driven)
    for name in NAMES
    for driven in linkage(name).prescribed
    if name not in ("pendulum", "doublependulum")
]


@pytest.mark.parametrize(("name", "driven"), CASES)
def test_driven_columns_against_differences_of_the_positions(name, driven):
    """With Φ_z ż = −Φ_q, z_q is the derivative of the dependent coordinates: Φ times it is 0."""
    start = linkage(name)
    speeds = {f"drives.{other}.speed": float(other == driven) for other in start.prescribed}
    system = System(linkage(name, **speeds))
    derivative = difference(system, lambda time: places_at(system, time))
    scaled = system.jacobian * unit_lengths(system)
    order = [*system.mechanism.bodies]
    z = [order.index(body) for body in system.topology.dependent]
    q = order.index(driven)
    z_q = -np.linalg.solve(scaled[:, z], scaled[:, q])
    # differences: rounding 1e-16/1e-3 and truncation 1e-12 times a fifth derivative of order 1e2
    assert z_q == pytest.approx(derivative[z], abs=2e-10, rel=2e-10)
    others = [order.index(b) for b in (*system.topology.driven, *system.topology.free)]
    assert derivative[others] == pytest.approx([float(i == q) for i in others], abs=1e-11)


@pytest.mark.parametrize(
    ("name", "free", "number"),
    [
        ("clearance", "crank", "free.crank.angle"),
        ("clearance", "gap", "clearances.gap.angle"),
        ("ninebar", "r1", "clearances.r1.angle"),
    ],
)
def test_free_columns_against_differences_of_the_positions(name, free, number):
    system = System(linkage(name))
    angle = system.mechanism.initial[free].position
    derivative = difference(
        system, lambda shift: System(linkage(name, **{number: angle + shift})).places()
    )
    scaled = system.jacobian * unit_lengths(system)
    assert scaled @ derivative == pytest.approx(np.zeros(len(scaled)), abs=2e-10)  # as above
    # its own angle comes from places 1 m away and 0.15 mm apart: 1e-16/1.5e-4/STEP
    assert derivative[[*system.mechanism.bodies].index(free)] == pytest.approx(1, abs=2e-9)


@pytest.mark.parametrize("name", NAMES)
def test_rank_gives_grueblers_mobility(name):
    system = System(linkage(name))
    assert numerical_mobility(system.jacobian) == system.topology.mobility


def test_rank_shows_what_grueblers_formula_does_not():
    """A parallelogram in line: the Jacobian loses rank and the mobility rises by one."""
    text = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.5}
  coupler: {joints: [A, B], length: 1}
  rocker: {joints: [C, B], length: 0.5}
drives: {crank: {angle: 0, speed: 1}}
assembly: {B: [1.5, 0.1]}
"""
    topology = build_topology(mechanism(text))
    places = {"O": [0, 0], "C": [1, 0], "A": [0.5, 0], "B": [1.5, 0]}
    jacobian = closure_jacobian(topology, {j: np.array(p, float) for j, p in places.items()}, {})
    assert numerical_mobility(jacobian) == 2 == topology.mobility + 1


@pytest.mark.parametrize("name", NAMES)
def test_columns_have_unit_length_or_no_part_in_a_loop(name):
    system = System(linkage(name))
    norms = np.linalg.norm(system.jacobian, axis=0)
    looped = {
        step.body
        for block in system.topology.solved_blocks
        for way in ground_loop(system.topology, block.loops[0])
        for step in way
    }
    expected = [float(body in looped) for body in system.mechanism.bodies]
    assert norms == pytest.approx(expected, abs=4e-16)  # one rounding of a square root


def test_condition_of_a_dyad_is_that_of_the_angle_between_its_links():
    """Two unit vectors at the angle δ have the condition number √((1 + c)/(1 − c)), c = |cos δ|."""
    system = System(linkage("fourbar"))
    places = system.places()
    a, b = places["B"] - places["A"], places["C"] - places["B"]
    c = abs(a @ b) / np.linalg.norm(a) / np.linalg.norm(b)
    (found,) = system.conditions
    assert found == pytest.approx(np.sqrt((1 + c) / (1 - c)), rel=1e-13)  # 2×2 singular values


def test_a_pendulum_has_no_closure():
    system = System(linkage("doublependulum"))
    assert system.jacobian.shape == (0, 2)
    assert numerical_mobility(system.jacobian) == 2


def test_derivative_of_a_step_and_its_way_back():
    step = Step("link", "A", "B")
    assert step.reversed == Step("link", "B", "A")
    own = axis_label("piston")
    assert Step("piston", own, "B").reversed == Step("piston", "B", own)


def test_mobility_counts_singular_values_that_are_no_round_off():
    """Columns have unit length: 1e-6 is a bad condition, 1e-12 is what rounding leaves of 0."""
    for smallest, mobility in ((1e-3, 0), (1e-6, 0), (1e-8, 0), (1e-10, 1), (1e-15, 1), (0.0, 1)):
        assert numerical_mobility(np.diag([1.0, 0.5, smallest])) == mobility
    assert numerical_mobility(np.diag([1.0, 0.5, 1e-8])[:, [0, 1, 2, 2]]) == 1


def test_columns_of_huge_lengths_do_not_overflow():
    """A trammel of 1e300 m has the normalised Jacobian of one of 1 m; its squares overflow."""
    text = """
joints: {{O: [0, 0]}}
bars: {{link: {{points: {{X: [0, 0], Y: [{0}, 0]}}}}}}
sliders:
  across: {{joint: X, through: O, angle: 0, mass: 1}}
  upright: {{joint: Y, through: O, angle: 80 deg, mass: 1}}
drives: {{link: {{angle: 2, speed: 1}}}}
"""
    huge, small = (System(loads(text.format(size))) for size in ("1e300", "1"))
    np.testing.assert_allclose(huge.jacobian, small.jacobian, rtol=1e-12, atol=1e-15)
    with np.errstate(over="raise"):
        assert huge.mobility == small.mobility == 1
    np.testing.assert_allclose(huge.conditions, small.conditions, rtol=1e-12)
