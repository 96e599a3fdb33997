"""The library's pendulums against elliptic functions and states in extended precision."""

import numpy as np
import pytest
from library_runs import column, reference, results
from scipy.special import ellipj, ellipk

G = 9.81
MODULUS = np.sin(np.radians(75)) ** 2
RATE = np.sqrt(1.5 * G)
"""Of small swings: a uniform bar of 1 m swings like a point at two thirds."""
PERIOD = 4 * ellipk(MODULUS) / RATE


def test_pendulum_period():
    data = results("pendulum", end=PERIOD, samples=5, rtol=1e-13)
    angle = np.degrees(column(data, "bar_angle", "rod")) + 90
    # some 300 steps; in degrees
    assert angle == pytest.approx([150, 0, -150, 0, 150], abs=1e-9)
    speed = column(data, "bar_speed", "rod")
    fastest = 2 * RATE * np.sqrt(MODULUS)
    assert speed == pytest.approx([0, -fastest, 0, fastest, 0], abs=2e-11)


def test_pendulum_motion():
    data = results("pendulum", rtol=1e-13)
    sn, *_ = ellipj(ellipk(MODULUS) - RATE * data.time.to_numpy(), MODULUS)
    angle = 2 * np.arcsin(np.sqrt(MODULUS) * sn)
    assert column(data, "bar_angle", "rod") + np.pi / 2 == pytest.approx(angle, abs=1e-11)


DOUBLE = reference("double_pendulum")["cases"]
POINTS = {
    f"bars.{bar}.{key}": value
    for bar in ("upper", "lower")
    for key, value in (("center", 1), ("inertia", 0))
}


@pytest.mark.parametrize("case", DOUBLE)
def test_double_pendulum(case):
    """To 10 s; at 20 s the chaotic ones have lost all digits but two."""
    given = DOUBLE[case]
    starts = dict(zip(("upper", "lower"), given["angles"], strict=True))
    overrides = {f"free.{bar}.angle": float(a) - np.pi / 2 for bar, a in starts.items()}
    if given["kind"] == "point":
        overrides |= POINTS
    data = results("double-pendulum", overrides, end=10.0, samples=21, rtol=1e-13)
    for row in given["rows"][:-1]:
        time = float(row["t"])
        sample = round(2 * time)
        angles = data.bar_angle[sample].to_numpy() + np.pi / 2
        found = [*angles, *data.bar_speed[sample].to_numpy()]
        # The integration is off by some 1e-13, and that grows by a factor e in a second.
        limit = 1e-12 * np.exp(1.05 * time)
        assert found == pytest.approx([float(v) for v in row["state"]], abs=limit), time
