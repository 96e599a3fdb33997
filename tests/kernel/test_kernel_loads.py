"""Forces, torques, springs and dampers: generalised forces, power and stored energy."""

import numpy as np
import pytest
from kernel_motion import carried_along, difference
from linkage_models import system_of, values

FOUR_BAR = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  coupler: {points: {A: [0, 0], B: [0.9, 0], E: [0.4, 0.3]}, mass: 1, center: [0.4, 0.1],
    inertia: 0.1}
  rocker: {joints: [C, B], length: 0.7, mass: 1}
LOADS
free: {crank: {angle: ANGLE, speed: SPEED}}
assembly: {B: left}
"""
QUICK_RETURN = """
joints: {O: [0, 0], P: [0, 0.1]}
bars:
  crank: {joints: [P, A], length: 0.05, mass: 1}
  arm: {joints: [O, B], length: 0.25, mass: 2}
sliders: {block: {joint: A, on: arm, through: O}}
LOADS
free: {crank: {angle: ANGLE, speed: SPEED}}
"""
SPRINGS = {
    "between joints": "springs: [{between: [O, E], stiffness: 30, length: 0.2}]",
    "relaxed at zero length": "springs: [{between: [C, A], stiffness: 30, length: 0}]",
    "torsional": "springs: [{bar: rocker, stiffness: 5, angle: 0.3}]",
    "between bars": "springs: [{between_bars: [coupler, rocker], stiffness: 5, angle: 0.3}]",
    "two": "springs: [{bar: crank, stiffness: 5, angle: 0.3}, "
    "{between: [A, C], stiffness: 30, length: 0.4}]",
}


def at(loads, angle=0.8, speed=0.0, text=FOUR_BAR):
    numbers = text.replace("ANGLE", repr(angle)).replace("SPEED", repr(speed))
    return system_of(numbers.replace("LOADS", loads))


def generalised_force(of):
    """Σ power of all loads at the partial velocities of the free coordinate."""
    (partial,) = of.model.partials
    total = of.model.graph.total(load.power(partial) for load in of.model.loads)
    return of.evaluate([total])[0, 0]


@pytest.mark.parametrize("kind", SPRINGS)
@pytest.mark.parametrize("angle", [0.8, 2.5, -1.0])
def test_springs_pull_down_their_energy(kind, angle):
    """Q = −∂V/∂q, by differences of the potential energy."""
    of = at(SPRINGS[kind], angle)

    def potential(h):
        state = of.state.copy()
        state[0] += h
        return values(of, "potential_energy", 0.0, state[:, None])[0, 0]

    slope = difference(potential, 2e-3)
    assert potential(0.0) > 0
    assert generalised_force(of) == pytest.approx(-slope, abs=1e-10)  # energies of 1 J


@pytest.mark.parametrize("kind", SPRINGS)
def test_springs_have_no_power_of_their_own(kind):
    """What they store is in the potential energy: T + V stays, load_power is zero."""
    of = at(SPRINGS[kind], 0.8, 3.0)
    assert values(of, "load_power")[0, 0] == 0.0
    n = len(of.state) // 2
    accelerations = of.model.integrated_accelerations(of.model.changes)
    second = of.evaluate(accelerations)[:, 0]

    def energy(h):
        state = np.concatenate(
            [of.state[:n] + h * of.state[n:] + h * h / 2 * second, of.state[n:] + h * second]
        )
        names = ("kinetic_energy", "potential_energy")
        return sum(values(of, name, 0.0, state[:, None])[0, 0] for name in names)

    assert difference(energy, 1e-3) == pytest.approx(0.0, abs=1e-9)


DAMPERS = {
    "between joints": "dampers: [{between: [O, E], damping: 3}]",
    "beside a spring": "springs: [{between: [O, E], stiffness: 0, length: 0, damping: 3}]",
    "joint": "dampers: [{joint: B, damping: 2}]",
    "on the ground": "dampers: [{joint: C, damping: 2}]",
    "between bars": "dampers: [{joint: A, bars: [crank, coupler], damping: 2}]",
}


@pytest.mark.parametrize("kind", DAMPERS)
def test_dampers_take_power_in_squares(kind):
    """P = −c v²; the generalised force is P/q̇, and reverses with the motion."""
    forward, backward = (at(DAMPERS[kind], 0.8, speed) for speed in (3.0, -3.0))
    power = values(forward, "load_power")[0, 0]
    assert power < 0
    assert values(backward, "load_power")[0, 0] == pytest.approx(power, rel=1e-13)
    assert generalised_force(forward) == pytest.approx(power / 3, rel=1e-13)
    assert generalised_force(backward) == pytest.approx(-power / 3, rel=1e-13)
    assert values(at(DAMPERS[kind], 0.8, 6.0), "load_power")[0, 0] == pytest.approx(
        4 * power, rel=1e-13
    )
    assert values(at(DAMPERS[kind], 0.8, 0.0), "load_power")[0, 0] == 0.0


def test_rates_of_dampers():
    of = at(DAMPERS["between joints"], 0.8, 3.0)

    def distance(h):
        state = of.state.copy()
        state[0] += 3 * h
        joints = of.topology.joints
        places = values(of, "joint_position", 0.0, state[:, None]).reshape(len(joints), 2)
        return np.linalg.norm(places[joints.index("E")] - places[joints.index("O")])

    power = values(of, "load_power")[0, 0]
    assert power == pytest.approx(-3 * difference(distance, 1e-3) ** 2, rel=1e-10)
    speeds = values(at(DAMPERS["joint"], 0.8, 3.0), "bar_speed")[:, 0]
    power = values(at(DAMPERS["joint"], 0.8, 3.0), "load_power")[0, 0]
    assert power == pytest.approx(-2 * (speeds[1] - speeds[2]) ** 2, rel=1e-13)


LOADS = {
    "force at a joint": "loads: [{joint: E, force: [3, -4]}]",
    "torque": "loads: [{bar: rocker, torque: 2}]",
    "torque between bars": "loads: [{bars: [coupler, rocker], torque: 2}]",
}


@pytest.mark.parametrize("kind", LOADS)
def test_forces_do_work_on_what_they_act_on(kind):
    """Virtual work, by differences of places and angles."""
    of = at(LOADS[kind], 0.8, 2.0)
    joints = of.topology.joints

    def work(h):
        state = of.state.copy()
        state[0] += h
        x, y = values(of, "joint_position", 0.0, state[:, None]).reshape(-1, 2)[joints.index("E")]
        angles = values(of, "bar_angle", 0.0, state[:, None])[:, 0]
        if kind == "force at a joint":
            return 3 * x - 4 * y
        return 2 * (angles[2] - (angles[1] if kind == "torque between bars" else 0.0))

    expected = difference(work, 1e-3)
    assert generalised_force(of) == pytest.approx(expected, rel=1e-10)
    assert values(of, "load_power")[0, 0] == pytest.approx(2 * expected, rel=1e-10)


def test_loads_may_depend_on_time():
    of = at("loads: [{bar: crank, torque: '2*sin(3*t)'}, {joint: A, force: ['t', '1 - t']}]")
    (partial,) = of.model.partials
    total = of.model.graph.total(load.power(partial) for load in of.model.loads)
    for time in (0.0, 0.4, 1.1):
        a = 0.3 * np.array([-np.sin(0.8), np.cos(0.8)])
        expected = 2 * np.sin(3 * time) + a @ [time, 1 - time]
        assert of.evaluate([total], time)[0, 0] == pytest.approx(expected, abs=1e-15)


def test_a_force_along_a_moving_axis_acts_on_both_ends():
    """Power is force times the rate of sliding, whatever the guide does."""
    of = at("loads: [{slider: block, force: 7}]", 0.5, 2.0, QUICK_RETURN)
    rate = values(of, "slider_velocity")[0, 0]
    assert values(of, "load_power")[0, 0] == pytest.approx(7 * rate, rel=1e-14)
    assert generalised_force(of) == pytest.approx(7 * rate / 2, rel=1e-14)
    damped = at("dampers: [{slider: block, damping: 4}]", 0.5, 2.0, QUICK_RETURN)
    assert values(damped, "load_power")[0, 0] == pytest.approx(-4 * rate**2, rel=1e-14)


# --- whole turns --------------------------------------------------------------------------------

PENDULUM = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 3}}
springs: [{bar: rod, stiffness: 2, angle: RELAXED}]
free: {rod: {angle: ANGLE, speed: 0}}
"""


