"""``tolerance`` and ``import`` on the command line."""

import json
from pathlib import Path

import numpy as np
import pytest

import linkages

SET = ("--set", "bars.crank.length=40 ± 0.02 mm", "--set", "bars.rod.length=140 ± 0.05 mm")
STROKE = "stroke(piston.position)"
FAST = ("--draws", "200", "--samples", "41")


def test_it_writes_what_it_found(cli):
    done = cli(
        "tolerance", "slider-crank", *SET, *FAST, "--of", STROKE, "--of",
        "max(abs(error(piston.position)))", "--limits", f"{STROKE} > 79.98 mm",
    )  # fmt: skip
    assert done.code == 0, done.err
    assert "bars.crank.length" in done.out
    assert "95 % confidence" in done.out
    folder = "results/slider-crank/tolerance"
    written = {f"{folder}.nc", f"{folder}.csv", f"{folder}_1.png", f"{folder}_2.png"}
    assert {name for name in done.files if "." in name} == written
    data = linkages.open(f"{folder}.nc")
    assert data.mechanism.tolerances.keys() == {"bars.crank.length", "bars.rod.length"}
    again = data.compute()
    assert np.array_equal(again["sample"], data.data["sample"])
    lines = Path(f"{folder}.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 201
    assert lines[0].startswith("draw,bars.crank.length (m),bars.rod.length (m),")


def test_json_has_the_contributions(cli):
    done = cli("tolerance", "slider-crank", *SET, *FAST, "--of", STROKE, "--json", "--no-figures")
    found = json.loads(done.out)
    (measure,) = found["measures"]
    first, second = measure["contributors"]
    assert (first["path"], second["path"]) == ("bars.crank.length", "bars.rod.length")
    assert first["contribution"] == pytest.approx(4e-5, rel=1e-10)
    assert first["share"] == pytest.approx(1.0)
    assert measure["worst"] == pytest.approx([0.08 - 4e-5, 0.08 + 4e-5], rel=1e-12)
    assert found["draws"] == found["computed"] == 200


def test_a_link_becomes_a_file_once(cli):
    link = (
        "2P.Ay,1E8.K,0.1011.MA,A,0mv,0VU,0.GB,B,0e_,E6,0.GC,C,l1,WW,0.KD,D,qD,0Pk,0."
        ".YRAB,AB,Fe,Fe,0ix,08i,c5cae9,A,B,,.YRBC,BC,Fe,Fe,32,NJ,303e9f,B,C,,"
        ".YRCD,CD,Fe,Fe,nd,3P,0d125a,C,D,,...N_v"
    )
    done = cli("import", link, "--out", "four.yaml", "--no-masses", "--clearance", "C=0.1mm")
    assert done.code == 0, done.err
    assert done.files == {"four.yaml"}
    mechanism = linkages.load("four.yaml")
    assert mechanism.clearances[0].size == 1e-4
    cli.refused("import", link, "--out", "four.yaml", says="four.yaml exists; --force replaces it")
    says = "no bar has a joint 'X'"
    cli.refused("import", link, "--out", "other.yaml", "--clearance", "X=1mm", says=says)
