"""A motion that cannot go on: exit code 1, when, where and why, and the samples so far."""

import json

import numpy as np
import pytest
import xarray as xr

# The sum of its shortest and longest bar exceeds that of the others: the crank cannot turn.
FOUR_BAR = """\
joints: {O2: [0, 0], O4: [0.1, 0]}
bars:
  crank: {joints: [O2, A], length: 0.06}
  coupler: {joints: [A, B], length: 0.07}
  rocker: {joints: [O4, B], length: 0.05, mass: 0.3}
drives: {crank: {angle: 0.5, speed: 1}}
assembly: {B: left}
simulate: {end: 6, samples: 601}
"""


@pytest.mark.parametrize("json_wanted", [True, False])
def test_what_was_computed_is_kept(cli, tmp_path, json_wanted):
    (tmp_path / "m.yaml").write_text(FOUR_BAR)
    result = cli("simulate", "m.yaml", "--no-figures", *(["--json"] if json_wanted else []))
    assert result.code == 1
    assert "Traceback" not in result.err
    # coupler and rocker stretched: (0.07 + 0.05)² = 0.1² + 0.06² − 2·0.1·0.06·cos θ
    limit = np.arccos((0.1**2 + 0.06**2 - 0.12**2) / (2 * 0.1 * 0.06))
    with xr.open_dataset(tmp_path / "results/m/simulate.nc", engine="h5netcdf") as data:
        time = data.time.to_numpy()
    assert time[-1] <= limit - 0.5 < time[-1] + 0.01
    if json_wanted:
        content = json.loads(result.out)
        assert content["completed"] is False
        assert content["samples"] == len(time)
        # bisected to the last digit of time
        assert content["stopped"]["time"] == pytest.approx(limit - 0.5, rel=1e-12)
        reason = content["stopped"]["reason"]
    else:
        assert result.err.startswith("stopped at t = ")
        reason = result.err
    for words in ("joint B", "block 0", "coupler and rocker", f"{limit - 0.5:.6g}"[:6]):
        assert words in reason


@pytest.mark.slow
def test_figures_of_a_motion_cut_short(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(FOUR_BAR)
    result = cli("simulate", "m.yaml", "--json")
    assert result.code == 1
    assert any(path.endswith(".png") for path in json.loads(result.out)["files"])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ninebar", "ninebar-ideal"])
def test_press_folded_onto_itself_is_singular(cli, tmp_path, name):
    """With E on the other side, rocker 6 and link 8 fold onto each other."""
    result = cli(
        "simulate", name, "--no-figures", "--json",
        "--set", "assembly.E=left", "--set", "simulate.samples=201",
    )  # fmt: skip
    assert result.code == 1
    content = json.loads(result.out)
    for words in ("joint F", "link8 and slider9", "singular", "1.546"):
        assert words in content["stopped"]["reason"]
    with xr.open_dataset(tmp_path / f"results/{name}/simulate.nc", engine="h5netcdf") as data:
        assert 1.53 < float(data.time[-1]) <= content["stopped"]["time"]
        assert data.sizes["time"] == content["samples"]
        assert all(np.isfinite(variable).all() for variable in data.data_vars.values())
