"""``orbit`` and ``follow``: what they print and write, labelled points, and stores."""

import json
import os
import signal
import subprocess
import sys
import time
from csv import DictReader
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import linkages
from linkages.cli import terminal
from linkages.kernel.system import System
from linkages.opened import Opened
from linkages.plots.chaos.diagrams import locus_curves
from linkages.sweeps.store import CHUNKS

W, C = 0.8, 0.1
GRAZING = float(np.hypot(1.0 - W**2, C * W))
"""Amplitude of the force at which the mass of x'' + c x' + x = A cos(w t) reaches 1."""

OSCILLATOR = "impact-oscillator"
FOLLOW = ("follow", OSCILLATOR, "--vary", "parameters.A=0.3:1", "--largest-step", "0.2")


@pytest.fixture(scope="module")
def branches(tmp_path_factory):
    """The file of branches of the impact oscillator, as the command writes it."""
    folder = tmp_path_factory.mktemp("branches")
    arguments = [sys.executable, "-m", "linkages", *FOLLOW, "--no-figures"]
    subprocess.run(arguments, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return folder / "results" / OSCILLATOR / "follow.nc"


def found(result):
    assert result.code == 0, result.err
    assert not result.err
    return json.loads(result.out)


def test_an_orbit_without_impacts_is_the_closed_form(cli, tmp_path):
    """x = Re(A exp(iwt)/(1 − w² + icw)); multipliers exp(λT), λ the roots of λ² + cλ + 1."""
    said = found(cli("orbit", OSCILLATOR, "--set", "parameters.A=0.3", "--json"))
    period = 2 * np.pi / W
    assert said["period"] == pytest.approx(period, rel=1e-15)
    assert (said["periods"], said["contacts"], said["stable"], said["zeros"]) == (1, 0, True, 0)
    swing = 0.3 / (1 - W**2 + 1j * C * W)
    expected = {"mass.position": swing.real, "mass.velocity": (1j * W * swing).real}
    assert said["state"].keys() == expected.keys()
    for name, value in expected.items():
        assert said["state"][name] == pytest.approx(value, abs=1e-9)  # the file's rtol is 1e-10
    roots = np.exp(np.roots([1.0, C, 1.0]) * period)
    multipliers = [complex(*pair) for pair in said["multipliers"]]
    assert sorted(multipliers, key=np.imag) == pytest.approx(sorted(roots, key=np.imag), abs=1e-9)
    assert said["reason"].startswith("the largest multiplier has the magnitude")
    assert max(said["multiplier_errors"]) < 1e-8
    assert max(said["residual"], said["state_change"]) < 1e-8
    names = {"orbit.nc", "orbit.csv", "orbit.png", "orbit_multipliers.png", "orbit_time.png",
             "orbit_positions.png"}  # fmt: skip
    assert {path.rpartition("/")[2] for path in said["files"]} == names
    folder = tmp_path / "results" / OSCILLATOR
    with (folder / "orbit.csv").open() as file:
        rows = list(DictReader(file))
    times = np.array([float(row["time (s)"]) for row in rows])
    places = np.array([float(row["mass.position (m)"]) for row in rows])
    assert times[[0, -1]] == pytest.approx([0.0, period])
    # interpolated between steps
    np.testing.assert_allclose(places, (swing * np.exp(1j * W * times)).real, atol=1e-8)


def test_several_starts_find_both_orbits_below_grazing(cli):
    """A silent and a knocking motion coexist at w = 1.2, A = 0.3 < 0.456."""
    at = ("--set", "parameters.w=1.2", "--set", "parameters.A=0.3")
    said = found(cli("orbit", OSCILLATOR, *at, "--starts", "8", "--json", "--no-figures"))
    assert [one["contacts"] for one in said["orbits"]] == [0, 1]
    assert all(one["stable"] for one in said["orbits"])
    assert {key: said[key] for key in said["orbits"][0]} == said["orbits"][0]
    shown = cli("orbit", OSCILLATOR, *at, "--starts", "8", "--no-figures")
    assert "2 orbits" in shown.out
    assert "Orbit 2: stable orbit of 5.23599 s, one period of the drives, 1 contact" in shown.out


def test_a_state_is_read_with_its_unit(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\n"
        "bars: {rod: {joints: [O, P], length: 1, mass: 1}}\n"
        "free: {rod: {angle: -90 deg}}\nsimulate: {end: 20}\n"
    )
    short = ("orbit", "m.yaml", "--json", "--no-figures", "--skip", "0")
    degrees, radians = (
        found(cli(*short, "--state", f"rod.angle={text}")) for text in ("-60 deg", "-60*pi/180")
    )
    assert degrees["state"] == radians["state"]
    assert degrees["period"] > 2 * np.pi / np.sqrt(1.5 * 9.81)  # that of small swings
    with xr.open_dataset(tmp_path / "results/m/orbit.nc", engine="h5netcdf") as data:
        assert json.loads(data.attrs["options"])["state"] == ["rod.angle=-60*pi/180"]
    again = linkages.open(tmp_path / "results/m/orbit.nc")
    xr.testing.assert_equal(again.compute(), again.data)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("mass.positon=1", "found no coordinate 'mass.positon'; did you mean 'mass.position'?"),
        ("mass.position", "expected NAME=VALUE, found 'mass.position'"),
        ("mass.position=1 rad", "expected a number in m, or another unit of it, found '1 rad'"),
        ("mass.position=much", "expected a number, found 'much'"),
    ],
)
@pytest.mark.parametrize("command", [("orbit", OSCILLATOR), FOLLOW], ids=["orbit", "follow"])
def test_a_state_that_is_none_is_refused(command, text, expected, cli):
    result = cli(*command, "--state", text)
    assert result.code == 2
    assert result.err.startswith("--state: 1 problem\n")
    assert expected in result.err
    assert result.files == frozenset()


