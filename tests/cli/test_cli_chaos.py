"""The verbs that analyse motions: what they write and print, and what they refuse."""

import csv
import json
import os
import re

import numpy as np
import pytest
import xarray as xr
from shared_definitions import DRIVEN_PENDULUM

from linkages.cli.requests import initial_states
from linkages.cli.swept import INTERRUPTED, TOO_EARLY

PENDULUM = DRIVEN_PENDULUM + "simulate: {end: 10, samples: 11, rtol: 1e-8}\n"
PERIOD = 3 * np.pi
DAMPING = "dampers[0].damping"


@pytest.fixture
def pendulum(cli, tmp_path):
    """Run a verb on a driven pendulum, whose divergence is minus its damping."""
    (tmp_path / "m.yaml").write_text(PENDULUM)
    return lambda verb, *arguments: cli(verb, "m.yaml", *arguments)


def opened(tmp_path, name):
    with xr.open_dataset(tmp_path / f"results/m/{name}", engine="h5netcdf") as data:
        return data.load()


def rows(tmp_path, name):
    with (tmp_path / f"results/m/{name}").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


# poincare


def test_poincare_writes_a_point_for_each_period(pendulum, tmp_path):
    result = pendulum("poincare", "--periods", "8", "--skip", "2", "--phase", "0.25")
    assert (result.code, result.err) == (0, "")
    assert "8 points, one per period of 9.42478 s" in result.out
    data = opened(tmp_path, "poincare.nc")
    np.testing.assert_allclose(data["time"], PERIOD * (2.25 + np.arange(8)), rtol=1e-15)
    table = rows(tmp_path, "poincare.csv")
    assert [float(row["bar_angle[arm] (rad)"]) for row in table] == list(data["bar_angle"][:, 0])
    assert "results/m/poincare.png" in result.files


def test_geometric_section(pendulum, tmp_path):
    result = pendulum(
        "poincare", "--periods", "6", "--section", "arm.speed=0", "--direction", "down",
        "--no-wrap", "--no-figures", "--rtol", "1e-10",
    )  # fmt: skip
    assert result.code == 0
    assert "where arm.speed=0 is crossed downwards" in result.out
    # round-off of the crossing
    np.testing.assert_allclose(opened(tmp_path, "poincare.nc")["bar_speed"], 0, atol=1e-7)


def test_too_few_points_are_noted(pendulum, tmp_path):
    arguments = ("--section", "arm.speed=0", "--periods", "20", "--end", "30", "--no-figures")
    result = pendulum("poincare", *arguments)
    count = opened(tmp_path, "poincare.nc").sizes["crossing"]
    assert 0 < count < 20
    assert (result.code, result.err) == (0, "")
    note = f"{count} of 20 points: the section is not crossed more often within 30 s"
    assert f"note: {note}" in result.out
    content = json.loads(pendulum("poincare", *arguments, "--json").out)
    assert content["warning"].startswith(note)
    assert set(content["taken"]) == {"section", "direction"}


def test_enough_points_need_no_note(pendulum):
    result = pendulum("poincare", "--periods", "3", "--json", "--no-figures")
    assert json.loads(result.out)["warning"] is None


def test_a_section_that_ends_early_is_kept(cli, tmp_path):
    """Rocker 6 and link 8 fold onto each other at t = 1.546 s."""
    result = cli(
        "poincare", "ninebar", "--section", "r1.speed=0", "--periods", "5000",
        "--set", "assembly.E=left", "--out", "o",
    )  # fmt: skip
    assert result.code == 1
    assert result.err.startswith("stopped at t = 1.54")
    kept = tmp_path / "o/poincare.nc"
    assert result.err.rstrip().endswith(os.path.join("o", "poincare.nc"))
    with xr.open_dataset(kept, engine="h5netcdf") as data:
        assert (data["time"] < 1.55).all()


# phase


def test_phase_writes_two_series(pendulum, tmp_path):
    result = pendulum("phase", "--x", "arm.angle", "--y", "kinetic_energy", "--skip", "4")
    assert (result.code, result.err) == (0, "")
    data = opened(tmp_path, "phase_arm.angle_kinetic_energy.nc")
    assert data.sizes["time"] > 5000
    assert float(data["time"][0]) == pytest.approx(4, abs=1e-9)
    table = rows(tmp_path, "phase_arm.angle_kinetic_energy.csv")
    assert list(table[0]) == ["time (s)", "arm.angle (rad)", "kinetic_energy (J)"]
    assert float(table[-1]["kinetic_energy (J)"]) == float(data["kinetic_energy"][-1])
    assert "results/m/phase_arm.angle_kinetic_energy.png" in result.files


