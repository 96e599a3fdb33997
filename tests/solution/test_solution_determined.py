"""Singular dyads that redundant constraints see through: no change point, nothing stops there."""

from pathlib import Path

import numpy as np
import pytest
import yaml

import linkages
from linkages import IncompleteError

DATA = Path(__file__).parents[1] / "data" / "redundant"
START, SPEED, CRANK = 1.0, 2.0, 0.1
IN_LINE = (np.pi - START) / SPEED
"""When the first two cranks of three are in line with their pivots."""


def three_cranks(**changes):
    path = DATA / "three-cranks.yaml"
    return linkages.load(path, set={key.replace("__", "."): v for key, v in changes.items()})


def said_of_change_points(solution):
    return [note for note in solution.notes if "change point" in note]


@pytest.mark.slow_except("stop*", "pass-4.0")
@pytest.mark.parametrize("end", [4.0, -4.0])
@pytest.mark.parametrize("change_points", [None, "stop", "pass"])
def test_three_parallel_cranks_never_stop(change_points, end):
    """Everything goes round in circles: only weight does work, and the cranks turn alike."""
    solution = linkages.simulate(
        three_cranks(), end=end, samples=1001, outputs="all", change_points=change_points
    )
    assert said_of_change_points(solution) == []
    data = solution.data
    angle = START + SPEED * data.time.to_numpy()
    for crank in ("first", "second", "third"):
        assert data.bar_angle.sel(bar=crank).to_numpy() == pytest.approx(angle, abs=1e-12)
    assert data.bar_angle.sel(bar="plate").to_numpy() == pytest.approx(0, abs=1e-12)
    weights = 0.5 * (0.5 + 0.5 + 0.4) + 1.0
    effort = 9.81 * CRANK * weights * np.cos(angle)
    # ε/m³ of accelerations at the nearest node, m = 0.015, is 7e-11
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(effort, abs=1e-9)
    assert float(data.closure_residual.max()) < 1e-13


@pytest.mark.parametrize("offset", [0.0, 1e-9, -1e-5, 1e-3])
def test_samples_at_the_aligned_position(offset):
    """The second sample lies in it, or beside."""
    data = linkages.simulate(three_cranks(), end=2 * (IN_LINE + offset), samples=3).data
    effort = 9.81 * CRANK * 1.7 * np.cos(START + SPEED * data.time.to_numpy())
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(effort, abs=1e-9)


def test_start_in_the_aligned_position():
    start = {
        "drives.first.angle": 0.0, "assembly": {"B": [0.4, 0.0], "C": [0.2, 0.2]}
    }  # fmt: skip
    found = linkages.load(DATA / "three-cranks.yaml", set=start)
    data = linkages.simulate(found).data
    angle = SPEED * data.time.to_numpy()
    assert data.bar_angle.sel(bar="third").to_numpy() == pytest.approx(angle, abs=1e-12)
    effort = 9.81 * CRANK * 1.7 * np.cos(angle)
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(effort, abs=1e-9)


@pytest.mark.slow
def test_free_cranks_go_on_even_if_told_to_stop_at_change_points():
    """There is none. Energy is kept, and all cranks turn alike for several turns."""
    found = three_cranks(drives={}, free={"first": {"angle": START, "speed": 20.0}})
    solution = linkages.simulate(
        found, end=2.0, samples=201, rtol=1e-11, outputs="all", change_points="stop"
    )
    assert said_of_change_points(solution) == []
    data = solution.data
    assert float(data.bar_angle.sel(bar="first")[-1]) > 25
    turned = data.bar_angle.sel(bar="third") - data.bar_angle.sel(bar="first")
    assert turned.to_numpy() == pytest.approx(0, abs=1e-10)
    assert float(np.abs(data.energy_residual).max()) < 1e-9


def without_third(**changes):
    plate = {"points": {"A": [0, 0], "B": [0.3, 0]}, "mass": 1, "center": [0.1, 0.05],
             "inertia": 1e-2}  # fmt: skip
    return three_cranks(
        joints={"O1": [0, 0], "O2": [0.3, 0]},
        bars={
            "first": {"joints": ["O1", "A"], "length": CRANK, "mass": 0.5},
            "second": {"joints": ["O2", "B"], "length": CRANK, "mass": 0.5}, "plate": plate,
        },
        assembly={"B": [0.354, 0.084]}, **changes,
    )  # fmt: skip


