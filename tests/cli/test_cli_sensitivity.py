"""``sensitivity`` on the command line: what it prints, writes and refuses."""

import csv
import json

import pytest
import xarray as xr

import linkages

EFFORT = "max(abs(crank.effort))"


def test_a_table_in_units_of_the_file_with_files_and_figures(cli):
    found = cli("sensitivity", "slider-crank", "--of", EFFORT, "--to", "bars.*", "--to", "drives.*")
    assert found.code == 0
    assert f"{EFFORT} = 20.241 N m" in found.out
    results = "results/slider-crank"
    names = ("sensitivity.nc", "sensitivity.csv", "sensitivity.png", "sensitivity_curves.png")
    assert found.files >= {f"{results}/{name}" for name in names}
    rows = [line.split() for line in found.out.splitlines() if "bars.rod.length" in line]
    assert rows[0][1:3] == ["140", "mm"]
    data = xr.load_dataset(f"{results}/sensitivity.nc", engine="h5netcdf")
    exact = linkages.sensitivities(linkages.load("slider-crank"), EFFORT, "bars.rod.length")
    slope = data[EFFORT].sel(parameter="bars.rod.length").item()
    # along other directions sums of the same terms may round differently
    assert slope == pytest.approx(exact[EFFORT].item(), rel=1e-12)
    with open(f"{results}/sensitivity.csv", encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    row = next(row for row in table if row["parameter"] == "bars.rod.length")
    assert float(row["derivative"]) == pytest.approx(slope * 1e-3, rel=1e-12)
    assert float(row["relative"]) == pytest.approx(slope * 0.14 / float(row["value"]), rel=1e-12)


def test_json_has_the_largest_effect_first(cli):
    found = cli(
        "sensitivity", "slider-crank", "--of", "stroke(piston.position)", "--to", "bars.*.length",
        "--json", "--no-figures",
    )  # fmt: skip
    (measure,) = json.loads(found.out)["measures"]
    assert measure["effects"][0]["parameter"] == "bars.crank.length"
    assert measure["effects"][0]["relative"] == pytest.approx(1.0)  # the stroke is 2 r


def test_units_are_those_of_numbers_with_a_tolerance_as_well(cli):
    found = cli(
        "sensitivity", "slider-crank", "--set", "bars.rod.length=140 ± 0.2 mm (uniform)",
        "--of", EFFORT, "--to", "bars.rod.length", "--no-figures",
    )  # fmt: skip
    (row,) = [line.split() for line in found.out.splitlines() if line.startswith("bars.rod.length")]
    assert row[1:3] == ["140", "mm"]


def test_a_measure_that_fails_has_its_reason_in_table_and_files(cli):
    late = "at(3 s, crank.effort)"
    asked = ("sensitivity", "slider-crank", "--of", late, "--of", EFFORT, "--to", "bars.*.length")
    found = cli(*asked)
    assert found.code == 0
    assert f"{late} has no value" in found.out
    assert f"{EFFORT} = 20.241 N m" in found.out
    assert f"note: measure '{late}': t = 3 s is outside of the motion" in found.out
    with open("results/slider-crank/sensitivity.csv", encoding="utf-8", newline="") as file:
        rows = {row["measure"]: row for row in csv.DictReader(file)}
    assert rows[late]["derivative"] == rows[EFFORT]["reason"] == ""
    assert "outside of the motion" in rows[late]["reason"]
    failed, sound = json.loads(cli(*asked, "--json", "--no-figures").out)["measures"]
    assert failed["value"] is failed["effects"][0]["derivative"] is sound["reason"] is None
    assert "outside of the motion" in failed["reason"]
