"""Sampled states and digital controllers: exact discretisation, contact, orbits, periods."""

from itertools import pairwise

import numpy as np
import pytest
from component_reading import complaints, component
from scipy.signal import cont2discrete

import linkages
from linkages.chaos.common_period import common_period
from linkages.components.state_equations import SampledState
from linkages.equations import derive, render
from linkages.errors import InputError
from linkages.kernel.system import System
from linkages.orbits.orbit import orbit
from linkages.spec.formulas import formula

PLANT = """
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, angle: 0, mass: 2}}
springs: [{slider: m, stiffness: 30, position: 0}]
dampers: [{slider: m, damping: 1.5}]
free: {m: {position: 0.1, speed: 0}}
"""
H = 0.02
LOOP = (
    PLANT
    + """
parameters: {h: 20 ms}
states:
  sum: {next: sum.value + 0.4 - m.position, period: h}
  u: {initial: 0.5, next: 25*(0.4 - m.position) + 1.5*sum.value - 2*m.velocity, period: h}
loads: [{slider: m, force: u.value}]
"""
)
A, B = np.array([[0, 1], [-15, -0.75]]), np.array([[0], [0.5]])
AD, BD, *_ = cont2discrete((A, B, np.eye(2), np.zeros((2, 1))), H)
GAIN = np.array([-25, -2, 1.5, 0.0])
CLOSED = np.zeros((4, 4))
"""What a period does to position, velocity, sum and held force, less where they rest."""
CLOSED[:2, :2] = AD
CLOSED[:2] += BD @ GAIN[None]
CLOSED[2], CLOSED[3] = [-1, 0, 1, 0], GAIN
TIMES = H * np.arange(101)


def discrete(count):
    """The loop at multiples of its period, each before the update there."""
    x, total, held, rows = np.array([0.1, 0.0]), 0.0, 0.5, []
    for _ in range(count):
        rows.append([*x, total, held])
        held = 25 * (0.4 - x[0]) + 1.5 * total - 2 * x[1]
        total = total + 0.4 - x[0]
        x = AD @ x + BD[:, 0] * held
    return np.array(rows)


def states(data):
    names = ("slider_position", "slider_velocity", "internal_state")
    return np.hstack([data[name].to_numpy() for name in names])


def test_same_from_yaml_and_python():
    made = SampledState(
        name="sum", next=formula("sum.value + 0.4 - m.position"), period=formula("h")
    )
    assert component(LOOP, "states", "sum") == made
    mechanism = linkages.loads(LOOP)
    assert linkages.loads(mechanism.to_yaml()) == mechanism


@pytest.mark.slow_except("*dop853*")
@pytest.mark.parametrize(
    ("method", "step"),
    [("dop853", None), ("tsit5", None), ("vern9", None), ("radau", None), ("rk4", 1e-3),
     ("gauss8", 9e-3)],
)  # fmt: skip
def test_a_linear_plant_against_its_exact_discretisation(method, step):
    mechanism = linkages.loads(LOOP)
    solution = linkages.simulate(mechanism, times=TIMES, method=method, step=step)
    # rtol 1e-10; rk4: (1 ms · 4/s)⁴ of it
    near = 1e-11 if step is None else 1e-10
    assert states(solution.data) == pytest.approx(discrete(101), abs=near)
    (changed,) = solution.motion.changes.values()
    updates = changed.time[changed.rises]
    assert len(updates) == 100
    # at multiples of the period to a few units in the last place, or 1e-12 periods
    assert updates == pytest.approx(TIMES[:100], rel=1e-14, abs=1e-13)