def test_phase_as_json(pendulum):
    arguments = ("--x", "arm.angle", "--y", "arm.speed", "--end", "2", "--samples", "11")
    result = pendulum("phase", *arguments, "--no-figures", "--json")
    content = json.loads(result.out)
    assert content["stopped"] is None
    assert [row["name"] for row in content["series"]] == [
        "time (s)", "arm.angle (rad)", "arm.speed (rad/s)",
    ]  # fmt: skip
    assert content["series"][0]["greatest"] == 2.0


def test_phase_of_a_motion_that_stops(cli, tmp_path):
    arguments = ("--x", "r1.angle", "--y", "slider9.velocity", "--set", "assembly.E=left")
    result = cli("phase", "ninebar", *arguments, "--out", "o")
    assert result.code == 1
    assert result.err.startswith("stopped at t = 1.54")
    with xr.open_dataset(
        tmp_path / "o/phase_r1.angle_slider9.velocity.nc", engine="h5netcdf"
    ) as data:
        assert 1.5 < float(data["time"][-1]) < 1.55


# lyapunov


def test_exponents_sum_to_the_divergence(pendulum, tmp_path):
    result = pendulum("lyapunov", "--periods", "64", "--json")
    content = json.loads(result.out)
    # the trace of the Jacobian is −0.5 everywhere; the rest is the tolerance of the integration
    assert content["sum"]["value"] == pytest.approx(-0.5, abs=1e-5)
    assert [row["index"] for row in content["exponents"]] == [1, 2]
    (row,) = content["certificate"]
    assert (row["name"], row["holds"]) == ("sum of all exponents", True)
    assert row["expected"] == pytest.approx(-0.5, abs=1e-12)  # from inertia and damping alone
    assert "results/m/lyapunov.png" in result.files
    assert float(rows(tmp_path, "lyapunov.csv")[-1]["exponent 1 (1/s)"]) == pytest.approx(
        content["exponents"][0]["value"], rel=1e-12
    )


def test_an_interval_that_counts_as_the_period_is_shown(pendulum, tmp_path):
    result = pendulum("lyapunov", "--periods", "64", "--interval", "0.05 s", "--no-figures")
    assert "over 64 intervals of 0.05 s, up to t = 3.2 s" in result.out
    attributes = opened(tmp_path, "lyapunov.nc").attrs
    assert (attributes["periods"], attributes["period"]) == (64, 0.05)
    result = pendulum("lyapunov", "--periods", "16", "--no-figures")
    assert f"exponents up to t = {16 * PERIOD:.6g} s" in result.out


def test_exponents_as_a_table(pendulum):
    result = pendulum("lyapunov", "--periods", "64", "--count", "1", "--no-figures")
    assert (result.code, result.err) == (0, "")
    assert "standard error" in result.out
    assert "Certificate" not in result.out  # nothing is known of one exponent alone
    assert "2 files in" in result.out


@pytest.mark.slow
def test_lost_exponents_are_shown(cli, tmp_path):
    (tmp_path / "m.yaml").write_text("""\
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
springs: [{slider: m, stiffness: 1}]
friction: [{slider: m, force: 1}]
free: {m: {position: 5.3}}
simulate: {end: 2}
""")
    result = cli("lyapunov", "m.yaml", "--periods", "64", "--no-figures")
    assert "1 more is −∞" in result.out
    result = cli("chaos", "m.yaml", "--periods", "200", "--skip", "10", "--no-figures")
    assert re.search(r"2, lost\W+−∞", result.out)
    content = json.loads((tmp_path / "results/m/chaos.json").read_text(encoding="utf-8"))
    assert (content["verdict"], content["exponents"], content["lost"]) == ("at rest", [0.0], 1)


