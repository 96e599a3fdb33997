"""The plate on three legs against an independent solution of its three leg lengths."""

import numpy as np
import pytest
from library_runs import TURN, column, place, results
from scipy.optimize import root

LOCAL = np.array([[0, 0], [0.2, 0], [0.09, 0.16]])
LEGS = np.array([0.23, 0.15, 0.21])
SPEED = TURN


def feet(time):
    """Where the legs stand, and the velocity and acceleration of these places."""
    angle = SPEED * time
    e, n = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    zero = np.zeros(2)
    return (
        np.array([0.05 * e, [0.33, -0.07], [0.25, 0.39]]),
        np.array([0.05 * SPEED * n, zero, zero]),
        np.array([-0.05 * SPEED**2 * e, zero, zero]),
    )


def corners(pose):
    """Corners of the plate and their derivatives with respect to its angle."""
    x, y, angle = pose
    c, s = np.cos(angle), np.sin(angle)
    arms = LOCAL @ np.array([[c, s], [-s, c]])
    return np.array([x, y]) + arms, arms @ np.array([[0, 1], [-1, 0]])


def jacobian(pose, time):
    """Of half the squared lengths of the legs."""
    places, turning = corners(pose)
    legs = places - feet(time)[0]
    return np.column_stack([legs, (legs * turning).sum(axis=1)])


def solved(pose, time):
    """Pose, its rate and its acceleration: three equations each."""

    def stretch(pose):
        return 0.5 * ((corners(pose)[0] - feet(time)[0]) ** 2).sum(axis=1) - 0.5 * LEGS**2

    found = root(stretch, pose, jac=lambda p: jacobian(p, time), tol=1e-15)
    pose = found.x - np.linalg.solve(jacobian(found.x, time), stretch(found.x))
    matrix = jacobian(pose, time)
    places, turning = corners(pose)
    at, velocity, acceleration = feet(time)
    legs = places - at
    rate = np.linalg.solve(matrix, (legs * velocity).sum(axis=1))
    slip = rate[:2] + turning * rate[2] - velocity
    bias = acceleration + (places - pose[:2]) * rate[2] ** 2
    right = (legs * bias).sum(axis=1) - (slip**2).sum(axis=1)
    return pose, rate, np.linalg.solve(matrix, right)


def test_against_scipy():
    data = results("class-three", end=1.0, samples=73)
    pose = np.array([0.138, 0.212, np.radians(-67)])
    angle, speed, acceleration = (
        column(data, f"bar_{name}", "plate") for name in ("angle", "speed", "acceleration")
    )
    poses = []
    for sample, time in enumerate(data.time.to_numpy()):
        pose, rate, second = solved(pose, time)
        poses.append(pose)
        for joint, corner in zip("EFG", corners(pose)[0], strict=True):
            # residuals of 1e-17 m² over legs of 0.2 m, condition below 10
            assert place(data, joint)[:, sample] == pytest.approx(corner, abs=1e-14)
        assert np.sin(angle[sample] - pose[2]) == pytest.approx(0, abs=1e-14)
        assert speed[sample] == pytest.approx(rate[2], abs=1e-12)
        assert acceleration[sample] == pytest.approx(second[2], abs=1e-11)
    assert poses[-1] == pytest.approx(poses[0], abs=1e-14)  # the mode is kept


@pytest.mark.slow
def test_power_comes_back():
    """Over whole turns the drive does no net work, and its power is T + V's rate."""
    data = results("class-three", outputs="all")
    # the drive's work is integrated at a tolerance of 1e-10
    assert float(np.abs(data.energy_residual).max()) < 1e-10
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy[-1] == pytest.approx(energy[0], rel=1e-11)
