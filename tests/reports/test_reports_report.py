"""Reports say what was computed, from what, and can be computed again."""

import re
from dataclasses import replace

import numpy as np
import openpyxl
import pytest
from pypdf import PdfReader

import linkages
from linkages.plots.style import DEGREES, Scale, axis_scale, shown_in
from linkages.reports.report import Items, Section, rounded
from linkages.reports.sheets import MARK, input_rows, run_report
from linkages.reports.tables import LATE, LOADS, OPEN, SI, rows_of_loads, rows_of_measures, wanted
from linkages.solution.files import origin_of


@pytest.fixture(scope="module")
def solution():
    mechanism = linkages.load("ninebar", set={"clearances.r1.size": "0.2 mm"})
    return linkages.simulate(mechanism, end=0.02, samples=41)


def parts_of(solution):
    """Facts, rows of least and largest values, and what marks in them mean."""
    report = run_report(solution, origin_of(solution.mechanism, solution.options))
    facts = next(part.texts for part in report.parts if isinstance(part, Items))
    sections = [part for part in report.parts if isinstance(part, Section)]
    table, *marks = next(part.parts for part in sections if part.heading.startswith("Least"))
    return facts, table.cells, marks


def test_inputs_are_all_entries_and_mark_what_differs(solution):
    rows = dict(input_rows(solution.mechanism))
    assert "size 0.2 mm" in rows[f"{MARK} clearances.r1"]
    assert sum(name.startswith(MARK) for name in rows) == 1
    bars = {bar.name for bar in solution.mechanism.components if bar.section == "bars"}
    assert {f"bars.{name}" for name in bars} <= rows.keys()


@pytest.mark.slow
def test_values_beyond_the_horizon_are_marked(solution):
    late = replace(solution, data=solution.data.assign_attrs(horizon=1e-9))
    facts, rows, marks = parts_of(late)
    ends = [row[place : place + 2] for row in rows for place in (2, 4)]
    assert {LATE in value for value, time in ends if time != "0"} == {True}
    assert any(text.startswith(LATE) for text in marks)
    assert "predictable to t = 1e-09 s" in facts
    assert not any(LATE in row[2] + row[4] for row in parts_of(solution)[1])


def test_least_and_largest_values_are_those_of_the_run(solution):
    ends = [
        (row[2].rstrip(LATE + OPEN), row[4].rstrip(LATE + OPEN)) for row in parts_of(solution)[1]
    ]
    moving = [row for row in solution.maxima if row["least"] or row["greatest"]]
    assert ends == [(rounded(row["least"]), rounded(row["greatest"])) for row in moving]
    assert len(moving) < len(solution.maxima)  # fixed pivots have no velocity


def test_a_page_needs_no_other_file_and_is_computed_again(solution, tmp_path):
    path = linkages.save_report(solution, tmp_path / "report.html")
    text = path.read_text(encoding="utf-8")
    assert "clearances.r1.size = 0.2 mm" in text
    assert not re.findall(r'(?:src|href)="(?!data:)', text)
    assert str(tmp_path) not in text
    assert linkages.load(path) == solution.mechanism


@pytest.fixture(scope="module")
def sheet(solution, tmp_path_factory):
    return linkages.save_report(solution, tmp_path_factory.mktemp("reports") / "report.pdf")


@pytest.mark.slow
def test_a_sheet_is_computed_again(solution, sheet):
    (page,) = PdfReader(sheet).pages
    assert tuple(map(float, page.mediabox[2:])) == pytest.approx((1190.88, 841.68))  # A3 in points
    assert linkages.load(sheet) == solution.mechanism


@pytest.mark.slow
def test_a_sheet_shows_vectors_and_all_rows(solution, sheet):
    (page,) = PdfReader(sheet).pages
    assert not page.images
    text = page.extract_text()
    words = {word for row in input_rows(solution.mechanism) for word in row[0].split()}
    words |= {row[4] for row in parts_of(solution)[1]}
    assert {word for word in words if word not in text} == set()


@pytest.mark.slow
def test_long_tables_take_more_sheets(tmp_path):
    chain = linkages.simulate(linkages.load("jansen"), end=0.1, samples=5, outputs="all")
    sheets = PdfReader(linkages.save_report(chain, tmp_path / "report.pdf")).pages
    assert len(sheets) > 1
    kind = "joint reaction"
    values = sum(row["long_name"] == kind and bool(row["value"]) for row in chain.maxima)
    loads = sum(row[0] == kind for row in rows_of_loads(chain, SI))
    assert sum(sheet.extract_text().count(kind) for sheet in sheets) == values + loads


def test_an_ending_is_refused(solution, tmp_path):
    with pytest.raises(ValueError, match=r"\.html or \.pdf"):
        linkages.save_report(solution, tmp_path / "report.doc")


@pytest.fixture(scope="module")
def shared_pins():
    """A motion with pins of three bodies, a guide and a clearance."""
    outputs = ["joint_position", "bar_angle", "slider_position", "drive_effort", *LOADS]
    return linkages.simulate(linkages.load("ninebar"), end=0.2, samples=41, outputs=outputs)