@pytest.mark.slow
def test_a_violated_certificate_is_said_loudly(pendulum, monkeypatch):
    """No error of integration at all is allowed here, so that the first one violates."""
    monkeypatch.setattr("linkages.chaos.lyapunov.SMALL", 0.0)
    monkeypatch.setattr("linkages.chaos.lyapunov.STEPS", 0.0)
    shown = pendulum("lyapunov", "--periods", "64", "--no-figures").out
    assert "sum of all exponents: VIOLATED" in shown
    assert "The sum of all exponents must be -0.5" in " ".join(shown.split())
    report = json.loads(pendulum("chaos", "--quick", "--no-figures", "--json").out)
    assert report["verdict"] == "undecided"
    assert any("the exponents cannot be right" in reason for reason in report["reasons"])
    assert not report["certificate"][0]["holds"]


# bifurcation


@pytest.mark.slow
def test_bifurcation_keeps_all_points_and_says_why_some_are_missing(pendulum, tmp_path):
    """Without inertia at its end the arm cannot move: the first mass of the range fails."""
    result = pendulum(
        "bifurcation", "--vary", "masses.P=0:2:3", "--periods", "4", "--skip", "1", "--exponent",
    )  # fmt: skip
    assert result.code == 0, result.err
    data = opened(tmp_path, "bifurcation.nc")
    assert data["bar_angle"].shape == (1, 3, 4, 1)
    missing = [bool(reason) for reason in data["reason"].values[0]]
    assert missing == [True, False, False]
    assert len(rows(tmp_path, "bifurcation.csv")) == 8
    table = rows(tmp_path, "bifurcation_values.csv")
    assert [row["points"] for row in table] == ["0", "4", "4"]
    assert table[0]["exponent (1/s)"] == ""
    assert table[0]["reason"]
    assert "note: 1 value: " in result.out
    assert {"results/m/bifurcation.png", "results/m/bifurcation_rates.png"} <= result.files


def test_ranges_in_lockstep_and_named_starts(pendulum, tmp_path):
    result = pendulum(
        "bifurcation", "--vary", f"{DAMPING}=0.5:1:2", "--vary", "gravity[1]=-1:-2:2",
        "--initial", "free.arm.angle=0,free.arm.speed=1", "--initial", "free.arm.angle=1",
        "--periods", "2", "--skip", "0", "--no-figures", "--json",
    )  # fmt: skip
    assert result.code == 0, result.err
    content = json.loads(result.out)
    assert content["starts"] == ["free.arm.angle=0, free.arm.speed=1", "free.arm.angle=1"]
    data = opened(tmp_path, "bifurcation.nc")
    assert list(data["gravity[1]"]) == [-1, -2]
    assert data["bar_angle"][:, :, 0, 0].values.tolist() == [[0, 0], [1, 1]]


def test_both_directions_together(pendulum, tmp_path):
    result = pendulum(
        "bifurcation", "--vary", f"{DAMPING}=0.6:0.8:3", "--start", "both", "--periods", "3",
        "--skip", "2", "--no-figures",
    )  # fmt: skip
    assert result.code == 0, result.err
    data = opened(tmp_path, "bifurcation.nc")
    assert data["start"].values.tolist() == ["forward", "backward"]
    # the first of either begins as the file says, so that they differ at both ends
    assert not np.allclose(data["bar_angle"][0], data["bar_angle"][1], atol=1e-9)


def test_interrupted_sweep_is_kept(pendulum, tmp_path, monkeypatch):
    """Eight values go side by side: the first eight are there, the other four are not."""
    from linkages.chaos import bifurcation

    run, done = bifurcation._Request.answers, []

    def interrupted(self, first, last):
        if done:
            raise KeyboardInterrupt
        done.append(1)
        return run(self, first, last)

    monkeypatch.setattr(bifurcation._Request, "answers", interrupted)
    arguments = ("--vary", f"{DAMPING}=0.5:1:12", "--periods", "2", "--skip", "0", "--cores", "1")
    result = pendulum("bifurcation", *arguments, "--no-figures")
    where = os.path.join("results", "m", "unfinished")
    assert (result.code, result.err.strip()) == (1, f"{INTERRUPTED} {where}")
    points = [int(row["points"]) for row in rows(tmp_path, "unfinished/bifurcation_values.csv")]
    assert points == [2] * 8 + [0] * 4
    result = pendulum("bifurcation", *arguments, "--no-figures")
    assert (result.code, result.err.strip()) == (1, TOO_EARLY)


