"""`linkages.benchmark` and the verb `bench`: errors are true errors, times are not flattered."""

import json
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import linkages
from linkages.benchmark import work_precision as measuring
from linkages.benchmark.problem import (
    PEERS,
    InitialValueProblem,
    derivative,
    seconds_per_evaluation,
)
from linkages.benchmark.work_precision import TARGETS, Point, seconds_at, work_precision
from linkages.errors import ComputationError
from linkages.plots.study_figures import work_precision_figure
from linkages.solvers.integration import METHODS

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "data" / "ninebar_states.json").read_text(encoding="utf-8")
)
START = {
    "drives.crank1.angle": REFERENCE["drives"]["crank1"]["angle"],
    "drives.crank4.angle": REFERENCE["drives"]["crank4"]["angle"],
    "clearances.r1.angle": 0.0,
}
TINY = ("--set", "simulate.end=0.005", "--repeats", "1")


def points(*rows, method="m"):
    """Runs of one method from (setting, error, seconds)."""
    return [Point(method, setting, True, error, seconds, None) for setting, error, seconds in rows]


# -- time for an error -----------------------------------------------------------------------


def test_time_between_two_runs_is_interpolated_on_both_log_scales():
    runs = points((1e-4, 1e-2, 1.0), (1e-6, 1e-4, 4.0))
    assert seconds_at(runs, "m", 1e-3) == pytest.approx(2.0)
    assert seconds_at(runs, "m", 1e-4) == pytest.approx(4.0)


def test_time_for_an_error_that_is_never_reached():
    assert seconds_at(points((1e-4, 1e-2, 1.0), (1e-6, 1e-4, 4.0)), "m", 1e-5) is None
    assert seconds_at(points((1e-4, 1e-2, 1.0)), "another", 1.0) is None
    assert seconds_at([], "m", 1.0) is None


def test_time_where_every_run_is_good_enough():
    assert seconds_at(points((1e-4, 1e-2, 1.0), (1e-6, 1e-4, 4.0)), "m", 0.5) == 1.0


def test_lucky_zero_crossing_proves_nothing():
    """The loosest run meets 1e-9 by accident, as the next one shows; only the tightest counts."""
    runs = points((1e-4, 1e-10, 1.0), (1e-6, 1e-4, 2.0), (1e-8, 1e-6, 3.0), (1e-10, 1e-9, 6.0))
    assert seconds_at(runs, "m", 1e-9) == pytest.approx(6.0)
    assert seconds_at(runs, "m", 1e-6) == pytest.approx(3.0)
    assert seconds_at(runs, "m", 1e-11) is None


def test_time_does_not_fall_with_the_error():
    runs = points(
        (1e-4, 3e-2, 1.0), (1e-5, 5e-6, 1.4), (1e-6, 2e-4, 2.0), (1e-7, 1e-6, 3.1), (1e-8, 1e-9, 4)
    )
    times = [seconds_at(runs, "m", error) for error in np.geomspace(1e-2, 1e-9, 50)]
    assert (np.diff(times) >= -1e-12).all()


def test_failed_run_is_no_run():
    runs = [*points((1e-6, 1e-4, 4.0)), Point("m", 1e-4, True, None, math.nan, None, "stopped")]
    assert seconds_at(runs, "m", 1e-3) == 4.0


# -- the problem and its reference -----------------------------------------------------------


@pytest.fixture(scope="module")
def reference_problem():
    end = REFERENCE["states"][-1]["t"]
    return InitialValueProblem(linkages.load("ninebar", set=START), end)


@pytest.mark.slow
def test_reference_agrees_with_states_of_extended_precision(reference_problem):
    """Two seconds of the nine-bar against another program in more digits.

    Round-off moves the state by 1e-16 per step; the motion amplifies it about 100-fold.
    """
    expected = float(REFERENCE["states"][-1]["clearance_angle"])
    off = abs(reference_problem.exact[0] - expected)
    assert off < 1e-12
    assert reference_problem.uncertainty < 1e-12
    # the uncertainty that is claimed is about the error that there is
    assert off < 10 * reference_problem.uncertainty + 1e-13


