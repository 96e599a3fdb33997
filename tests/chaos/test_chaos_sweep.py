"""What sweeps say of points that fail, and how they end early."""

import pickle

import numpy as np
import pytest
from shared_definitions import DRIVEN_PENDULUM

import linkages
from linkages.chaos.maps import chaos_map
from linkages.errors import ComputationError, InputError, Interrupted, Problem
from linkages.sweeps.axes import parse_range
from linkages.sweeps.running import Threads, reason_of

PENDULUM = DRIVEN_PENDULUM.replace(
    '"1.15*cos(2*t/3)"', "{harmonic: {amplitude: 1.15, angular_frequency: 2/3}}"
)
PENDULUM += "simulate: {end: 10, samples: 101, rtol: 1e-8}\n"
DAMPING, AMPLITUDE = "dampers[0].damping", "loads[0].torque.harmonic.amplitude"

# Rocker 6 and link 8 fold onto each other at t = 1.546 s.
FOLDING = {"assembly.E": "left", "simulate.change_points": "stop"}


def pendulum():
    return linkages.loads(PENDULUM)


def test_reasons_say_no_times():
    early, late = (
        ComputationError(f"at t = {t} s, joint F: cannot be assembled", time=t) for t in (1.5, 2.7)
    )
    assert reason_of(early) == reason_of(late) == "joint F: cannot be assembled"
    assert reason_of(ComputationError("at t = 3 s: diverged", time=3.0)) == "diverged"
    problem = Problem(message="expected > 0, found '-1' (from set a.b=-1)", path="a.b", line=3)
    assert reason_of(InputError("m.yaml", [problem])) == "a.b: expected > 0, found '-1'"


def test_one_reason_for_all_that_stop_in_the_same_way():
    mechanism = linkages.load("ninebar", set=FOLDING)
    speeds = {"clearances.r1.speed": [0.0, 100.0, 200.0]}
    data = linkages.bifurcation(mechanism, speeds, periods=5, skip=0)
    (reason,) = set(data.reason.to_numpy().ravel())
    assert "joint F" in reason
    assert "t =" not in reason
    assert data.stop_time.to_numpy() == pytest.approx(1.546, abs=1e-3)


def test_points_before_a_stop_are_kept():
    """The period is 2.1 s: there is the first point, at the start, and no other."""
    data = linkages.bifurcation(
        linkages.load("ninebar", set=FOLDING), {"clearances.r1.speed": [0.0, 100.0]},
        periods=5, skip=0,
    )  # fmt: skip
    speed = data.clearance_speed[0, :, :, 0].to_numpy()
    assert speed[:, 0] == pytest.approx([0.0, 100.0], abs=1e-9)
    assert np.isnan(speed[:, 1:]).all()


class Elsewhere(Threads):
    """Sends tasks and results as another process would get them."""

    def run(self, task, points):
        sent = pickle.loads(pickle.dumps((task, list(points))))
        return (pickle.loads(pickle.dumps(outcome)) for outcome in super().run(*sent))


@pytest.mark.slow_except("None")
@pytest.mark.parametrize("section", [None, "r1.speed=0"])
def test_tasks_and_results_can_be_sent_to_other_processes(section):
    """Those of motions that stop, too."""
    mechanism, vary = linkages.load("ninebar", set=FOLDING), {"clearances.r1.speed": [0.0, 100.0]}
    run = {"periods": 2000, "skip": 0, "section": section}
    here = linkages.bifurcation(mechanism, vary, **run)
    there = linkages.bifurcation(mechanism, vary, **run, executor=Elsewhere())
    assert "joint F" in here.reason[0, 0].item()
    assert there.identical(here)


@pytest.mark.parametrize("run", ["map", "bifurcation", "section", "exponent"])
def test_a_slow_point_is_left_out(run):
    """A budget of steps that the first value exceeds, whose damping makes it stiff."""
    vary = {DAMPING: [1e5, 0.5]}
    given = {"max_steps": 3000}
    if run == "map":
        data = chaos_map(pendulum(), vary, {AMPLITUDE: [1.0, 1.1]}, periods=5, **given)
        reasons, values = data.reason[0].to_numpy(), data.indicator[0]
    else:
        given |= {"section": "arm.speed=0"} if run == "section" else {}
        given |= {"exponent": True, "max_steps": 10_000} if run == "exponent" else {}
        data = linkages.bifurcation(pendulum(), vary, periods=5, skip=0, **given)
        reasons = data.reason[0].to_numpy()
        values = data.exponent[0] if run == "exponent" else data.bar_speed[0, :, -1, 0]
    assert "number of steps was used up" in reasons[0]
    assert reasons[1] == ""
    assert np.isfinite(values.to_numpy()).tolist() == [False, True]


