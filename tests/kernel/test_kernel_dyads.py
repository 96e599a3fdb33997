"""Closed-form dyads against complex numbers, differences and each other."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from kernel_motion import places_at
from linkage_models import LOOPED, system, text_of

from linkages.components.mechanisms.definition import from_document
from linkages.kernel.differentiation import Evaluator
from linkages.kernel.dyads import LinkAndSlider, LinkInGuide, TwoLinks, TwoSliders
from linkages.kernel.model import Model
from linkages.kernel.scalars import Level, ScalarGraph, Vector
from linkages.kernel.system import System
from linkages.reading.document import parse

# Motions of the gap are quadratic in time, so that differences of them are known exactly.
GAP, RATE, ACCELERATION = 0.7 + 0.2j, -0.4 + 0.9j, 1.3 - 0.6j
H = 2e-3
"""Step of differences of eighth order. With rates around 1 their truncation is H⁸/630 of a ninth
derivative, 4e-25 times up to 1e12 (the five-bar); rounding is 1e-16/H, and 1e-16/H² for second
derivatives."""
FIRST = ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
SECOND = ((1, 8 / 5), (2, -1 / 5), (3, 8 / 315), (4, -1 / 560))


def gap_at(t):
    return GAP + RATE * t + 0.5 * ACCELERATION * t * t


def inputs(count):
    graph = ScalarGraph()
    return [graph.input("y", i, Level.STATE) for i in range(count)]


def evaluated(nodes, *numbers):
    return np.array([float(v) for v in Evaluator(nodes)(y=np.array(numbers))])


def first_derivative(f):
    return sum(w * (f(k * H) - f(-k * H)) for k, w in FIRST) / H


def second_derivative(f):
    sides = sum(w * (f(k * H) + f(-k * H)) for k, w in SECOND)
    return (sides - 205 / 72 * f(0.0)) / H**2


def circles(gap, a, b, side):
    """Angles of both links: the law of cosines."""
    c = abs(gap)
    cosine = (a * a + c * c - b * b) / (2 * a * c)
    first = a * gap / c * np.exp(1j * side * np.arccos(cosine))
    return np.array([np.angle(first), np.angle(gap - first)])


SIDES = pytest.mark.parametrize("side", [1, -1])


# --- two links ----------------------------------------------------------------------------------


def two_links():
    gx, gy, a, b, s, vx, vy, ax, ay = inputs(9)
    dyad = TwoLinks.solve(Vector(gx, gy), a, b, s)
    rates = dyad.rates(Vector(vx, vy))
    accelerations = dyad.accelerations(Vector(ax, ay), rates)
    return dyad, rates, accelerations


LENGTHS = st.floats(0.1, 10)


@given(st.floats(-np.pi, np.pi), st.floats(0.02, 0.98), LENGTHS, LENGTHS, st.sampled_from([1, -1]))
def test_two_links_meet_where_circles_intersect(direction, fraction, a, b, side):
    nearest, farthest = abs(a - b), a + b
    distance = nearest + fraction * (farthest - nearest)
    assume(distance > 0.01)
    gap = distance * np.exp(1j * direction)
    dyad, *_ = two_links()
    nodes = [dyad.first.x, dyad.first.y, dyad.second.x, dyad.second.y, dyad.margin]
    fx, fy, sx, sy, margin = evaluated(nodes, gap.real, gap.imag, a * a, b * b, side, *[0] * 4)
    first, second = fx + 1j * fy, sx + 1j * sy
    size = max(a, b, distance) ** 2 / min(distance, a, b)
    # the height is the root of a difference of squares and keeps about half of the digits near
    # line-up; `fraction` keeps 2 % away, where it loses three digits at most
    tolerance = 1e-12 * size
    assert abs(first + second - gap) <= tolerance
    assert abs(abs(first) - a) <= tolerance
    assert abs(abs(second) - b) <= tolerance
    angles = circles(gap, a, b, side)
    assert abs(first - a * np.exp(1j * angles[0])) <= 100 * tolerance
    # the margin is the vector product of both links: positive turns left
    product = (np.conj(first) * second).imag
    assert margin == pytest.approx(product, abs=100 * tolerance * (a + b))
    assert np.sign(margin) == -side  # an apex on the left makes a right turn


@SIDES
def test_left_is_left_of_the_gap(side):
    dyad, *_ = two_links()
    x, y = evaluated([dyad.first.x, dyad.first.y], 1.0, 0, 0.64, 0.81, side, *[0] * 4)
    assert np.sign(y) == side
    assert x > 0


@SIDES
def test_two_links_turn_as_their_positions_change(side):
    a, b = 0.6, 0.5
    _, rates, accelerations = two_links()
    numbers = (GAP, a * a, b * b, side, RATE, ACCELERATION)
    flat = [v for n in numbers for v in ((n.real, n.imag) if isinstance(n, complex) else (n,))]
    speed, acceleration = evaluated(rates, *flat), evaluated(accelerations, *flat)

    def angles(t):
        return circles(gap_at(t), a, b, side)

    assert speed == pytest.approx(first_derivative(angles), abs=1e-12)  # see H
    assert acceleration == pytest.approx(second_derivative(angles), abs=1e-9)


@SIDES
def test_margin_of_two_links_changes_at_its_rate(side):
    a, b = 0.6, 0.5
    dyad, rates, _ = two_links()
    rate = dyad.margin_rate(rates)
    flat = [GAP.real, GAP.imag, a * a, b * b, side, RATE.real, RATE.imag, 0, 0]
    (found,) = evaluated([rate], *flat)

    def margin(t):
        first, second = np.exp(1j * circles(gap_at(t), a, b, side)) * [a, b]
        return (np.conj(first) * second).imag

    assert found == pytest.approx(first_derivative(margin), abs=1e-12)  # see H


@pytest.mark.parametrize(
    ("distance", "reachable"), [(0.05, False), (0.11, True), (1.09, True), (1.2, False)]
)
def test_two_links_reach_between_difference_and_sum(distance, reachable):
    dyad, *_ = two_links()
    (radicand,) = evaluated([dyad.radicand], distance, 0, 0.36, 0.25, 1, *[0] * 4)
    assert (radicand > 0) == reachable


def test_margin_scale_of_two_links_is_reached_at_right_angles():
    dyad, *_ = two_links()
    gap = np.hypot(0.6, 0.5)
    margin, scale = evaluated([dyad.margin, dyad.margin_scale], gap, 0, 0.36, 0.25, 1, *[0] * 4)
    assert abs(margin) == pytest.approx(scale, rel=1e-14)  # a few operations
    assert scale == pytest.approx(0.3, rel=1e-15)


# --- link and slider ----------------------------------------------------------------------------

AXIS = np.exp(0.4j)


def link_and_slider():
    gx, gy, square, ex, ey, s, vx, vy, ax, ay = inputs(10)
    dyad = LinkAndSlider.solve(Vector(gx, gy), square, Vector(ex, ey), s)
    rates = dyad.rates(Vector(vx, vy))
    return dyad, rates, dyad.accelerations(Vector(ax, ay), rates)


def slider_numbers(side, length):
    gap, axis = (GAP.real, GAP.imag), (AXIS.real, AXIS.imag)
    return [
        *gap,
        length**2,
        *axis,
        side,
        RATE.real,
        RATE.imag,
        ACCELERATION.real,
        ACCELERATION.imag,
    ]


def line_and_circle(gap, length, side):
    """Angle of the link and position of the slider: gap + link lies on the axis."""
    relative = gap / AXIS
    link = AXIS * (side * np.sqrt(length**2 - relative.imag**2) - 1j * relative.imag)
    return np.array([np.angle(link), ((gap + link) / AXIS).real])


@SIDES
def test_link_ends_on_the_axis(side):
    length = 0.9
    dyad, *_ = link_and_slider()
    nodes = [dyad.link.x, dyad.link.y, dyad.position, dyad.margin, dyad.margin_scale]
    x, y, position, margin, scale = evaluated(nodes, *slider_numbers(side, length))
    angle, expected = line_and_circle(GAP, length, side)
    # numbers around 1 and a handful of operations
    assert x + 1j * y == pytest.approx(length * np.exp(1j * angle), abs=1e-15)
    assert position == pytest.approx(expected, abs=1e-15)
    assert GAP + x + 1j * y == pytest.approx(position * AXIS, abs=1e-15)
    assert np.sign(margin) == side
    assert scale == pytest.approx(length, rel=1e-15)


@SIDES
def test_slider_moves_as_its_position_changes(side):
    length = 0.9
    dyad, rates, accelerations = link_and_slider()
    numbers = slider_numbers(side, length)

    def position(t):
        return line_and_circle(gap_at(t), length, side)

    found = evaluated(rates, *numbers)
    assert found == pytest.approx(first_derivative(position), abs=1e-12)  # see H
    found = evaluated(accelerations, *numbers)
    assert found == pytest.approx(second_derivative(position), abs=1e-9)

    def forward(t):
        return (length * np.exp(1j * position(t)[0]) / AXIS).real

    (rate,) = evaluated([dyad.margin_rate(rates)], *numbers)
    assert rate == pytest.approx(first_derivative(forward), abs=1e-12)


@pytest.mark.parametrize(("length", "reachable"), [(0.05, False), (0.1, True)])
def test_link_reaches_the_axis_or_not(length, reachable):
    dyad, *_ = link_and_slider()
    assert 0.05 < abs((GAP / AXIS).imag) < 0.1
    (radicand,) = evaluated([dyad.radicand], *slider_numbers(1, length))
    assert (radicand > 0) == reachable


# --- link in a turning guide -----------------------------------------------------------------


@SIDES
@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_link_in_a_guide_reaches_along_its_axis(side, size):
    """The guide's axis passes the gap at the distance of its base; margins scale with the gap."""
    gx, gy, bx, by, ex, ey, s = inputs(7)
    dyad = LinkInGuide.solve(Vector(gx, gy), Vector(bx, by), Vector(ex, ey), 1.0, s)
    gap, base = size * GAP, size * (0.2 + 0.1j)
    nodes = [dyad.unit.x, dyad.unit.y, dyad.position, dyad.margin, dyad.margin_scale]
    numbers = [v for z in (gap, base, AXIS) for v in (z.real, z.imag)]
    x, y, position, margin, scale = evaluated(nodes, *numbers, side)
    # numbers around `size` and a handful of operations
    assert (x + 1j * y) * (base + position * AXIS) == pytest.approx(gap, abs=1e-15 * size)
    across = (base / AXIS).imag
    assert margin == pytest.approx(side * np.sqrt(abs(gap) ** 2 - across**2), rel=1e-14, abs=0)
    assert scale == pytest.approx(abs(gap), rel=1e-15, abs=0)


