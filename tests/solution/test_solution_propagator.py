"""States and tangents moved by a propagator: against `lyapunov`, differences and `simulate`."""

import numpy as np
import pytest
from solution_mechanisms import DOUBLE_ROCKER

import linkages
from linkages.chaos.exponents import random_directions
from linkages.errors import InputError

THROWN = {"upper": (2.0, 0.0), "lower": (2.5, 0.0)}
ARM = 9.81 * 1.5  # of a uniform rod of length 1 m: ω² = 3g/2L


def double_pendulum():
    return linkages.load("double-pendulum").with_state(THROWN)


def test_exponents_by_qr_are_those_of_lyapunov():
    """Benettin's method with a few lines of one's own, as a reader of the page would write it."""
    mechanism = linkages.load("double-pendulum").with_state(
        {"upper": (-1.2, 0.0), "lower": (-1.8, 0.0)}
    )
    data = linkages.lyapunov(mechanism, periods=6)
    rhs = linkages.compile(mechanism)
    flow = rhs.flow(tangents=4)
    y, tangents, growth, time = rhs.state, random_directions(4, 4), np.zeros(4), 0.0
    for later in data.time.to_numpy():
        end = flow.advance(y, time, later, tangents)
        tangents, r = np.linalg.qr(end.tangents)
        growth += np.log(abs(np.diag(r)))
        y, time = end.y, later
    # hanging masses swing regularly, so that errors of 1e-6 in tangents do not grow exponentially
    assert growth / time == pytest.approx(data.exponent.to_numpy(), abs=1e-5)


def test_tangents_are_derivatives_of_the_motion():
    rhs = linkages.compile(double_pendulum())
    plain = rhs.flow(rtol=1e-13)
    step = 1e-6  # central differences: truncation and round-off are both about 1e-9
    columns = [
        (plain.advance(rhs.state + d, 0, 1).y - plain.advance(rhs.state - d, 0, 1).y) / (2 * step)
        for d in step * np.eye(4)
    ]
    found = rhs.flow(tangents=4, rtol=1e-12).advance(rhs.state, 0.0, 1.0).tangents
    size = abs(found).max()
    # tangents have an absolute tolerance of 1e-6 of their length
    assert found == pytest.approx(np.array(columns).T, abs=1e-5 * size)
    back = rhs.flow(tangents=4).advance(plain.advance(rhs.state, 0, 1).y, 1.0, 0.0, found)
    assert back.tangents == pytest.approx(np.eye(4), abs=1e-4)
    assert back.y == pytest.approx(rhs.state, abs=1e-9)


def test_states_are_those_of_simulate_with_all_turns():
    mechanism = linkages.load("pendulum").with_state({"rod": (0.0, 12.0)})  # turns over
    rhs, end = linkages.compile(mechanism), 5.0
    expected = linkages.simulate(mechanism, end=end, samples=2).data
    found = rhs.flow().advance(rhs.state + np.array([6 * np.pi, 0.0]), 0.0, end).y
    assert found[0] - 6 * np.pi == pytest.approx(expected.bar_angle.to_numpy()[-1, 0], abs=1e-8)
    assert found[0] - 6 * np.pi > 2 * np.pi


def test_events_are_found_at_their_times():
    """A pendulum released from rest at 60°: a quarter of its period is K(sin 30°)/ω₀."""
    from scipy.special import ellipk

    rhs = linkages.compile(linkages.load("pendulum"))
    period = 4 * ellipk(np.sin(rhs.state[0] / 2 + np.pi / 4) ** 2) / np.sqrt(ARM)
    events = {"rod.speed": "both", "rod.angle=-90 deg": "down", "rod.angle=270 deg": "up"}
    found = rhs.flow(events=events).advance(rhs.state, 0.0, 2.2 * period)
    assert found.time == 2.2 * period
    turning = found.crossings["rod.speed"]
    assert turning.time == pytest.approx(period * np.arange(0.5, 2.1, 0.5), abs=1e-8)
    assert abs(turning.y[1]).max() < 1e-8
    down, up = (found.crossings[name] for name in list(events)[1:])
    assert down.time == pytest.approx(period * np.array([0.25, 1.25]), abs=1e-8)
    assert up.time == pytest.approx(period * np.array([0.75, 1.75]), abs=1e-8)
    assert down.y[0] == pytest.approx(-np.pi / 2, abs=1e-12)