def test_branches_are_told_with_their_special_points(branches, cli, tmp_path):
    said = found(cli(*FOLLOW, "--json"))
    assert said["parameter"] == "parameters.A"
    labels = {point["label"]: point for point in said["points"]}
    assert [point["kind"] for point in said["points"]] == ["grazing", "period doubling"]
    assert labels["G1"]["value"] == pytest.approx(GRAZING, rel=1e-9)
    assert labels["G1"]["about"] == "stops[0].upper: touch"
    assert labels["PD1"]["value"] == pytest.approx(0.518209866616, rel=1e-9)
    assert labels["PD1"]["period"] == pytest.approx(2 * np.pi / W)
    (branch,) = said["branches"]
    assert (branch["what"], branch["periods"], branch["parent"]) == ("orbits", 1, None)
    assert [end["reason"] for end in branch["ends"]] == ["range", "range"]
    values, stable = np.array(branch["points"]), np.array(branch["stable"])
    assert values[[0, -1]] == pytest.approx([0.3, 1.0])
    away = np.abs(values[:, None] - [labels["G1"]["value"], labels["PD1"]["value"]]).min(1) > 1e-6
    assert (stable == ((values < GRAZING) | (values > labels["PD1"]["value"])))[away].all()
    assert said["notes"] == []
    with (tmp_path / "results" / OSCILLATOR / "follow.csv").open() as file:
        rows = list(DictReader(file))
    assert [float(row["parameters.A"]) for row in rows] == branch["points"]
    assert [row["label"] for row in rows if row["label"]] == ["G1", "PD1"]
    assert {path.rpartition("/")[2] for path in said["files"]} == {
        "follow.nc", "follow.csv", "follow.png",
    }  # fmt: skip
    # another process finds the same bits
    with xr.open_dataset(branches, engine="h5netcdf") as data:
        assert data["value"].to_numpy().ravel().tolist() == branch["points"]


def test_what_is_printed_has_the_units_of_the_file(cli):
    shown = cli(
        "follow", "contact-slider-crank", "--vary", "clearances.gap.size=0.12mm:0.1185mm",
        "--no-unstable", "--skip", "300", "--no-figures",
    )  # fmt: skip
    assert shown.code == 0, shown.err
    assert "PD1    period doubling  0.119315175" in shown.out  # docs/contact_published.md
    assert " mm " in shown.out.splitlines()[3]
    assert "the branch has lost its stability" in shown.out