@pytest.fixture(scope="module")
def short():
    return InitialValueProblem(linkages.load("ninebar", set=START), 0.1)


def test_error_is_measured_from_the_reference(short):
    assert short.error(short.exact) == 0.0
    assert short.error(short.exact + 1e-3) == pytest.approx(1e-3)


def test_problem_that_cannot_be_solved_says_when_and_why():
    stuck = InitialValueProblem(linkages.load("ninebar", set={"assembly.E": "left"}), 2.0)
    with pytest.raises(ComputationError, match=r"dop853 stopped at t = 1\.5\d+ s") as caught:
        stuck.solve("dop853")
    assert caught.value.time == pytest.approx(1.546, abs=1e-3)


@pytest.mark.parametrize("peer", PEERS, ids=lambda peer: peer.name)
def test_peer_agrees_within_its_tolerance(peer, short):
    """The same equations in other hands; 1e-10 per step over some hundred steps."""
    if not peer.available:
        pytest.skip(f"{peer.name} is not installed")
    solve = peer.prepare(short)
    assert short.error(solve(1e-10)) < 1e-7
    assert short.error(solve(1e-10)) < 1e-7  # a second run starts where the first one did
    assert short.error(solve(1e-13)) < 1e-10


def test_peers_name_themselves_once():
    names = [peer.name for peer in PEERS]
    assert len(set(names)) == len(names)
    assert not set(names) & set(METHODS)


def test_right_hand_side_for_peers_is_that_of_the_model(short):
    """The compiled function against the graph of scalars evaluated by NumPy."""
    system = short.system
    right_hand_side = derivative(short.flow)
    for time, state in ((0.0, [0.0, 0.0]), (0.7, [1.0, -200.0]), (1.3, [-2.0, 50.0])):
        found = right_hand_side(time, np.array(state))
        expected = system.evaluate(system.model.free_accelerations, time, np.array(state)[:, None])[
            :, 0
        ]
        assert found[0] == state[1]
        assert found[1:] == pytest.approx(expected, rel=1e-10)


def test_right_hand_side_where_nothing_can_be_assembled_is_nan():
    """A peer has no statuses; nan makes it shorten its step or fail."""
    problem = InitialValueProblem(linkages.load("ninebar"), 1.0)
    rate = derivative(problem.flow)(0.0, np.array([np.nan, 0.0]))
    assert np.isnan(rate).all()


def test_time_per_evaluation_is_that_of_compiled_code(short):
    """How long that is depends on the machine and on what else it does."""
    assert seconds_per_evaluation(short.flow, short.system.state, repeats=1) > 0


GROUP = {"drives": {}, "free": {"crank": {"angle": 0, "speed": 6}}}


@pytest.mark.slow
def test_group_solved_by_iteration_is_measured(monkeypatch):
    """With coordinates that are carried along; a peer that knows no iteration is left out."""
    problem = InitialValueProblem(linkages.load("class-three", set=GROUP), 0.1)
    assert problem.flow.carried == 4
    assert problem.uncertainty < 1e-13
    monkeypatch.setattr(measuring, "TOLERANCES", (1e-4, 1e-8))
    monkeypatch.setattr(measuring, "HALVINGS", 6)
    found = list(work_precision(problem, repeats=1, longest=math.inf))
    names = {point.method for point in found}
    assert names == {*METHODS, "scipy solve_ivp DOP853"}
    best = {name: min(p.error for p in found if p.method == name) for name in names}
    assert max(best.values()) < 1e-6
    assert seconds_per_evaluation(problem.flow, problem.system.state, repeats=1) > 0