def test_ctrl_c_in_a_map_raises_and_keeps_the_points():
    def interrupt(progress):
        if progress.done == 8:  # those go side by side
            raise KeyboardInterrupt

    x, y = {AMPLITUDE: [1.0, 1.1, 1.2]}, {DAMPING: [0.4, 0.5, 0.6]}
    with pytest.raises(Interrupted, match="interrupted after 8 of 9 points") as caught:
        chaos_map(pendulum(), x, y, periods=5, executor=Threads(1), watch=interrupt)
    kept = caught.value.kept["map"]
    whole = chaos_map(pendulum(), x, y, periods=5)
    assert kept.attrs["interrupted"] == 1
    flat = kept.indicator.to_numpy().ravel()
    assert (flat[:8] == whole.indicator.to_numpy().ravel()[:8]).all()
    assert np.isnan(flat[8])
    assert kept.reason[2, 2].item() == "not computed: interrupted"


def test_axes_are_mappings_ranges_or_axes():
    x, y = [1.0, 1.1], [0.5, 0.6]
    texts = f"{AMPLITUDE}=1:1.1:2", f"{DAMPING}=0.5:0.6:2"
    found = [
        chaos_map(pendulum(), *axes, periods=4)
        for axes in (({AMPLITUDE: x}, {DAMPING: y}), texts, tuple(map(parse_range, texts)))
    ]
    assert found[0].identical(found[1])
    assert found[0].identical(found[2])
    assert found[0][AMPLITUDE].attrs["units"] == "N m"
    with pytest.raises(TypeError, match="expected a mapping of paths to values, or a range"):
        chaos_map(pendulum(), 3.0, {DAMPING: y})


def test_values_of_an_axis_are_in_the_unit_of_its_range():
    data = linkages.bifurcation(pendulum(), "free.arm.angle=10deg:20deg:2", periods=2, skip=0)
    assert data["free.arm.angle"].to_numpy().tolist() == [10, 20]
    assert data["free.arm.angle"].attrs["units"] == "deg"
    assert data.bar_angle[0, :, 0, 0].to_numpy() == pytest.approx(np.radians([10, 20]))


@pytest.mark.parametrize("name", ["poincare", "lyapunov", "bifurcation", "chaos_map"])
def test_numbers_of_periods_are_whole(name):
    vary = {DAMPING: [0.5, 0.6]}
    arguments = {"bifurcation": [vary], "chaos_map": [vary, {AMPLITUDE: [1, 2]}]}.get(name, [])
    with pytest.raises(ValueError, match=r"periods must be a whole number > 0, found 20\.5"):
        getattr(linkages, name)(pendulum(), *arguments, periods=20.5)
    with pytest.raises(TypeError, match="periods must be a number, found '20'"):
        getattr(linkages, name)(pendulum(), *arguments, periods="20")


def test_a_diagram_says_what_was_computed():
    data = linkages.bifurcation(
        pendulum(), {DAMPING: [0.5, 0.6]}, periods=2, skip=3, rtol=1e-7, section="arm.speed=0"
    )
    said = {"periods": 2, "skip": 3, "section": "arm.speed=0", "direction": "up", "start": "same",
            "method": "dop853", "rtol": 1e-7, "atol": 1e-7}  # fmt: skip
    assert {key: data.attrs[key] for key in said} == said
    data = chaos_map(pendulum(), {DAMPING: [0.5, 0.6]}, {AMPLITUDE: [1, 2]}, periods=4)
    assert (data.attrs["periods"], data.attrs["rtol"]) == (4, 1e-8)


def test_too_few_points_are_said_at_their_value():
    """A free pendulum turns back more often within a time the less it is damped."""
    text = PENDULUM.replace("amplitude: 1.15", "amplitude: 0")
    data = linkages.bifurcation(
        linkages.loads(text), {DAMPING: [0.01, 0.5]}, periods=20, skip=0,
        section="arm.speed=0",
    )  # fmt: skip
    alone = linkages.poincare(linkages.loads(text), periods=20, section="arm.speed=0")
    few, warned = data.warning[0].to_numpy().astype(bool), np.isnan(data.bar_speed[0, :, -1, 0])
    assert few.any()
    assert few.tolist() == warned.to_numpy().tolist()
    assert alone.attrs["warning"] in data.warning[0].to_numpy()


def test_values_side_by_side_are_sections_alone():
    """In all bits: beside each other, and beside one that stops."""
    mechanism = linkages.load("ninebar", set=FOLDING | {"simulate.rtol": 1e-8})
    speeds = [0.0, 30.0, 100.0, 200.0]
    given = {"periods": 3, "skip": 0}
    data = linkages.bifurcation(mechanism, {"clearances.r1.speed": speeds}, **given)
    assert (data.outcome == 3).all()
    mechanism = linkages.load("ninebar", set={"simulate.rtol": 1e-8})
    data = linkages.bifurcation(mechanism, {"clearances.r1.speed": speeds}, **given)
    assert not data.outcome.any()
    for column, speed in enumerate(speeds):
        alone = linkages.poincare(mechanism.with_values({"clearances.r1.speed": speed}), **given)
        for name in ("clearance_angle", "clearance_speed"):
            assert (data[name][0, column].to_numpy() == alone[name].to_numpy()).all()
        # a single section looks at forces more often
        least = float(data.least_force[0, column, 0])
        assert float(alone.least_force[0]) <= least + 1e-9 * abs(least)
