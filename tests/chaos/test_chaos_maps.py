"""What maps say of points whose motion is known."""

import numpy as np
import pytest

import linkages
from linkages.chaos.exponents import Exponents
from linkages.chaos.maps import sign_of
from linkages.sweeps.axes import parse_range, together
from linkages.sweeps.running import Threads

# θ'' = −sin θ, so that what rotates is known; the torque of nothing gives it a period.
FREE = """\
name: Pendulum
gravity: [1, 0]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
loads: [{bar: arm, torque: {harmonic: {amplitude: 0, angular_frequency: 1}}}]
free: {arm: {angle: 0, speed: 1}}
simulate: {end: 10, samples: 101, rtol: 1e-8}
"""
SPEED, DAMPING = "free.arm.speed", "dampers[0].damping"


def pendulum(text=FREE):
    return linkages.loads(text)


def test_librations_rotations_and_what_is_both():
    """Without friction it rotates from 2 rad/s on; a rotating one that is stopped does both."""
    data = linkages.chaos_map(pendulum(), {SPEED: [1.9, 2.1]}, {"gravity[0]": [1, 1]}, periods=10)
    assert data.rotation[0, :, 0].to_numpy().tolist() == ["libration", "rotation"]
    text = FREE + "dampers: [{joint: O, damping: 0.1}]\n"
    data = linkages.chaos_map(
        pendulum(text), {SPEED: [1.0, 3.5]}, {DAMPING: [0.1, 0.1]}, periods=10
    )
    assert data.rotation[0, :, 0].to_numpy().tolist() == ["libration", "mixed"]


def test_regular_motions_of_a_map_are_not_told_from_zero():
    """Libration and rotation without friction: tangents grow like T, exponents like ln(T)/T."""
    data = linkages.chaos_map(pendulum(), {SPEED: [1.0, 3.0]}, {"gravity[0]": [1, 1]}, periods=20)
    assert (data.indicator > 0).all()
    assert (data.sign == 0).all()
    assert (data.error >= 0).all()


def test_friction_has_a_negative_exponent():
    text = FREE + "dampers: [{joint: O, damping: 0.4}]\n"
    data = linkages.chaos_map(
        pendulum(text), {SPEED: [1.0, 1.5]}, {DAMPING: [0.4, 0.4]}, periods=20
    )
    assert (data.sign == -1).all()
    assert data.indicator.to_numpy() == pytest.approx(-0.2, abs=0.02)  # half the damping


def series(growth):
    growth = np.asarray(growth, dtype=float)[:, None]
    times = np.arange(len(growth) + 1.0)
    return Exponents(growth=growth, states=np.zeros((len(times), 1)), times=times)


@pytest.mark.parametrize(
    ("rates", "expected"),
    [
        ("steady", 1),
        ("shrinking", -1),
        ("power", 0),
        ("noise", 0),
        ("turning", 0),
    ],
)
def test_signs(rates, expected):
    """Growth of a tangent from one interval to the next, for 1000 of them."""
    number = np.arange(1000)
    noise = np.random.default_rng(1).normal(size=1000)
    growth = {
        "steady": 0.1 + 0.1 * noise,
        "shrinking": -0.1 + 0.1 * noise,
        "power": 2 * np.diff(np.log1p(np.arange(1001.0))),  # t², as volumes may on a torus
        "noise": 0.01 * noise,
        "turning": np.where(number < 700, 0.1, -0.1),  # the whole grows, the end shrinks
    }[rates]
    assert sign_of(series(growth)) == expected


def test_ranges_of_different_units_do_not_vary_together():
    """One unit is shared by all paths of an axis: metres would be read as millimetres."""
    first, second = parse_range("bars.a.length=1mm:2mm:3"), parse_range("bars.b.length=1m:2m:3")
    with pytest.raises(ValueError, match="equally many values and the same unit"):
        together([first, second])
    with pytest.raises(ValueError, match="equally many values and the same unit"):
        together([first, parse_range("bars.b.length=1mm:2mm:4")])


@pytest.mark.slow_except("fli")
@pytest.mark.parametrize("indicator", ["exponent", "fli", "gali"])
def test_points_side_by_side_are_those_alone(indicator):
    """In all bits, whatever computes them: also beside a point that stops, and one that is none."""
    mechanism = pendulum()
    x, y = {SPEED: [0.5, 1.9, 2.5]}, {"bars.arm.length": [-1.0, 0.8, 1.0, 1.3]}
    given = {"indicator": indicator, "periods": 6, "max_steps": 100}
    whole = linkages.chaos_map(mechanism, x, y, executor=Threads(1), **given)
    assert set(whole.outcome.to_numpy().ravel()) == {0, 1, 4}
    for row, length in enumerate(y["bars.arm.length"]):
        pair = {"bars.arm.length": [length, 1.1]}
        alone = linkages.chaos_map(mechanism, x, pair, executor=Threads(3), **given)
        assert (
            whole.isel(y=row)
            .drop_vars("bars.arm.length")
            .identical(alone.isel(y=0).drop_vars("bars.arm.length"))
        )
