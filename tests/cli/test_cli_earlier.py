"""Results, stores and plug-ins of earlier versions still open, resume and compute."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

import linkages

EARLIER = Path(__file__).parents[1] / "data/earlier"
PENDULUM = str(EARLIER / "pendulum.yaml")
STORES = {
    "sweep-store": (
        "sweep.csv", "sweep", "slider-crank", "--vary", "bars.crank.length=30mm:50mm:5",
        "--measure", "max(abs(crank.effort))",
    ),
    "free-store": (
        "free.csv", "sweep", PENDULUM, "--vary", "dampers[0].damping=0.05:0.1:3",
        "--measure", "max(arm.angle)", "--end", "2",
    ),
    "map-store": (
        "map.csv", "map", PENDULUM, "--x", "free.arm.angle=-2:2:3",
        "--y", "free.arm.speed=-1:1:3", "--indicator", "fli", "--periods", "5",
    ),
    "bif-store": (
        "bifurcation.csv", "bifurcation", PENDULUM, "--vary", "dampers[0].damping=0.05:0.2:3",
        "--periods", "10",
    ),
}  # fmt: skip


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


def value(cell):
    try:
        return float(cell)
    except ValueError:
        return cell


def expected_cell(cell):
    number = value(cell)
    return pytest.approx(number, rel=1e-7) if isinstance(number, float) else number


@pytest.mark.parametrize("store", STORES)
def test_a_store_goes_on_to_the_same_table(store, cli, tmp_path):
    """What it holds is not computed again, what it lacks is, with digits of this processor."""
    table, verb, *arguments = STORES[store]
    shutil.copytree(EARLIER / store, tmp_path / store)
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / store / "chunks").iterdir()}
    done = cli(verb, *arguments, "--store", store, "--out", "results", "--no-figures")
    assert done.code == 0, done.err
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    found, expected = rows(tmp_path / "results" / f"{verb}.csv"), rows(EARLIER / table)
    assert [[expected_cell(cell) for cell in row] for row in expected] == [
        [value(cell) for cell in row] for row in found
    ]


def test_results_open_and_are_computed_again():
    opened = linkages.open(EARLIER / "simulate.nc")
    again = opened.compute().data
    assert list(again.data_vars) == list(opened.data.data_vars)
    for name, values in opened.data.data_vars.items():
        np.testing.assert_allclose(again[name], values, rtol=1e-12, atol=1e-15)


def test_a_figure_is_a_definition(cli):
    done = cli("simulate", str(EARLIER / "slider_position.svg"), "--no-figures", "--json")
    assert done.code == 0, done.err
    assert '"mechanism": "Slider-crank"' in done.out
