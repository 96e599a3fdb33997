"""``workspace`` on the command line: what it prints, writes and refuses."""

import json

import xarray as xr


def test_curves_are_printed_drawn_and_written(cli):
    found = cli("workspace", "five-bar", "--point", "B", "--samples", "41")
    assert (found.code, found.err) == (0, "")
    assert "Curves of the workspace of B" in found.out
    results = "results/five-bar"
    names = ("workspace.nc", "workspace.csv", "workspace.png")
    assert {f"{results}/{name}" for name in names} <= found.files
    data = xr.load_dataset(f"{results}/workspace.nc", engine="h5netcdf")
    assert data.attrs["point"] == "B"
    assert {*data.kind.values} == {"inverse"}
    with open(f"{results}/workspace.csv", encoding="utf-8") as file:
        head, *rows = file.read().splitlines()
    assert head == "curve,kind,branch,x (m),y (m),crank1 (rad),crank2 (rad)"
    assert len(rows) == data.sizes["node"]


def test_json_has_a_row_for_each_curve(cli):
    asked = ("workspace", "five-bar", "--point", "B", "--samples", "41", "--own", "--json",
             "--range", "crank1=0:90 deg", "--no-figures")  # fmt: skip
    found = json.loads(cli(*asked).out)
    assert {one["kind"] for one in found["curves"]} == {"inverse", "limit"}
    assert {one["branch"] for one in found["curves"]} == {"left"}


def test_a_file_of_results_is_computed_again(cli):
    cli("workspace", "five-bar", "--point", "B", "--samples", "41", "--own")
    again = cli("workspace", "results/five-bar/workspace.nc", "--out", "again", "--no-figures")
    assert (again.code, again.err) == (0, "")
    first, second = (
        xr.load_dataset(path, engine="h5netcdf")
        for path in ("results/five-bar/workspace.nc", "again/workspace.nc")
    )
    assert first.equals(second)


def test_a_wrong_range_is_refused(cli):
    found = cli("workspace", "five-bar", "--point", "B", "--range", "crank9=0:1")
    assert found.code == 2
    assert "unknown drive or actuator 'crank9'" in " ".join(found.err.split())
