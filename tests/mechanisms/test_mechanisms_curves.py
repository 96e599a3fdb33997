"""Coupler curves of the library's straight-line linkages and legs against computed figures."""

import numpy as np
import pytest
from library_runs import column, edited, place, reference, results
from scipy.interpolate import CubicSpline

import linkages

CURVES = reference("coupler_curves")


@pytest.mark.parametrize("row", CURVES["hoeken"], ids=lambda row: str(row["delta_beta_deg"]))
def test_hoeken(row):
    """Length and height of the line while the crank turns through its middle part."""
    mechanism = edited("hoeken", **{"2.625": row["ground"], "3.438": row["coupler"]})
    # one turn in 1 s, starting at 0: samples at every tenth of a degree
    data = linkages.simulate(mechanism, end=1.0, samples=3601, outputs=["joint_position"]).data
    middle = 1800 + np.arange(-5 * row["delta_beta_deg"], 5 * row["delta_beta_deg"] + 1)
    x, y = place(data, "P")[:, middle]
    assert np.ptp(x) / 0.04 == pytest.approx(float(row["dx"]), abs=1e-13)
    # of 160 mm, between samples
    assert 100 * np.ptp(y) / np.ptp(x) == pytest.approx(float(row["dy_percent"]), rel=1e-4)


def test_chebyshev():
    figures = CURVES["chebyshev"]
    least, largest = float(figures["y_least"]), float(figures["y_largest"])
    # From a quarter of the swing to three quarters P crosses the stroke once; the unit is 100 mm.
    data = results("chebyshev", end=0.75, samples=3001, outputs=["joint_position"])
    x, y = 10 * place(data, "P")[:, 1000:]
    assert np.all(np.diff(x) > 0)
    order = np.argsort(x)
    height = CubicSpline(x[order], y[order])
    at = np.linspace(1, 3, 2001)
    assert height(2.0) == pytest.approx(float(figures["middle"][1]), abs=1e-12)
    assert height(at).max() == pytest.approx(largest, abs=1e-10)
    assert height(at).min() == pytest.approx(least, abs=1e-12)


JOINTS = ["X", "W", "U", "V", "T", "F"]


@pytest.mark.parametrize("speed", ["30 rpm", "-30 rpm"])
def test_jansen(speed):
    """Every joint, every 15° of the crank."""
    data = results("jansen", {"drives.m.speed": speed}, end=2.0, samples=25)
    rows = {row["crank_deg"]: row for row in CURVES["jansen"]["points"]}
    sign = -1 if speed.startswith("-") else 1
    for sample in range(25):
        row = rows[sign * 15 * sample % 360]
        for joint in JOINTS:
            found = 100 * place(data, joint)[:, sample]
            # coordinates up to 100 units through four dyads; the smallest angle of one is 17°
            assert found == pytest.approx([float(v) for v in row[joint]], abs=1e-12), joint


def test_jansen_step():
    data = results("jansen", end=2.0, samples=20_001, outputs=["joint_position"])
    foot = 100 * place(data, "F")
    expected = [[float(v) for v in CURVES["jansen"][f"foot_{axis}"]] for axis in "xy"]
    # between samples of 0.018°: a curvature of some 100 units times (1.6e-4)²/8
    found = np.transpose([foot.min(axis=1), foot.max(axis=1)])
    assert found == pytest.approx(np.array(expected), abs=2e-6)


def test_klann_step():
    """The stance is 64 mm long and flat within 4 mm for half a turn of the crank."""
    data = results("klann", end=1.0, samples=361)
    x, y = 1000 * place(data, "G")[:, :360]
    stance = np.arange(-2, 179)
    assert np.ptp(x[stance]) == pytest.approx(64.194, abs=0.001)
    assert np.ptp(y[stance]) == pytest.approx(3.948, abs=0.001)
    assert y.max() - y[stance].max() > 25
    assert np.ptp(column(data, "bar_angle", "crank")) == pytest.approx(2 * np.pi)
