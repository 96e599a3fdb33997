"""Motions whose modes change: closed forms, invariance, tangents, and what cannot go on."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from switched_blocks import (
    belted,
    block,
    bounced,
    choosing,
    damped_floor,
    floor,
    forces_by_nodes,
    impacts,
    named,
    remembering_floor,
    rubbed,
    rubbing,
    sticking,
    stopped,
)

import linkages
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.change_points import exchanged_tangents
from linkages.solution.march import March

ADAPTIVE = ("tsit5", "dop853", "vern9", "radau")
TIMES = np.linspace(0.0, 3.0, 301)


@pytest.fixture(autouse=True)
def _forces():
    with forces_by_nodes():
        yield


def positions(mechanism, times=TIMES, **options):
    return linkages.simulate(mechanism, times=times, **options).data.slider_position.to_numpy()[
        :, 0
    ]


@pytest.mark.parametrize("method", ADAPTIVE)
def test_ball_on_a_spring(method):
    found = positions(block(floor, 1.0, 0.0), method=method, rtol=1e-11)
    # a thousand times the tolerance: speeds of 4.4 m/s, and 14 changes in a row
    assert found == pytest.approx(bounced(TIMES, 1.0), abs=1e-8)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_friction_of_constant_magnitude(method):
    found = positions(block(rubbing, 0.1, 0.0), method=method, rtol=1e-11)
    assert found == pytest.approx(rubbed(TIMES, 0.1), abs=1e-10)


def test_order_of_a_fixed_step_survives():
    """Steps that straddle a jump of the force would leave order one."""
    mechanism = block(rubbing, 0.1, 0.0)
    steps = np.array([0.02, 0.01, 0.005])
    errors = [
        np.abs(
            positions(mechanism, TIMES[:201], method="rk4", step=h) - rubbed(TIMES[:201], 0.1)
        ).max()
        for h in steps
    ]
    slope, _ = np.polyfit(np.log(steps), np.log(errors), 1)
    assert slope == pytest.approx(4.0, abs=0.15)


def test_error_falls_with_the_tolerance():
    mechanism = block(floor, 1.0, 0.0)
    errors = [
        np.abs(positions(mechanism, rtol=rtol) - bounced(TIMES, 1.0)).max()
        for rtol in (1e-6, 1e-8, 1e-10)
    ]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def march(mechanism, times, tangents=0, tangent_atol=1e-6, **options):
    run = RunOptions(**{"rtol": 1e-11, **options})
    found = March(System(mechanism), run, tangents=tangents, tangent_atol=tangent_atol)
    return found, found.advance(np.asarray(times))


def test_times_of_impacts():
    """Falls shorten geometrically: t_k = t_1 (1 + 2 e (1 - e^(k-1))/(1 - e))."""
    _, motion = march(block(impacts, 1.0, 0.0), [3.5])
    found = motion.changes["floor: impact"]
    k, e = np.arange(len(found.time)), 0.8
    expected = math.sqrt(2 / 9.81) * (1 + 2 * e * (1 - e**k) / (1 - e))
    assert len(k) == 9
    assert found.time == pytest.approx(expected, abs=1e-10)
    assert found.rises.all()
    assert found.count == len(k)
    # located to round-off: the floor is where it is
    assert np.abs(np.concatenate([p.state[0] for p in found.pieces])).max() < 1e-14


def test_impacts_without_end_are_named():
    end = math.sqrt(2 / 9.81) * (1 + 2 * 0.8 / 0.2)
    _, motion = march(block(impacts, 1.0, 0.0), [end + 1.0])
    assert "floor: impact: A mode changes again and again" in motion.failure
    # where they accumulate: flights that last no longer than round-off of time
    assert motion.stop_time == pytest.approx(end, abs=1e-9)


def test_sliding_is_named():
    # the spring of 100 N/m pulls with less than the friction of 0.5 N within 5 mm
    _, motion = march(block(choosing, 0.023, 0.0), [3.0])
    assert "block: sign(speed): A mode has no value" in motion.failure
    assert motion.stop_time == pytest.approx(2 * math.pi / 10, abs=1e-10)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_block_comes_to_rest_and_stays(method):
    """Amplitudes fall by 10 mm each half of a swing; within 5 mm the spring is too weak."""
    found = linkages.simulate(
        block(sticking, 0.0972, 0.0, "0 N"), times=TIMES * 2, method=method, rtol=1e-11,
        outputs=["slider_position", "slider_velocity", "slider_acceleration", "load_force"],
    )  # fmt: skip
    data = {name: array.to_numpy()[:, 0] for name, array in found.data.data_vars.items()}
    moving = np.pi > 2 * TIMES
    assert data["slider_position"][moving] == pytest.approx(
        rubbed(2 * TIMES[moving], 0.0972), abs=1e-10
    )
    assert data["slider_position"][~moving] == pytest.approx(0.0972 - 10 * 0.01, abs=1e-10)
    assert np.abs(data["slider_velocity"][~moving]).max() < 1e-15
    assert np.abs(data["slider_acceleration"][~moving]).max() < 1e-14
    # friction is what the spring asks for
    assert np.abs(data["load_force"][~moving]).max() < 1e-14


def test_rest_ends_where_friction_no_longer_holds():
    """A force that grows by 1 N/s moves a block at rest when it reaches the friction of 0.5 N."""
    _, motion = march(block(sticking, 0.0, 0.0, "t"), np.linspace(0.0, 1.0, 11)[1:])
    found = motion.changes["block: sign(speed)"]
    assert found.time == pytest.approx([0.5], abs=1e-12)
    t = motion.time - 0.5
    expected = np.where(t > 0, (t - np.sin(10 * t) / 10) / 100, 0.0)
    assert motion.state[0] == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize("method", ADAPTIVE)
@pytest.mark.parametrize("rtol", [1e-6, 1e-11])
def test_no_release_is_missed(method, rtol):
    """Nothing moves at rest, so that steps would be long; a force beyond friction is short."""
    mechanism = block(sticking, 0.0, 0.0, "0.501*sin(7*t)")
    _, motion = march(mechanism, [1.0], method=method, rtol=rtol)
    times = motion.changes["block: sign(speed)"].time
    assert len(times) == 4
    assert times[0] == pytest.approx(math.asin(0.5 / 0.501) / 7, abs=1e-12)


def belt_by_hand(end):
    """Stick and slip on the belt by SciPy, each with its own equations and events."""

    def sliding(_t, y):
        return [y[1], 2.0 + 3.0 * np.exp(-(0.2 - y[1]) / 0.1) - 100 * y[0]]

    def meets(_t, y):
        return 0.2 - y[1] + 1e-13

    meets.terminal, meets.direction = True, -1
    t, y = 0.0, np.array([0.0, 0.0])
    while True:
        found = solve_ivp(
            sliding, (t, end), y, events=meets, rtol=1e-12, atol=1e-14, method="DOP853"
        )
        t, y = found.t[-1], found.y[:, -1]
        if t == end:
            return y
        length = (0.05 - y[0]) / 0.2  # sticks until the spring pulls with 5 N
        if t + length > end:
            return np.array([y[0] + 0.2 * (end - t), 0.2])
        t, y = t + length, np.array([0.05, 0.2 - 1e-13])


def test_stick_and_slip_on_a_belt():
    _, motion = march(block(belted, 0.0, 0.0), [4.0])
    assert motion.changes["block: sign(slip)"].count > 6
    assert motion.state[:, -1] == pytest.approx(belt_by_hand(4.0), abs=1e-7)


def test_tangents_lose_a_direction_in_sticking():
    """While a block is held its speed is no freedom: neighbours are where they came to rest."""
    rhs = linkages.compile(block(sticking, 0.0972, 0.0, "0 N"))
    flow = rhs.flow(tangents=2, rtol=1e-12)
    own, aside = flow.advance(rhs.state, 0.0, 4.0), np.array([1e-6, 0.0])
    ends = [flow.advance(rhs.state + s * aside, 0.0, 4.0).y for s in (1, -1)]
    assert own.tangents[:, 0] == pytest.approx((ends[0] - ends[1]) / 2e-6, abs=1e-7)
    assert np.abs(own.tangents[1]).max() < 1e-12


def test_samples_change_nothing():
    mechanism = block(remembering_floor, 1.0, 0.0)
    end = [march(mechanism, times)[0].state for times in ([3.0], TIMES[1:], [0.45, 0.4517, 3.0])]
    assert end[0].tobytes() == end[1].tobytes() == end[2].tobytes()


def test_outputs_take_the_modes_of_their_samples():
    data = linkages.simulate(
        block(remembering_floor, 1.0, 0.0),
        times=np.linspace(0.0, 3.0, 3001),
        outputs=["slider_position", "slider_acceleration", "load_force"],
        rtol=1e-11,
    ).data
    touching = data.slider_position.to_numpy()[:, 0] < 0.0
    assert 20 < touching.sum() < 2000
    force = data.load_force.to_numpy()[:, 0]
    assert force[~touching] == pytest.approx(-9.81)
    assert (force[touching] >= -9.81 - 1e-9).all()
    # of a block of 1 kg, and by another road: the kernel's acceleration
    assert data.slider_acceleration.to_numpy()[:, 0] == pytest.approx(force, abs=1e-6)


@pytest.mark.parametrize("law", [floor, damped_floor, remembering_floor, impacts])
def test_halves_equal_the_whole(law):
    mechanism = block(law, 1.0, 0.3)
    whole, _ = march(mechanism, [1.9])
    half, _ = march(mechanism, [0.4713])
    half.advance(np.array([1.9]))
    assert half.state == pytest.approx(whole.state, abs=1e-8)
    for name, values in whole.held.items():
        assert half.held[name] == pytest.approx(values, abs=1e-8)


@pytest.mark.parametrize("law", [floor, damped_floor, remembering_floor, impacts, rubbing])
@pytest.mark.parametrize("method", ["dop853", "vern9", "radau"])
def test_tangents_cross_changes(law, method):
    """Against differences of the motion itself."""
    start = (0.1, 0.03) if law is rubbing else (1.0, 0.3)
    rhs = linkages.compile(block(law, *start))
    flow = rhs.flow(tangents=2, rtol=1e-12, method=method)
    own, size = flow.advance(rhs.state, 0.0, 1.4), len(rhs.state)
    found = np.empty((size, size))
    for column in range(size):
        aside = 1e-6 * np.eye(size)[column]
        ends = [flow.advance(rhs.state + s * aside, 0.0, 1.4).y for s in (1, -1)]
        found[:, column] = (ends[0] - ends[1]) / 2e-6
    scale = np.abs(found).max()
    assert scale > 1.5 or law is rubbing
    # differences of 1e-6 have errors of 1e-12/1e-6 by tolerance, and square ones of bends
    assert np.abs(own.tangents - found).max() < 1e-6 * scale


def test_tangents_of_an_impact():
    """For speed v of approach the saltation matrix is [[-e, 0], [(1 + e) g/v, -e]]."""
    g, e, height = 9.81, 0.8, 1.0
    fall = math.sqrt(2 * height / g)
    found, _ = march(block(impacts, height, 0.0), [1.5 * fall], tangents=2)
    across = np.array([[-e, 0.0], [(1 + e) / fall, -e]])
    expected = [[1.0, 0.5 * fall], [0.0, 1.0]] @ across @ [[1.0, fall], [0.0, 1.0]]
    assert found.tangents == pytest.approx(expected, abs=1e-9)


def test_memory_is_a_part_of_tangents():
    """Halves with what is remembered, and its tangents, equal the whole."""
    rhs = linkages.compile(block(remembering_floor, 1.0, 0.3))
    flow = rhs.flow(tangents=2, rtol=1e-12)
    whole = flow.advance(rhs.state, 0.0, 1.4)
    touch = flow.advance(rhs.state, 0.0, 0.487)
    assert touch.y[0] < 0.0
    half = flow.advance(touch.y, 0.487, 1.4, touch.tangents, touch.held)
    assert half.y == pytest.approx(whole.y, abs=1e-9)
    assert half.tangents == pytest.approx(whole.tangents, abs=1e-7)
    # and without it there is another motion
    assert np.abs(flow.advance(touch.y, 0.487, 1.4).y - whole.y).max() > 1e-3


def test_backward_in_time():
    mechanism = block(floor, 1.0, 0.3)
    forth, _ = march(mechanism, [2.0], rtol=1e-12)
    forth.advance(np.array([0.0]))
    assert forth.state == pytest.approx(System(mechanism).state, abs=1e-8)


def test_no_way_back_from_what_is_remembered():
    with pytest.raises(ComputationError, match="'floor: touch' remembers or jumps"):
        march(block(remembering_floor, 1.0, 0.3), [-1.0])


@pytest.mark.parametrize("method", ["rk4", "gauss8", "radau"])
def test_impacts_between_equal_steps(method):
    """A fall is a polynomial that each method integrates exactly, in pieces between impacts."""
    _, motion = march(block(impacts, 1.0, 0.0), [3.5], method=method, step=0.05)
    k, e = np.arange(9), 0.8
    expected = math.sqrt(2 / 9.81) * (1 + 2 * e * (1 - e**k) / (1 - e))
    assert motion.changes["floor: impact"].time == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("method", "step"), [("gauss8", 0.02), ("radau", 2e-3)])
def test_tangents_of_implicit_steps_cross_impacts(method, step):
    start, times = block(impacts, 1.0, 0.0), [1.4]
    expected, _ = march(start, times, tangents=2, rtol=1e-13)
    found, _ = march(start, times, tangents=2, method=method, step=step)
    assert found.tangents == pytest.approx(expected.tangents, abs=1e-10)


def test_right_hand_side_takes_modes():
    rhs = linkages.compile(block(rubbing, 0.1, 0.2))
    assert rhs(0.0, rhs.state)[1] == pytest.approx(-10.5)
    assert rhs(0.0, rhs.state, {"mode block: sign(speed)": -1.0})[1] == pytest.approx(-9.5)
    assert rhs.held(0.0, -rhs.state) == {"mode block: sign(speed)": -1.0}
    both = rhs.batch(0.0, np.column_stack([rhs.state, -rhs.state]))
    assert both[1] == pytest.approx([-10.5, 10.5])


CRANK = """gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  {crank}: {{joints: [O, A], length: 0.04, mass: 0.8, center: 0.01, inertia: 6e-4}}
  rod: {{joints: [A, B], length: 0.14, mass: 0.5}}
