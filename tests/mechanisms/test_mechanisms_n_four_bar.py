"""N four-bars in a row go through the positions where all bars are in line as parallelograms."""

import numpy as np
import pytest
from library_runs import place, reference
from make import n_four_bar

import linkages

EXACT = reference("n_four_bar")
COUNTS = [1, 2, pytest.param(40, marks=pytest.mark.slow)]


@pytest.mark.parametrize("count", [1, 2, 5])
def test_both_ways_of_building_agree(count):
    built = n_four_bar.mechanism(count)
    written = linkages.loads(n_four_bar.definition(count))
    assert built.components == written.components
    assert built.name == written.name


def test_shipped_file_is_the_generators():
    assert linkages.load("n-four-bar").components == n_four_bar.mechanism(2).components


@pytest.mark.slow_except("1")
@pytest.mark.parametrize("count", COUNTS)
def test_against_the_one_coordinate(count):
    """B0 over 20 s, ten turns, through the aligned positions twice per turn."""
    outputs = ["joint_position", "joint_velocity", "bar_angle", "kinetic_energy",
               "potential_energy", "energy_residual", "closure_residual"]  # fmt: skip
    solution = linkages.simulate(
        n_four_bar.mechanism(count), end=20.0, samples=201, rtol=1e-12, outputs=outputs
    )
    data = solution.data
    post = data.bar_angle.sel(bar="post0").to_numpy()
    for row in EXACT["rows"][str(count)]:
        sample = round(10 * float(row["t"]))
        assert np.pi / 2 - post[sample] == pytest.approx(float(row["theta"]), abs=1e-8)
        expected = [float(row["B0x"]), float(row["B0y"])]
        assert place(data, "B0")[:, sample] == pytest.approx(expected, abs=1e-8)
        velocity = data.joint_velocity.sel(joint="B0")[sample].to_numpy()
        expected = [float(row["vB0x"]), float(row["vB0y"])]
        assert velocity == pytest.approx(expected, abs=5e-8)  # up to 7 m/s

    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    # forty passages, each with the round-off of close positions, in proportion to the bars
    within = 1e-11 + 4e-12 * count
    assert energy == pytest.approx(float(EXACT["energy"][str(count)]), rel=within)
    # every head stays as far from its foot as B0 from A0: no window has folded
    moved = place(data, "B0")
    for i in range(count + 1):
        assert place(data, f"B{i}") == pytest.approx(
            moved + np.array([[i], [0]]), abs=1e-12 * count
        )
    assert float(data.closure_residual.max()) <= 1e-13 * (count + 1)


@pytest.mark.parametrize("count", [1, 2])
def test_samples_in_line(count):
    """At the time at which the bars are in line for the first time, and just around it."""
    time = float(EXACT["in_line_first"][str(count)])
    data = linkages.simulate(
        n_four_bar.mechanism(count), end=2 * time, samples=3, rtol=1e-13, outputs="all"
    ).data
    assert place(data, "B0")[:, 1] == pytest.approx([1, 0], abs=1e-11)
    for name in ("bar_angle", "bar_speed", "joint_position", "joint_velocity", "energy_residual"):
        assert np.isfinite(data[name]).all(), name
