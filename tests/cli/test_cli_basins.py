"""Commands that find attractors of many starts, and their figures."""

import json

import pytest
import xarray as xr
from shared_definitions import IMPACTS

PLANE = "--x", "free.block.position=-3:0.9:6", "--y", "free.block.speed=-3:3:6"


@pytest.fixture
def file(tmp_path):
    (tmp_path / "m.yaml").write_text(IMPACTS)
    return "m.yaml"


def test_basins_have_the_keys_of_the_contract(cli, file):
    result = cli("basins", file, *PLANE, "--draws", "30", "--out", "o", "--json")
    assert result.code == 0, result.err
    found = json.loads(result.out)
    assert [one["kind"] for one in found["attractors"]] == ["periodic", "periodic"]
    for one in found["attractors"]:
        low, high = one["interval"]
        assert low <= one["fraction"] <= high
        assert one["period"] == pytest.approx(5.2359878)
    assert sum(found["cells"]) == 36
    names = {name.rpartition("/")[2] for name in found["files"]}
    assert names == {"basins.nc", "basins.csv", "basins_attractors.csv", "basins.png"}


def test_a_diagram_of_starts_shows_hysteresis(cli, file, tmp_path):
    vary = "parameters.A=0.1:0.6:6"
    result = cli("bifurcation", file, "--vary", vary, "--starts", "5", "--out", "o", "--json")
    assert result.code == 0, result.err
    found = json.loads(result.out)
    (both,) = found["coexisting"]
    assert (both["from"], both["to"]) == pytest.approx((0.2, 0.4))
    assert {(jump["attractor"], jump["becomes"]) for jump in found["jumps"]} == {(1, 2), (2, 1)}
    with xr.open_dataset(tmp_path / "o/bifurcation.nc", engine="h5netcdf") as data:
        assert data.sizes["start"] == 5
    assert (tmp_path / "o/bifurcation.png").stat().st_size > 0


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (("--starts", "4", "--start", "forward"), "goes with diagrams from given states"),
        (("--starts", "4", "--skip", "30"), "goes with diagrams from given states"),
        (("--within", "free.block.position=0:1"), "goes with --starts"),
    ],
)
def test_flags_that_do_not_go_together(cli, file, flags, message):
    cli.refused("bifurcation", file, "--vary", "parameters.A=0.1:0.6:6", *flags, says=message)
