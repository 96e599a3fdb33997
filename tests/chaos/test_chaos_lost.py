"""Directions that sticking friction and closed contacts take away: their exponents are −∞."""

import math

import numpy as np
import pytest

import linkages
from linkages.errors import UnfinishedError

STICK_SLIP = """
joints: {{O: [0, 0]}}
sliders: {{m: {{joint: P, through: O, mass: 1}}}}
springs: [{{slider: m, stiffness: 1}}]
friction: [{{slider: m, force: {friction}}}]
loads: [{{slider: m, force: "{amplitude}*cos({frequency}*t)"}}]
free: {{m: {{position: 0.1}}}}
"""
# A body at rest beside an arm that hangs at rest, whose pair of exponents is −C/(2·m·l²).
C = 0.5
ARM = """
gravity: [0, -9.81]
joints: {{O: [0, 0], Q: [1, 0]}}
sliders: {{block: {{joint: P, through: O, angle: 90 deg, mass: 1}}}}
bars: {{arm: {{joints: [{pin}, R], length: 1}}}}
masses: {{R: 1 kg}}
dampers: [{{bars: [ground, arm], damping: {damping}}}]
free: {{block: {{position: 0, speed: 0}}, arm: {{angle: -90 deg}}}}
simulate: {{end: 1}}
"""
BALL = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {block: {joint: P, through: O, angle: 90 deg, mass: 1}}
stops: [{slider: block, lower: 0, restitution: 0.5}]
free: {block: {position: 0, speed: 0}}
"""


def stick_slip(friction=0.8, amplitude=2.0, frequency=0.25):
    text = STICK_SLIP.format(friction=friction, amplitude=amplitude, frequency=frequency)
    return linkages.loads(text)


@pytest.mark.parametrize(
    ("friction", "amplitude", "frequency", "expected"),
    [
        (0.8, 2.0, 0.25, -0.038120),
        (1.0, 2.0, 0.25, -0.056467),
        (1.1, 2.0, 0.25, -0.067922),
        (0.8, 1.2, 0.3, -0.156921),
    ],
)
def test_stick_slip(friction, amplitude, frequency, expected):
    """Sticking maps (δx, δv) to (δx, 0): −∞, and ln|dx'/dx|/T of the map from stick to stick.

    The numbers are those of that map, computed by itself to the digits that are given.
    """
    data = linkages.lyapunov(stick_slip(friction, amplitude, frequency), periods=20, skip=5)
    assert data.exponent.to_numpy() == pytest.approx([expected], abs=3e-6)
    assert data.attrs["lost"] == 1
    assert data.attrs["settled"] == 1


@pytest.mark.parametrize(
    ("how", "lost"),
    [
        ({}, 1),
        ({"count": 1}, 0),
        ({"interval": 8 * math.pi / 3, "periods": 60}, 1),
        ({"interval": 400 * math.pi, "periods": 4}, 1),
        ({"method": "tsit5"}, 1),
        ({"method": "rk4", "step": 0.02}, 1),
        ({"rtol": 1e-6}, 1),
    ],
    ids=str,
)
def test_stick_slip_however_it_is_computed(how, lost):
    asked = {"periods": 20, "skip": 3} | how
    data = linkages.lyapunov(stick_slip(), **asked)
    # of intervals that are no periods the sum swings by ln 2 or so, over 500 s
    assert data.exponent.to_numpy() == pytest.approx([-0.03812], abs=2e-3)
    assert data.attrs["lost"] == lost


def test_a_verdict_on_stick_slip():
    report = linkages.verdict(stick_slip(), periods=200)
    assert report.verdict == "periodic"
    assert report.exponents.exponent.to_numpy() == pytest.approx([-0.038120], abs=3e-6)
    assert report.exponents.attrs["lost"] == 1


@pytest.mark.slow
def test_exponents_of_many_side_by_side():
    """The largest one in diagrams and maps, of motions in lanes."""
    axis = "friction[0].force=0.8:1.1:4"
    diagram = linkages.bifurcation(stick_slip(), [axis], periods=24, skip=8, exponent=True)
    expected = [-0.038120, -0.056467, -0.067922]
    assert diagram.exponent.to_numpy().ravel()[[0, 2, 3]] == pytest.approx(expected, abs=1e-4)
    run = {"periods": 24, "skip": 8, "rtol": 1e-10}
    chart = linkages.chaos_map(stick_slip(), "free.m.position=0.1:0.2:2", axis, **run)
    for column in chart.indicator.to_numpy().T:
        assert column[[0, 2, 3]] == pytest.approx(expected, abs=1e-4)
    for indicator in ("fli", "gali"):
        chart = linkages.chaos_map(
            stick_slip(), "free.m.position=0.1:0.2:2", axis, indicator=indicator, **run
        )
        assert np.isfinite(chart.indicator).all()


def test_what_is_kept_of_a_run_that_ends_early():
    with pytest.raises(UnfinishedError) as caught:
        linkages.lyapunov(stick_slip(), periods=400, skip=5, max_steps=20000)
    kept = caught.value.kept["lyapunov"]
    assert kept.exponent.to_numpy() == pytest.approx([-0.03812], abs=1e-3)
    assert kept.attrs["lost"] == 1


def at_rest(kind):
    """A block that a stop or friction holds, with an arm beside it or on it."""
    text = ARM.format(pin="Q" if kind == "stop" else "P", damping=C)
    if kind == "stop":
        return linkages.loads(text + "stops: [{slider: block, lower: 0, restitution: 0.5}]\n")
    text = text.replace("angle: 90 deg, mass", "angle: 0 deg, mass")
    return linkages.loads(text + "friction: [{slider: block, force: 3 N}]\n")


@pytest.mark.slow_except("*-16")
@pytest.mark.parametrize("skip", [0, 16])
@pytest.mark.parametrize(
    ("kind", "lost", "others"),
    [("stop", 2, [-C / 2, -C / 2]), ("friction", 1, [0, -C / 2, -C / 2])],
)
def test_a_block_at_rest_from_the_beginning(kind, lost, others, skip):
    """Within e⁻¹⁵⁰ of the arm's decay, beside which round-off of lost directions would grow."""
    data = linkages.lyapunov(at_rest(kind), periods=600, skip=skip)
    assert data.attrs["lost"] == lost
    # the pair swings about its mean by ln 10 or so within 600 s
    assert data.exponent.to_numpy() == pytest.approx(others, abs=5e-3)
    begun = 2e-3 if skip == 0 else 1e-6  # directions are random at first
    assert data.exponent.to_numpy()[-2:].sum() == pytest.approx(-C, rel=begun)