def test_equilibria_have_no_period(cli, tmp_path):
    """Without torque φ = −90° is at rest, its eigenvalues those of θ'' + 0.1 θ' + θ."""
    (tmp_path / "m.yaml").write_text(
        "gravity: [0, -1]\nparameters: {m: 0.0}\njoints: {O: [0, 0]}\n"
        "bars: {rod: {joints: [O, P], length: 1, mass: 1, center: 1, inertia: 0}}\n"
        "dampers: [{bars: [ground, rod], damping: 0.1}]\nloads: [{bar: rod, torque: m}]\n"
        "free: {rod: {angle: -90 deg}}\nsimulate: {end: 200, rtol: 1e-10}\n"
    )
    vary = ("--vary", "parameters.m=0:1.1", "--what", "equilibria")
    said = found(cli("follow", "m.yaml", *vary, "--json"))
    (fold,) = said["points"]
    assert (fold["kind"], fold["period"]) == ("fold", None)
    assert fold["value"] == pytest.approx(1.0, rel=1e-11)  # sin φ ≤ 1
    (branch,) = said["branches"]
    assert branch["what"] == "equilibria"
    assert branch["points"][-1] == pytest.approx(0.0, abs=1e-12)  # upright
    assert (branch["stable"][0], branch["stable"][-1]) == (True, False)


# -- labelled points -------------------------------------------------------------------------


def test_every_command_takes_a_labelled_point(branches, cli, tmp_path):
    said = found(cli("simulate", str(branches), "--at", "G1", "--end", "20", "--json"))
    (largest,) = [row for row in said["maxima"] if row["variable"] == "slider_position"]
    assert largest["greatest"] == pytest.approx(1.0, abs=1e-9)  # grazes the stop
    # of a symmetric orbit; impacts move it by the square root of round-off
    assert largest["least"] == pytest.approx(-1.0, abs=1e-4)
    assert said["files"][0].startswith("results/follow-G1/")
    opened = linkages.open(tmp_path / "results/follow-G1")
    values = opened.mechanism.definition.content["parameters"]
    assert float(values["A"]) == pytest.approx(GRAZING, rel=1e-9)
    page = cli("check", str(branches), "--at", "PD1")
    assert page.code == 0, page.err
    assert "with parameters.A = 0.518209866" in page.out


def test_a_search_begins_at_the_labelled_point_itself(branches, cli):
    """Unstable orbits are not left before Newton's method begins; a bifurcation is undecided."""
    said = found(cli("orbit", str(branches), "--at", "PD1", "--json", "--no-figures"))
    assert said["multipliers"][0] == pytest.approx([-1.0, 0.0], abs=1e-8)
    assert not said["stable"]
    assert said["reason"].endswith("which is 1 within its error: a bifurcation")
    near = cli(
        "orbit", str(branches), "--at", "PD1", "--set", "parameters.A=0.45", "--json",
        "--no-figures",
    )  # fmt: skip
    unstable = found(near)
    assert (unstable["periods"], unstable["contacts"], unstable["stable"]) == (1, 1, False)
    assert unstable["multipliers"][0][0] < -1.5


def test_results_at_a_point_are_kept_beside_the_branches(branches, cli, tmp_path):
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "follow.nc").write_bytes(branches.read_bytes())
    (folder / "other.nc").write_bytes(branches.read_bytes())
    result = cli("poincare", "here", "--at", "PD1", "--periods", "3", "--no-figures")
    assert result.code == 0, result.err
    assert {"here/follow.nc", "here/PD1/poincare.nc"} <= result.files
    with xr.open_dataset(folder / "PD1/poincare.nc", engine="h5netcdf") as data:
        places = data["slider_position"].to_numpy().ravel()
    np.testing.assert_allclose(places, places[0], atol=1e-9)


@pytest.mark.parametrize(
    ("file", "label", "expected"),
    [
        ("", "PD7", "found no point 'PD7'; labelled points: G1, PD1"),
        ("", "", "found no point ''; labelled points: G1, PD1"),
        (OSCILLATOR, "PD1", "expected a file of branches, such as follow.nc"),
        ("results/pendulum/simulate.nc", "PD1", "has no labelled points; expected a file of br"),
    ],
)
def test_labels_that_are_none_are_refused(file, label, expected, branches, cli):
    if file.endswith("simulate.nc"):
        cli("simulate", "pendulum", "--end", "0.1", "--no-figures")
    result = cli("simulate", file or str(branches), "--at", label)
    assert result.code == 2
    assert result.err.startswith("--at: 1 problem\n")
    assert expected in result.err


