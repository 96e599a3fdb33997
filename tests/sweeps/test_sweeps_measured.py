"""Sweeps of measures: equal to single runs in all bits, whatever computes them, and in order."""

import pickle
import random

import numpy as np
import pytest

import linkages
from linkages.kernel.system import System
from linkages.solution.measure_names import measured_series
from linkages.spec.measures import read_measure
from linkages.sweeps.driven_batch import serves
from linkages.sweeps.engine import Code
from linkages.sweeps.running import TaskOutcome, Threads, attempt

EFFORT = "max(abs(crank.effort))"
ROD = "bars.rod.length"


class Shuffled(Threads):
    """Computes tasks in any order, as another process would get them."""

    def run(self, task, points):
        order = list(enumerate(points))
        random.Random(1).shuffle(order)
        task = pickle.loads(pickle.dumps(task))
        for index, point in order:
            outcome = attempt(task, index, point)
            yield TaskOutcome(index, pickle.loads(pickle.dumps(outcome.value)), outcome.reason)


def single(mechanism, path, value, measure):
    # the work, from which residuals follow, would be integrated with the motion, in other steps
    outputs = ["joint_reaction"] if "reaction" in measure else None
    solution = linkages.simulate(mechanism.with_values({path: value}), outputs=outputs)
    return linkages.measure(solution, measure)


CASES = [
    ("slider-crank", ROD, "uniform(120 mm, 160 mm)", EFFORT),
    ("slider-crank", "bars.crank.mass", "uniform(0.5, 1)", "rms(crank.effort) + 1 N m"),
    ("slider-crank", ROD, "uniform(120 mm, 160 mm)", "max(abs(B.y reaction))"),
    ("four-bar", "bars.rocker.length", "uniform(120 mm, 125 mm)", "range(rocker.angle)"),
    ("scotch-yoke", "drives.crank.speed", "uniform(1, 2)", "mean(kinetic_energy)"),
    ("toggle-press", "drives.crank.speed", "uniform(5, 6)", "max(ram.velocity)*final(t)"),
    ("pendulum", "free.rod.angle", "uniform(0.1, 0.5)", "max(rod.speed)"),
]


def cases():
    for name, path, distribution, measure in CASES:
        yield pytest.param(name, path, distribution, measure, id=f"{name}-{measure}")


@pytest.mark.parametrize(("name", "path", "distribution", "measure"), [*cases()])
def test_a_sweep_equals_single_runs_in_all_bits(name, path, distribution, measure):
    mechanism = linkages.load(name)
    data = linkages.sweep(mechanism, {path: distribution}, measure, draws=4, seed=1)
    assert not data.outcome.any(), data.reason.to_numpy()
    unit = data[path].attrs["units"] if "mm" in distribution else ""
    values = [f"{value!r} {unit}" if unit else value for value in data[path].to_numpy().tolist()]
    name = measure.replace("/", "÷")
    assert data[name].to_numpy().tolist() == [
        single(mechanism, path, value, measure) for value in values
    ]


DRAG_LINK = """
joints: {O: [0, 0], C: [60 mm, 0]}
bars:
  crank: {joints: [O, A], length: 120 mm}
  coupler: {joints: [A, B], length: 110 mm}
  follower: {joints: [C, B], length: 130 mm}
drives: {crank: {angle: 0.3, speed: 10}}
assembly: {A: [0.11, 0.03], B: [0.08, 0.12]}
simulate: {end: 2, samples: 301}
"""


@pytest.mark.parametrize(
    "measure", ["final(follower.angle)", "max(follower.angle)", "at(1.2345, follower.angle)"]
)
def test_dependent_angles_count_whole_turns_in_sweeps(measure):
    """Ground is the shortest of four: both of its neighbours go round, more than three times."""
    mechanism = linkages.loads(DRAG_LINK)
    lengths = [0.105, 0.11, 0.115]
    path = "bars.coupler.length"
    data = linkages.sweep(mechanism, {path: lengths}, measure)
    found = data[measure].to_numpy().tolist()
    assert found == [single(mechanism, path, value, measure) for value in lengths]
    assert min(found) > 10.0  # 2 s are 20 rad of the crank
    assert serves(System(mechanism), measured_series(System(mechanism), read_measure(measure)))


