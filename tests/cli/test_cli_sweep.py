"""``sweep`` on the command line: what it prints, writes and refuses."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

import linkages

EFFORT = ("--measure", "max(abs(crank.effort))")
ROD = ("--vary", "bars.rod.length=20mm:150mm:5")


def test_a_sweep_prints_writes_and_notes(cli):
    found = cli("sweep", "slider-crank", *EFFORT, *ROD)
    assert found.code == 0
    assert "4 of 5 points" in found.out
    assert "note: 1 point: joint B" in found.out
    results = "results/slider-crank"
    assert found.files >= {f"{results}/sweep.{ending}" for ending in ("nc", "csv", "png")}
    data = xr.load_dataset(f"{results}/sweep.nc", engine="h5netcdf")
    mechanism = linkages.load("slider-crank")
    rods = [f"{value!r} mm" for value in np.linspace(20, 150, 5).tolist()]
    expected = linkages.sweep(mechanism, {"bars.rod.length": rods}, EFFORT[1])
    assert data[EFFORT[1]].equals(expected[EFFORT[1]])
    with open(f"{results}/sweep.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][:3] == ["bars.rod.length (mm)", f"{EFFORT[1]} (N m)", "outcome"]
    assert [row[2] for row in rows[1:]] == ["stopped", *["computed"] * 4]


def test_grids_lists_lockstep_and_draws(cli):
    found = cli(
        "sweep", "slider-crank", *EFFORT, "--measure", "stroke(piston.position)",
        "--vary", "bars.rod.length=140mm:150mm:2,bars.crank.mass=0.8:0.9:2",
        "--vary", "drives.crank.speed=1000rpm,1500rpm,1600rpm",
        "--sample", "bars.crank.length=normal(40 mm, 0.1 mm)", "--draws", "3", "--seed", "7",
        "--sequence", "sobol", "--json",
    )  # fmt: skip
    assert "same unit" in found.err  # what varies together has one unit
    found = cli(
        "sweep", "slider-crank", *EFFORT, "--measure", "stroke(piston.position)",
        "--vary", "bars.rod.mass=0.5:0.6:2,bars.crank.mass=0.8:0.9:2",
        "--vary", "drives.crank.speed=1000rpm,1500rpm,1600rpm",
        "--sample", "bars.crank.length=normal(40 mm, 0.1 mm)", "--draws", "3", "--seed", "7",
        "--sequence", "sobol", "--json", "--no-figures",
    )  # fmt: skip
    content = json.loads(found.out)
    assert (content["points"], content["computed"]) == (18, 18)
    effort, stroke = content["measures"]
    assert effort["units"] == "N m"
    assert stroke["mean"] == pytest.approx(0.08, rel=0.01)
    data = xr.load_dataset("results/slider-crank/sweep.nc", engine="h5netcdf")
    assert dict(data.sizes) == {"bars.rod.mass": 2, "drives.crank.speed": 3, "draw": 3}


def test_no_point_at_all_fails(cli):
    found = cli("sweep", "slider-crank", *EFFORT, "--vary", "bars.rod.length=10mm:20mm:2")
    assert found.code == 1
    assert "no point could be computed: joint B" in found.err


@pytest.mark.slow
def test_a_store_goes_on_and_says_what_it_holds(cli):
    arguments = ("slider-crank", *EFFORT, *ROD, "--store", "study", "--no-figures", "--json")
    one, other = (json.loads(cli("sweep", *arguments).out) for _ in range(2))
    assert one == other
    found = json.loads(cli("sweep", "--status", "study", "--json").out)
    assert (found["points"], found["done"], found["left"]) == (5, 5, 0)
    assert found["outcomes"] == {"computed": 4, "stopped": 1}
    text = cli("sweep", "--status", "study").out
    assert "study: 5 of 5 points, finished" in text
    assert "1 point: joint B" in text
    other = ("--vary", "bars.rod.length=20mm:151mm:5", "--store", "study")
    says = "holds another sweep: numbers of points (checksum) is"
    cli.refused("sweep", "slider-crank", *EFFORT, *other, says=says)
    assert cli("sweep", "--status", "slider-crank").code == 2


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_a_signal_keeps_the_store_and_the_same_command_goes_on(tmp_path):
    """The answer comes at once: nobody waits for points under way."""
    command = [
        sys.executable, "-m", "linkages", "sweep", "ninebar", "--no-figures",
        "--measure", "max(abs(crank1.effort))", "--set", "simulate.end=20", "--store", "study",
        "--sample", "clearances.r1.angle=uniform(0, 6)", "--draws", "32", "--cores", "2",
    ]  # fmt: skip
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    chunks = tmp_path / "study" / "chunks"
    while process.poll() is None and not list(chunks.glob("?????????")):
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate()
    assert process.returncode == 1, said
    assert "the same command continues with the results in study" in said
    subprocess.run(command, cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    found = xr.load_dataset(tmp_path / "study" / "result.nc", engine="h5netcdf")
    assert not found.outcome.any()