def test_a_digital_controller_with_limits():
    """P e + z − D v at multiples of 20 ms, clipped; z follows with back-calculation over P/I."""
    text = PLANT + (
        "controllers: {c: {slider: m, of: m.position, setpoint: 0.6, proportional: 25, integral: "
        "40, derivative: 2, limits: [-6, 12], period: 20 ms}}\n"
    )
    data = linkages.simulate(linkages.loads(text), times=TIMES).data
    x, held, total, rows = np.array([0.1, 0.0]), 0.0, 0.0, []
    for _ in TIMES:
        rows.append([*x, held, total])
        error = 0.6 - x[0]
        wanted = 25 * error + total - 2 * x[1]
        held = np.clip(wanted, -6, 12)
        total = total + H * (40 * error + (held - wanted) / (25 / 40))
        x = AD @ x + BD[:, 0] * held
    rows = np.array(rows)
    assert (rows[1:, 2] == 12.0).any()
    assert states(data) == pytest.approx(rows, abs=1e-10)
    names = ["controllers.c.effort", "controllers.c.integral"]
    assert data.internal.to_numpy().tolist() == names
    assert data.internal_state.attrs["units"] == "N"


def test_multipliers_and_exponents_of_a_loop():
    """Eigenvalues of a period; an update leaves nothing of the held force: one is zero."""
    mechanism = linkages.loads(LOOP)
    assert common_period(mechanism) == H
    expected = np.linalg.eigvals(CLOSED)
    found = orbit(mechanism)["multiplier"].to_numpy() @ np.array([1, 1j])
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(expected), abs=1e-9)
    data = linkages.lyapunov(mechanism, periods=2000, skip=200)
    rates = np.sort(np.log(np.abs(expected[np.abs(expected) > 1e-9])) / H)[::-1]
    assert data.attrs["lost"] == 1
    # a pair turns: its mean over 40 s, and each by 1/(40 s)
    assert data.exponent.to_numpy() == pytest.approx(rates, abs=0.03)
    assert data.attrs["sum"] == pytest.approx(rates.sum(), abs=1e-3)


def test_an_orbit_of_commensurate_periods():
    """A force of 60 ms beside updates of 20 ms: multipliers of three of them."""
    text = LOOP.replace("force: u.value", 'force: "u.value + cos(2*pi*t/0.06)"')
    mechanism = linkages.loads(text)
    assert common_period(mechanism) == pytest.approx(0.06, rel=1e-12)
    data = orbit(mechanism)
    found = data["multiplier"].to_numpy() @ np.array([1, 1j])
    expected = np.linalg.eigvals(np.linalg.matrix_power(CLOSED, 3))
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(expected), abs=1e-8)
    assert data.attrs["period"] == pytest.approx(0.06, rel=1e-12)
    assert data.attrs["stable"] == 1


def test_sensitivities_by_the_period_and_a_gain():
    """Against central differences with steps of 1e-5."""
    mechanism = linkages.loads(LOOP)
    paths, end = ["parameters.h", "sliders.m.mass"], 0.407
    found = linkages.sensitivities(mechanism, "final(m.position)", paths, end=end, rtol=1e-12)
    for path, exact in zip(paths, found["final(m.position)"].to_numpy(), strict=True):
        at = 0.02 if path == "parameters.h" else 2.0
        ends = [
            linkages.simulate(mechanism.with_values({path: at * (1 + s)}), end=end, rtol=1e-12)
            .data.slider_position.to_numpy()[-1, 0]
            for s in (-1e-5, 1e-5)
        ]  # fmt: skip
        assert exact == pytest.approx((ends[1] - ends[0]) / (2e-5 * at), rel=1e-6)


@pytest.mark.parametrize("order", [1, -1])
def test_updates_at_the_same_time_see_the_values_before(order):
    """Of 2 ms and 3 ms, in either order of the file."""
    lines = [
        "  a: {initial: 1, next: 0.5*a.value + b.value, period: 3 ms}",
        "  b: {initial: 2, next: a.value - 0.25*b.value, period: 2 ms}",
    ]
    text = PLANT + "\n".join(["states:", *lines[::order]])
    data = linkages.simulate(linkages.loads(text), times=1e-3 * np.arange(61)).data
    a, b, rows = 1.0, 2.0, []
    for k in range(61):
        rows.append([a, b])
        a, b = (
            0.5 * a + b if k % 3 == 0 else a,
            a - 0.25 * b if k % 2 == 0 else b,
        )
    found = data.internal_state.sel(internal=["states.a", "states.b"]).to_numpy()
    assert found.tolist() == rows


