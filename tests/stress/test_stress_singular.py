"""How close to a singular position a motion can come, and what is reported."""

import math

import numpy as np
import pytest
from stress_mechanisms import CLOSURE, defined

import linkages
from linkages import IncompleteError
from linkages.kernel.dyads import LEAST_MARGIN

CRANK, COUPLER, GROUND = 0.04, 0.12, 0.1
OUTPUTS = ["joint_position", "closure_residual", "energy_residual", "bar_speed"]


def rocker_for(margin):
    """Length at which coupler and rocker, folded, miss each other by an angle of that sine.

    They are closest where the crank lies along the ground and A is `GROUND - CRANK` from O4: the
    law of cosines there.
    """
    gap = GROUND - CRANK
    return COUPLER * math.sqrt(1 - margin**2) - math.sqrt(gap**2 - (COUPLER * margin) ** 2)


def four_bar(margin, *sections):
    text = (
        f"joints: {{O2: [0, 0], O4: [{GROUND}, 0]}}\n"
        f"bars:\n  crank: {{joints: [O2, A], length: {CRANK}, mass: 0.2}}\n"
        f"  coupler: {{joints: [A, B], length: {COUPLER}, mass: 0.01}}\n"
        f"  rocker: {{joints: [O4, B], length: {rocker_for(margin)!r}, mass: 0.01}}\n"
        "assembly: {B: left}\n"
    )
    return defined("".join([text, *(f"{section}\n" for section in sections)]))


DRIVEN = "drives: {crank: {angle: -1, speed: 2}}"
FREE = "free: {crank: {angle: -1, speed: 20}}"


def least_margin(data):
    """Least sine of the angle between coupler and rocker at the samples."""
    a, b, o = (data.joint_position.sel(joint=joint).to_numpy() for joint in ("A", "B", "O4"))
    first, second = b - a, b - o
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return np.abs(cross).min() / (COUPLER * np.linalg.norm(second[0]))


@pytest.mark.parametrize("margin", [1e-2, 1e-3, 1e-4, 3e-5])
def test_driven_dyad_passes_close_to_its_change_point(margin):
    """Sampled where it is closest, after half the time; positions close to round-off even there."""
    data = linkages.simulate(four_bar(margin, DRIVEN), end=1.0, samples=201, outputs=OUTPUTS).data
    assert data.sizes["time"] == 201
    # ε/m is what is left of the digits of an angle near its extreme
    assert least_margin(data) == pytest.approx(margin, rel=1e-9 / margin)
    assert float(data.closure_residual.max()) <= CLOSURE
    # Work by quadrature across a peak of the driving torque that is m wide in time.
    assert np.isfinite(data.bar_speed).all()


@pytest.mark.parametrize("margin", [9e-6, 1e-6, 1e-8])
@pytest.mark.parametrize("samples", [2, 200])
def test_driven_dyad_too_close_is_reported_as_singular(margin, samples):
    with pytest.raises(IncompleteError) as caught:
        linkages.simulate(four_bar(margin, DRIVEN), end=1.0, samples=samples)
    # On its way there; the crank is in line after 0.5 s.
    assert caught.value.time == pytest.approx(0.5, abs=LEAST_MARGIN)
    for words in ("joint B", "block 0", "coupler and rocker are in line", "singular"):
        assert words in str(caught.value)
    assert (caught.value.solution.data.time < caught.value.time).all()


@pytest.mark.slow_except("*-dop853")
@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5"])
@pytest.mark.parametrize("margin", [1e-2, 1e-3, 1e-4])
def test_free_motion_passes_close_to_its_change_point(margin, method):
    """A crank that turns by its own inertia; nothing adds energy or takes it away.

    Where links are nearly in line the rocker is thrown around: its speed grows as 1/m. Round-off
    of accelerations there, some ε/m³, is what the balance of energy can be held to.
    """
    solution = linkages.simulate(
        four_bar(margin, FREE), end=0.12, samples=401, outputs=OUTPUTS, method=method, throw=False
    )
    assert solution.completed, solution.motion.failure
    data = solution.data
    assert float(data.closure_residual.max()) <= CLOSURE
    turned = data.bar_speed.sel(bar="crank").to_numpy()
    assert (turned > 0).all()
    energy = 0.5 * 0.2 * 0.04**2 / 3 * 400
    assert float(np.abs(data.energy_residual).max()) < (1e-7 + 1e-15 / margin**3) * energy


@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5"])
def test_free_motion_too_close_may_pass_as_a_change_point(method):
    """Six digits of the angle are left: what such links do cannot be told from the exact ones."""
    found = four_bar(1e-6, FREE)
    solution = linkages.simulate(
        found, end=0.12, samples=401, method=method, change_points="pass", outputs="all"
    )
    assert any("change point" in note for note in solution.notes)
    data = solution.data
    assert float(data.closure_residual.max()) <= CLOSURE
    energy = 0.5 * 0.2 * 0.04**2 / 3 * 400
    assert float(np.abs(data.energy_residual).max()) < 1e-7 * energy


@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5"])
def test_free_motion_too_close_is_reported_as_singular(method):
    found = four_bar(1e-6, FREE)
    solution = linkages.simulate(
        found, end=0.12, samples=401, method=method, change_points="stop", throw=False
    )
    assert not solution.completed
    for words in ("joint B", "are in line", "singular"):
        assert words in solution.motion.failure
    assert (solution.data.time < solution.motion.stop_time).all()
    assert all(np.isfinite(solution.data[name]).all() for name in solution.data)
    assert float(solution.data.closure_residual.max()) <= CLOSURE
