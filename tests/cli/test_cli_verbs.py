"""What each verb prints and writes when all goes well."""

import csv
import json
import math
import re

import numpy as np
import pytest
import xarray as xr

import linkages
from linkages.cli.terminal import console, print_notes
from linkages.reading.document import shipped

VERBS = (
    "simulate", "check", "equations", "export", "animate", "phase", "poincare", "lyapunov",
    "bifurcation", "map", "sweep", "sensitivity", "chaos", "bench", "list",
)  # fmt: skip
# A short run of a mechanism that nothing integrates: fast.
SHORT = ("--set", "simulate.end=0.02", "--set", "simulate.samples=21")


def plain(text):
    """Without the colours that a terminal gets."""
    return re.sub("\x1b\\[[0-9;]*m", "", text)


@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_help_names_every_verb(cli, flag):
    result = cli(flag)
    assert (result.code, result.err) == (0, "")
    assert all(f" {verb} " in plain(result.out) for verb in VERBS)


@pytest.mark.parametrize("verb", VERBS)
def test_help_of_a_verb(cli, verb):
    result = cli(verb, "--help")
    assert (result.code, result.err) == (0, "")
    text = plain(result.out)
    assert f"linkages {verb}" in text
    assert "--json" in text
    assert ("--set" in text) == ("FILE" in text) == (verb != "list")


def test_no_arguments_shows_help_and_fails(cli):
    result = cli()
    assert result.code == 2
    assert "simulate" in plain(result.out + result.err)


def test_version_is_the_packages(cli):
    result = cli("--version")
    assert (result.code, result.out, result.err) == (0, f"linkages {linkages.__version__}\n", "")


def test_list_shows_every_shipped_mechanism_with_its_name(cli):
    result = cli("list")
    assert (result.code, result.err) == (0, "")
    rows = dict(line.split(None, 1) for line in plain(result.out).splitlines()[2:])
    assert {name: title.strip() for name, title in rows.items()} == {
        name: linkages.load(path).name for name, path in shipped().items()
    }


def test_list_as_json(cli):
    result = cli("list", "--json")
    assert json.loads(result.out)["mechanisms"] == {
        name: {"title": linkages.load(path).name, "file": str(path)}
        for name, path in shipped().items()
    }


# check


def test_check_as_json_counts_the_nine_bar(cli):
    """Counted by hand: nine moving bodies with the clearance link; pins A, B (three bodies), C, C',
    D, E (three), F, O (two on the ground): eleven pairs; three loops (the paper's Eq. 1).
    """
    result = cli("check", "ninebar", "--json")
    assert (result.code, result.err) == (0, "")
    content = json.loads(result.out)
    assert content["mobility"] == {"gruebler": 3, "numerical": 3}
    assert (content["revolute_pairs"], content["prismatic_pairs"], content["loops"]) == (11, 1, 3)
    assert (content["driven"], content["free"]) == (["crank1", "crank4"], ["r1"])
    assert {body["name"]: body["mass"] for body in content["bodies"]} == {
        "crank1": 0.985, "link2": 2.836, "link3": 3.051, "crank4": 0.361, "rocker6": 2.701,
        "link7": 1.993, "link8": 2.701, "slider9": 4.288, "r1": 0.0,
    }  # fmt: skip
    assert [(b["unknowns"], b["apex"], b["side"]) for b in content["blocks"]] == [
        (["link2", "link3"], "B", "left"),
        (["rocker6", "link7"], "E", "right"),
        (["link8", "slider9"], "F", "forward"),
    ]
    assert all(1 <= block["condition"] < 10 for block in content["blocks"])
    assert "kernel" not in content