def test_a_method_is_given_up_once_a_run_takes_too_long(short, monkeypatch):
    """By a clock of the test's own: runs take 1 s, 3 s, 5 s, …, and two make a point."""
    times = iter(np.cumsum(np.arange(100.0)))
    monkeypatch.setattr(measuring, "time", SimpleNamespace(perf_counter=lambda: next(times)))
    monkeypatch.setattr(measuring, "_peers", lambda _: ())
    monkeypatch.setattr(measuring, "ADAPTIVE_METHODS", ("dop853",))
    monkeypatch.setattr(measuring, "FIXED_STEP_METHODS", ())
    found = list(work_precision(short, repeats=1, longest=9.0))
    assert [point.seconds for point in found] == [3.0, 7.0, 11.0]


def test_right_hand_side_of_a_group_writes_within_its_memory():
    """A kernel writes what was settled behind the margins; there must be room for it."""
    problem = InitialValueProblem(linkages.load("class-three", set=GROUP), 0.1)
    state = problem.system.state
    rate = derivative(problem.flow)(0.0, state)
    count = problem.flow.coordinates
    assert rate.shape == (2 * count,)
    assert rate[:count] == pytest.approx(state[count:])
    sizes = {array.size for array in held_arrays(derivative(problem.flow))}
    assert count + 2 * len(problem.flow.margin_scale) + 2 * problem.flow.carried in sizes


def held_arrays(function):
    """Arrays that a function keeps alive, by itself or in an object that it holds."""
    held = [cell.cell_contents for cell in function.__closure__]
    held += [part for thing in held for part in getattr(thing, "__dict__", {}).values()]
    return [thing for thing in held if isinstance(thing, np.ndarray)]


def test_right_hand_side_keeps_alive_what_compiled_code_writes(short):
    """Arrays by their addresses: the kernel's own, its parameters, and what it works on."""
    function = derivative(short.flow)
    ((kernel, work),) = (
        cell.cell_contents._addresses
        for cell in function.__closure__
        if hasattr(cell.cell_contents, "_addresses")
    )
    held = {array.ctypes.data: array for array in held_arrays(function)}
    assert {kernel, work, int(held[kernel][2])} <= set(held)


def test_andrews_against_its_motion_in_50_digits():
    """The angle of K1 after 30 ms by the reference of the benchmark itself."""
    data = json.loads(
        (Path(__file__).parents[1] / "data" / "andrews.json").read_text(encoding="utf-8")
    )
    problem = InitialValueProblem(linkages.load("andrews"), float(data["time"]))
    exact = float(dict(zip(data["order"], data["angles"], strict=True))["beta"])
    assert problem.exact[0] == pytest.approx(exact, abs=1e-12)
    assert problem.uncertainty < 1e-12


def test_every_method_is_measured():
    problem = InitialValueProblem(linkages.load("ninebar", set=START), 0.004)
    found = list(work_precision(problem, repeats=1, longest=0.05))
    names = [*METHODS, *(peer.name for peer in PEERS if peer.available)]
    assert {point.method for point in found} == set(names)
    best = {name: min(p.error for p in found if p.method == name) for name in names}
    assert max(best.values()) < 1e-4
    assert len(work_precision_figure(found, "heading").axes[0].lines) == len(names)


@pytest.mark.parametrize("name", ["ninebar", "andrews"])
def test_pages_show_numbers_of_every_method(name):
    """`python docs/make bench-NAME.json` measures them anew."""
    docs = Path(__file__).parents[2] / "docs"
    content = json.loads((docs / "_static" / f"bench-{name}.json").read_text(encoding="utf-8"))
    assert {point["method"] for point in content["points"]} >= set(METHODS)
    assert content["machine"]
    assert content["date"]
    page = (docs / "benchmark.md").read_text(encoding="utf-8")
    assert all(f"| `{name}` | {METHODS[name].summary} |" in page for name in METHODS)


# -- the verb --------------------------------------------------------------------------------


