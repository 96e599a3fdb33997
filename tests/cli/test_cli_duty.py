"""``duty`` on the command line: what it prints and writes, and that it is computed again."""

import json

import xarray as xr

ASKED = ("duty", "slider-crank", "--fluctuation", "0.02", "--motors", "crank=300 N m, 3000 rpm")


def test_a_table_a_figure_and_files(cli):
    found = cli(*ASKED)
    assert (found.code, found.err) == (0, "")
    assert "Duty over a cycle of" in found.out
    assert "flywheel (kg m^2)" in found.out
    names = ("duty.nc", "duty.csv", "duty.png")
    assert {f"results/slider-crank/{name}" for name in names} <= found.files
    with open("results/slider-crank/duty.csv", encoding="utf-8") as file:
        head, row = file.read().splitlines()
    assert head.startswith("drive,effort_peak (N m),")
    assert row.startswith("crank,")


def test_json_and_the_same_again(cli):
    content = json.loads(cli(*ASKED, "--json", "--no-figures").out)
    (row,) = content["drives"]
    assert row["drive"] == "crank"
    assert row["flywheel"] > 0
    again = cli("duty", "results/slider-crank/duty.nc", "--out", "again", "--no-figures")
    assert (again.code, again.err) == (0, "")
    first, second = (
        xr.load_dataset(path, engine="h5netcdf")
        for path in ("results/slider-crank/duty.nc", "again/duty.nc")
    )
    assert first.equals(second)