@pytest.mark.parametrize("name", ["impact-oscillator", "idling-engine", "ninebar", "motor"])
def test_the_mechanism_of_a_point_has_its_state(name):
    """Coordinates of bodies, offsets in clearances, massless links and internal states."""
    from linkages.options.analysis_options import OrbitOptions
    from linkages.orbits.shooting import Shooting
    from linkages.orbits.starting_states import with_first_state

    mechanism = linkages.loads(MOTOR) if name == "motor" else linkages.load(name)
    shooting = Shooting(mechanism, (), OrbitOptions())
    before = shooting.initial([])
    state = before + 1e-5 * (1.0 + np.arange(len(before)))
    result = with_first_state(mechanism, shooting.names, state)
    after = Shooting(result, (), OrbitOptions())
    assert after.names == shooting.names
    np.testing.assert_allclose(after.initial([]), state, rtol=1e-12, atol=1e-15)
    assert linkages.loads(result.to_yaml()) == result


MOTOR = """
name: Motor
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 0.3, mass: 0.2}}
motors: {drive: {bar: arm, voltage: 5, torque_constant: 0.05, resistance: 1.2, inductance: 2 mH}}
free: {arm: {angle: -90 deg, speed: 0}}
"""


def test_a_point_keeps_the_way_of_assembly():
    """A hint chooses the nearest position, which far away is that of the other way of assembly."""
    from linkages.orbits.starting_states import with_first_state

    mechanism = linkages.loads("""
gravity: [0, -9.81]
joints: {O2: [0, 0], O4: [0.04, 0]}
bars:
  crank: {joints: [O2, A], length: 0.1, mass: 0.2}
  coupler: {joints: [A, B], length: 0.1, mass: 0.5}
  other: {joints: [O4, B], length: 0.09, mass: 0.3}
free: {crank: {angle: 60 deg, speed: 0}}
assembly: {B: [0.13, 0.02]}
""")
    ways = set()
    for degrees in range(60, 420, 15):
        state = np.array([np.radians(degrees), 1.0])
        names = ["crank.angle", "crank.speed"]
        places = [
            System(each).places()
            for each in (with_first_state(mechanism, names, state),
                         mechanism.with_state({"crank": tuple(state)}))
        ]  # fmt: skip
        sides = [np.linalg.det([p["B"] - p["A"], [0.04, 0.0] - p["A"]]) < 0.0 for p in places]
        assert sides[0]
        ways.add(bool(sides[1]))
    assert ways == {True, False}  # without new hints the other one would be taken


# -- what is seen while branches are followed --------------------------------------------------


def test_special_points_stay_on_a_terminal_and_nothing_is_written_elsewhere(capsys, monkeypatch):
    with terminal.counter("branches", shown=True) as update:
        update("1 0.1")
        update("2 0.2 PD1 period doubling", True)
    assert capsys.readouterr() == ("", "")
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    with terminal.counter("branches", shown=True) as update:
        update("1 0.1")
        update("2 0.2 PD1 period doubling", True)
    seen = capsys.readouterr()
    assert seen.out == ""
    assert "2 0.2 PD1 period doubling" in seen.err
    assert "1 0.1" not in seen.err
    with terminal.counter("branches", shown=False) as update:
        update("2 0.2 PD1 period doubling", True)
    assert capsys.readouterr() == ("", "")


# -- honest ends -------------------------------------------------------------------------------


def test_no_orbit_is_an_error_with_a_reason(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\n"
        "bars: {rod: {joints: [O, P], length: 1, mass: 1}}\n"
        "dampers: [{bars: [ground, rod], damping: 1}]\n"
        "free: {rod: {angle: -60 deg}}\nsimulate: {end: 20}\n"
    )
    result = cli("orbit", "m.yaml")
    assert result.code == 1
    assert "the motion comes to rest" in result.err
    assert result.files == {"m.yaml"}


def test_a_law_with_memory_is_refused_by_name(cli):
    for command in (("orbit",), ("follow", "--vary", "clearances.gap.size=0.4mm:0.5mm")):
        says = "the contact law of 'gap' remembers the rate"
        cli.refused(command[0], "slider-crank-contact", *command[1:], says=says)


@pytest.mark.parametrize(
    ("vary", "expected"),
    [
        ("parameters.B=0:1", "parameters.B"),
        ("parameters.A=0:1:5", "expected a range such as"),
        ("parameters.A=1:1", "expected a range from a value to a larger one"),
    ],
)
def test_ranges_that_are_none_are_refused(vary, expected, cli):
    cli.refused("follow", OSCILLATOR, "--vary", vary, says=expected)


def test_branches_are_computed_again(branches):
    opened = linkages.open(branches)
    assert isinstance(opened, Opened)
    assert opened.analysis == "follow"
    xr.testing.assert_identical(opened.compute().drop_attrs(), opened.data.drop_attrs())