TABLE_DRIVE = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 1}
  rod: {joints: [A, B], length: 140 mm, mass: 1}
sliders: {piston: {joint: B, through: O, mass: 1}}
drives: {crank: {law: {table: {times: [0, 0.5, 1], values: [0 deg, 60 deg, 0 deg], OPTIONS}}}}
assembly: {B: [0.18, 0]}
simulate: {end: 1, samples: 41}
"""


@pytest.mark.slow_except("bars*true", "*values2-*pchip")
@pytest.mark.parametrize("options", ["periodic: true", "interpolation: pchip"])
@pytest.mark.parametrize(
    ("path", "values"),
    [
        (ROD, ["140 mm", "150 mm", "140 mm"]),
        ("drives.crank.law.table.values[1]", ["50 deg", "60 deg", "50 deg"]),
        ("drives.crank.law.table.times[1]", ["0.4 s", "0.5 s", "0.6 s"]),
    ],
)
def test_sweeps_of_driven_tables_equal_single_runs(path, values, options):
    """Each copy has the numbers of its own table, also at extremes between samples."""
    mechanism = linkages.loads(TABLE_DRIVE.replace("OPTIONS", options))
    measures = [EFFORT, "max(abs(piston.velocity))", "at(0.333, piston.position)"]
    data = linkages.sweep(mechanism, {path: values}, measures)
    for measure in measures:
        wanted = [single(mechanism, path, value, measure) for value in values]
        assert data[measure].to_numpy().tolist() == wanted
    first = read_measure(EFFORT)
    assert serves(System(mechanism), measured_series(System(mechanism), first))


@pytest.mark.slow
def test_tolerances_and_global_searches_take_tables_on_drives():
    mechanism = linkages.loads(TABLE_DRIVE.replace("OPTIONS", "periodic: true"))
    varied = mechanism.with_values({ROD: "140 ± 0.1 mm"})
    found = linkages.tolerance(varied, "at(0.5, piston.position)", draws=100)
    assert float(found["computed"][0]) == 100
    best = linkages.optimise(
        mechanism, {"drives.crank.law.table.values[1]": ("50 deg", "70 deg")},
        minimise="abs(at(0.5, crank.angle) - 1.1 rad)", search="global", seed=1, runs=60,
    )  # fmt: skip
    assert float(best.data["number"][1, 0]) == pytest.approx(1.1, abs=0.01)


def test_results_do_not_depend_on_cores_chunks_or_order(monkeypatch):
    from linkages.sweeps import point_measures as measured

    mechanism = linkages.load("slider-crank")
    over = {ROD: "normal(140 mm, 20 mm)", "bars.crank.length": [0.03, 0.045]}
    asked = {"draws": 40, "seed": 2}

    def found(**how):
        return linkages.sweep(mechanism, over, [EFFORT, "mean(crank.effort)"], **asked, **how)

    one = found(cores=1)
    assert found(cores=3).identical(one)
    monkeypatch.setattr(measured, "TOGETHER", (7, 7))
    assert found(cores=2).identical(one)
    assert found(executor=Shuffled()).identical(one)


def test_points_that_do_not_differ_have_the_same_measures():
    mechanism = linkages.load("slider-crank")
    same = linkages.sweep(mechanism, {(ROD, "bars.rod.mass"): [[0.14, 0.5]] * 9}, EFFORT)
    assert not same.outcome.any()
    assert (same[EFFORT] == single(mechanism, ROD, 0.14, EFFORT)).all()


def test_more_draws_do_not_change_the_first():
    mechanism = linkages.load("slider-crank")
    few, many = (
        linkages.sweep(mechanism, {ROD: "normal(140 mm, 1 mm)"}, EFFORT, draws=draws)
        for draws in (5, 12)
    )
    assert many[EFFORT].isel(draw=slice(5)).equals(few[EFFORT])


def test_failures_are_data():
    """The first value, too; each has the code and the reason that it has alone."""
    mechanism = linkages.load("slider-crank")
    rods = [-1.0, 0.02, 0.03, 0.039, 0.14]
    data = linkages.sweep(mechanism, {ROD: rods}, {"effort": EFFORT})
    outcomes = [Code(code).words for code in data.outcome.to_numpy()]
    assert outcomes == ["invalid", "stopped", "stopped", "stopped", "computed"]
    assert np.isnan(data.effort.to_numpy()[:4]).all()
    assert data.effort.to_numpy()[4] == single(mechanism, ROD, 0.14, EFFORT)
    reasons = data.reason.to_numpy()
    assert "expected a length > 0" in reasons[0]
    assert reasons[4] == ""
    assert len(set(reasons[1:4])) == 1
    # the crank of 40 mm is perpendicular to the rod's reach where sin of its angle is rod/crank
    angle = np.arcsin(np.array(rods[1:4]) / 0.04)
    speed = 1500 * 2 * np.pi / 60
    assert data.stop_time.to_numpy()[1:4] == pytest.approx(angle / speed, rel=1e-9)
    assert not linkages.sweep(mechanism, {ROD: rods[::-1]}, EFFORT).outcome.to_numpy()[0]


def test_a_mechanism_that_cannot_be_assembled_is_told_from_a_wrong_value():
    mechanism = linkages.load("four-bar")
    data = linkages.sweep(mechanism, {"bars.rocker.length": [0.9, 0.12, -1]}, "max(rocker.speed)")
    words = [Code(code).words for code in data.outcome.to_numpy()]
    assert words == ["not_assembled", "computed", "invalid"]


def test_budgets():
    mechanism = linkages.load("pendulum")
    angles = {"free.rod.angle": [0.1, 0.5]}
    data = linkages.sweep(mechanism, angles, "max(rod.speed)", max_steps=5)
    assert (data.outcome == Code.OVER_BUDGET).all()
    assert "max_steps" in data.reason.to_numpy()[0]
    assert (data.evaluations > 0).all()
    data = linkages.sweep(
        mechanism, angles, "max(rod.speed)", end=1e6, samples=2, time_per_point=1e-9
    )
    assert (data.outcome == Code.OVER_TIME).all()


def test_division_by_zero_is_an_outcome():
    mechanism = linkages.load("slider-crank")
    data = linkages.sweep(mechanism, {ROD: [0.14, 0.15]}, "1/(max(t) - max(t))")
    assert (data.outcome == Code.UNDEFINED).all()
    assert "divides by zero" in data.reason.to_numpy()[0]


def test_units_and_names():
    mechanism = linkages.load("slider-crank")
    over = {ROD: ["130 mm", "140 mm"], "bars.crank.mass": "normal(0.8, 0.01)"}
    data = linkages.sweep(mechanism, over, {"peak": EFFORT, "stroke": "stroke(piston.position)"},
                          draws=3)  # fmt: skip
    assert data.peak.dims == (ROD, "draw")
    assert data.peak.attrs["units"] == "N m"
    assert data[ROD].attrs["units"] == "mm"
    assert data["bars.crank.mass"].attrs["units"] == "kg"
    assert data["bars.crank.mass"].dims == ("draw",)
    assert data.stroke.to_numpy() == pytest.approx(0.08, rel=1e-11)


def test_progress_counts_failures():
    mechanism, seen = linkages.load("slider-crank"), []
    linkages.sweep(mechanism, {ROD: [0.02, 0.14]}, EFFORT, watch=seen.append)
    assert (seen[-1].done, seen[-1].total, seen[-1].failures) == (2, 2, {"stopped": 1})
    assert seen[-1].rate > 0


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"measure": "max(crank.efort)"}, "did you mean 'crank.effort'"),
        ({"measure": []}, "nothing is measured"),
        ({"sequence": "halton"}, "sequence must be"),
        ({"time_per_point": 0.0}, "time_per_point must be"),
        ({"cores": 2, "executor": Threads(1)}, "expected one of them"),
        ({"end": 0.0}, "end must be"),
    ],
)
def test_contradictions_are_refused(how, message):
    mechanism = linkages.load("slider-crank")
    given = {"measure": EFFORT, **how}
    with pytest.raises(ValueError) as caught:  # noqa: PT011
        linkages.sweep(mechanism, {ROD: [0.13, 0.14]}, **given)
    assert message in str(caught.value)
