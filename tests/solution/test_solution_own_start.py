"""Simulations with sample times, an initial state and events of one's own."""

import numpy as np
import pytest
from solution_mechanisms import DOUBLE_ROCKER

import linkages

TURNING = {"rod": (0.0, 12.0)}


@pytest.mark.slow_except("slider-crank", "ninebar", "pendulum")
@pytest.mark.parametrize("name", ["slider-crank", "ninebar", "pendulum", "class-three", "andrews"])
def test_samples_are_those_of_the_same_motion_whenever_they_are_taken(name):
    """Driven or free: the motion starts at t = 0, and nothing depends on where samples lie."""
    mechanism = linkages.load(name)
    end = min(mechanism.simulation.end, 0.2)
    whole = linkages.simulate(mechanism, end=end, samples=41, outputs="all").data
    some = [11, 12, 27, 40]
    own = linkages.simulate(mechanism, times=whole.time.to_numpy()[some], outputs="all").data
    assert own.time.to_numpy() == pytest.approx(whole.time.to_numpy()[some])
    for output, values in own.items():
        expected = whole[output][some]
        if output.endswith(("residual", "_error")):
            continue  # round-off, and differences of two motions: see the next two lines
        size = 1e-9 * max(1.0, float(abs(whole[output].where(np.isfinite)).max()))
        assert float(abs(values - expected).max()) <= size, output
    for residual in ("energy_residual", "closure_residual"):
        scale = 1.0 if residual == "closure_residual" else float(abs(whole.kinetic_energy).max())
        assert float(abs(own[residual]).max()) <= 1e-6 * max(scale, 1e-3)


def test_peaks_lie_between_uneven_samples():
    times = [0.0, 0.2, 0.3, 0.7, 0.9]
    solution = linkages.simulate(linkages.load("pendulum"), times=times, outputs=["bar_speed"])
    fine = linkages.simulate(
        linkages.load("pendulum"), end=0.9, samples=9001, outputs=["bar_speed"]
    )
    (row,), (other,) = solution.maxima, fine.maxima
    assert abs(row["value"]) > abs(solution.data.bar_speed.to_numpy()).max()
    assert row["value"] == pytest.approx(other["value"], rel=1e-8)  # of the integration
    assert row["time"] == pytest.approx(other["time"], abs=1e-5)
    single = linkages.simulate(linkages.load("pendulum"), times=[0.3], outputs=["bar_speed"])
    values = solution.data.bar_speed.to_numpy()[:, 0]
    assert single.maxima[0]["value"] == pytest.approx(values[2], abs=1e-9)


def test_times_may_go_back():
    mechanism = linkages.load("pendulum")
    there = linkages.simulate(mechanism, times=[-0.5, -1.0, -2.0]).data.bar_angle.to_numpy()
    back = linkages.simulate(mechanism, end=-2.0, samples=5).data.bar_angle.to_numpy()
    assert there == pytest.approx(back[[1, 2, 4]], abs=1e-8)


@pytest.mark.slow_except("pendulum", "ninebar", "double-pendulum")
@pytest.mark.parametrize("name", ["pendulum", "ninebar", "class-three-free", "double-pendulum"])
def test_a_motion_goes_on_from_a_state_at_the_first_time(name):
    """From the state that `compile` gives at half time: same coordinates, same assembly mode."""
    mechanism = free(name)
    rhs = linkages.compile(mechanism)
    half, end = 0.1, 0.2
    middle = rhs.flow(rtol=1e-12).advance(rhs.state, 0.0, half).y
    expected = linkages.simulate(mechanism, times=[half, end], rtol=1e-12).data
    found = linkages.simulate(mechanism, times=[half, end], state=middle, rtol=1e-12).data
    count = len(rhs.state) // 2
    names = [text.rpartition(".")[0] for text in rhs.names[:count]]
    free_names = [n for n in names if n in linkages.simulate(mechanism, end=0.01).mechanism.initial]
    mapping = {
        name: (middle[names.index(name)], middle[count + names.index(name)]) for name in free_names
    }
    mapped = linkages.simulate(mechanism, times=[half, end], state=mapping, rtol=1e-12).data
    for other in (found, mapped):
        # 1e-12 per step, some 1000 steps, positions of about 1 m
        assert float(abs(other.joint_position - expected.joint_position).max()) < 1e-8
    back = linkages.simulate(mechanism, times=[half, 0.0], state=middle, rtol=1e-12).data
    start = linkages.simulate(mechanism, end=0.01, samples=2).data.joint_position[0]
    assert float(abs(back.joint_position[-1] - start).max()) < 1e-8


