"""Andrews' squeezer against its motion in 50 digits."""

import numpy as np
import pytest
from library_runs import place, reference, results

EXACT = reference("andrews")
PARTS = {  # bodies in terms of the test set's angles
    "K1": ["beta"], "K2": ["beta", "theta"], "K3": ["gamma"], "K4": ["phi", "delta"],
    "K5": ["delta"], "K6": ["omega", "epsilon"], "K7": ["epsilon"],
}  # fmt: skip


def of_bodies(values):
    named = dict(zip(EXACT["order"], map(float, values), strict=True))
    return [sum(named[part] for part in parts) for parts in PARTS.values()]


@pytest.fixture(scope="module")
def data():
    return results("andrews", end=EXACT["time"], samples=31, rtol=1e-13)


def test_start(data):
    assert list(data.bar.to_numpy()) == list(PARTS)
    assert data.bar_angle[0].to_numpy() == pytest.approx(of_bodies(EXACT["angles_t0"]), abs=1e-14)
    for joint in "OABCDEFGH":
        expected = [float(value) for value in EXACT["points_t0"][joint]]
        assert place(data, joint)[:, 0] == pytest.approx(expected, abs=1e-16)


def test_end(data):
    """Two and a half turns of K1; errors of the start grow some tenfold until then."""
    angles = data.bar_angle[-1].to_numpy()
    assert angles == pytest.approx(of_bodies(EXACT["angles"]), abs=1e-11)
    speeds = data.bar_speed[-1].to_numpy()
    assert speeds == pytest.approx(of_bodies(EXACT["speeds"]), rel=1e-9)


@pytest.mark.slow
def test_energy():
    """The torque's work is in the motion and in the spring: T + ½ k (d − l)² = torque·(β − β₀)."""
    run = results("andrews", samples=301, outputs="all", rtol=1e-13)
    turned = run.bar_angle.sel(bar="K1") - run.bar_angle.sel(bar="K1")[0]
    energy = run.kinetic_energy + run.potential_energy
    work = 0.033 * turned.to_numpy()
    assert (energy - energy[0]).to_numpy() == pytest.approx(work, abs=1e-11)  # of 0.5 J
    distance = np.hypot(*(place(run, "D") - place(run, "C")))
    stored = 0.5 * 4530 * (distance - 0.07785) ** 2
    assert run.potential_energy.to_numpy() == pytest.approx(stored, abs=1e-13)