# -- stores ------------------------------------------------------------------------------------


def command_in(folder):
    arguments = [sys.executable, "-m", "linkages", *FOLLOW, "--store", "kept", "--no-figures"]
    folder.mkdir(exist_ok=True)
    return subprocess.Popen(
        arguments, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.slow_except("1")
@pytest.mark.parametrize("kills", [1, 6], ids=str)
def test_a_killed_run_goes_on_and_ends_with_the_same_bytes(kills, cli, tmp_path, monkeypatch):
    generator = np.random.default_rng(kills)
    killed, whole = tmp_path / "killed", tmp_path / "whole"
    done = 0
    for _ in range(kills):
        process = command_in(killed)
        wanted = done + int(generator.integers(3, 40 // kills + 4))
        chunks = killed / "kept" / CHUNKS
        while process.poll() is None and len(list(chunks.glob("?????????"))) < wanted:
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
        process.wait()
        count = len(list(chunks.glob("?????????")))
        assert count >= done
        done = count
    assert done
    for folder in (killed, whole):
        folder.mkdir(exist_ok=True)
        monkeypatch.chdir(folder)
        assert cli(*FOLLOW, "--store", "kept", "--no-figures").code == 0
    written = ["follow.nc", "follow.csv"]
    for name in written:
        one, other = (each / "results" / OSCILLATOR / name for each in (killed, whole))
        assert one.read_bytes() == other.read_bytes()


def test_a_store_of_other_branches_is_refused(cli):
    assert cli(*FOLLOW, "--store", "kept", "--no-figures").code == 0
    kept = cli(*FOLLOW, "--store", "kept", "--no-figures")
    assert kept.code == 0
    cli.refused(*FOLLOW, "--store", "kept", "--no-figures", "--points", "3", says="kept")


def test_loci_are_drawn_over_planes_of_periods(cli):
    """The locus of grazing has a closed form; motions on one side of it touch the stop."""
    at = ("--set", "parameters.A=0.3", "--set", "parameters.w=0.9", "--no-figures")
    locus = ("--locus", "G1", "--and", "parameters.w=0.85:0.95", "--points", "8")
    vary = ("--vary", "parameters.A=0.1:0.5", "--out", "g", "--json")
    found(cli("follow", OSCILLATOR, *at, *vary, *locus))
    plane = ("--x", "parameters.A=0.1:0.4:7", "--y", "parameters.w=0.86:0.94:3")
    period = ("--indicator", "period", "--out", "m", "--json")
    said = found(cli("map", OSCILLATOR, *plane, *period, "--loci", "g/follow.nc", "--page"))
    assert "m/map.png" in said["files"]
    assert "m/map.html" in said["files"]
    assert '"loci":[["grazing",' in Path("m/map.html").read_text(encoding="utf-8")
    data = linkages.open("m/map.nc").data
    ((a, w),) = locus_curves(data, [linkages.open("g/follow.nc").data]).values()
    assert np.isnan([a[-1], w[-1]]).all()  # which ends a curve
    np.testing.assert_allclose(a[:-1], np.hypot(1 - w[:-1] ** 2, C * w[:-1]), rtol=1e-8)
    silent = data.touches.sel(touch="stops[0].upper") == 0
    known = np.hypot(1 - data["parameters.w"] ** 2, C * data["parameters.w"])
    assert (silent == (data["parameters.A"] < known)).all()


def test_loci_that_do_not_fit_a_plane_are_refused(cli, branches):
    plane = ("map", OSCILLATOR, "--x", "parameters.A=0.1:0.4:3", "--y", "parameters.w=0.8:0.9:3")
    result = cli(*plane, "--indicator", "period", "--loci", str(branches))
    assert "holds no locus; expected a file that follow --locus wrote" in result.err
    result = cli(*plane, "--loci", str(branches))
    assert "loci are drawn over planes of periods" in result.err


def test_pages_that_do_not_fit_a_plane_are_refused_before_it_is_computed(cli):
    plane = ("map", OSCILLATOR, "--x", "parameters.A=0.1:0.4:3", "--y", "parameters.w=0.8:0.9:3")
    cli.refused(*plane, "--page", says="a page plays planes of periods")
    period = ("--indicator", "period", "--page")
    cli.refused(*plane, *period, "--refine", "2", says="a page plays every point")
    cli.refused(*plane[:3], "simulate.rtol=1e-9:1e-8:2", *plane[4:], *period, says="cannot change")
