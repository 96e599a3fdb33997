"""Tables and reports that `simulate` writes."""

import sys

import pytest


def test_the_command_writes_them(cli, tmp_path):
    asked = ("simulate", "slider-crank", "--no-figures", "--samples", "5", "--out", "x")
    assert cli(*asked, "--units", "mm,deg", "--table", "xlsx").code == 0
    names = {path.name for path in (tmp_path / "x").iterdir() if path.is_file()}
    assert names == {"simulate.nc", "simulate.xlsx"}
    assert cli(*asked, "--units", "mm").code == 0
    assert "slider_position[piston] (mm)" in (tmp_path / "x/simulate.csv").read_text()
    cli.refused(*asked, "--units", "kg", says="no output is measured in 'kg'")


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--units", "mm,rmp"], "did you mean 'rpm'"),
        (["--units", "mm,m"], "'mm' and 'm' measure the same"),
        (["--table", "xlsx"], "pip install 'linkages[xlsx]'"),
    ],
)
def test_what_cannot_be_written_is_refused_before_anything_is_computed(
    flags, says, cli, monkeypatch
):
    monkeypatch.setitem(sys.modules, "xlsxwriter", None)
    monkeypatch.setattr("linkages.cli.verbs.simulate_command.as_far_as_possible", None)
    cli.refused("simulate", "slider-crank", *flags, says=says, files=set())