def free(name):
    if name != "class-three-free":
        return linkages.load(name)
    definition = linkages.load("class-three").to_yaml()
    return linkages.loads(definition.replace("drives:", "free:").replace("60 rpm", "6"))


def test_a_state_at_zero_is_that_of_with_state():
    mechanism = linkages.load("double-pendulum")
    expected = linkages.simulate(
        mechanism.with_state({"upper": (1.0, 2.0), "lower": (0.0, 0.0)}), end=0.5, samples=3
    )
    found = linkages.simulate(mechanism, end=0.5, samples=3, state={"upper": (1.0, 2.0)})
    assert found.data.equals(expected.data)  # the other one keeps its own: 0 rad, 0 rad/s


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"times": [3.0, 2.0]}, "must lead away from t = 0"),
        ({"times": [-1.0, 1.0]}, "must lead away from t = 0"),
        ({"times": []}, "times must be finite numbers"),
        ({"times": [0.0, np.nan]}, "times must be finite numbers"),
        ({"times": [0.0, 1.0, 1.0]}, "times must increase, or decrease"),
        ({"times": [0.0, 1.0], "end": 2.0}, "end and samples do not go with times"),
        ({"state": {"rd": (1, 2)}}, "'rd' is no free coordinate; did you mean 'rod'"),
        ({"state": {"rod": 1.0}}, "expected the value and the rate of rod"),
        ({"times": "now"}, "times must be finite numbers .* found 'now'"),
        ({"state": "up"}, "state must be 2 finite numbers: rod, then their rates; found 'up'"),
        ({"state": [1.0]}, "state must be 2 finite numbers: rod, then their rates"),
        ({"events": {"rod.sped": "up"}}, "event 'rod.sped=0': rod has no 'sped'; did you mean"),
        ({"events": {"rod.speed": "sideways"}}, "expected up, down or both, found 'sideways'"),
    ],
)
def test_arguments_that_make_no_sense_are_named(given, message):
    with pytest.raises(ValueError, match=message):
        linkages.simulate(linkages.load("pendulum"), **given)


def test_a_driven_mechanism_takes_no_state():
    with pytest.raises(ValueError, match="state: nothing is free to move"):
        linkages.simulate(linkages.load("slider-crank"), state={})


def test_a_state_that_cannot_be_assembled_is_named():
    with pytest.raises(ValueError, match=r"state: at t = 1 s, joint A, block \d"):
        linkages.simulate(linkages.loads(DOUBLE_ROCKER), times=[1.0, 2.0], state=[np.pi, 0.0])


def test_events_of_a_pendulum_are_at_their_times():
    """Thrown over: ω² = ω₀² + (3g/L)(−sin θ), so that speeds at given angles are known."""
    solution = linkages.simulate(
        linkages.load("pendulum").with_state(TURNING),
        end=3.0,
        events={"rod.angle=90 deg": "up", "rod.angle=-90 deg": "both", "rod.speed": "both"},
        outputs=["bar_angle", "bar_speed", "bar_acceleration", "joint_reaction"],
    )
    top, bottom, turning = solution.events.values()
    assert top.sizes["time"] >= 4
    assert len(bottom.time) in (len(top.time), len(top.time) - 1)
    assert turning.sizes["time"] == 0
    turns = 2 * np.pi * np.arange(len(top.time))
    assert top.bar_angle.to_numpy()[:, 0] == pytest.approx(np.pi / 2 + turns, abs=1e-9)
    assert top.bar_speed.to_numpy() == pytest.approx(np.sqrt(144 - 3 * 9.81), abs=1e-7)
    assert bottom.bar_speed.to_numpy() == pytest.approx(np.sqrt(144 + 3 * 9.81), abs=1e-7)
    assert top.bar_acceleration.to_numpy() == pytest.approx(0.0, abs=1e-7)
    pull = 9.81 + 0.5 * (144 + 3 * 9.81)  # of a mass of 1 kg at 0.5 m
    assert bottom.joint_reaction.sel(axis="y").to_numpy()[:, 0] == pytest.approx(pull, abs=1e-5)
    assert top.attrs["event"] == "rod.angle=90 deg"
    assert set(top.data_vars) == set(solution.data.data_vars)