def test_measures_loads_and_units_are_equal_in_all_formats(shared_pins, tmp_path):
    asked = {"units": "mm,kN", "measures": ["max(abs(crank1.effort))", "min(r1.force)"]}
    effort = linkages.measure(shared_pins, "max(abs(crank1.effort))")
    force = shared_pins.data.pin_reaction.sel(pin="B.link3")
    page = linkages.save_report(shared_pins, tmp_path / "r.html", **asked).read_text("utf-8")
    sheet = linkages.save_report(shared_pins, tmp_path / "r.pdf", **asked)
    book = openpyxl.load_workbook(linkages.save_table(shared_pins, tmp_path / "r.xlsx", **asked))
    measures, loads = ([[*row] for row in book[name].values] for name in ("measures", "loads"))
    assert measures[1] == ["max(abs(crank1.effort))", pytest.approx(effort), "kN mm"]
    (largest,) = [row[2] for row in loads if row[1] == "B.link3"]
    sampled = 1e-3 * float((force**2).sum("axis").max() ** 0.5)
    assert sampled <= largest * (1 + 1e-12)
    assert largest == pytest.approx(sampled, rel=0.05)
    written = "".join(part.extract_text() for part in PdfReader(sheet).pages)
    for row in (measures[1], measures[2]):
        assert f"<td>{row[1]:.6g}</td><td>{row[2].replace(' ', '·')}</td>" in page
        assert f"{row[1]:.6g}" in written
    for row in loads[1:]:
        assert f"<td>{row[0]}</td><td>{row[1]}</td><td>{row[2]:.6g}</td>" in page
        assert f"{row[2]:.6g}" in written


def test_curves_are_in_the_units_of_tables_in_all_formats(shared_pins, tmp_path):
    curves = ["crank1.effort", "r1.force", "slider9.position", "crank1.angle"]
    asked = {"units": "mm,kN,deg", "curves": curves}
    page = run_report(
        shared_pins, origin_of(shared_pins.mechanism, shared_pins.options),
        wanted("mm,kN,deg"), (), curves,
    )  # fmt: skip
    sections = [part for part in page.parts if isinstance(part, Section)]
    drawn = next(part.parts for part in sections if part.heading == "Curves")
    axes = [picture.figure.axes[0] for picture in drawn]
    labels = [ax.get_ylabel().rpartition("[")[2].rstrip("]") for ax in axes]
    assert labels == ["kN·mm", "kN", "mm", "°"]
    assert {ax.get_xlabel() for ax in axes} == {"time [s]"}
    book = openpyxl.load_workbook(linkages.save_table(shared_pins, tmp_path / "r.xlsx", **asked))
    heads, *rows = book["curves"].values
    assert heads[1:] == tuple(
        f"{name} ({unit})" for name, unit in zip(curves, ["kN mm", "kN", "mm", "deg"], strict=True)
    )
    for index, ax in enumerate(axes):
        column = [row[index + 1] for row in rows]
        low, high = min(column), max(column)
        shown = np.concatenate([
            *(line.get_ydata() for line in ax.lines),
            *(path.vertices[:, 1] for own in ax.collections for path in own.get_paths()),
        ])  # fmt: skip
        assert (shown.min(), shown.max()) == pytest.approx((low, high), rel=1e-6, abs=1e-9)
    data = shared_pins.data
    effort = data["drive_effort"].sel(drive="crank1").to_numpy()  # 1 N m is 1 kN mm
    assert np.interp(data["time"], [row[0] for row in rows], [row[1] for row in rows]) == (
        pytest.approx(effort, rel=0.02, abs=0.02 * np.abs(effort).max())
    )


def test_values_of_tables_have_four_digits():
    values = [0.0, 268.0, -0.1, 1000.0, 99999.6, 2.7755e-17, 4.0]
    shown = ["0", "268.0", "-0.1000", "1000", "1.000e+05", "2.776e-17", "4.000"]
    assert [rounded(value) for value in values] == shown


def test_units_that_nobody_named_are_shown_as_elsewhere():
    with shown_in(wanted("mm,rpm").chosen):
        assert axis_scale([3e-5], "m") == Scale(1e3, "mm")
        assert axis_scale([1.0], "rad/s").units == "rpm"
        assert axis_scale([1.0], "rad") == Scale(DEGREES, "°")
        assert axis_scale([2e7], "m/s²") == Scale(1e3, "mm/s²")
        assert axis_scale([2e4], "N").units == "kN"
    with shown_in(wanted("m,rad").chosen):
        assert axis_scale([3e-5], "m") == Scale(1.0, "m")
        assert axis_scale([3.0], "rad") == Scale(1.0, "rad")
    assert axis_scale([3e-5], "m").units == "µm"


def test_loads_have_every_body_of_a_shared_pin_once(shared_pins):
    named = [row[1] for row in rows_of_loads(shared_pins, SI)]
    assert {"O.ground", "O.crank1", "O.rocker6", "E.link7", "A", "F", "slider9"} <= {*named}
    assert named.count("O.ground") == 1


def test_a_measure_without_a_value_has_its_reason(shared_pins):
    ((_, value, _),) = rows_of_measures(shared_pins, ["max(1/(r1.force - r1.force))"], SI)
    assert "divides by zero" in value


def test_a_report_draws_the_curves_that_are_asked_for(shared_pins, tmp_path):
    page = linkages.save_report(shared_pins, tmp_path / "r.html", curves=["r1.force", "A.reaction"])
    assert page.read_text("utf-8").count("<figure>") == 3  # with the drawing
    with pytest.raises(ValueError, match=r"did you mean 'r1\.force'"):
        linkages.save_report(shared_pins, tmp_path / "r.html", curves=["r1.forc"])
    with pytest.raises(ValueError, match="no output is measured in 'kg'"):
        linkages.save_report(shared_pins, tmp_path / "r.html", units="kg")
