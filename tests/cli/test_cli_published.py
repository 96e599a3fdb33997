"""A folder of results: whose files are in it, and what becomes of them when a run is repeated."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from linkages.reading.document import read, shipped
from linkages.reading.output_files import HOST, remove_leftovers, replaced
from linkages.reading.overrides import as_yaml

CRANK = """\
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.03}, rod: {joints: [A, B], length: 0.1, mass: 0.2}}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
drives: {crank: {angle: 0.3, speed: 10}}
assembly: {B: [0.12, 0]}
simulate: {end: 0.6, samples: 13}
"""
STUCK = ("--set", "bars.crank.length=0.2")  # longer than the rod: the crank cannot turn


@pytest.fixture
def simulate(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(CRANK)
    return lambda *options: cli("simulate", "m.yaml", *options)


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def attributes(path):
    with xr.open_dataset(path, engine="h5netcdf") as data:
        return dict(data.attrs)


@pytest.fixture
def interrupted(simulate, monkeypatch):
    """Ctrl-C while figures are drawn."""

    def press(*_, **given):  # noqa: ARG001
        raise KeyboardInterrupt

    def run():
        with monkeypatch.context() as patch:
            patch.setattr("linkages.plots.figures.save_figures", press)
            return simulate()

    return run


@pytest.mark.slow
def test_an_interrupted_run_leaves_the_complete_one_alone(simulate, interrupted, tmp_path):
    folder = tmp_path / "results/m"
    assert simulate("--no-figures").code == 0
    before = contents(folder)
    assert interrupted().code == 1
    assert contents(folder) == before
    assert contents(folder / "unfinished").keys() == {"simulate.nc", "simulate.csv"}
    assert attributes(folder / "unfinished/simulate.nc")["complete"] == "no"
    assert attributes(folder / "simulate.nc")["complete"] == "yes"
    assert simulate("--no-figures").code == 0
    assert not (folder / "unfinished").exists()


@pytest.mark.slow
def test_a_motion_that_stops_is_a_result(simulate, tmp_path):
    """The same command would stop it again; nothing of a motion that did not stop stays beside."""
    folder = tmp_path / "results/m"
    assert simulate().code == 0
    result = simulate("--no-figures", *STUCK)
    assert result.code == 1
    assert f"2 files in {os.path.join('results', 'm')}" in result.out
    assert contents(folder).keys() == {"simulate.nc", "simulate.csv"}
    assert attributes(folder / "simulate.nc")["complete"] == "no"


@pytest.mark.slow
def test_an_unfinished_run_of_another_verb_stays(simulate, interrupted, cli, tmp_path):
    unfinished = tmp_path / "results/m/unfinished"
    assert interrupted().code == 1
    (unfinished / "mine.txt").write_text("mine")
    assert cli("phase", "m.yaml", "--x", "time", "--y", "piston.position", "--no-figures").code == 0
    assert contents(unfinished).keys() == {"simulate.nc", "simulate.csv", "mine.txt"}
    assert simulate("--no-figures").code == 0
    assert contents(unfinished).keys() == {"mine.txt"}


@pytest.mark.slow
def test_files_that_a_run_does_not_write_again_are_removed(simulate, cli, tmp_path):
    folder = tmp_path / "results/m"
    assert simulate().code == 0
    assert {"mechanism.png", "drive_effort.png"} <= contents(folder).keys()
    assert cli("phase", "m.yaml", "--x", "time", "--y", "piston.position", "--no-figures").code == 0
    (folder / "notes.txt").write_text("mine")
    (folder / "traces.png").write_bytes(b"drawn over by somebody")
    assert simulate("--format", "svg", "--outputs", "slider_position").code == 0
    assert contents(folder).keys() == {
        "simulate.nc", "simulate.csv", "slider_position.svg",
        "phase_time_piston.position.nc", "phase_time_piston.position.csv",
        "notes.txt", "traces.png",
    }  # fmt: skip
    assert (folder / "traces.png").read_bytes() == b"drawn over by somebody"


def test_files_without_a_record_are_nobodys(simulate, tmp_path):
    folder = tmp_path / "results/m"
    folder.mkdir(parents=True)
    (folder / "traces.png").write_bytes(b"older than records")
    assert simulate("--no-figures").code == 0
    assert contents(folder).keys() == {"simulate.nc", "simulate.csv", "traces.png"}


@pytest.mark.slow_except("?*files*x*")
@pytest.mark.parametrize("record", ["", "[]", '{"files": 3}', '{"files": {"../m.yaml": "x"}}'])
def test_a_record_that_is_none_does_no_harm(simulate, tmp_path, record):
    records = tmp_path / "results/m/.linkages"
    records.mkdir(parents=True)
    (records / "simulate.json").write_text(record)
    assert simulate("--no-figures").code == 0
    assert (tmp_path / "m.yaml").read_text() == CRANK
    assert set(json.loads((records / "simulate.json").read_text())["files"]) == {
        "simulate.nc", "simulate.csv"
    }  # fmt: skip


def test_results_can_be_computed_again_from_themselves(simulate, cli, tmp_path):
    sizes = ("0.03", "0.04")
    for size in sizes:
        assert (
            simulate("--no-figures", "--set", f"bars.crank.length={size}", "--out", size).code == 0
        )
    first, second = (attributes(tmp_path / size / "simulate.nc") for size in sizes)
    assert first["definition"] != second["definition"]
    assert first["version"].startswith("linkages ")
    assert second["command"].endswith("--set bars.crank.length=0.04 --out 0.04")
    options = json.loads(first["options"])
    assert (options["end"], options["samples"]) == (0.6, 13)
    assert cli("simulate", "0.04/simulate.nc", "--no-figures", "--out", "again").code == 0
    assert (tmp_path / "again/simulate.csv").read_bytes() == (
        tmp_path / "0.04/simulate.csv"
    ).read_bytes()
    assert attributes(tmp_path / "again/simulate.nc")["name"] == "m"


def test_results_without_a_definition_define_nothing(cli, tmp_path):
    xr.Dataset({"x": ("t", np.zeros(2))}).to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
    cli.refused("simulate", "x.nc", says="has no definition in it")


@pytest.mark.parametrize("name", shipped())
def test_a_definition_is_written_as_it_was_read(name, tmp_path):
    document = read(shipped()[name])
    (tmp_path / "again.yaml").write_text(as_yaml(document), encoding="utf-8")
    assert read(tmp_path / "again.yaml").content == document.content


def test_texts_that_yaml_takes_for_something_else_are_written_as_texts(tmp_path):
    texts = ["", "~", "null", "on", "1e-3", "- x", "a: b # c", "'", "[1", "a\nb", " a", "!t", "*a"]
    document = read(shipped()["four-bar"])
    document.content["odd"] = {**dict.fromkeys("ab", texts), "<<": "x", "none": None}
    (tmp_path / "again.yaml").write_text(as_yaml(document), encoding="utf-8")
    assert read(tmp_path / "again.yaml").content == document.content


def test_leftovers_of_killed_processes_are_removed_and_no_others(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True
    )
    gone, here = int(done.stdout), os.getpid()
    own = f".linkages-{HOST}-"
    leftovers = [f"{own}{gone}-a1.nc", f"{own}{gone}-b2"]
    others = [
        f"{own}{here}-a1.nc", f".linkages-x{HOST}-{gone}-a1.nc", ".linkages-a1.nc", ".m-a1.nc"
    ]  # fmt: skip
    for name in (*leftovers, *others):
        (tmp_path / name).touch()
    (tmp_path / leftovers[1]).unlink()
    (tmp_path / leftovers[1]).mkdir()
    (tmp_path / leftovers[1] / "half.csv").touch()
    with replaced(tmp_path / "m.csv") as temporary:
        temporary.write_text("x")
    assert {path.name for path in tmp_path.iterdir()} == {*others, "m.csv"}
    for name in others:
        os.utime(tmp_path / name, (0, 0))
    remove_leftovers(tmp_path)  # the number of a process may be another one's after some days
    assert {path.name for path in tmp_path.iterdir()} == {*others[2:], "m.csv"}


def test_what_a_killed_run_has_written_aside_is_removed_by_the_next(simulate, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True
    )
    records = tmp_path / "results/m/.linkages"
    aside = records / f".linkages-{HOST}-{int(done.stdout)}-a1"
    aside.mkdir(parents=True)
    (aside / "simulate.nc").write_bytes(b"half")
    assert simulate("--no-figures").code == 0
    assert [path.name for path in records.iterdir()] == ["simulate.json"]


@pytest.mark.slow
@pytest.mark.parametrize("failure", [OSError("disk full"), KeyboardInterrupt()], ids=["os", "key"])
def test_a_failure_while_files_are_written_loses_nothing(simulate, tmp_path, monkeypatch, failure):
    folder = tmp_path / "results/m"
    assert simulate().code == 0
    before = contents(folder)

    def broken(*_, **given):  # noqa: ARG001
        raise failure

    monkeypatch.setattr("linkages.plots.figures.save_figures", broken)
    result = simulate("--set", "bars.crank.length=0.04")
    assert contents(folder) == before
    if isinstance(failure, OSError):
        assert (result.code, result.err.strip()) == (1, "cannot be written: disk full")
        assert not (folder / "unfinished").exists()
    else:
        assert result.code == 1
        assert contents(folder / "unfinished").keys() == {"simulate.nc", "simulate.csv"}
        assert str(len(contents(folder / "unfinished"))) in result.err
    assert not [path for path in (folder / ".linkages").iterdir() if path.suffix != ".json"]


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs a limit on the size of files")
def test_a_full_disk_loses_nothing_and_says_so(tmp_path):
    """A limit on the size of files stands for the end of a disk."""
    import resource

    (tmp_path / "m.yaml").write_text(CRANK)
    command = [sys.executable, "-m", "linkages", "simulate", "m.yaml", "--no-figures"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    before = contents(tmp_path / "results/m")
    largest = len(before["simulate.csv"])
    done = subprocess.run(
        [*command, "--set", "simulate.samples=5001"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest)),
    )
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1, done.stderr
    assert "cannot be written" in done.stderr
    assert contents(tmp_path / "results/m") == before


@pytest.mark.slow
@pytest.mark.parametrize("form", ["png", "svg", "pdf"])
def test_a_figure_is_computed_again(simulate, cli, tmp_path, form):
    changed = ("--set", "bars.crank.length=0.04", "--samples", "7")
    result = simulate(*changed, "--format", form)
    assert result.out.startswith("with bars.crank.length = 0.04\n")
    figure = f"results/m/slider_position.{form}"
    again = cli("simulate", figure, "--no-figures", "--out", "again", "--json")
    assert json.loads(again.out)["changes"] == ["bars.crank.length=0.04"]
    folders = (tmp_path / "results/m", tmp_path / "again")
    assert len({(folder / "simulate.csv").read_bytes() for folder in folders}) == 1


@pytest.mark.slow
def test_what_is_said_goes_before_what_results_say(simulate, cli, tmp_path):
    assert simulate("--no-figures", "--samples", "7", "--out", "first").code == 0
    for given in (("--samples", "5"), ("--set", "simulate.samples=5")):
        assert cli("simulate", "first/simulate.nc", "--no-figures", *given, "--out", "x").code == 0
        assert len((tmp_path / "x/simulate.csv").read_text().splitlines()) == 1 + 5


@pytest.mark.slow
def test_files_tell_no_folders_of_a_machine(simulate, cli, tmp_path):
    assert simulate().code == 0
    whole = str(tmp_path / "m.yaml")
    assert cli("simulate", whole, "--out", str(tmp_path / "b")).code == 0
    for folder in ("results/m", "b"):
        for path in (tmp_path / folder).rglob("*.*"):
            assert not path.is_file() or str(tmp_path).encode() not in path.read_bytes(), path


@pytest.mark.slow
def test_a_folder_holds_results_of_one_definition(simulate, cli, tmp_path):
    phase = ("phase", "m.yaml", "--x", "time", "--y", "piston.position", "--no-figures")
    folder = tmp_path / "results/m"
    assert simulate("--no-figures").code == 0
    assert cli(*phase).code == 0
    assert not (folder / "earlier").exists()
    (folder / "notes.txt").write_text("mine")
    result = cli(*phase, "--set", "bars.crank.length=0.04")
    aside = os.path.join("results", "m", "earlier")
    assert f"note: moved 2 files of simulate to {aside}: computed from another" in result.out
    assert contents(folder).keys() == {
        "phase_time_piston.position.nc", "phase_time_piston.position.csv", "notes.txt",
    }  # fmt: skip
    assert contents(folder / "earlier").keys() == {"simulate.nc", "simulate.csv"}
    assert simulate("--no-figures").code == 0
    assert contents(folder).keys() == {"simulate.nc", "simulate.csv", "notes.txt"}
    assert len(contents(folder / "earlier")) == 4


def test_a_folder_of_results_stands_for_the_file_in_it(simulate, cli, tmp_path):
    assert simulate("--no-figures", "--samples", "7").code == 0
    before = (tmp_path / "results/m/simulate.csv").read_bytes()
    assert cli("simulate", "results/m", "--no-figures").code == 0
    assert (tmp_path / "results/m/simulate.csv").read_bytes() == before
    assert not (tmp_path / "results/simulate").exists()