sliders: {{piston: {{joint: B, through: O, mass: 0.4}}}}
assembly: {{A: [0.02, 0.034], B: [0.156, 0]}}
loads: [{{slider: piston, force: 1 N}}]
free: {free}
"""


@pytest.fixture(scope="module")
def cranks():
    """A piston with friction and a stop that remembers, at equal states said in two ways."""
    angle, speed, r, rod = math.pi / 3, 40.0, 0.04, 0.14
    along = math.sqrt(rod**2 - (r * math.sin(angle)) ** 2)
    position = r * math.cos(angle) + along
    rate = -r * math.sin(angle) * (1 + r * math.cos(angle) / along) * speed
    return [
        linkages.loads(CRANK.format(crank=named(stopped, "crank"), free=free))
        for free in (
            f"{{{named(stopped, 'crank')}: {{angle: {angle!r}, speed: {speed!r}}}}}",
            f"{{piston: {{position: {position!r}, speed: {rate!r}}}}}",
        )
    ]


def test_modes_outlive_an_exchange_of_coordinates(cranks):
    names = ["bar_angle", "slider_position", "joint_reaction", "load_force", "energy_residual"]
    one, other = (
        linkages.simulate(c, end=1.0, samples=101, rtol=1e-11, outputs=names) for c in cranks
    )
    assert "piston was exchanged for crank" in other.notes[0]
    for name, scale in zip(names, (25.0, 0.2, 130.0, 100.0, 1.0), strict=True):
        difference = np.abs(one.data[name].to_numpy() - other.data[name].to_numpy()).max()
        assert difference < 1e-8 * scale, name
    # work of friction and stop is integrated along: energy is what is left of it
    assert np.abs(one.data.energy_residual.to_numpy()).max() < 1e-9
    for name, found in one.motion.changes.items():
        assert found.count == 8
        assert other.motion.changes[name].time == pytest.approx(found.time, abs=1e-9)


@pytest.mark.slow
def test_tangents_outlive_an_exchange_of_coordinates(cranks):
    one, other = (march(c, [0.2], tangents=2, tangent_atol=1e-10)[0] for c in cranks)
    start = March(System(cranks[1]), RunOptions()).sample
    unit = np.eye(start.system.layout.directions)
    into = exchanged_tangents(start, one.layout.free, unit)
    assert other.layout.free == one.layout.free
    assert other.tangents == pytest.approx(one.tangents @ into, abs=1e-7)


LOADER = """
gravity: [0, -9.81]
joints: {O: [0, 0], H: [0.35, -0.35]}
bars:
  boom: {points: {O: [0, 0], M: [0.8, 0.15], A: [1.6, 0]}, mass: 120, center: [0.8, 0.05],
    inertia: 30}
  bucket: {points: {A: [0, 0], T: [0.6, 0]}, mass: 60, center: [0.3, -0.1], inertia: 4}
