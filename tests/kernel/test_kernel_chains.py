"""Long chains of bodies that follow each other, against closed forms: no depth of recursion."""

from itertools import pairwise

import numpy as np
import pytest

import linkages
from linkages.cli.verbs.check_commands import check_content
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.run import RunOptions
from linkages.solution.many import march_many
from linkages.solution.march import March

RATIO = -1.001
G = 9.80665


def geared(count):
    """A train of gears on fixed axes."""
    bars = "".join(f"  b{i}: {{joints: [O{i}, P{i}], length: 0.1}}\n" for i in range(count))
    pivots = "".join(f"  O{i}: [{0.2 * i}, 0]\n" for i in range(count))
    gears = "".join(f"  - {{bars: [b{i}, b{i + 1}], ratio: {RATIO}}}\n" for i in range(count - 1))
    return f"joints:\n{pivots}bars:\n{bars}gears:\n{gears}drives: {{b0: {{angle: 0, speed: 1}}}}\n"


def welded(count, before="", drive="b0"):
    """A zigzag of welded bars, which `before` may turn."""
    pins = ["O", *(f"P{i}" for i in range(count))]
    bars = "".join(
        f"  b{i}: {{joints: [{a}, {b}], length: 0.1}}\n" for i, (a, b) in enumerate(pairwise(pins))
    )
    welds = "".join(
        f"  P{i}: {{bars: [b{i}, b{i + 1}], angle: {-30 if i % 2 else 30} deg}}\n"
        for i in range(count - 1)
    )
    drives = f"drives: {{{drive}: {{angle: 0, speed: 1}}}}\n"
    return f"joints: {{O: [0, 0], G: [0, 1]}}\nbars:\n{bars}{before}welds:\n{welds}{drives}"


def stacked(count):
    """Sliders of which each slides on the one before, all of them driven."""
    sliders = "".join(
        f"  s{i}: {{joint: S{i}, "
        + (f"on: s{i - 1}, through: S{i - 1}, angle: 0.001" if i else "through: [0, 0]")
        + "}\n"
        for i in range(count)
    )
    drives = "".join(f"  s{i}: {{position: 1 mm, speed: 1}}\n" for i in range(count))
    return f"sliders:\n{sliders}drives:\n{drives}"


LONG = [500, pytest.param(2000, marks=pytest.mark.slow)]


def simulated(text, *outputs):
    return linkages.simulate(linkages.loads(text), end=0.5, samples=2, outputs=outputs).data


@pytest.mark.parametrize("count", LONG)
def test_a_long_train_of_gears_turns_by_powers_of_its_ratio(count):
    angles = simulated(geared(count), "bar_angle", "bar_speed").isel(time=-1)
    powers = RATIO ** np.arange(count)
    # each angle is that of the bar before times the ratio, rounded: count·ε/2 at most
    np.testing.assert_allclose(angles.bar_speed, powers, rtol=count * 2e-16)
    np.testing.assert_allclose(np.cos(angles.bar_angle), np.cos(0.5 * powers), atol=1e-11)


@pytest.mark.parametrize("count", LONG)
def test_a_long_chain_of_welded_bars_is_one_body(count):
    data = simulated(welded(count), "joint_position", "joint_velocity").isel(time=-1)
    angles = 0.5 + np.deg2rad(np.arange(count) % 2 * 30.0)
    end = 0.1 * np.exp(1j * angles).sum()
    x, y = data.joint_position.sel(joint=f"P{count - 1}").values
    u, v = data.joint_velocity.sel(joint=f"P{count - 1}").values
    # sums of `count` rounded numbers, of which the last are the largest
    np.testing.assert_allclose([x + 1j * y, u + 1j * v], [end, 1j * end], rtol=count * 2e-16)


def test_a_long_chain_of_welds_behind_a_gear():
    """Its bodies turn with the sum of two angles, so that none stands for the others."""
    before = "  arm: {joints: [G, A], length: 0.1}\ngears: [{bars: [arm, b0], ratio: 3}]\n"
    count = 400
    data = simulated(welded(count, before, "arm"), "joint_position").isel(time=-1)
    end = 0.1 * np.exp(1j * (1.5 + np.deg2rad(np.arange(count) % 2 * 30.0))).sum()
    x, y = data.joint_position.sel(joint=f"P{count - 1}").values
    assert x + 1j * y == pytest.approx(end, rel=count * 2e-16)


