"""Loads as outputs: they are what acts, by name, and only where they are asked for."""

import numpy as np
import pytest
from solution_mechanisms import SLIDER_CRANK, mechanism

import linkages
from linkages.solution.series import data_series

LOADS = """\
loads:
  - {slider: piston, force: "-200 - 30*sin(9*t)"}
  - {joint: A, force: ["4*t", 7]}
  - {bar: crank, torque: {table: {times: [0, 0.1, 0.3], values: [0, 2, 1], interpolation: linear}}}
springs:
  - {between: [O, B], stiffness: 300, length: 0.1, damping: 4}
  - {between_bars: [crank, rod], stiffness: 2, angle: 0.4, damping: 0.1}
dampers: [{slider: piston, damping: 5}]
"""
TEXT = SLIDER_CRANK[: SLIDER_CRANK.index("loads:")]


@pytest.fixture(scope="module")
def data():
    return linkages.simulate(mechanism(TEXT, LOADS), end=0.4, samples=81, outputs="all").data


def test_forces_and_torques_are_the_laws(data):
    time = data.time.to_numpy()
    names = ["loads[0]", "loads[1].x", "loads[1].y"]
    assert list(data.force.to_numpy()) == names
    expected = np.array([-200 - 30 * np.sin(9 * time), 4 * time, np.full_like(time, 7)]).T
    assert data.load_force.to_numpy() == pytest.approx(expected, rel=1e-14)
    assert list(data.torque.to_numpy()) == ["loads[2]"]
    values = np.interp(time, [0, 0.1, 0.3], [0, 2, 1])
    assert data.load_torque.to_numpy()[:, 0] == pytest.approx(values, abs=1e-14)
    assert (data.load_force.attrs["units"], data.load_torque.attrs["units"]) == ("N", "N m")


def test_springs_and_dampers(data):
    """From positions and velocities: a pull is positive, the torque is that on the second bar."""
    place, velocity = (
        data[f"joint_{n}"].sel(joint="B").to_numpy() for n in ("position", "velocity")
    )
    distance = np.linalg.norm(place, axis=1)
    rate = (place * velocity).sum(axis=1) / distance
    pull = data.spring_force.sel(spring="springs[0]")
    # a few roundings of some tens of newtons
    assert pull.to_numpy() == pytest.approx(300 * (distance - 0.1) + 4 * rate, rel=1e-12, abs=1e-11)
    friction = data.spring_force.sel(spring="dampers[0]").to_numpy()
    slid = data.slider_velocity.sel(slider="piston").to_numpy()
    assert friction == pytest.approx(-5 * slid, rel=1e-12, abs=1e-12)
    turned, speed = (
        (data[name].sel(bar="rod") - data[name].sel(bar="crank")).to_numpy()
        for name in ("bar_angle", "bar_speed")
    )
    torque = data.torsional_spring_torque.sel(torsional_spring="springs[1]").to_numpy()
    turns = 2 * np.pi * np.round((turned[0] - 0.4) / (2 * np.pi))
    assert torque == pytest.approx(-2 * (turned - 0.4 - turns) - 0.1 * speed, rel=1e-12, abs=1e-11)


def test_power_of_what_acts_is_the_power_of_loads(data):
    """Forces as given out, times the velocities of what they act on."""
    force = {str(n): data.load_force.sel(force=n).to_numpy() for n in data.force.to_numpy()}
    slid = data.slider_velocity.sel(slider="piston").to_numpy()
    at = data.joint_velocity.sel(joint="A").to_numpy()
    end = data.joint_velocity.sel(joint="B").to_numpy()
    place = data.joint_position.sel(joint="B").to_numpy()
    rate = (place * end).sum(axis=1) / np.linalg.norm(place, axis=1)
    crank, rod = (data.bar_speed.sel(bar=name).to_numpy() for name in ("crank", "rod"))
    power = (
        force["loads[0]"] * slid
        + force["loads[1].x"] * at[:, 0]
        + force["loads[1].y"] * at[:, 1]
        + data.load_torque.to_numpy()[:, 0] * crank
        - 4 * rate**2
        - 0.1 * (rod - crank) ** 2
        + data.spring_force.sel(spring="dampers[0]").to_numpy() * slid
    )
    assert data.load_power.to_numpy() == pytest.approx(power, rel=1e-10, abs=1e-10)


def test_names_of_single_series(data):
    names = set(data_series(data))
    assert {"loads[0].force", "loads[1].x.force", "loads[2].torque", "springs[0].force"} <= names
    assert {"springs[1].torque", "dampers[0].force"} <= names


def test_given_loads_come_unasked_and_springs_do_not():
    found = linkages.simulate(mechanism(TEXT, LOADS), end=0.1, samples=3).data
    assert {"load_force", "load_torque"} <= set(found)
    assert not {"spring_force", "torsional_spring_torque", "spring"} & {*found, *found.dims}
    alone = linkages.simulate(
        mechanism(TEXT, LOADS), end=0.1, samples=3, outputs="load_torque"
    ).data
    assert list(alone.data_vars) == ["load_torque"]
    with pytest.raises(ValueError, match="this mechanism has no load_force"):
        linkages.simulate(mechanism(TEXT), outputs=["load_force"])


@pytest.mark.slow
def test_only_loads_that_vary_stand_in_figures_and_maxima():
    from linkages.cli.verbs.simulate_command import shown_maxima
    from linkages.plots.figures import FIGURES

    solution = linkages.simulate(mechanism(TEXT, LOADS), end=0.4, samples=81)
    rows = [row["element"] for row in shown_maxima(solution) if row["variable"] == "load_force"]
    assert rows == ["loads[0]", "loads[1].x"]
    asked = shown_maxima(solution, ["load_force"])
    assert [row["element"] for row in asked] == ["loads[0]", "loads[1].x", "loads[1].y"]
    figure = FIGURES["load_force"](solution.data, solution.mechanism)
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert [entry.split(":")[0] for entry in legend] == ["loads[0]", "loads[1].x"]
    constant = linkages.simulate(mechanism(SLIDER_CRANK), end=0.1, samples=3)
    assert FIGURES["load_force"](constant.data, constant.mechanism) is None
    assert FIGURES["load_torque"](constant.data, constant.mechanism) is None


def test_the_largest_load_is_one_that_acts():
    """A polynomial through samples beside a step finds more than the table has."""
    table = "{times: [0, 0.1, 0.11, 0.16, 0.17, 0.4], values: [0, 0, 7, 7, -3, 0]}"
    load = f"loads: [{{bar: crank, torque: {{table: {table}}}}}]"
    solution = linkages.simulate(mechanism(TEXT, load), end=0.4, samples=29)
    (row,) = [row for row in solution.maxima if row["variable"] == "load_torque"]
    assert row["value"] == float(np.abs(solution.data.load_torque).max())
    assert (row["missed"], row["value"]) == (0.0, pytest.approx(7.0, rel=1e-12))