@pytest.mark.slow
def test_a_verdict_on_a_ball_at_rest():
    report = linkages.verdict(at_rest("stop"), periods=200, skip=0)
    assert report.verdict == "at rest"
    assert report.exponents.attrs["lost"] == 2
    assert report.exponents.exponent.to_numpy() == pytest.approx([-C / 2, -C / 2], abs=0.02)


def test_a_rod_at_rest_on_the_wall_of_its_bearing():
    """It hangs on the wall: a pendulum of 0.25 m, and a journal that slides on the wall."""
    text = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 0.5, mass: 2}}
clearances: {gap: {joint: O, bar: rod, size: 1 mm, contact: restitution, restitution: 0.8,
                   offset: [0, -1 mm]}}
free: {rod: {angle: -90 deg}}
dampers: [{bars: [ground, rod], damping: 0.05}]
simulate: {end: 1}
"""
    data = linkages.lyapunov(linkages.loads(text), periods=64)
    assert data.attrs["lost"] == 2
    assert data.sizes["index"] == 4
    assert data.attrs["sum"] == pytest.approx(-1.2, rel=1e-3)


def test_indicators_where_no_neighbours_are_left():
    from linkages.chaos.deviation_vectors import LinkageTangents
    from linkages.chaos.indicators import ROUND_OFF, fast_indicators
    from linkages.kernel.system import System

    for mechanism in (linkages.loads(BALL), stick_slip()):
        tangents = LinkageTangents(System(mechanism), 2)
        found = fast_indicators(tangents, intervals=40, interval=1.0, count=2)
        assert np.isfinite(found.fli).all()
        assert found.gali[-1] == ROUND_OFF


def test_what_is_lost_before_the_average_does_not_count():
    """A mass that friction holds at first, and that turns round at once ever after.

    Neighbours of its first state are those at rest; those of a later one have another exponent. At
    each turn their speeds change as accelerations do: the sum is the mean of ln(a⁺/a⁻).
    """
    text = STICK_SLIP.format(friction=0.5, amplitude=5.0, frequency=2.0)
    mechanism = linkages.loads(text.replace("position: 0.1", "position: 5.2"))
    assert linkages.lyapunov(mechanism, periods=64).attrs["lost"] == 1
    later = linkages.lyapunov(mechanism, periods=32, skip=32)
    assert later.attrs["lost"] == 0
    begin, end = 32 * math.pi, 64 * math.pi
    (piece,) = (
        linkages.simulate(mechanism, end=end, rtol=1e-12)
        .motion.changes["friction[0]: sign(m.velocity)"]
        .pieces
    )
    turns = piece.time > begin
    force = 5.0 * np.cos(2.0 * piece.time[turns]) - piece.state[0, turns]
    ratios = (abs(force) - 0.5) / (abs(force) + 0.5)
    assert (ratios > 0).all()
    assert turns.sum() >= 32
    expected = np.log(ratios).sum() / (end - begin)
    assert later.attrs["sum"] == pytest.approx(expected, rel=1e-7)