@pytest.mark.parametrize("samples", [2, 2001])
def test_events_of_a_driven_motion_are_found_between_few_samples(samples):
    """Dead centres of a slider-crank are where the crank is in line with the slider's path."""
    mechanism = linkages.load("slider-crank")
    solution = linkages.simulate(
        mechanism,
        end=0.08,
        samples=samples,
        events={"piston.velocity": "both", "piston.velocity=0": "up"},
    )
    both, up = solution.events.values()
    angles = both.bar_angle.sel(bar="crank").to_numpy()
    assert np.sin(angles - angles[0]) == pytest.approx(0.0, abs=1e-9)
    assert both.slider_velocity.to_numpy() == pytest.approx(0.0, abs=1e-9)
    assert len(up.time) in (len(both.time) // 2, (len(both.time) + 1) // 2)
    accelerations = up.slider_acceleration.to_numpy()
    assert (accelerations > 0).all()


def test_events_go_on_where_free_coordinates_are_exchanged():
    """A thrown four-bar that no one coordinate describes; against sign changes of its samples."""
    text = """
gravity: [0, -9.81]
joints: {O: [0, 0], D: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.5, mass: 1}
  coupler: {joints: [A, B], length: 0.6, mass: 1}
  rocker: {joints: [D, B], length: 0.7, mass: 1}
free: {crank: {angle: 60 deg, speed: 8}}
assembly: {B: left}
"""
    solution = linkages.simulate(
        linkages.loads(text), end=1.5, samples=3001,
        events={"rocker.speed": "both"}, outputs=["bar_speed", "closure_residual"],
    )  # fmt: skip
    assert sum("exchanged" in note for note in solution.notes) >= 3
    time = solution.data.time.to_numpy()
    speed = solution.data.bar_speed.sel(bar="rocker").to_numpy()
    before = np.flatnonzero(np.sign(speed[:-1]) != np.sign(speed[1:]))
    found = solution.events["rocker.speed"]
    assert len(found.time) == len(before) >= 3
    assert (time[before] <= found.time).all()
    assert (found.time <= time[before + 1]).all()
    assert abs(found.bar_speed.sel(bar="rocker")).max() < 1e-12
    assert found.closure_residual.max() < 1e-14


PARALLELOGRAM = """
joints: {O: [0, 0], D: [2, 0]}
bars:
  crank: {joints: [O, A], length: 1, mass: 1}
  coupler: {joints: [A, B], length: 2, mass: 1}
  rocker: {joints: [D, B], length: 1, mass: 1}
free: {crank: {angle: 0.5, speed: 7}}
assembly: {B: [2.87, 0.479]}
"""


def test_events_go_on_through_change_points():
    """A parallelogram stretches twice a turn: its coupler keeps its angle all the way through."""
    solution = linkages.simulate(
        linkages.loads(PARALLELOGRAM),
        end=3.0,
        events={"crank.angle=1 rad": "up", "rocker.angle=1 rad": "up"},
    )
    assert any("change point" in note for note in solution.notes)
    times = [found.time.to_numpy() for found in solution.events.values()]
    expected = (0.5 + 2 * np.pi * np.arange(4)) / 7.0  # nothing acts: it turns steadily
    for found in times:
        assert found == pytest.approx(expected[expected < 3.0], abs=1e-7)


def test_events_that_lie_within_a_passage_are_found():
    """Crank and rocker of the parallelogram are at 0 just where it passes its change point."""
    for motion in ("free", "drives"):
        solution = linkages.simulate(
            linkages.loads(PARALLELOGRAM.replace("free", motion)),
            end=1.5,
            change_points="pass",
            events={"rocker.angle=0.0001": "up"},
        )
        times = solution.events["rocker.angle=0.0001"].time.to_numpy()
        assert times == pytest.approx([(2 * np.pi - 0.4999) / 7.0], abs=1e-6)


def test_events_are_saved_as_a_table(tmp_path):
    solution = linkages.simulate(
        linkages.load("pendulum"), end=3.0, events={"rod.speed": "up", "rod.angle": "down"}
    )
    paths = solution.save(tmp_path)
    assert [path.name for path in paths] == ["simulate.nc", "simulate.csv", "events.csv"]
    head, *rows = paths[-1].read_text(encoding="utf-8").splitlines()
    assert head == "time (s),event"
    times = [float(row.split(",")[0]) for row in rows]
    assert times == sorted(times)
    assert len(rows) == sum(len(found.time) for found in solution.events.values()) > 1