def test_sweep_without_any_result(pendulum):
    result = pendulum("bifurcation", "--vary", "masses.P=0:0:2", "--periods", "2", "--no-figures")
    assert result.code == 1
    assert "no value could be computed: " in result.err


@pytest.mark.slow_except("*-backward")
@pytest.mark.parametrize("start", ["same", "forward", "backward"])
@pytest.mark.parametrize("bounds", ["-0.2:0.2:3", "0.2:-0.2:3"])
def test_values_that_make_no_sense_do_not_stop_the_others(pendulum, tmp_path, start, bounds):
    result = pendulum(
        "bifurcation", "--vary", f"{DAMPING}={bounds}", "--start", start, "--periods", "2",
        "--skip", "0", "--no-figures",
    )  # fmt: skip
    assert result.code == 0, result.err
    table = rows(tmp_path, "bifurcation_values.csv")
    wrong = 0 if bounds.startswith("-") else 2
    assert [row["points"] for row in table] == ["0" if n == wrong else "2" for n in range(3)]
    assert "damping" in table[wrong]["reason"]


def test_values_without_a_period_do_not_stop_the_others(cli, tmp_path):
    """The frequency of the drive goes through zero, where nothing repeats."""
    harmonic = "{harmonic: {amplitude: 1, angular_frequency: 1}}"
    (tmp_path / "m.yaml").write_text(PENDULUM.replace('"1.15*cos(2*t/3)"', harmonic))
    path = "loads[0].torque.harmonic.angular_frequency"
    result = cli(
        "bifurcation", "m.yaml", "--vary", f"{path}=0:2:3", "--periods", "2", "--skip", "0",
        "--no-figures",
    )  # fmt: skip
    assert result.code == 0, result.err
    points = [row["points"] for row in rows(tmp_path, "bifurcation_values.csv")]
    assert points == ["0", "2", "2"]


def test_initial_states_are_split_at_assignments():
    found = initial_states(["free.arm.angle=1, free.arm.speed=2", "gravity=[0, -1],masses.P=2"])
    assert found == [
        {"free.arm.angle": "1", "free.arm.speed": "2"},
        {"gravity": "[0, -1]", "masses.P": "2"},
    ]


# map


@pytest.mark.slow_except("fli")
@pytest.mark.parametrize("indicator", ["exponent", "fli", "gali"])
def test_map(pendulum, tmp_path, indicator):
    result = pendulum(
        "map", "--x", "free.arm.angle=-1:1:3", "--y", f"{DAMPING}=0.5:1:2", "--periods", "5",
        "--indicator", indicator, "--json",
    )  # fmt: skip
    assert result.code == 0, result.err
    content = json.loads(result.out)
    assert (content["computed"], content["points"], content["indicator"]) == (6, 6, indicator)
    assert sum(content["rotation"]["arm"].values()) == 6
    assert opened(tmp_path, "map.nc")["indicator"].shape == (2, 3)
    table = rows(tmp_path, "map.csv")
    heads = ("free.arm.angle (rad)", f"{DAMPING} (N m s/rad)")
    places = [tuple(float(row[head]) for head in heads) for row in table]
    assert places == [(x, y) for y in (0.5, 1) for x in (-1, 0, 1)]
    assert {"results/m/map.png", "results/m/map_rotation.png"} <= result.files


def test_a_map_of_periods(pendulum, tmp_path):
    """The pendulum of Baker and Gollub with q = 2: chaotic at g = 1.15, not with more damping."""
    result = pendulum(
        "map", "--x", f"{DAMPING}=0.5:0.8:4", "--y", "masses.P=1:1.001:2", "--json",
        "--indicator", "period", "--refine", "2",
    )  # fmt: skip
    assert result.code == 0, result.err
    content = json.loads(result.out)
    assert (content["points"], content["indicator"], content["start"]) == (8, "period", "same")
    found = sum(content["periods"].values()) + content["chaotic"] + content["undecided"]
    assert found == content["computed"] + content["filled"] == 8
    assert content["chaotic"] >= 1
    assert content["periods"]["1"] >= 2
    data = opened(tmp_path, "map.nc")
    assert data["indicator"].shape == (2, 4)
    assert list(data["regime"].attrs["flag_values"]) == [0, 1, 2, 3]
    table = rows(tmp_path, "map.csv")
    assert {row["found"] for row in table} <= {"periodic", "chaotic", "undecided"}
    assert {"results/m/map.png"} <= result.files


