"""Jerk: against a closed form, and against differences of accelerations."""

import numpy as np
import pytest

import linkages

CRANK = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.2, mass: 1}}
drives: {crank: {angle: 0.3, speed: 4}}
"""


def test_a_point_on_a_circle_has_the_cube_of_the_speed():
    data = linkages.simulate(
        linkages.loads(CRANK), end=1.0, samples=7, outputs=["bar_angle", "joint_jerk"]
    ).data
    angle = data.bar_angle.to_numpy()[:, 0]
    expected = 0.2 * 4.0**3 * np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    assert data.joint_jerk.sel(joint="A").to_numpy() == pytest.approx(expected, abs=1e-13)
    assert not data.joint_jerk.sel(joint="O").any()


@pytest.mark.parametrize(
    "name", ["four-bar", "ninebar", "double-pendulum", "class-three", "andrews", "scotch-yoke"]
)
def test_it_is_the_rate_of_acceleration(name):
    """Central differences of order 4 over five samples, h apart: errors of h⁴ and of ε/h."""
    mechanism = linkages.load(name)
    if name == "double-pendulum":
        mechanism = mechanism.with_state({"upper": (0.5, 2.0), "lower": (-1.0, 1.0)})
    step = 1e-5 if name in ("ninebar", "andrews") else 2e-4
    times = 0.01 + step * np.arange(5)
    outputs = ["joint_acceleration", "joint_jerk"]
    data = linkages.simulate(mechanism, times=times, rtol=1e-13, outputs=outputs).data
    a = data.joint_acceleration.to_numpy()
    expected = (a[0] - 8 * a[1] + 8 * a[3] - a[4]) / (12 * step)
    size = abs(expected).max() + 1e-9 * abs(a).max() / step
    assert abs(data.joint_jerk.to_numpy()[2] - expected).max() < 1e-4 * size


def test_its_magnitude_has_a_largest_value():
    solution = linkages.simulate(linkages.loads(CRANK), end=1.0, samples=7, outputs="joint_jerk")
    rows = {row["element"]: row["value"] for row in solution.maxima}
    assert rows["A"] == pytest.approx(0.2 * 64)