free: {boom: {angle: 10 deg, speed: 0}, bucket: {angle: -20 deg, speed: 0}}
cylinders:
  lift: {between: [H, M], bore: 60 mm, rod: 35 mm, pressure: "12e5*(1 - exp(-3*t))", damping: 9e3}
stops:
  - {bars: [boom, bucket], lower: -60 deg, upper: 30 deg, stiffness: 2e5, damping: 300}
  - {between: [H, M], lower: 0.6, upper: 1.1, stiffness: 5e6, damping: 5e4}
friction: [{joint: A, torque: 40}]
loads: [{joint: T, on: bucket, force: [-100, 0]}]
"""


def test_two_modes_that_change_at_the_start_of_one_step_follow_each_other():
    """A taut stop and a bucket that comes to rest: each came before the other, without end."""
    ends = {}
    for method in ("dop853", "vern9", "tsit5"):
        solution = linkages.simulate(
            linkages.loads(LOADER), end=2.0, samples=201, method=method, rtol=1e-9,
            outputs=["bar_angle", "bar_speed"],
        )  # fmt: skip
        assert solution.completed
        ends[method] = solution.data.bar_angle.isel(time=-1).to_numpy()
        assert sum(found.count for found in solution.motion.changes.values()) > 10
    for end in ends.values():
        assert end == pytest.approx(ends["dop853"], abs=1e-6)