@pytest.mark.parametrize("order", [1, -1])
def test_a_long_period_is_not_near_for_many_short_ones(order):
    """Of 1 ms and 5000 s: the latter has one update, at the start."""
    lines = [
        "  fast: {next: fast.value + 1, period: 1 ms}",
        "  slow: {next: slow.value + 1, period: 5000 s}",
    ]
    text = PLANT + "\n".join(["states:", *lines[::order]])
    data = linkages.simulate(linkages.loads(text), times=[0.0, 10.5e-3]).data
    found = data.internal_state.sel(internal=["states.fast", "states.slow"]).to_numpy()
    assert found[-1].tolist() == [11.0, 1.0]


def test_no_update_is_missed_however_fast():
    """Of 100 kHz beside a motion of seconds, whose first step alone would pass many."""
    text = PLANT + "states: {count: {next: count.value + 1, period: 10 us}}\n"
    data = linkages.simulate(linkages.loads(text), times=[0.0, 1e-3, 0.0123456]).data
    assert data.internal_state.to_numpy()[:, 0].tolist() == [0, 100, 1235]


def test_equal_steps_are_short_enough():
    message = r"step must be at most 0\.0098 s, for states are updated within a step otherwise"
    with pytest.raises(ValueError, match=message):
        linkages.simulate(linkages.loads(LOOP), end=1, method="rk4", step=0.01)


BALL = """
joints: {O: [0, 0]}
sliders: {ball: {joint: P, through: O, angle: 90 deg, mass: 2}}
gravity: [0, -10]
stops: [{slider: ball, lower: 0, restitution: 0.75}]
states: {push: {next: 30*(0.05 - ball.position) - 4*ball.velocity, period: 30 ms}}
loads: [{slider: ball, force: push.value}]
free: {ball: {position: 0.4, speed: 0}}
"""


def test_impacts_between_updates():
    """Parabolas between updates and bounces, in closed form."""
    times = 0.03 * np.arange(41)
    data = linkages.simulate(linkages.loads(BALL), times=times).data
    place, speed, rows, bounces = 0.4, 0.0, [], 0
    for begin, end in pairwise([*times, np.inf]):
        rows.append([place, speed])
        pull = (30 * (0.05 - place) - 4 * speed) / 2 - 10
        left = end - begin
        while np.isfinite(left) and left > 0:
            roots = np.roots([0.5 * pull, speed, place])
            ahead = roots[(abs(roots.imag) < 1e-12) & (roots.real > 1e-9)].real
            part = min([left, *ahead])
            place, speed = place + speed * part + 0.5 * pull * part**2, speed + pull * part
            left -= part
            if left > 0:
                place, speed, bounces = 0.0, -0.75 * speed, bounces + 1
    assert bounces >= 2
    found = np.hstack([data.slider_position, data.slider_velocity])
    assert found == pytest.approx(np.array(rows), abs=1e-9)


def test_friction_sticks_through_updates():
    """A force of whole newtons, one more every 0.1 s, moves a block from 5 N on."""
    text = """
joints: {O: [0, 0]}
sliders: {block: {joint: P, through: O, angle: 0, mass: 1}}
friction: [{slider: block, force: 4.5 N}]
states: {pull: {next: pull.value + 1, period: 0.1}}
loads: [{slider: block, force: pull.value}]
free: {block: {position: 0, speed: 0}}
"""
    data = linkages.simulate(linkages.loads(text), times=np.linspace(0, 0.7, 8)).data
    # accelerations 0.5, 1.5, 2.5 m/s² from 0.4 s on, each for 0.1 s
    speed = np.array([0, 0, 0, 0, 0, 0.05, 0.2, 0.45])
    assert data.slider_velocity.to_numpy()[:, 0] == pytest.approx(speed, abs=1e-12)
    assert data.slider_position.to_numpy()[:5, 0] == pytest.approx(0.0, abs=1e-15)


