"""States beside positions and rates: in Python, restarts, files, sections, exponents, exchanges."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid

import linkages
from linkages.chaos.continuation import end_of
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.march import March

PENDULUM = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, A], length: 1 m, mass: 1 kg}}
gravity: [0, -9.81]
free: {rod: {angle: 0.3, speed: 1}}
motors:
  m: {bar: rod, voltage: "6*sin(3*t)", torque_constant: 0.5, resistance: 0.4, inductance: 0.1,
      gear_ratio: 2, current: 1}
maxwell: [{bar: rod, stiffness: 5, damping: 2}]
"""
SWITCHING = (
    PENDULUM
    + """
friction: [{joint: O, torque: 1.5, bars: [ground, rod]}]
stops: [{bars: [ground, rod], upper: 20 deg, stiffness: 400, damping: 3}]
"""
)


def by_hand(t, y):
    """The equations of `PENDULUM`: uniform rod, J = ml²/3; L di/dt = U - k n ω - R i."""
    angle, speed, stretch, current = y
    weight = -0.5 * 9.81 * np.cos(angle)
    torque = 2 * 0.5 * current - 5 * stretch
    voltage = 6 * np.sin(3 * t) - 0.5 * 2 * speed - 0.4 * current
    return [speed, 3 * (weight + torque), speed - 5 * stretch / 2, voltage / 0.1]


def test_against_equations_by_hand():
    rhs = linkages.compile(linkages.loads(PENDULUM))
    assert rhs.names == ("rod.angle", "rod.speed", "maxwell[0].deflection", "motors.m.current")
    assert rhs.units == ("rad", "rad/s", "rad", "A")
    assert rhs.state.tolist() == [0.3, 1.0, 0.0, 1.0]
    states = np.random.default_rng(1).normal(size=(4, 5))
    for column, time in zip(states.T, (0.0, 0.1, 0.2, 0.5, 1.0), strict=True):
        assert rhs(time, column) == pytest.approx(by_hand(time, column), rel=1e-13)
    times = np.linspace(0, 1, 5)
    batch = rhs.batch(times, states)
    assert (
        pytest.approx(
            np.array([by_hand(*a) for a in zip(times, states.T, strict=False)]), rel=1e-13
        )
        == batch.T
    )
    own = solve_ivp(by_hand, (0, 3), rhs.state, rtol=1e-12, atol=1e-13, method="DOP853")
    given = solve_ivp(
        rhs, (0, 3), rhs.state, rtol=1e-9, atol=1e-9, method="Radau", jac=rhs.jacobian
    )
    assert given.y[:, -1] == pytest.approx(own.y[:, -1], abs=1e-7)
    end = rhs.flow(rtol=1e-12, atol=1e-12).advance(rhs.state, 0.0, 3.0)
    assert end.y == pytest.approx(own.y[:, -1], abs=1e-10)


def test_jacobian_and_outputs():
    rhs = linkages.compile(linkages.loads(PENDULUM))
    state, step = np.array([0.4, -0.7, 0.05, 1.2]), 1e-6
    columns = [
        (rhs(0.7, state + step * unit) - rhs(0.7, state - step * unit)) / (2 * step)
        for unit in np.eye(4)
    ]
    # second differences of functions of size 30: 1e-12·30 + 1e-16/1e-6
    assert rhs.jacobian(0.7, state) == pytest.approx(np.array(columns).T, abs=1e-7)
    found = rhs.outputs(["internal_state", "internal_state_rate", "load_torque"], 0.7, state)
    assert found.internal_state.to_numpy()[0] == pytest.approx([0.05, 1.2])
    assert found.internal_state_rate.to_numpy()[0] == pytest.approx(by_hand(0.7, state)[2:])
    assert found.load_torque.sel(torque="motors.m").item() == pytest.approx(2 * 0.5 * 1.2)


@pytest.mark.parametrize("text", [PENDULUM, SWITCHING], ids=["smooth", "stick and stop"])
def test_tangents_against_neighbours(text):
    rhs = linkages.compile(linkages.loads(text))
    flow = rhs.flow(tangents=4, rtol=1e-12, atol=1e-12)
    time, step = 1.2, 1e-6
    end = flow.advance(rhs.state, 0.0, time)
    for column, unit in enumerate(np.eye(4)):
        ahead, back = (flow.advance(rhs.state + s * unit, 0.0, time).y for s in (step, -step))
        # integration at 1e-12 over twice the step
        assert end.tangents[:, column] == pytest.approx((ahead - back) / (2 * step), abs=2e-5)