def test_check_places_joints_where_the_lengths_say(cli):
    joints = {j["joint"]: j["position"] for j in json.loads(cli("check", "ninebar", "--json").out)[
        "joints"
    ]}  # fmt: skip
    distance = {
        ("O", "A"): 0.3, ("A", "B"): 0.893, ("C.r1", "B"): 0.962, ("D", "C"): 0.1,
        ("O", "E"): 0.85, ("E", "B"): 0.623, ("E", "F"): 0.85, ("C", "C.r1"): 0.15e-3,
    }  # fmt: skip
    for (first, second), length in distance.items():
        # a few roundings of positions of order 1
        assert np.hypot(*np.subtract(joints[first], joints[second])) == pytest.approx(
            length, abs=1e-15
        )
    assert joints["F"][1] == 0


def test_check_as_text_says_the_same(cli):
    result = cli("check", "ninebar", "--kernel")
    text = plain(result.out)
    assert (result.code, result.err) == (0, "")
    for expected in (
        "11 revolute and 1 prismatic pairs, 3 independent loops",
        "mobility 3 by the Chebychev–Grübler–Kutzbach criterion, 3 by the rank",
        "driven: crank1, crank4",
        "free: r1",
        "RRR dyad, closed form",
        "RRP dyad, closed form",
        "Operations of the kernel",
    ):
        assert expected in text


def test_kernel_leaves_out_what_a_driven_crank_carries(cli):
    """Both cranks turn at constant speed: their mass and inertia enter no equation of motion."""
    kernel = json.loads(cli("check", "ninebar", "--kernel", "--json").out)["kernel"]
    assert kernel["left_out"] == [
        "bars.crank1.mass", "bars.crank1.inertia", "bars.crank4.mass", "bars.crank4.inertia",
    ]  # fmt: skip
    counts = kernel["operations"]
    assert set(counts) == {"once per run", "once per distinct time", "once per state"}
    # cos and sin: of the clearance per state, of both cranks per time; one root per dyad
    assert [part["trigonometric calls"] for part in counts.values()] == [0, 4, 2]
    assert counts["once per state"]["square roots"] == 3


def test_kernel_of_a_driven_mechanism_is_none(cli):
    kernel = json.loads(cli("check", "four-bar", "--kernel", "--json").out)["kernel"]
    assert "nothing is free" in kernel["note"]


def test_check_mentions_free_ends_and_what_it_chose(cli, tmp_path):
    assert "joint P is a free end" in plain(cli("check", "four-bar").out)
    (tmp_path / "m.yaml").write_text(
        "joints: {O: [0, 0]}\nbars:\n  rod: {joints: [O, P], length: 1, mass: 1}\n"
        "assembly: {P: [0, -1]}\n"
    )
    notes = json.loads(cli("check", "m.yaml", "--json").out)["notes"]
    assert any(note.startswith("rod was chosen as a free coordinate") for note in notes)


def test_a_joint_that_a_spring_or_an_axis_holds_is_no_free_end(cli, tmp_path):
    """S is where a spring pulls at the rod, X where the axis of a block begins; T has neither."""
    (tmp_path / "m.yaml").write_text(
        "joints: {O: [0, 0], W: [1, 1]}\n"
        "bars:\n  rod: {points: {O: [0, 0], S: [1, 0], X: [0.5, 0], T: [0, 1]}}\n"
        "sliders: {block: {joint: E, on: rod, through: X, mass: 1}}\n"
        "springs: [{between: [S, W], stiffness: 10, length: 1}]\n"
        "drives: {rod: {angle: 0, speed: 1}}\nfree: {block: {position: 0.2}}\n"
    )
    notes = json.loads(cli("check", "m.yaml", "--json").out)["notes"]
    ends = [note.split()[1] for note in notes if "is a free end" in note]
    assert "T" in ends
    assert not {"S", "X"} & set(ends)


EVERYTHING = """\
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.5, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  coupler: {joints: [A, B], length: 0.4, mass: 1}
  rocker: {joints: [D, B], length: 0.3, mass: 1}
  lever: {joints: [B, L], length: 0.1}
  wheel: {joints: [D, W], length: 0.1, mass: 1}
welds: {B: {bars: [rocker, lever], angle: 40 deg}}
gears: [{bars: [crank, wheel], ratio: -2}]
masses: {L: 2 kg}
springs:
  - {between: [D, A], stiffness: 500, length: 0.1, damping: 3}
  - {bar: rocker, stiffness: 5, angle: 1}
dampers: [{joint: A, damping: 0.1}, {between: [D, L], damping: 0}]
loads: [{joint: B, force: [0, -20*sin(3*t)]}, {bars: [crank, coupler], torque: 4}]
free: {crank: {angle: 1}}
assembly: {B: left}
"""