def test_a_restart_goes_on_where_it_was():
    """At an update, and between two of them; the state there is that before the update."""
    rhs = linkages.compile(linkages.loads(LOOP))
    flow = rhs.flow(rtol=1e-12, atol=1e-12)
    whole = flow.advance(rhs.state, 0.0, 0.4).y
    assert whole == pytest.approx(discrete(21)[-1], abs=1e-12)
    for middle in (0.1, 0.2, 0.0737):
        half = flow.advance(rhs.state, 0.0, middle)
        # what is held follows from the time, too
        assert flow.advance(half.y, middle, 0.4).y == pytest.approx(whole, abs=1e-12)
        assert flow.advance(half.y, middle, 0.4, held=half.held).y == pytest.approx(
            whole, abs=1e-12
        )


def test_a_sweep_has_the_bits_of_single_runs():
    mechanism = linkages.loads(LOOP)
    values = [0.01, 0.02, 0.03]
    swept = linkages.sweep(mechanism, {"parameters.h": values}, "final(m.position)", end=1)
    made = (mechanism.with_values({"parameters.h": value}) for value in values)
    single = [linkages.measure(linkages.simulate(one, end=1), "final(m.position)") for one in made]
    assert swept["final(m.position)"].to_numpy().tolist() == single


def test_printed_equations_are_those_of_the_kernel():
    system = System(linkages.loads(LOOP))
    equations = derive(system.topology)
    module = {}
    exec(compile(render(equations, "python"), "equations.py", "exec"), module)
    state = np.array([0.3, 0.0, 0.0, -1.2, 0.7, 2.5])
    own = system.evaluate(system.model.next_values, 0.0, state[:, None])[:, 0]
    assert own == pytest.approx([0.7 + 0.1, 25 * 0.1 + 1.5 * 0.7 + 2.4], rel=1e-14)
    given = (0.0, [0.3], [-1.2], [0.7, 2.5])
    assert module["updated_states"](*given) == pytest.approx(own, rel=1e-14)
    assert list(module["internal_rates"](*given)) == [0.0, 0.0]
    assert "at every multiple of 0.02 s, constant between" in render(equations, "text")


def test_no_equilibrium_of_a_sampled_state():
    with pytest.raises(InputError, match=r"states\.u: it changes at multiples of a period alone"):
        linkages.equilibrium(linkages.loads(LOOP))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("h}\n  u", "0}\n  u"), "expected a time > 0 (seconds, or with a unit), or the name of a"),
        (("h}\n  u", "m.position}\n  u"), "or the name of a parameter, found 'm.position'"),
        (
            ("h}\n  u", "3 N}\n  u"),
            "expected a time (s), found '3 N': it is a force (N), not a time",
        ),
        ((", period: h}\n  u", "}\n  u"), "missing key 'period'"),
        (("next: sum", "rate: 3, next: sum"), "unknown key 'rate'"),
        (("initial: 0.5", "initial: 0.5 N"), ""),
        (
            ("u: {initial: 0.5, next: 25*", "u: {initial: 0.5 N, next: 25 N*"),
            "states.u.next: expected a value of 'u' (N), found '25 N*(0.4 - m.position)",
        ),
        (("sum: {next", "sum: {scale: -1, next"), "scale: expected a value > 0"),
    ],
    ids=str,
)
def test_bad_input(change, message):
    if message:
        found = complaints(LOOP.replace(*change))
        assert any(message in each for each in found), found
    else:  # a formula without units is in SI
        linkages.loads(LOOP.replace(*change))


def test_a_parameter_that_is_no_period():
    mechanism = linkages.loads(LOOP.replace("h: 20 ms", "h: -1"))
    with pytest.raises(InputError, match=r"states\.sum\.period: expected a time > 0"):
        linkages.simulate(mechanism, end=1)