def test_two_cranks_have_a_change_point():
    with pytest.raises(IncompleteError, match="go on in two ways") as caught:
        linkages.simulate(without_third())
    assert caught.value.solution.motion.stop_time == pytest.approx(IN_LINE, abs=1e-5)
    passed = linkages.simulate(without_third(), change_points="pass")
    assert len(said_of_change_points(passed)) == 2  # at half a turn and a whole one


def test_three_pivots_in_line_keep_the_change_point():
    """All cranks are in line together: the third does not tell which way to go either."""
    found = three_cranks(
        joints__O3=[0.5, 0], bars__plate__points__C=[0.5, 0],
        assembly={"B": [0.354, 0.084], "C": [0.554, 0.084]},
    )  # fmt: skip
    assert linkages.simulate(found, end=1.0).completed
    with pytest.raises(IncompleteError, match="go on in two ways") as caught:
        linkages.simulate(found)
    assert caught.value.solution.motion.stop_time == pytest.approx(IN_LINE, abs=1e-5)


def test_a_change_point_elsewhere_still_stops():
    """A rocker that makes a parallelogram with the first crank: in line where that is upright."""
    added = {
        "joints.F": [0, 0.4], "bars.rod": {"joints": ["A", "E"], "length": 0.4},
        "bars.rocker": {"joints": ["F", "E"], "length": CRANK},
    }  # fmt: skip
    found = linkages.load(
        DATA / "three-cranks.yaml",
        set={**added, "drives.first.angle": 2.0,
             "assembly": {"B": [0.26, 0.09], "C": [0.06, 0.29], "E": [-0.04, 0.49]}},
    )  # fmt: skip
    with pytest.raises(IncompleteError, match="rod and rocker are in line") as caught:
        linkages.simulate(found)
    motion = caught.value.solution.motion
    assert motion.stop_time == pytest.approx((1.5 * np.pi - 2) / SPEED, abs=1e-5)
    data = caught.value.solution.data  # past the aligned cranks at half a turn
    assert float(data.bar_angle.sel(bar="third")[-1]) > 4.6


@pytest.mark.slow
def test_cognates_draw_one_curve():
    """Roberts: all three four-bars guide P, so that the curve is that of the first one alone."""
    solution = linkages.simulate(linkages.load(DATA / "roberts.yaml"), outputs="all")
    assert said_of_change_points(solution) == []
    data = solution.data
    assert float(data.closure_residual.max()) < 1e-13
    text = yaml.safe_load((DATA / "roberts.yaml").read_text(encoding="utf-8"))
    alone = {
        "joints": {"OA": [0, 0], "OB": [0.3, 0]},
        "bars": {name: text["bars"][name] for name in ("crank", "rocker", "coupler")},
        "assembly": {"B": text["assembly"]["B"]},
    }
    one = linkages.simulate(linkages.load(DATA / "roberts.yaml", set=alone)).data
    for joint in ("A", "B", "P"):
        found, wanted = (d.joint_position.sel(joint=joint).to_numpy() for d in (data, one))
        assert found == pytest.approx(wanted, abs=1e-12)
    # cognates turn alike: the link at OA with the coupler, the one at OC with the crank; beside the
    # change point round-off grows: speeds there scatter by 1.5e-10 with the tolerance
    for bar, other in (("left", "coupler"), ("left_coupler", "crank"), ("right_top", "crank")):
        turned = data.bar_speed.sel(bar=bar) - data.bar_speed.sel(bar=other)
        assert turned.to_numpy() == pytest.approx(0, abs=1e-9)
        assert np.sort(np.abs(turned.to_numpy()))[-4] < 1e-10


@pytest.mark.slow
def test_a_large_group_is_not_singular_because_it_is_large():
    """Eight unknowns by least squares: the determinant of the normal equations is a square."""
    solution = linkages.simulate(linkages.load(DATA / "roberts-group.yaml"))
    (block,) = solution.system.topology.solved_blocks
    assert (len(block.unknowns), block.surplus) == (8, 2)
    assert float(solution.data.closure_residual.max()) < 1e-13
    left = solution.data.bar_speed.sel(bar="left_coupler").to_numpy()
    assert left == pytest.approx(3.0, abs=1e-9)  # it turns with the crank
