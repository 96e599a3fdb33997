"""Single series of outputs by name."""

import numpy as np
import pytest

import linkages
from linkages.kernel.system import System
from linkages.solution.series import data_series, find_series, system_series


@pytest.fixture(scope="module")
def solution():
    mechanism = linkages.load("ninebar", set={"simulate.end": 0.01, "simulate.samples": 3})
    return linkages.simulate(mechanism, outputs="all")


@pytest.mark.parametrize(
    ("name", "variable", "place"),
    [
        ("r1.angle", "clearance_angle", {"clearance": "r1"}),
        ("r1.force", "clearance_force", {"clearance": "r1"}),
        ("crank1.speed", "bar_speed", {"bar": "crank1"}),
        ("crank1.effort", "drive_effort", {"drive": "crank1"}),
        ("slider9.position error", "slider_position_error", {"slider": "slider9"}),
        ("B.y velocity", "joint_velocity", {"joint": "B", "axis": "y"}),
        ("B.x reaction", "joint_reaction", {"joint": "B", "axis": "x"}),
        ("E.transmission angle", "transmission_angle", {"dyad": "E"}),
        ("crank4.link7.mechanical advantage", "mechanical_advantage",
         {"drive": "crank4", "bar": "link7"}),
        ("kinetic_energy", "kinetic_energy", {}),
    ],
)  # fmt: skip
def test_names(solution, name, variable, place):
    series = find_series(data_series(solution.data), name)
    assert (series.variable, dict(series.place)) == (variable, place)
    assert find_series(system_series(solution.system), name) == series
    np.testing.assert_array_equal(series.of(solution.data), solution.data[variable].sel(place))


def test_every_series_of_the_data_has_a_name_of_its_own(solution):
    count = sum(array[0].size for array in solution.data.data_vars.values())
    assert len(data_series(solution.data)) == count + 1  # and time
    assert set(system_series(solution.system)) == set(data_series(solution.data))


def test_series_as_nodes_of_a_model(solution):
    system = System(solution.mechanism)
    names = ["r1.angle", "slider9.velocity", "B.y position", "crank4.link7.mechanical advantage"]
    known = system_series(system)
    values = system.evaluate([known[name].node(system.model) for name in names])[:, 0]
    expected = [float(known[name].of(solution.data)[0]) for name in names]
    assert values == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("r1.angel", "r1 has no 'angel'; did you mean 'r1.angle'"),
        ("slidr9.velocity", "unknown element 'slidr9'; did you mean 'slider9.velocity'"),
        ("qqq", "unknown output 'qqq'; expected a name such as crank1.angle"),
        ("nothing.angle", "expected one of: .*slider9"),
        ("r1.mass", "r1 has no 'mass'; expected angle, speed, acceleration or force"),
    ],
)
def test_unknown_names(solution, name, words):
    with pytest.raises(ValueError, match=words):
        find_series(data_series(solution.data), name)
