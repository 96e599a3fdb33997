"""Tables in units of their readers, read back by other programs and compared with the run."""

import sys

import numpy as np
import openpyxl
import pandas as pd
import pytest

import linkages
from linkages.reports.tables import Wanted

ASKED = ["slider_position", "slider_velocity", "bar_angle", "bar_speed", "drive_effort"]
EXPECTED = {  # head in the table → output, element, size of the unit in SI
    "slider_position[piston] (mm)": ("slider_position", "piston", 1e-3),
    "slider_velocity[piston] (mm/ms)": ("slider_velocity", "piston", 1.0),
    "bar_angle[crank] (deg)": ("bar_angle", "crank", np.pi / 180),
    "bar_speed[crank] (rpm)": ("bar_speed", "crank", 2 * np.pi / 60),
    "drive_effort[crank] (N mm)": ("drive_effort", "crank", 1e-3),
}
UNITS = "mm, ms, deg, rpm"


@pytest.fixture(scope="module")
def solution():
    mechanism = linkages.load("slider-crank", set={"bars.rod.length": 0.3})
    return linkages.simulate(mechanism, outputs=ASKED, samples=11)


def _compare(read, solution):
    assert read.columns[0] == "time (ms)"
    np.testing.assert_allclose(read["time (ms)"], solution.data["time"] * 1e3, rtol=1e-15)
    for head, (name, element, size) in EXPECTED.items():
        array = solution.data[name]
        wanted = array.sel({array.dims[1]: element}) / size
        np.testing.assert_allclose(read[head], wanted, rtol=1e-14)  # two roundings of a factor


def test_a_text_is_read_back(solution, tmp_path):
    path = linkages.save_table(solution, tmp_path / "run.csv", UNITS)
    _compare(pd.read_csv(path), solution)


def test_a_workbook_is_read_back(solution, tmp_path):
    path = linkages.save_table(solution, tmp_path / "run.xlsx", UNITS)
    _compare(pd.read_excel(path, sheet_name="series"), solution)
    book = openpyxl.load_workbook(path)
    run = [[cell.value for cell in row] for row in book["run"].rows]
    assert ["differs from its file", "bars.rod.length=0.3"] in run
    text = "\n".join(row[0].value or "" for row in list(book["definition"].rows)[1:])
    assert linkages.loads(text) == solution.mechanism
    largest = {(row[0].value, row[1].value): row[4].value for row in book["maxima"].rows}
    wanted = next(row for row in solution.maxima if row["variable"] == "drive_effort")
    assert largest[wanted["long_name"], "crank"] == pytest.approx(
        wanted["greatest"] * 1e3, rel=1e-14
    )


def test_without_units_a_table_is_that_of_the_run(solution, tmp_path):
    own = linkages.save_table(solution, tmp_path / "run.csv")
    _, text = solution.save(tmp_path)
    assert own.read_bytes() == text.read_bytes()


@pytest.mark.parametrize(
    ("units", "message"),
    [
        (["kg"], "no output is measured in 'kg'; found s"),
        (["mm", "cm"], "'mm' and 'cm' measure the same"),
        (["milimeter"], "did you mean 'millimeter'"),
    ],
)
def test_units_that_make_no_sense_are_named(solution, tmp_path, units, message):
    with pytest.raises(ValueError, match=message):
        linkages.save_table(solution, tmp_path / "run.csv", units)
    assert not (tmp_path / "run.csv").exists()


def test_a_part_of_a_unit_is_exchanged():
    units = Wanted(("mm", "kN"))
    assert units.of("N m") == ("kN mm", pytest.approx(1.0, rel=1e-15))
    assert units.of("m/s^2") == ("mm/s^2", pytest.approx(1e3, rel=1e-15))
    assert units.of("1") == ("1", 1.0)


def test_a_package_that_is_missing_is_named(solution, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "xlsxwriter", None)
    with pytest.raises(ImportError, match=r"pip install 'linkages\[xlsx\]'"):
        linkages.save_table(solution, tmp_path / "run.xlsx")


def test_an_ending_is_refused(solution, tmp_path):
    with pytest.raises(ValueError, match=r"\.csv or \.xlsx"):
        linkages.save_table(solution, tmp_path / "run.txt")