@pytest.mark.slow
def test_bench_writes_its_numbers_and_a_figure(cli, tmp_path):
    result = cli("bench", "ninebar", *TINY, "--out", "found", "--json")
    assert (result.code, result.err) == (0, "")
    content = json.loads(result.out)
    assert content["files"] == [
        str(Path("found") / n) for n in ("bench.json", "work_precision.png")
    ]
    written = json.loads((tmp_path / "found" / "bench.json").read_text())
    assert json.loads(written.pop("origin")["changes"]) == content.pop("changes")
    assert written == {key: value for key, value in content.items() if key != "files"}
    assert (tmp_path / "found" / "work_precision.png").stat().st_size > 10_000
    assert content["end"] == 0.005
    assert {point["method"] for point in content["points"]} >= set(METHODS)
    assert list(content["seconds_at_error"]) == [f"{target:g}" for target in TARGETS]
    assert content["reference_uncertainty"] < 1e-12
    costs = content["costs"]
    # times are those of this machine with whatever else it does
    assert costs["compile_seconds"] > 0  # processor time
    assert costs["simulation_seconds"] > 0
    # a process with NumPy takes more than 10 MB
    assert costs["peak_bytes"] is None or costs["peak_bytes"] > 1e7


@pytest.mark.slow
def test_what_is_compiled_is_counted_where_nothing_is_cached(monkeypatch, tmp_path):
    """Processor time, whatever else the machine does: two runs need not differ by it."""
    from linkages.benchmark import work_precision as report

    runs = []
    once = report._run
    monkeypatch.setattr(report, "_run", lambda *given: runs.append(once(*given)) or runs[-1])
    file = tmp_path / "pendulum.yaml"
    file.write_text(
        "joints: {O: [0, 0]}\nbars: {rod: {joints: [O, P], length: 1, mass: 1}}\n"
        "free: {rod: {angle: 1}}\nsimulate: {end: 0.01, samples: 2}\n"
    )
    costs = report.measure_costs(str(file), ())
    cold, warm = runs
    assert costs.compile_seconds == cold["compiling"] > 0
    assert warm["compiling"] == 0


def test_bench_prints_a_table(cli, tmp_path, monkeypatch):
    """What is printed, of numbers that are not measured here."""
    from linkages.benchmark import work_precision
    from linkages.benchmark.work_precision import BenchReport, Costs

    runs = [
        *points((1e-4, 1e-4, 0.001), (1e-8, 1e-10, 0.004), method="dop853"),
        *points((1e-4, 1e-3, 0.01), method="another"),
        Point("third", 1e-3, False, None, math.nan, None, "stopped"),
    ]
    costs = Costs(5.0, 2.0, 0.1, 100 * 2**20)
    report = BenchReport("Press", 2.0, tuple(runs), 1e-14, 72e-9, costs)
    monkeypatch.setattr(work_precision, "run_benchmark", lambda *_, **__: report)
    result = cli("bench", "ninebar", "--no-figures")
    assert (result.code, result.err) == (0, "")
    for words in ("error (rad or m)", "ratio to the fastest", "72.0 ns per evaluation", "100 MiB"):
        assert words in result.out
    lines = [line.split() for line in result.out.splitlines() if line.strip()]
    assert ["dop853", "rtol", "1.0e-08", "1.0e-10", "4"] in lines
    assert any(line[:1] == ["third"] and "failed" in line for line in lines)
    (row,) = [line for line in lines if line[0] == "another" and "rtol" not in line]
    assert row == ["another", "10", "ms", "(10.0×)", "–", "–", "–"]
    files = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert files == {"bench.json"}  # and no figure
    assert json.loads((tmp_path / "results/ninebar/bench.json").read_text())["end"] == 2.0
    assert cli("bench", "ninebar", "--format", "svg").code == 0
    files = {path.name for path in tmp_path.rglob("*") if path.is_file()}
    assert files == {"bench.json", "work_precision.svg"}


def test_bench_of_a_driven_mechanism_is_refused(cli):
    says = "all coordinates are driven, so nothing is integrated"
    found = cli.refused("bench", "slider-crank", says=says, files=set())
    assert "expected a free coordinate" in found


def test_bench_of_a_file_that_is_not_there(cli):
    cli.refused("bench", "ninebra", says="ninebar")