def test_restarts():
    mechanism = linkages.loads(SWITCHING)
    whole = linkages.simulate(mechanism, end=2.0, samples=201)
    middle = linkages.simulate(mechanism, end=1.0, samples=101)
    rhs = linkages.compile(mechanism)
    flow = rhs.flow(rtol=1e-10, atol=1e-10)
    one = flow.advance(rhs.state, 0.0, 1.0)
    two = flow.advance(one.y, 1.0, 2.0, held=one.held)
    last = whole.data.isel(time=-1)
    values = [last.bar_angle.item(), last.bar_speed.item(), *last.internal_state.to_numpy()]
    assert two.y == pytest.approx(values, abs=1e-8)
    data = middle.data.isel(time=-1)
    inner = dict(
        zip(data.internal.to_numpy(), data.internal_state.to_numpy().tolist(), strict=True)
    )
    state = {"rod": (data.bar_angle.item(), data.bar_speed.item()), **inner}
    times = np.linspace(1.0, 2.0, 101)
    again = linkages.simulate(mechanism, times=times, state=state)
    vector = linkages.simulate(mechanism, times=times, state=one.y)
    for other in (again, vector):
        found = other.data.isel(time=-1)
        assert found.internal_state.to_numpy() == pytest.approx(values[2:], abs=1e-8)
    with pytest.raises(ValueError, match=r"then maxwell\[0\]\.deflection, then motors\.m\.current"):
        linkages.simulate(mechanism, state=[0.0, 0.0])
    with pytest.raises(ValueError, match=r"did you mean 'motors\.m\.current'"):
        linkages.simulate(mechanism, state={"motors.m.curent": 1.0})


def test_files(tmp_path):
    solution = linkages.simulate(
        linkages.loads(PENDULUM), end=1.0, samples=11, state={"motors.m.current": 0.5}
    )
    assert solution.data.internal_state.attrs["units"] == "rad or A"
    solution.save(tmp_path)
    again = linkages.open(tmp_path).compute()
    assert np.array_equal(again.data.internal_state, solution.data.internal_state)


@pytest.mark.slow_except("dop853-200")
@pytest.mark.parametrize(("method", "periods"), [("dop853", 200), ("radau", 60)])
def test_exponents_of_a_linear_system(method, periods):
    """Small swings about the hanging rod: real parts of the eigenvalues, one for each state."""
    text = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, A], length: 1 m, mass: 1 kg}}
gravity: [0, -9.81]
free: {rod: {angle: -90.0001 deg}}
maxwell: [{bar: rod, stiffness: 5, damping: 2}]
"""
    options = {"periods": periods, "skip": 5, "interval": 0.5, "method": method, "rtol": 1e-8}
    data = linkages.lyapunov(linkages.loads(text), **options)
    matrix = np.array([[0, 1, 0], [-1.5 * 9.81, 0, -15], [0, 1, -2.5]])
    expected = sorted(np.linalg.eigvals(matrix).real, reverse=True)
    assert data.exponent.to_numpy() == pytest.approx(expected, abs=0.02)  # a pair turns: 1/(20 s)
    # the sum is the divergence at every time: d(ds/dt)/ds
    assert data.attrs["sum"] == pytest.approx(-2.5, abs=1e-6)


def test_sections_and_sweeps():
    mechanism = linkages.loads(PENDULUM)
    data = linkages.poincare(mechanism, periods=5, skip=20)
    assert data.internal_state.dims == ("crossing", "internal")
    at = data.time.to_numpy()
    direct = linkages.simulate(mechanism, times=at).data.internal_state.to_numpy()
    assert data.internal_state.to_numpy() == pytest.approx(direct, abs=1e-7)
    swept = linkages.bifurcation(mechanism, "motors.m.resistance=0.3:0.5:3", periods=3, skip=5)
    assert swept.internal_state.shape[-1] == 2
    # the last value goes on from the last point of the one before it
    system = System(mechanism.with_values({"motors.m.resistance": 0.4}))
    march = March(system, RunOptions())
    motion = march.advance(np.array([1.0, 2.0]))
    end = end_of(system, motion)
    other = end.system(mechanism.with_values({"motors.m.resistance": 0.5}))
    assert list(end.internal.values()) == pytest.approx(march.state[system.layout.internal_rows])
    assert other.state == pytest.approx(march.state, abs=1e-12)


CRANK = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.1, mass: 1}, rod: {joints: [A, B], length: 0.3, mass: 0.5}}
sliders: {piston: {joint: B, through: O, angle: 0, mass: 0.4}}
assembly: {A: left}
free: {piston: {position: 0.35, speed: -2}}
motors: {m: {bar: crank, voltage: 10, torque_constant: 0.2, resistance: 0.5, inductance: 0.02}}
maxwell: [{slider: piston, stiffness: 800, damping: 20}]
"""


