"""Laws on the command line: ranges in ``check``, loads in figures, tables and phase diagrams."""

import json

import pytest

import linkages

PUMP = """\
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.5, mass: 10}, rod: {joints: [A, B], length: 2, mass: 5}}
sliders: {p: {joint: B, through: O, mass: 20}}
drives: {crank: {angle: 0.3, speed: "2*pi/6"}}
assembly: {B: [2, 0]}
loads:
  - slider: p
    force: {table: {file: rod.csv, columns: [t, F], units: [s, kN], periodic: true}}
  - {joint: A, force: [3, "t**2"]}
  - bar: crank
    torque: {table: {times: [0, 1, 1.1, 3], values: [0, 0, 1, 1], interpolation: spline}}
simulate: {end: 12, samples: 121}
"""
ROD = "t;F\n0;-20\n1.5;-20\n1.6;-40\n4.5;-40\n4.6;-20\n6;-20\n"


@pytest.fixture
def pump(tmp_path):
    (tmp_path / "rod.csv").write_text(ROD)
    file = tmp_path / "pump.yaml"
    file.write_text(PUMP)
    return str(file)


def test_check_shows_ranges(cli, pump):
    found = json.loads(cli("check", pump, "--json").out)
    assert [row["value"] for row in found["drives"]] == ["0.3 rad at t = 0, 1.0472 rad/s"]
    values = [row["value"] for row in found["loads"]]
    assert values[0] == "-40000 to -20000 N in each period of 6 s"
    assert values[1] == "[3 N, 0 to 144 N until t = 12 s]"
    assert values[2].endswith(" N m until t = 12 s")
    assert any("loads[2].torque.table: the spline leaves the range" in n for n in found["notes"])
    text = cli("check", pump).out
    assert "Drives" in text
    assert "-40000 to -20000 N in each period of 6 s" in text


def test_a_drive_by_a_law(cli, pump):
    law = "drives.crank={law: 0.3 + sin(t)}"
    found = json.loads(cli("check", pump, "--json", "--set", law).out)
    assert found["drives"][0]["value"] == "-0.7 to 1.3 rad until t = 12 s"


@pytest.mark.slow
def test_loads_have_figures_and_maxima(cli, pump, tmp_path):
    result = cli("simulate", pump, "--out", str(tmp_path / "out"))
    assert {"load_force.png", "load_torque.png"} <= {p.name for p in (tmp_path / "out").iterdir()}
    assert "loads[0]" in result.out
    assert "loads[1].y" in result.out
    assert "loads[1].x" not in result.out
    assert "the spline leaves the range of its values" in " ".join(result.out.split())


def test_a_load_in_a_phase_diagram(cli, pump, tmp_path):
    out = tmp_path / "phase"
    cli("phase", pump, "--x", "p.position", "--y", "loads[0].force", "--out", str(out))
    assert list(out.glob("*.png"))


def test_tables_outside_of_the_folder_of_the_definition(tmp_path, cli):
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "outer.csv").write_text("secret,x\n0,1\n1,2\n2,1\n", encoding="utf-8")
    text = linkages.load("pendulum").to_yaml() + (
        "loads: [{bar: rod, torque: {table: {file: ../outer.csv}}}]\n"
    )
    (inner / "x.yaml").write_text(text, encoding="utf-8")
    refused = cli("check", str(inner / "x.yaml"))
    assert refused.code == 2
    assert "--tables-from" in refused.err
    assert "secret" not in refused.err
    assert cli("check", str(inner / "x.yaml"), "--tables-from", str(tmp_path)).code == 0