def test_an_advance_stops_at_an_event_if_asked():
    """An angle half a turn away is no crossing: thrown over, the rod passes -90° before -270°."""
    rhs = linkages.compile(linkages.load("pendulum").with_state({"rod": (0.0, -12.0)}))
    flow = rhs.flow(tangents=2, events={"rod.angle=90 deg": "both"}, stop=True)
    end = flow.advance(rhs.state, 0.0, 10.0)
    (time,) = end.crossings["rod.angle=90 deg"].time
    assert end.time == pytest.approx(time, rel=1e-15)  # t + θh, rounded once or twice
    assert end.y[0] == pytest.approx(-3 * np.pi / 2, abs=1e-12)
    again = flow.advance(end.y, end.time, 10.0, end.tangents)
    assert again.y[0] == pytest.approx(-7 * np.pi / 2, abs=1e-12)


def test_groups_that_are_iterated_are_moved_too():
    rhs = linkages.compile(linkages.load("class-three"))
    expected = linkages.simulate(linkages.load("class-three"), end=0.2, samples=2).data
    found = rhs.outputs(["joint_position"], 0.2, rhs.flow().advance(rhs.state, 0.0, 0.2).y)
    assert found.joint_position[0].to_numpy() == pytest.approx(
        expected.joint_position[-1].to_numpy(), abs=1e-9
    )


def test_free_coordinates_are_exchanged_on_the_way():
    """A rocker cannot stay free at its dead points; states and tangents are still its own.

    Against differences of motions that start beside each other: some 1e-6 of step and tolerance.
    """
    mechanism = linkages.loads(DOUBLE_ROCKER.replace("speed: 0", "speed: 5"))
    solution = linkages.simulate(mechanism, end=1.0, samples=2, rtol=1e-12)
    assert any("exchanged" in note for note in solution.notes)
    rhs = linkages.compile(mechanism)
    flow = rhs.flow(tangents=2, rtol=1e-12)
    end = flow.advance(rhs.state, 0.0, 1.0)
    bar = solution.data.isel(time=-1).sel(bar="rocker")
    assert end.y == pytest.approx([float(bar.bar_angle), float(bar.bar_speed)], abs=1e-9)
    for column in range(2):
        beside = [
            flow.advance(rhs.state + sign * 1e-6 * np.eye(2)[column], 0.0, 1.0).y
            for sign in (1, -1)
        ]
        difference = (beside[0] - beside[1]) / 2e-6
        assert end.tangents[:, column] == pytest.approx(difference, rel=1e-4, abs=1e-4)


def test_a_motion_that_cannot_go_on_is_an_error():
    """At a change point the equations of one assembly mode end, though a simulation goes on."""
    text = """
joints: {O: [0, 0], D: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 1}
  coupler: {joints: [A, B], length: 0.1, mass: 1}
  rocker: {joints: [D, B], length: 0.04, mass: 1}
free: {crank: {angle: 60 deg, speed: 5}}
assembly: {B: left}
"""
    rhs = linkages.compile(linkages.loads(text))
    with pytest.raises(linkages.ComputationError, match="can go on in two ways"):
        rhs.flow().advance(rhs.state, 0.0, 10.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda flow: flow.advance([1.0], 0.0, 1.0), r"y must have shape \(2,\), found \(1,\)"),
        (lambda flow: flow.advance([1.0, 0.0], 0.0, 1.0, np.eye(2)), r"tangents must have shape"),
    ],
)
def test_shapes_that_do_not_fit_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(linkages.compile(linkages.load("pendulum")).flow(tangents=1))