@pytest.mark.slow
def test_where_free_coordinates_are_exchanged():
    """A slider cannot say where its crank is at dead centres; a crank can all the time."""
    one = linkages.simulate(linkages.loads(CRANK), end=1.0, samples=51)
    assert any("was exchanged" in note for note in one.notes)
    start = one.data.isel(time=0)
    text = CRANK.replace("assembly: {A: left}\n", "")
    free = (start.bar_angle.sel(bar="crank").item(), start.bar_speed.sel(bar="crank").item())
    state = f"crank: {{angle: {free[0]!r}, speed: {free[1]!r}}}"
    text = text.replace("piston: {position: 0.35, speed: -2}", state)
    other = linkages.simulate(linkages.loads(text), end=1.0, samples=51)
    for name, size in (("internal_state", 1e-7), ("slider_position", 1e-8)):
        assert one.data[name].to_numpy() == pytest.approx(other.data[name].to_numpy(), abs=size)
    flow = linkages.compile(linkages.loads(CRANK)).flow(tangents=4, rtol=1e-11, atol=1e-11)
    rhs = linkages.compile(linkages.loads(CRANK))
    end = flow.advance(rhs.state, 0.0, 0.2)
    step = 1e-7
    for column in (1, 2, 3):
        unit = np.eye(4)[column] * step
        ahead, back = (flow.advance(rhs.state + s * unit, 0.0, 0.2).y for s in (1, -1))
        slope = (ahead - back) / (2 * step)
        assert end.tangents[:, column] == pytest.approx(slope, rel=1e-4, abs=1e-3)


GROUP = """
free: {crank: {angle: 0.2, speed: 6}}
motors: {m: {bar: crank, voltage: 12, torque_constant: 0.3, resistance: 0.5, inductance: 0.05}}
maxwell: [{between: [C, G], stiffness: 1e3, damping: 5}]
"""


@pytest.mark.slow
def test_with_groups_that_iterate():
    """Coordinates carried along stand behind internal states in what is integrated."""
    plain = linkages.load("class-three").to_yaml().split("simulate:")[0]
    driven = plain[plain.index("drives:") : plain.index("assembly:")]
    mechanism = linkages.loads(plain.replace(driven, GROUP.lstrip()))
    rhs = linkages.compile(mechanism)
    assert rhs.names[-2:] == ("maxwell[0].deflection", "motors.m.current")
    assert len(rhs.state) == 2 * len(rhs.system.layout.bodies) + 2 > 4
    data = linkages.simulate(mechanism, end=0.5, samples=6, outputs=["energy_residual"])
    assert abs(data.data.energy_residual.to_numpy()).max() < 1e-8
    flow = rhs.flow(tangents=4, rtol=1e-12, atol=1e-12)
    end, step = flow.advance(rhs.state, 0.0, 0.3), 1e-6
    places = [0, len(rhs.system.layout.bodies), -2, -1]
    for column, place in enumerate(places[2:], 2):
        unit = np.zeros(len(rhs.state))
        unit[place] = step
        ahead, back = (flow.advance(rhs.state + s * unit, 0.0, 0.3).y for s in (1, -1))
        slope = ((ahead - back) / (2 * step))[places]
        assert end.tangents[:, column] == pytest.approx(slope, abs=1e-4)


def test_through_impacts():
    """A pin that bounces in its hole while a motor turns: internal states go on as they were."""
    text = CRANK.replace("piston: {position: 0.35, speed: -2}", "crank: {angle: 1, speed: 5}")
    gap = "gap: {joint: A, bar: rod, size: 0.2 mm, contact: restitution, restitution: 0.7}"
    text = text.replace("assembly: {A: left}\n", "") + f"clearances: {{{gap}}}\n"
    outputs = ["internal_state", "bar_speed", "energy_residual"]
    solution = linkages.simulate(linkages.loads(text), end=0.05, samples=501, outputs=outputs)
    assert sum(changed.count for changed in solution.motion.changes.values()) > 5
    current = solution.data.internal_state.sel(internal="motors.m.current").to_numpy()
    speed = solution.data.bar_speed.sel(bar="crank").to_numpy()
    # L di/dt + R i = U - k ω, summed up over jumps of ω by trapezes
    drop = trapezoid(0.5 * current - 10 + 0.2 * speed, solution.data.time.to_numpy())
    assert 0.02 * (current[-1] - current[0]) + drop == pytest.approx(0.0, abs=1e-5)
    assert abs(solution.data.energy_residual.to_numpy()).max() < 1e-7
