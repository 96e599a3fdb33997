"""``wear``: what it prints and writes, and that results are computed again."""

import csv
import json

import numpy as np
import pytest
from PIL import Image

import linkages
from linkages.plots.motion import wear_figures

ROTOR = """
name: Rotor
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rotor: {joints: [O, P], length: 0.1, mass: 2 ± 10 %, center: 0, inertia: 1e-3}}
drives: {rotor: {angle: 0, speed: 200}}
clearances:
  gap: {joint: O, bar: rotor, size: 0.1 mm, angle: -90 deg, pin_radius: 10 mm, width: 20 mm,
        wear: {journal: {wear_rate: 1e-14}, bearing: {wear_rate: 1e-13}}}
"""
FAST = ["--skip", "0", "--no-figures"]


@pytest.fixture
def rotor(tmp_path):
    (tmp_path / "m.yaml").write_text(ROTOR, encoding="utf-8")
    return "m.yaml"


def found(result):
    assert result.code == 0, result.err
    return json.loads(result.out)


def test_json_has_the_keys_of_wear(rotor, cli, tmp_path):
    said = found(cli("wear", rotor, "--revolutions", "1e6", "--json", "--out", "o", *FAST))
    assert said["revolutions"] == 1e6
    assert said["volume"].keys() == {"journal", "bearing"}
    assert said["volume"]["bearing"] == pytest.approx(10 * said["volume"]["journal"])
    assert 1e-4 < said["size"] < 1e-3
    assert 0.0 <= said["error"] < 1e-2 * (said["size"] - 1e-4)
    assert said["clearances"][0]["name"] == "gap"
    assert said["ended"] == "revolutions"
    with (tmp_path / "o" / "wear.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[-1]["size (m)"]) == pytest.approx(said["size"], rel=1e-9)
    opened = linkages.open(tmp_path / "o" / "wear.nc")
    assert np.array_equal(opened.compute()["size"], opened.data["size"])


def test_life_until_a_limit(rotor, cli, tmp_path):
    command = ["wear", rotor, "--until", "clearances.gap.size = 0.2 mm", "--life", "--draws", "3"]
    said = found(cli(*command, "--store", "s", "--json", "--out", "o", *FAST))
    life = said["life"]
    assert life["nominal"] == pytest.approx(said["revolutions"], rel=1e-9)
    assert life["uncertainty"] == 5.0
    assert life["revolutions"]["P10"] < life["revolutions"]["P50"] < life["revolutions"]["P90"]
    (own,) = life["sensitivities"]
    assert own["path"] == "bars.rotor.mass"
    assert own["exponent"] == pytest.approx(-1.0, abs=1e-3)
    assert (tmp_path / "s" / "life" / "result.nc").exists()
    again = found(cli(*command, "--store", "s", "--json", "--out", "p", *FAST))
    assert again["life"] == life
    text = cli(*command, "--store", "s", "--out", "q", *FAST).out
    assert "% of life per %" in text
    assert "with wear rates between 1/5 and 5 times those of the file" in text


def test_figures_and_film(rotor, cli, tmp_path, monkeypatch):
    monkeypatch.setattr(wear_figures, "FRAMES", 6)  # the last picture stays for a second
    command = ["wear", rotor, "--until", "clearances.gap.size = 0.2 mm", "--life", "--draws", "2"]
    found(cli(*command, "--film", "--json", "--out", "o", "--skip", "0"))
    names = {path.name for path in (tmp_path / "o").iterdir() if path.is_file()}
    assert {"wear.png", "wear_depth.png", "wear.gif", "life.png", "life.nc", "life.csv"} <= names
    with Image.open(tmp_path / "o" / "wear.gif") as film:
        assert film.n_frames > 1


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ([], "--revolutions"),
        (["--life", "--revolutions", "9"], "a life ends at a limit; expected --until"),
        (["--until", "clearances.gap.size=1 N"], "clearances.gap.size: expected a length > 0"),
    ],
)
def test_wrong_flags(rotor, cli, flags, message, tmp_path):
    result = cli("wear", rotor, *flags, "--out", "o", *FAST)
    assert result.code == 2
    assert message in result.err
    assert not (tmp_path / "o").exists()