SIZE, MASS = "clearances.gap.size", "bars.rod.mass"


def crank(**values):
    """A slider-crank with contact, whose pin hits the wall a dozen times in 4 ms."""
    own = {"clearances.gap.offset": [2e-5, 1e-5], **values}
    return linkages.load("contact-slider-crank").with_values(own)


@pytest.mark.parametrize(("path", "value"), [(SIZE, 1e-4), (MASS, 0.21)])
def test_derivatives_by_parameters_through_contact(path, value):
    """Against central differences, and passed on from one advance to the next."""
    rhs, step = linkages.compile(crank()), 1e-6 * value
    flow = rhs.flow(tangents=2, parameters=[SIZE, MASS], rtol=1e-12)
    ends = [
        linkages.compile(crank(**{path: value + side * step})).flow(rtol=1e-12)
        .advance(rhs.state, 0.0, 0.004).y
        for side in (1, -1)
    ]  # fmt: skip
    end = flow.advance(rhs.state, 0.0, 0.004)
    own = end.by_parameters[:, [SIZE, MASS].index(path)]
    assert own == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)
    assert end.tangents.shape == (4, 2)
    half = flow.advance(rhs.state, 0.0, 0.002)
    rest = {"tangents": half.tangents, "held": half.held, "by_parameters": half.by_parameters}
    again = flow.advance(half.y, 0.002, 0.004, **rest)
    assert again.by_parameters == pytest.approx(end.by_parameters, rel=1e-9)
    assert again.tangents == pytest.approx(end.tangents, rel=1e-9)


def test_parameters_that_are_none():
    rhs = linkages.compile(crank())
    with pytest.raises(InputError, match="found no number"):
        rhs.flow(parameters=["bars.rod.name"])
    with pytest.raises(ValueError, match=r"by_parameters must have shape \(4, 1\)"):
        rhs.flow(parameters=[SIZE]).advance(rhs.state, 0.0, 1e-3, by_parameters=[1.0])
    assert rhs.flow().advance(rhs.state, 0.0, 1e-3).by_parameters.shape == (4, 0)


def test_extrema_of_a_series():
    """A pendulum turns round at its first angle, and the gap of a pin is widest between touches."""
    rhs = linkages.compile(linkages.load("pendulum"))
    end = rhs.flow(extrema={"rod.angle": "max"}, rtol=1e-12).advance(rhs.state, 0.0, 10.0)
    met = end.crossings["rod.angle"]
    assert len(met.time) > 2
    assert met.y[1] == pytest.approx(0.0, abs=1e-9)
    assert np.diff(met.time) == pytest.approx(np.diff(met.time)[0], rel=1e-9)
    rhs = linkages.compile(crank())
    flow = rhs.flow(extrema={"gap.indentation": "both"}, events={"gap.touch": "both"})
    end = flow.advance(rhs.state, 0.0, 0.01)
    deepest, touches = end.crossings["gap.indentation"], end.crossings["gap.touch"]
    depth = np.hypot(*deepest.y[:2]) - 1e-4
    inside = np.searchsorted(touches.time, deepest.time) % 2 == 1  # between touch and loss
    assert (depth[inside] > 0.0).any()
    assert (depth[~inside] <= 0.0).all()
    assert (depth[inside] >= 0.0).all()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"rod.angle": "up"}, "expected max, min or both, found 'up'"),
        ({"rod.speed": "max"}, "expected a position, an angle or a distance"),
        ({"rod.angel": "max"}, "rod.angel"),
    ],
)
def test_extrema_that_are_none(asked, message):
    rhs = linkages.compile(linkages.load("pendulum"))
    with pytest.raises(ValueError, match=message):
        rhs.flow(extrema=asked)
    with pytest.raises(ValueError, match=r"found rod\.angle among both events and extrema"):
        rhs.flow(extrema={"rod.angle": "max"}, events={"rod.angle": "up"})