@SIDES
def test_guide_turns_and_its_slider_moves_as_the_gap_does(side):
    base = 0.2 + 0.1j
    gx, gy, bx, by, ex, ey, s, vx, vy = inputs(9)
    dyad = LinkInGuide.solve(Vector(gx, gy), Vector(bx, by), Vector(ex, ey), 1.0, s)
    rates = dyad.rates(Vector(vx, vy))

    def forward(t):
        return side * np.sqrt(abs(gap_at(t)) ** 2 - (base / AXIS).imag ** 2)

    def coordinates(t):
        """Angle of the guide and position along it: gap = e^iθ (base + position·axis)."""
        position = forward(t) - (base / AXIS).real
        return np.array([np.angle(gap_at(t) / (base + position * AXIS)), position])

    numbers = [v for z in (GAP, base, AXIS, side, RATE) for v in (z.real, z.imag)]
    del numbers[7]  # the side has no imaginary part
    turning, moving, growing = evaluated([*rates, dyad.margin_rate(rates)], *numbers)
    assert [turning, moving] == pytest.approx(first_derivative(coordinates), abs=1e-12)  # see H
    assert growing == pytest.approx(first_derivative(forward), abs=1e-12)


# --- two sliders --------------------------------------------------------------------------------


def test_two_sliders_bridge_the_gap():
    e, f = np.exp(0.3j), np.exp(1.9j)
    gx, gy, ex, ey, fx, fy, vx, vy, ax, ay = inputs(10)
    dyad = TwoSliders.solve(Vector(gx, gy), Vector(ex, ey), Vector(fx, fy))
    rates = dyad.rates(Vector(vx, vy))
    accelerations = dyad.accelerations(Vector(ax, ay), rates)
    nodes = [dyad.first, dyad.second, *rates, *accelerations, dyad.margin, dyad.margin_rate(rates)]
    parts = [v for z in (GAP, e, f, RATE, ACCELERATION) for v in (z.real, z.imag)]
    found = evaluated(nodes, *parts)
    for (first, second), bridged in zip(
        found[:6].reshape(3, 2), (GAP, RATE, ACCELERATION), strict=True
    ):
        assert second * f - first * e == pytest.approx(bridged, abs=1e-15)  # a few operations
    assert found[6] == pytest.approx(np.sin(1.6), abs=1e-15)
    assert found[7] == 0
    assert dyad.radicand is None