def test_check_doubts_a_clearance_as_long_as_a_link(cli):
    result = cli("check", "ninebar", "--set", "clearances.r1.size=0.2", "--json")
    assert result.code == 0
    (note,) = json.loads(result.out)["notes"]
    assert note.startswith("clearance r1 of 0.2 m is large beside link3")


@pytest.mark.parametrize(
    "setting", ["method=euler", "method=rk4", "rtol=5", "samples=1e12"],
)  # fmt: skip
def test_check_refuses_what_simulate_refuses(cli, setting):
    both = [cli(verb, "ninebar", "--set", f"simulate.{setting}") for verb in ("check", "simulate")]
    assert [result.code for result in both] == [2, 2]
    assert both[0].err == both[1].err != ""


def test_check_lists_welds_gears_loads_and_masses(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(EVERYTHING)
    content = json.loads(cli("check", "m.yaml", "--json").out)
    assert [(r["kind"], r["on"], r["path"]) for r in content["relations"]] == [
        ("weld", "rocker and lever", "welds.B"), ("gear", "crank and wheel", "gears[0]"),
    ]  # fmt: skip
    assert [(r["kind"], r["on"], r["value"]) for r in content["loads"]] == [
        ("force", "joint B", "[0 N, -20 to 0 N until t = 1 s]"),
        ("torque", "coupler against crank", "4 N m"),
        ("spring", "joints D and A", "500 N/m, length 0.1 m, damping 3 N s/m"),
        ("torsional spring", "rocker", "5 N m/rad, angle 1 rad"),
        ("torsional damper", "coupler against crank", "damping 0.1 N m s/rad"),
        ("mass", "joint L", "2 kg"),
    ]
    assert content["redundant"] == []
    text = plain(cli("check", "m.yaml").out)
    for expected in ("Welds and gears", "Loads, springs and masses", "at B, 40°", "springs[0]"):
        assert expected in text


@pytest.mark.parametrize(
    ("name", "titles"),
    [
        ("quick-return", {"RPR dyad, closed form", "RRP dyad, closed form"}),
        ("scotch-yoke", {"PP dyad, closed form"}),
        ("class-three", {"group of 2 loops, iterated"}),
    ],
)
def test_blocks_are_named_by_how_they_are_solved(cli, name, titles):
    content = json.loads(cli("check", name, "--json").out)
    assert {block["kind"] for block in content["blocks"]} == titles


def test_check_names_redundant_joints(cli, tmp_path):
    """A parallelogram with a third crank that repeats what the other two hold."""
    (tmp_path / "m.yaml").write_text(
        "joints: {O: [0, 0], D: [0.4, 0], E: [0.2, 0]}\nbars:\n"
        "  crank: {joints: [O, A], length: 0.1}\n  rocker: {joints: [D, B], length: 0.1}\n"
        "  coupler: {points: {A: [0, 0], B: [0.4, 0], C: [0.2, 0]}}\n"
        "  third: {joints: [E, C], length: 0.1, mass: 1}\n"
        "drives: {crank: {angle: 1, speed: 1}}\nassembly: {B: [0.454, 0.084], C: [0.254, 0.084]}\n"
    )
    result = cli("check", "m.yaml", "--json")
    assert (result.code, result.err) == (0, "")
    content = json.loads(result.out)
    assert content["mobility"] == {"gruebler": 0, "numerical": 1}
    assert content["redundant"]
    joints = ", ".join(content["redundant"])
    assert any(f"constraints at {joints} are redundant" in note for note in content["notes"])
    assert f"redundant joints: {joints}" in plain(cli("check", "m.yaml").out)


def test_markup_in_a_name_is_text(cli, tmp_path):
    title = "Press [/b] [bold]x[/red] :smile:"
    text = shipped()["four-bar"].read_text().replace("Four-bar linkage (crank-rocker)", "TITLE")
    (tmp_path / "m.yaml").write_text(text.replace("name: TITLE", f'name: "{title}"'))
    assert cli("check", "m.yaml").out.splitlines()[0] == title
    result = cli("simulate", "m.yaml", "--no-figures", *SHORT)
    assert (result.code, result.err) == (0, "")
    assert f"\n{title}: " in result.out


# equations


@pytest.mark.parametrize(
    ("form", "expected"),
    [
        ("text", ("Closure", "θ_rod", "s_piston", "θ_crank")),
        ("latex", (r"\begin{align*}", r"\theta_{\text{rod}}")),
        ("python", ("from numpy import", "def ")),
    ],
)
def test_equations(cli, form, expected):
    result = cli("equations", "slider-crank", "--format", form)
    assert (result.code, result.err) == (0, "")
    assert all(fragment in result.out for fragment in expected)
    whole = json.loads(cli("equations", "slider-crank", "--format", form, "--json").out)
    assert whole == {
        "mechanism": "Slider-crank", "format": form, "equations": result.out.removesuffix("\n"),
    }  # fmt: skip


def test_equations_as_python_are_python(cli):
    source = cli("equations", "slider-crank", "--format", "python").out
    compile(source, "equations", "exec")


# simulate


@pytest.mark.slow
def test_simulate_warns_of_pins_out_of_their_holes(cli):
    arguments = ("--set", "simulate.end=0.4", "--set", "simulate.samples=41", "--no-figures")
    result = cli("simulate", "ninebar-rotating", *arguments)
    assert result.code == 0
    text = plain(result.out)
    assert "note: The force in r1 has the wrong sign for " in text
    result = cli("simulate", "ninebar", "--no-figures", "--no-verify")
    assert "note: " not in result.out


def test_simulate_shows_bars_where_there_are_no_sliders(cli):
    text = plain(cli("simulate", "four-bar", *SHORT, "--no-figures").out)
    assert "angular acceleration" in text
    assert "angular acceleration" not in plain(
        cli("simulate", "slider-crank", *SHORT, "--no-figures").out
    )


def test_the_table_shows_the_outputs_that_were_asked_for(cli):
    outputs = ("--outputs", "transmission_angle,joint_reaction", "--no-figures")
    text = plain(cli("simulate", "four-bar", *SHORT, *outputs).out)
    assert "transmission angle" in text
    assert "joint reaction" in text
    assert "driving torque" not in text


def table_of(path):
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return head, np.array(rows, dtype=float)


def test_files_hold_what_python_computes(cli, tmp_path):
    result = cli("simulate", "slider-crank", "--no-figures", *SHORT)
    assert (result.code, result.err) == (0, "")
    folder = tmp_path / "results" / "slider-crank"
    assert {p.name for p in folder.iterdir() if p.is_file()} == {"simulate.csv", "simulate.nc"}
    expected = linkages.simulate(linkages.load("slider-crank"), end=0.02, samples=21).data
    with xr.open_dataset(folder / "simulate.nc", engine="h5netcdf") as found:
        # the same computation, and NetCDF keeps doubles: not one bit may differ
        assert expected.attrs.items() <= found.attrs.items()
        xr.testing.assert_identical(found.load(), expected.assign_attrs(found.attrs))
    head, rows = table_of(folder / "simulate.csv")
    assert rows.shape == (21, len(head))
    assert np.array_equal(rows[:, head.index("time (s)")], expected.time)
    piston = rows[:, head.index("slider_position[piston] (m)")]
    assert np.array_equal(piston, expected.slider_position.sel(slider="piston"))
    reached = rows[:, head.index("joint_velocity[A.y] (m/s)")]
    assert np.array_equal(reached, expected.joint_velocity.sel(joint="A", axis="y"))


def test_json_is_one_object_and_nothing_else(cli, tmp_path):
    result = cli("simulate", "slider-crank", "--no-figures", "--json", *SHORT)
    assert (result.code, result.err) == (0, "")
    content = json.loads(result.out)
    assert content["completed"] is True
    assert content["stopped"] is None
    assert content["samples"] == 21
    assert content["method"] is None  # nothing is integrated
    assert all((tmp_path / path).is_file() for path in content["files"])
    data = linkages.simulate(linkages.load("slider-crank"), end=0.02, samples=21).data
    efforts = data.drive_effort.sel(drive="crank")
    (row,) = [row for row in content["maxima"] if row["variable"] == "drive_effort"]
    place = int(np.argmax(np.abs(efforts.to_numpy())))
    assert (row["element"], row["units"]) == ("crank", "N m")
    assert row["value"] == pytest.approx(float(efforts[place]), rel=0.01)  # between samples
    assert row["time"] == pytest.approx(float(data.time[place]), abs=float(data.time[1]))
    assert row["beyond_horizon"] is None  # nothing is integrated


def test_table_of_maxima(cli):
    """Like the paper's: quantities with element, value, unit and time."""
    text = plain(cli("simulate", "slider-crank", "--no-figures", *SHORT).out)
    assert "\nSlider-crank: 21 samples to t = 0.02 s, all coordinates driven" in text
    for words in ("driving torque", "position", "velocity", "acceleration", "piston", "at t"):
        assert words in text
    assert "2 files in results/slider-crank" in text


@pytest.mark.slow
def test_table_of_all_outputs_has_all_maxima(cli):
    """What a single output shows is there when all are asked for."""
    arguments = ("simulate", "slider-crank", "--no-figures", *SHORT, "--outputs")
    everything = plain(cli(*arguments, "all").out).splitlines()
    alone = plain(cli(*arguments, "joint_reaction").out).splitlines()
    rows = [" ".join(line.split()) for line in alone if line.startswith("joint reaction")]
    assert len(rows) == 3
    assert set(rows) <= {" ".join(line.split()) for line in everything}


@pytest.mark.slow
def test_maxima_beyond_the_horizon_are_marked(cli):
    """A double pendulum that is predictable for some seconds of 30; its peak speed comes later."""
    how = ("--set", "simulate.end=30", "--set", "simulate.rtol=1e-6", "--verify", "--no-figures")
    text = plain(cli("simulate", "double-pendulum", *how).out)
    (horizon,) = re.findall(r"predictable to t = ([\d.]+) s:", text)
    end = r" +(-?[\d.]+)(\**) +([\d.]+)"
    rows = re.findall(rf"^angular speed +\w+{end}{end} +rad/s *$", text, re.MULTILINE)
    pairs = [(row[k + 1], row[k + 2]) for row in rows for k in (0, 3)]
    assert any(stars for stars, _ in pairs)
    for stars, time in pairs:
        assert bool(stars) == (float(time) > float(horizon))
    assert f"* later than t = {horizon} s, to which the motion is predictable" in text
    content = json.loads(cli("simulate", "double-pendulum", *how, "--json").out)
    for row in content["maxima"]:
        assert row["beyond_horizon"] == (row["time"] > content["horizon"]["time"])


@pytest.mark.slow
def test_the_table_does_not_depend_on_samples(cli):
    """Twelve samples a turn of a slider-crank, and a thousand."""
    few = ("--set", "simulate.end=0.04", "--set", "simulate.samples=7", "--no-figures")
    many = (*few[:3], "simulate.samples=501", "--no-figures")
    rows = [
        [line.split() for line in plain(cli("simulate", "slider-crank", *how).out).splitlines()
         if line.startswith(("velocity", "acceleration"))]
        for how in (few, many)
    ]  # fmt: skip
    assert len(rows[0]) == 2
    for one, other in zip(*rows, strict=True):
        for place in (2, 4):
            assert float(one[place]) == pytest.approx(float(other[place]), rel=1e-5)


def test_a_motion_too_long_to_be_looked_at_is_marked(cli, monkeypatch):
    monkeypatch.setattr("linkages.solution.dense.MOST", 21)
    short = ("--set", "simulate.end=0.1", "--set", "simulate.samples=21", "--no-figures")
    text = plain(cli("simulate", "ninebar", *short, "--no-verify").out)
    assert re.search(r"^clearance speed +r1 +-?[\d.]+~ ", text, re.MULTILINE)
    assert (
        "~ the motion is too long to be searched between samples: the value may be larger" in text
    )


STRUCTURE = """\
joints: {A: [0, 0], B: [1, 0]}
bars: {left: {joints: [A, C], length: 1}, right: {joints: [B, C], length: 1, mass: 2}}
assembly: {C: left}
simulate: {end: 1, samples: 3}
"""


def test_a_structure_is_called_one(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(STRUCTURE)
    text = plain(cli("simulate", "m.yaml", "--no-figures").out)
    assert "a structure, which cannot move, nothing integrated" in text


PARALLELOGRAM = """\
joints: {O: [0, 0], D: [0.5, 0]}
bars:
  crank: {joints: [O, A], length: 0.1}
  coupler: {joints: [A, B], length: 0.5, mass: 1}
  rocker: {joints: [D, B], length: 0.1}
drives: {crank: {angle: 1, speed: 2}}
assembly: {B: [0.554, 0.084]}
simulate: {end: 3, samples: 31}
"""


@pytest.mark.slow_except("stop-1")
@pytest.mark.parametrize(("option", "code"), [("pass", 0), ("stop", 1), (None, 1)])
def test_change_points_are_passed_where_asked_for(cli, tmp_path, option, code):
    """All bars of a parallelogram are in line where the crank has turned to π and 2π."""
    (tmp_path / "m.yaml").write_text(PARALLELOGRAM)
    chosen = () if option is None else ("--change-points", option)
    result = cli("simulate", "m.yaml", "--no-figures", *chosen)
    assert result.code == code
    lines = [line for line in result.out.splitlines() if line.startswith("note: at t")]
    if option == "pass":
        times = [float(re.search(r"at t = (\S+) s", line).group(1)) for line in lines]
        assert times == pytest.approx([(np.pi - 1) / 2, (2 * np.pi - 1) / 2], rel=1e-5)
        assert all("change point" in line and line.endswith("in line") for line in lines)
    else:
        assert not lines
        assert "stopped at t = 1.0707" in result.err


def test_of_many_notes_the_first_are_printed(capsys):
    print_notes([f"number {i}" for i in range(25)], console())
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == ["note: number 0", "note: number 1"]
    assert lines[-1] == "15 more notes; --json lists all of them"


@pytest.mark.slow
def test_an_iterated_motion_is_said_to_be_integrated(cli):
    """All coordinates of the class-III linkage are driven; its group is carried along."""
    result = cli("simulate", "class-three", "--no-figures", "--no-verify", *SHORT)
    assert (result.code, result.err) == (0, "")
    assert "nothing integrated" not in result.out


@pytest.mark.slow
def test_figures_are_written_beside_the_data(cli, tmp_path):
    result = cli("simulate", "four-bar", "--json", *SHORT)
    assert (result.code, result.err) == (0, "")
    files = [tmp_path / path for path in json.loads(result.out)["files"]]
    figures = [path for path in files if path.suffix == ".png"]
    assert {"mechanism", "drive_effort"} <= {path.stem for path in figures}
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in figures)
    assert {path.name for path in (tmp_path / "results/four-bar").iterdir() if path.is_file()} == {
        path.name for path in files
    }


def test_out_and_several_assignments(cli, tmp_path):
    result = cli(
        "simulate", "four-bar", "--no-figures", "--json", "--out", "deep/er",
        "--set", "simulate={end: 0.5, samples: 11}", "--set", "drives.crank.speed=120 rpm",
        "--set", "bars.rocker.mass=0.6",
    )  # fmt: skip
    assert (result.code, result.err) == (0, "")
    assert not (tmp_path / "results").exists()
    with xr.open_dataset(tmp_path / "deep/er/simulate.nc", engine="h5netcdf") as data:
        assert data.sizes["time"] == 11
        speed = data.bar_speed.sel(bar="crank").to_numpy()
        assert speed == pytest.approx(4 * np.pi, rel=1e-15)  # one rounding of the unit


def test_outputs_chooses_what_is_written(cli, tmp_path):
    result = cli("simulate", "four-bar", "--no-figures", "--outputs", "bar_angle", *SHORT)
    assert (result.code, result.err) == (0, "")
    with xr.open_dataset(tmp_path / "results/four-bar/simulate.nc", engine="h5netcdf") as data:
        assert list(data.data_vars) == ["bar_angle"]


def test_own_file_comes_before_a_shipped_one(cli, tmp_path):
    text = shipped()["four-bar"].read_text().replace("Four-bar linkage", "Mine")
    (tmp_path / "four-bar.yaml").write_text(text)
    assert cli("check", "four-bar.yaml").out.startswith("Mine")
    assert cli("check", str(shipped()["four-bar"])).out.startswith("Four-bar linkage")
    assert cli("check", "four-bar").out.startswith("Four-bar linkage")


@pytest.mark.slow
def test_second_run_replaces_the_first(cli, tmp_path):
    assert cli("simulate", "four-bar", "--no-figures", *SHORT).code == 0
    assert cli("simulate", "four-bar", "--no-figures", *SHORT[:2]).code == 0
    folder = tmp_path / "results/four-bar"
    assert {p.name for p in folder.iterdir() if p.is_file()} == {"simulate.csv", "simulate.nc"}
    assert len(table_of(folder / "simulate.csv")[1]) == 1001


def test_a_run_gives_up_after_some_steps_with_what_it_has(cli):
    result = cli("simulate", "pendulum", "--max-steps", "10", "--no-figures", "--json")
    assert result.code == 1
    found = json.loads(result.out)
    assert "allowed number of steps was used up" in found["stopped"]["reason"]
    assert 0 < found["samples"] < 1201
    assert found["horizon"]["whole"]  # the comparison may take more steps


@pytest.mark.slow
def test_places_of_a_driven_motion_count_as_steps(cli):
    fast = ("four-bar", "--set", "drives.crank.speed=1000.5", "--set", "simulate.end=1")
    result = cli("simulate", *fast, "--max-steps", "50000", "--no-figures")
    assert result.code == 2  # 1000.5 rad are 57324 degrees
    assert "drives turn by 5.73e+04 degrees" in result.err
    assert "max_steps beyond 50000" in result.err
    assert cli("simulate", *fast, "--max-steps", "60000", "--no-figures").code == 0


def test_simulate_shows_measures(cli):
    measures = ["--measure", "stroke(piston.position)", "--measure", "max(abs(B.x reaction))"]
    none = ["--measure", "1/(max(t) - max(t))"]
    found = cli("simulate", "slider-crank.yaml", "--no-figures", "--json", *measures, *none)
    stroke, reaction, undefined = json.loads(found.out)["measures"]
    assert stroke["value"] == pytest.approx(0.08, rel=1e-11)
    assert stroke["units"] == "m"
    assert reaction["units"] == "N"
    assert reaction["value"] > 0
    assert undefined["value"] is None
    assert "divides by zero" in undefined["reason"]
    assert "Measures" in cli("simulate", "slider-crank.yaml", "--no-figures", *measures).out


@pytest.mark.parametrize(
    ("measure", "message"),
    [
        ("max(crank.efort)", "did you mean 'crank.effort'"),
        ("max(error(piston.position))", "there is no other motion to compare with"),
    ],
)
def test_simulate_refuses_measures_before_it_computes(cli, measure, message):
    cli.refused("simulate", "slider-crank.yaml", "--measure", measure, says=message, files=set())


def test_a_measure_outside_of_the_motion_leaves_the_results(cli):
    late = ["--measure", "at(2*final(t), crank.angle)"]
    half = ["--measure", "at(final(t)/2, crank.angle)"]
    found = cli("simulate", "slider-crank.yaml", "--no-figures", "--json", *late, *half)
    assert found.code == 0
    missed, angle = json.loads(found.out)["measures"]
    assert missed["value"] is None
    assert "t = 0.16 s is outside of the motion, from 0 s to 0.08 s" in missed["reason"]
    assert angle["value"] == pytest.approx(2 * math.pi, rel=1e-12)


def test_list_without_a_name_draws_nothing(cli):
    cli.refused("list", "--dimensions", says="expected the NAME of a mechanism to draw")


def test_list_draws_dimensions_if_they_are_asked_for(cli, tmp_path):
    sizes = []
    for more in ((), ("--dimensions",)):
        result = cli("list", "four-bar", "--format", "svg", "--out", str(tmp_path), *more)
        assert result.code == 0
        sizes.append((tmp_path / "drawing.svg").stat().st_size)
    assert sizes[1] > sizes[0]


def test_simulate_says_what_is_doubtful_about_measures(cli):
    measures = [
        "last_turn(crank.angle, harmonic(1, piston.position))",
        "harmonic(1, piston.position)",
    ]
    options = [word for text in measures for word in ("--measure", text)]
    found = cli(
        "simulate", "slider-crank", "--no-figures", "--json", *options, "--set", "simulate.end=0.07"
    )
    rows = json.loads(found.out)
    assert rows["measures"][0]["value"] == pytest.approx(0.04, rel=1e-12)  # the crank's length
    (note,) = [note for note in rows["notes"] if "harmonic" in note]
    assert note.startswith(
        "measure 'harmonic(1, piston.position)': the ends of the window differ by"
    )


def test_optimize_is_optimise(cli):
    goal = [
        "--vary",
        "bars.crank.length=10:60mm",
        "--minimise",
        "bars.crank.length",
        "--no-figures",
    ]
    limit = ["--subject-to", "stroke(piston.position) > 60 mm"]
    result = cli("optimize", "slider-crank", *goal, *limit)
    assert (result.code, result.err) == (0, "")
    assert "results/slider-crank/optimised.yaml" in result.files
    assert "minimise bars.crank.length, " in result.out
    assert "optimize" not in cli("--help").out


def test_the_table_has_the_speed_of_what_a_motor_turns(cli, tmp_path):
    """A shaft without load, which ends at the speed of the motor without load over the ratio."""
    (tmp_path / "press.yaml").write_text(
        "joints: {O: [0, 0]}\n"
        "bars:\n"
        "  crank: {joints: [O, A], length: 120 mm, mass: 5}\n"
        "  rod: {joints: [A, B], length: 400 mm}\n"
        "sliders: {ram: {joint: B, through: O}}\n"
        "free: {crank: {angle: 0.3, speed: 0}}\n"
        "motors: {m: {bar: crank, stall_torque: 20 N m, no_load_speed: 40 rad/s, gear_ratio: 4,\n"
        "             rotor_inertia: 0.001, joint: O}}\n"
        "assembly: {B: [0.5, 0]}\n"
        "simulate: {end: 1}\n"
    )
    lines = cli("simulate", "press.yaml", "--no-figures").out.splitlines()
    (row,) = [line.split() for line in lines if line.startswith("angular speed")]
    assert row[2] == "crank"
    assert float(row[5]) == pytest.approx(10.0, rel=1e-6)


def test_measures_of_sweeps_are_called_as_they_are_written(cli, tmp_path):
    text = "max(piston.velocity)/drives.crank.speed"
    result = cli(
        "sweep",
        "slider-crank",
        "--no-figures",
        "--measure",
        text,
        "--vary",
        "bars.rod.length=0.12,0.14",
    )
    assert f"\n{text}  " in result.out
    (table,) = (tmp_path / "results/slider-crank").glob("*.csv")
    assert f"{text} (m)" in table.read_text(encoding="utf-8").splitlines()[0]