@pytest.mark.parametrize("turns", [0, 1, -3])
@pytest.mark.parametrize("relaxed", [0.0, 3.0, -9.0])
def test_a_torsional_spring_counts_the_whole_turns_of_an_angle_that_the_file_gives(turns, relaxed):
    """A free angle is what the file says: a spring may be wound up several turns at the start."""
    angle = 1.2 + 2 * np.pi * turns
    text = PENDULUM.replace("RELAXED", repr(relaxed)).replace("ANGLE", repr(angle))
    of = system_of(text)
    elongation = angle - relaxed
    assert values(of, "potential_energy")[0, 0] == pytest.approx(elongation**2, rel=1e-12)
    for moved in (0.0, 4.0, 20.0, -40.0):  # inertia 1, stiffness 2
        state = of.state + np.array([moved, 0.0])
        (found,) = of.evaluate(of.model.free_accelerations, state=state[:, None])[:, 0]
        assert found == pytest.approx(-2 * (elongation + moved), abs=1e-12)


def test_a_torsional_spring_on_a_bar_that_is_solved_for():
    """A drag link: the rocker starts within half a turn of relaxed and winds up turn by turn."""
    of = system_of("""
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 1.5}
  coupler: {joints: [A, B], length: 1.3}
  rocker: {joints: [C, B], length: 1.4}
springs: [{bar: rocker, stiffness: 2}, {between_bars: [crank, rocker], stiffness: 3}]
drives: {crank: {angle: 0.1, speed: 4}}
assembly: {B: left}
""")
    assert of.topology.carried == ("rocker",)
    times = np.linspace(0, 5, 101)
    states = carried_along(of, times)
    crank, _, rocker = values(of, "bar_angle", times, states)
    assert np.abs(np.diff(rocker)).max() < 1.0
    assert rocker[-1] - rocker[0] > 2 * np.pi * 2.5
    expected = rocker**2 + 1.5 * (rocker - crank) ** 2
    assert values(of, "potential_energy", times, states)[0] == pytest.approx(expected, rel=1e-12)


