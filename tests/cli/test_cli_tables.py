"""Tables and reports that `simulate` writes."""


def test_the_command_writes_them(cli, tmp_path):
    asked = ("simulate", "slider-crank", "--no-figures", "--samples", "5", "--out", "x")
    assert cli(*asked, "--units", "mm,deg", "--table", "xlsx").code == 0
    names = {path.name for path in (tmp_path / "x").iterdir() if path.is_file()}
    assert names == {"simulate.nc", "simulate.xlsx"}
    assert cli(*asked, "--units", "mm").code == 0
    assert "slider_position[piston] (mm)" in (tmp_path / "x/simulate.csv").read_text()
    cli.refused(*asked, "--units", "kg", says="no output is measured in 'kg'")