# --- whole mechanisms: rates and accelerations against differences of positions -----------------


def motion_of(of):
    """Coordinates, rates and accelerations of all bodies and joints as functions of time."""
    model = Model(of.topology)
    names = [*of.topology.dependent]
    positions = model.positions
    joints = [n for j in model.velocities.joints for n in vars(positions.joints[j]).values()]
    speeds = [n for v in model.velocities.joints.values() for n in (v.x, v.y)]
    assert {*model.velocities.joints} == {*positions.joints}
    assert [*model.velocities.joints] == [*model.accelerations.joints]
    accelerations = [n for a in model.accelerations.joints.values() for n in (a.x, a.y)]
    turning = [model.velocities.bodies[n] for n in names]
    turning_rates = [model.accelerations.bodies[n] for n in names]
    groups = [joints, speeds, accelerations, turning, turning_rates]
    evaluator = Evaluator([node for group in groups for node in group])
    parameters = of.parameters
    ends = np.cumsum([len(group) for group in groups])[:-1]

    def at(t, coordinates, rates, second):
        y = np.array([*coordinates, *rates])
        found = evaluator(t=np.array([t]), y=y, a=np.array(second), p=parameters)
        return np.split(np.array([float(v) for v in found]), ends)

    return at


@pytest.mark.parametrize("name", LOOPED)
def test_rates_and_accelerations_of_mechanisms(name):
    """All free coordinates move as q + v t + a t²/2, whatever the forces."""
    of = system(name)
    count = len(of.topology.free)
    coordinates, rates = of.state[:count], of.state[count:] + 0.7
    second = np.linspace(-1.5, 2.0, count)
    at = motion_of(of)

    def along(which):
        return lambda t: at(
            t,
            coordinates + rates * t + 0.5 * second * t * t,
            rates + second * t,
            second,
        )[which]

    _, speeds, accelerations, turning, turning_rates = at(0.0, coordinates, rates, second)
    # the slider-crank turns at 10 rad/s: its n-th derivatives are 10ⁿ times as large
    fast = {"slidercrank": 10.0}.get(name, 1.0)
    assert speeds == pytest.approx(first_derivative(along(0)), abs=3e-12 * fast)
    assert accelerations == pytest.approx(first_derivative(along(1)), abs=3e-12 * fast**2)
    assert turning_rates == pytest.approx(first_derivative(along(3)), abs=3e-12 * fast**2)
    assert len(turning) == len(of.topology.dependent)