def test_a_spring_winds_up_in_gears():
    """The second wheel turns three times as far, and so winds its spring."""
    of = system_of("""
joints: {O: [0, 0], C: [1, 0]}
bars:
  first: {joints: [O, A], length: 1, mass: 3}
  second: {joints: [C, B], length: 1, mass: 3}
gears: [{bars: [first, second], ratio: -3}]
springs: [{bar: second, stiffness: 2}]
free: {first: {angle: 0.2, speed: 0}}
""")
    for angle in (0.2, 2.0, 15.0, -8.0):
        state = np.array([[angle], [0.0]])
        (found,) = of.evaluate(of.model.free_accelerations, state=state)[:, 0]
        # inertia 1 + 9, torque −2·(−3 q) on the second, −3 times that on the first
        assert found == pytest.approx(-2 * 9 * angle / 10, rel=1e-13)


# --- point masses -------------------------------------------------------------------------------


def test_point_masses_swing_like_bars_of_points():
    """m l² θ̈ = −m g l cos θ; the bar itself has none."""
    of = system_of("""
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 0.8}}
masses: {P: 2.5}
free: {rod: {angle: 0.7, speed: 2}}
""")
    (found,) = of.evaluate(of.model.free_accelerations)[:, 0]
    assert found == pytest.approx(-9.81 / 0.8 * np.cos(0.7), rel=1e-14)
    assert values(of, "kinetic_energy")[0, 0] == pytest.approx(0.5 * 2.5 * 1.6**2, rel=1e-14)


def test_a_point_mass_is_a_bar_with_its_mass_at_the_joint():
    masses = at("masses: {E: 2, A: 0.5}", 0.8, 2.0)
    bars = at("", 0.8, 2.0, FOUR_BAR.replace("LOADS", """  extra: {joints: [E, X], length: 1}
masses: {A: 0.5, E: 2}
drives: {extra: {angle: 0, speed: 0}}"""))  # fmt: skip
    systems = (masses, bars, at("", 0.8, 2.0))
    one, other, without = (s.evaluate(s.model.free_accelerations)[0, 0] for s in systems)
    assert one == pytest.approx(other, rel=1e-13)
    assert one != pytest.approx(without, rel=1e-3)
