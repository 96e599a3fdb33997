"""``optimise`` and ``fit`` on the command line: what they print, write and refuse."""

import csv
import json

import numpy as np
import pytest
import xarray as xr

import linkages

CRANK = ("--vary", "bars.crank.length=10:60mm")
LONGEST = ("--maximise", "stroke(piston.position)", "--subject-to", "min(transmission_angle)>75deg")


def test_optimise_prints_and_writes(cli):
    found = cli("optimise", "slider-crank", *CRANK, *LONGEST)
    assert found.code == 0
    assert "bars.crank.length  40     36.2347  10    60  mm" in found.out
    assert "yes" in found.out
    results = "results/slider-crank"
    names = ("optimise.nc", "optimise.csv", "optimise_convergence.png", "optimise_curves.png")
    assert found.files >= {f"{results}/{name}" for name in (*names, "optimised.yaml")}
    best = linkages.load(f"{results}/optimised.yaml")
    solution = linkages.simulate(best)
    angle = linkages.measure(solution, "min(transmission_angle)")
    assert angle == pytest.approx(np.radians(75), rel=1e-8)
    data = xr.load_dataset(f"{results}/optimise.nc", engine="h5netcdf")
    with open(f"{results}/optimise.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["run", "bars.crank.length (mm)", "stroke(piston.position) (m)", "violation"]
    assert len(rows) == 1 + data.sizes["run"]
    assert float(rows[1][1]) == pytest.approx(40.0, rel=1e-14)


def test_optimise_as_json_of_a_global_search_within_some_runs(cli):
    found = cli(
        "optimise", "slider-crank", *CRANK, "--minimise", "max(abs(crank.effort))", "--json",
        "--search", "global", "--runs", "40", "--seed", "4", "--cores", "1", "--no-figures",
        "--set", "bars.rod.mass=0.6", "--samples", "51",
    )  # fmt: skip
    content = json.loads(found.out)
    assert content["runs"] == 40
    assert content["search"] == "global"
    assert content["optimum"] <= content["start"]
    assert linkages.load("results/slider-crank/optimised.yaml").definition.value(
        ("bars", "rod", "mass")
    ) == "0.6"  # fmt: skip


def test_fit_prints_and_writes(cli):
    times = np.linspace(0, 1, 21)
    true = linkages.load("four-bar", set={"bars.crank.length": "38 mm"})
    data = linkages.simulate(true, times=times, outputs=["joint_position"]).data
    place = 1e3 * data.joint_position.sel(joint="P", axis="x").to_numpy()
    lines = "\n".join(f"{t!r},{x!r}" for t, x in zip(times.tolist(), place.tolist(), strict=True))
    with open("measured.csv", "w", encoding="utf-8") as file:
        file.write(f"time (s),P.x position (mm)\n{lines}\n")
    words = ("--to", "measured.csv", "--vary", "bars.crank.length=30:50mm")
    found = cli("fit", "four-bar", *words, "--sigma", "P.x position=0.1 mm")
    assert found.code == 0
    assert "bars.crank.length  40     38" in found.out
    assert "chi-square" in found.out
    results = "results/four-bar"
    names = ("fit.nc", "fit.csv", "fit.png", "fitted.yaml")
    assert found.files >= {f"{results}/{name}" for name in names}
    crank = linkages.load(f"{results}/fitted.yaml").definition.value(("bars", "crank", "length"))
    assert float(crank.removesuffix(" mm")) == pytest.approx(38, rel=1e-12)
    content = json.loads(cli("fit", "four-bar", *words, "--json", "--no-figures").out)
    assert content["sigma_known"] is False
    assert content["probability"] is None


def test_fit_refuses_in_one_message(cli):
    with open("measured.csv", "w", encoding="utf-8") as file:
        file.write("time (s),P.x position (mm)\n0,1\n1,b\n")
    words = ("four-bar", "--vary", "bars.crank.length=30:50mm")
    found = cli("fit", *words, "--to", "measured.csv")
    assert (found.code, "line 3, column 2" in found.err) == (2, True)
    found = cli("fit", *words, "--to", "other.csv")
    assert (found.code, "No such file" in found.err) == (2, True)