def test_what_goes_with_periods_only_is_refused_elsewhere(pendulum):
    result = pendulum(
        "map", "--x", f"{DAMPING}=0.5:0.8:2", "--y", "masses.P=1:2:2", "--start", "forward"
    )
    assert result.code == 2
    assert "start = forward goes with the indicator 'period', and it is 'exponent'" in result.err


def test_points_of_a_map_that_make_no_sense_do_not_stop_the_others(pendulum, tmp_path):
    result = pendulum(
        "map", "--x", f"{DAMPING}=-0.2:0.2:3", "--y", "masses.P=1:2:2", "--periods", "4",
        "--no-figures",
    )  # fmt: skip
    assert result.code == 0, result.err
    assert [bool(row["reason"]) for row in rows(tmp_path, "map.csv")] == 2 * [True, False, False]


# chaos


def test_chaos_says_so_and_writes_a_page(pendulum, tmp_path):
    """The pendulum of Baker and Gollub with q = 2 and g = 1.15, which is chaotic."""
    result = pendulum("chaos", "--quick", "--format", "svg")
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith("Driven pendulum: chaotic\n- ")
    assert "mixed" in result.out
    assert "100 periods: the motion is settled from there on" in result.out
    page = (tmp_path / "results/m/chaos.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == 4  # the drawing, and three figures
    assert re.search(r'<span class="label"[^>]*>chaotic</span>', page)
    content = json.loads((tmp_path / "results/m/chaos.json").read_text(encoding="utf-8"))
    assert content["verdict"] == "chaotic"
    assert "Certificate of the Lyapunov exponents" in result.out
    assert "<td>sum of all exponents</td>" in page
    assert content["certificate"][0]["holds"]
    assert "results/m/chaos_spectrum.svg" in result.files


def test_chaos_as_json_without_figures(pendulum, tmp_path):
    (tmp_path / "m.yaml").write_text(PENDULUM.replace("Driven", '"<b>'.replace('"', "")))
    result = pendulum("chaos", "--quick", "--json", "--no-figures", "--rtol", "1e-7")
    content = json.loads(result.out)
    assert content["run"]["periods"] == 200
    assert content["run"]["skip"] == 100
    assert content["run"]["skipped"] == "the motion is settled from there on"
    assert content["run"]["period"] == pytest.approx(PERIOD)
    assert content["tighter"]["how"] == "rtol 1e-08"
    page = (tmp_path / "results/m/chaos.html").read_text(encoding="utf-8")
    assert "<b>" not in page
    assert "&lt;b&gt; pendulum" in page
    assert "base64" not in page


@pytest.mark.slow
def test_a_quick_verdict_takes_more_periods_where_it_needs_them(cli, tmp_path):
    """Three forces without a common period are never judged."""
    (tmp_path / "m.yaml").write_text("""\
name: Oscillator
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
loads: [{slider: m, force: "-m.position-m.velocity+cos(t)+cos(sqrt(2)*t)+cos(sqrt(3)*t)"}]
free: {m: {position: 1}}
simulate: {end: 1}
""")
    content = json.loads(cli("chaos", "m.yaml", "--quick", "--json", "--no-figures").out)
    assert content["verdict"] == "undecided"
    assert content["run"]["periods"] == 300


@pytest.mark.slow
def test_a_quick_verdict_on_the_nine_bar(cli):
    """200 periods do not decide how its tangents grow; 300 do, as tests of verdicts have it."""
    content = json.loads(cli("chaos", "ninebar", "--quick", "--json", "--no-figures").out)
    assert content["verdict"] == "quasi-periodic"
    assert content["closed_curves"] == 1
    assert content["run"]["periods"] == 300


# what is refused


def test_section_that_is_never_crossed(pendulum):
    result = pendulum("poincare", "--section", "arm.speed=99", "--periods", "2", "--end", "5")
    assert result.code == 1
    assert "is crossed 0 times within 5 s; expected" in result.err
    assert result.files == {"m.yaml"}