def test_a_long_stack_of_sliders_slides_in_turned_directions():
    count = 300
    data = simulated(stacked(count), "joint_position").isel(time=-1)
    end = 0.501 * np.exp(0.001j * np.arange(count)).sum()
    x, y = data.joint_position.sel(joint=f"S{count - 1}").values
    assert x + 1j * y == pytest.approx(end, rel=count * 2e-16)


def let_go(text):
    """The same, made of rods of 1 kg that nothing drives."""
    text = text[: text.index("drives:")].replace("length: 0.1}", "length: 0.1, mass: 1}")
    return f"{text}free: {{b0: {{angle: 0.3}}}}\ngravity: [0, {-G}]\n"


FALLING = [160, pytest.param(2000, marks=pytest.mark.slow)]


@pytest.mark.parametrize("count", FALLING)
def test_a_long_train_of_gears_falls_as_one_coordinate(count):
    data = simulated(let_go(geared(count)), "bar_acceleration", "energy_residual")
    powers = RATIO ** np.arange(count)
    force = -0.05 * G * (np.cos(0.3 * powers) * powers).sum()
    found = data.bar_acceleration.isel(time=0)
    # the cosines of angles up to 2 rad, which are off by count·ε; they cancel to some hundredths
    exact = force / (0.01 / 3 * (powers**2).sum()) * powers
    np.testing.assert_allclose(found, exact, rtol=1e-9)
    # in parts of the potential energy of a rod times their number; the tolerance is 1e-10
    assert abs(data.energy_residual).max() < 1e-9 * count


@pytest.mark.parametrize("count", FALLING)
def test_a_long_chain_of_welded_bars_falls_as_one_body(count):
    data = simulated(let_go(welded(count)), "bar_acceleration", "bar_angle", "energy_residual")
    bars = 0.1 * np.exp(1j * (0.3 + np.deg2rad(np.arange(count) % 2 * 30.0)))
    centres = np.cumsum(bars) - 0.5 * bars
    inertia = (np.abs(centres) ** 2).sum() + count * 0.01 / 12
    found = data.bar_acceleration.isel(time=0)
    np.testing.assert_allclose(found, -G * centres.real.sum() / inertia, rtol=1e-10)
    assert abs(data.energy_residual).max() < 1e-9 * count**2  # the chain is as high as it is long
    turned = np.diff(data.bar_angle, axis=0)
    # all turn alike, whole turns included; the round-off of an arctangent
    np.testing.assert_allclose(turned, np.broadcast_to(turned[:, :1], turned.shape), atol=1e-14)


def test_angles_that_are_counted_in_a_loop_are_the_same_in_lanes():
    """From seventeen on their loop is not written out; all turn more than once."""
    along = Varying(linkages.loads(let_go(welded(18)))).along(
        [{"free.b0.speed": speed} for speed in (20.0, 21.0, 22.0)]
    )
    systems, times = [along.system(i) for i in range(3)], np.linspace(0.05, 1.0, 20)
    several, alone = ([March(s, RunOptions(), counting=True) for s in systems] for _ in range(2))
    for found, march in zip(march_many(several, times), alone, strict=True):
        own = march.advance(times)
        (one,), (other,) = found.pieces, own.pieces
        angles = np.array([*one.counted.values()])
        assert np.array_equal(angles, [*other.counted.values()])
        assert np.ptp(angles, axis=1).min() > 2 * np.pi
        master = one.state[0] + 2 * np.pi * one.turns[0]
        apart = np.diff(angles - master, axis=1)  # the round-off of some turns
        np.testing.assert_allclose(apart, 0.0, atol=1e-13)


@pytest.mark.parametrize("text", [geared, welded])
def test_check_describes_a_long_chain(text):
    content = check_content(System(linkages.loads(text(500))))
    assert content["mobility"] == {"gruebler": 1, "numerical": 1}