@pytest.mark.parametrize("name", LOOPED)
def test_margins_of_mechanisms_change_at_their_rates(name):
    of = system(name)
    model = of.model

    def margins(t):
        count = len(of.topology.free)
        state = of.state.copy()
        state[:count] += state[count:] * t
        return of.evaluate(model.margins, t, state[:, None])[:, 0]

    found = of.evaluate(model.margin_rates)[:, 0]
    fast = {"slidercrank": 10.0}.get(name, 1.0)
    assert found == pytest.approx(first_derivative(margins), abs=3e-12 * fast)


@pytest.mark.parametrize("swap", ["order of the joints of a bar", "order of the bars"])
def test_the_motion_does_not_depend_on_how_it_is_written(swap):
    """Angles of a bar turn by π if its joints are swapped; joints move all the same."""
    text = text_of("fourbar").replace(", center: [0.4, 0.1]", "")
    if swap == "order of the bars":
        lines = text.splitlines()
        first, last = (
            next(i for i, s in enumerate(lines) if s.startswith(f"  {n}:"))
            for n in ("coupler", "rocker")
        )
        lines[first], lines[last] = lines[last], lines[first]
        other = "\n".join(lines).replace("B: left", "B: right")  # seen from C to A
    else:
        other = text.replace("[A, B]", "[B, A]").replace("[C, B]", "[B, C]")
    a, b = (System(from_document(parse(t, "m.yaml"))) for t in (text, other))
    for joint, place in places_at(a, 0.3).items():
        assert places_at(b, 0.3)[joint] == pytest.approx(place, abs=1e-14)  # other roundings
