"""Figures of sections, sweeps, exponents, spectra, maps and contact show what the data say."""

import re
from html import unescape
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from linkages.chaos.contact_log import contact_check, lost_spans
from linkages.chaos.indicators import power_spectrum
from linkages.chaos.periods import Kind
from linkages.components.mechanisms.definition import load
from linkages.plots.chaos.chaos_figures import (
    Zoom,
    chaos_figures,
    contact_figure,
    exponents,
    section_figure,
    shown_forces,
    spectrum_figure,
)
from linkages.plots.chaos.diagrams import (
    bifurcation_figure,
    class_figure,
    indicator_map,
    map_figure,
    rotation_map,
)
from linkages.plots.motion.phase_diagrams import free_coordinates
from linkages.plots.panels import show_degrees
from linkages.plots.style import PALETTE
from linkages.reports.pages import page
from linkages.reports.report import Definition, Items, Notes, Picture, Report, Section, Table
from linkages.reports.verdict_report import threshold_rows, verdict_report


def units(unit):
    return {"units": unit, "long_name": unit}


def section_data(angles, rates, names=("arm",)):
    shape = (len(angles), len(names))
    return xr.Dataset(
        {
            "bar_angle": (("crossing", "bar"), np.reshape(angles, shape), units("rad")),
            "bar_speed": (("crossing", "bar"), np.reshape(rates, shape), units("rad/s")),
        },
        {"bar": list(names), "time": ("crossing", np.arange(len(angles)) * 2.0)},
        {"name": "Pendulum", "period": 2.0},
    )


def sweep_data(exponent=False, starts=2):
    """Two starts, five values, four points; nothing at the last value, from neither start."""
    rng = np.random.default_rng(1)
    shape = (starts, 5, 4, 1)
    reason = np.full((starts, 5), "", dtype=object)
    reason[:, 4] = "cannot be assembled"
    reason[0, 1] = "cannot be assembled"
    angle = rng.uniform(-1, 1, shape)
    angle[:, 4], angle[0, 1] = np.nan, np.nan
    dims = ("start", "value", "crossing", "clearance")
    data = xr.Dataset(
        {
            "clearance_angle": (dims, angle, units("rad")),
            "clearance_speed": (dims, 10 * angle, units("rad/s")),
            "reason": (("start", "value"), reason),
        },
        {
            "clearances.r1.size": ("value", np.linspace(0.1, 0.5, 5), {"units": "mm"}),
            "clearance": ["r1"],
        },
        {"name": "Press", "varied": "clearances.r1.size"},
    )
    if exponent:
        values = np.where(reason == "", 0.5, np.nan)
        data["exponent"] = (("start", "value"), values, units("1/s"))
        data["error"] = (("start", "value"), np.full(values.shape, 0.1), units("1/s"))
    return data


# angles


def ticks(ax):
    low, high = ax.get_xlim()
    return [place for place in ax.xaxis.get_majorticklocs() if low <= place <= high]


def test_angles_all_around_get_the_whole_turn():
    ax = Figure().add_subplot()
    show_degrees(ax, [-178, np.nan, 172])
    assert ax.get_xlim() == (-180, 180)
    assert ticks(ax) == list(range(-180, 181, 45))


@pytest.mark.parametrize(("last", "step"), [(300, 45), (30 * 360, 4 * 360)])
def test_angles_that_count_turns_are_not_cut(last, step):
    ax = Figure().add_subplot()
    ax.set_xlim(0, last)
    show_degrees(ax, [0, last])
    assert ax.get_xlim() == (0, last)
    assert ticks(ax) == list(range(0, last + 1, step))


def test_panels_of_one_height_have_the_same_ticks():
    data = sweep_data()
    data["clearance_angle"] = data["clearance_angle"] * 0 + np.linspace(-3.1, 3.1, 4)[:, None]
    both = xr.concat([data, data.assign_coords(clearance=["r2"])], "clearance", data_vars="minimal")
    first, second = bifurcation_figure(both).axes
    assert list(first.yaxis.get_majorticklocs()) == list(second.yaxis.get_majorticklocs())


# sections


def test_section_shows_every_point():
    data = section_data([0.1, 0.3, -0.2], [1.0, 2.0, 3.0])
    figure = section_figure(data)
    (ax,) = figure.axes
    points = np.radians(ax.lines[0].get_xdata()), ax.lines[0].get_ydata()
    np.testing.assert_allclose(points, [[0.1, 0.3, -0.2], [1, 2, 3]])
    assert ax.get_xlabel() == "angle [°]"
    assert ax.get_title(loc="right") == "3 points"


def test_section_has_a_panel_for_each_coordinate():
    data = xr.concat(
        [section_data([0.1], [1.0], ("a",)), section_data([2.0], [3.0], ("b",))], "bar"
    )
    assert [ax.get_title(loc="left") for ax in section_figure(data).axes] == ["a", "b"]
    assert [found.name for found in free_coordinates(data)] == ["a", "b"]


def test_points_that_coincide_are_one():
    data = section_data(0.5 + 1e-12 * np.arange(9), 2 + 1e-11 * np.arange(9))
    (ax,) = section_figure(data).axes
    assert np.ptp(ax.get_xlim()) > 0.1
    assert np.ptp(ax.get_ylim()) > 0.1


def test_parts_of_a_section_are_drawn_once_more():
    angles, rates = np.radians(np.linspace(-40.0, 40.0, 9)), np.linspace(0.0, 4.0, 9)
    data, part = section_data(angles, rates), Zoom(-25.0, 25.0, 0.5, 3.5)
    main, one, other = section_figure(data, [part, Zoom(5.0, 15.0, 2.0, 3.0)]).axes
    assert [len(ax.lines[0].get_xdata()) for ax in (main, one, other)] == [9, 5, 1]
    assert one.get_xlim() == (-25.0, 25.0)
    (frame, _) = main.patches
    assert (*frame.get_xy(), frame.get_width(), frame.get_height()) == (-25.0, 0.5, 50.0, 3.0)


def test_parts_belong_to_one_free_coordinate():
    data = section_data(np.zeros((3, 2)), np.zeros((3, 2)), names=("arm", "rod"))
    assert len(section_figure(data, [Zoom(-1, 1, -1, 1, "rod")]).axes) == 2
    with pytest.raises(ValueError, match="one free coordinate, arm or rod; found -1,1,-1,1"):
        section_figure(data, [Zoom(-1, 1, -1, 1)])


def test_no_section_without_points():
    assert section_figure(section_data([], [])) is None


# bifurcation diagrams


def test_bifurcation_shows_points_over_the_parameter_in_its_unit():
    data = sweep_data()
    (ax,) = bifurcation_figure(data).axes
    assert ax.get_xlabel() == "radial clearance r1 [mm]"
    dots = [line for line in ax.lines if line.get_marker() == "o"]
    assert [line.get_color() for line in dots] == list(PALETTE[:2])
    x, y = dots[1].get_data()
    np.testing.assert_allclose(x, np.repeat(data["clearances.r1.size"], 4))
    angles = data["clearance_angle"][1, :, :, 0].to_numpy().ravel()
    np.testing.assert_allclose(np.radians(y), angles)


def test_values_without_contact_are_hatched():
    """From all starts that were computed: the second value from both, the third from one."""
    data = sweep_data()
    starts, values = data.sizes["start"], data.sizes["value"]
    lost = np.zeros((starts, values, 1))
    lost[:, 1] = 0.2
    lost[0, 2] = 0.1
    lost[1, 3:] = np.nan
    lost[0, 3] = 0.3
    data = data.assign(contact_lost=(("start", "value", "clearance"), lost))
    ax, *_ = bifurcation_figure(data).axes
    middles = [p.get_x() + 0.5 * p.get_width() for p in ax.patches if p.get_hatch()]
    np.testing.assert_allclose(middles, data["clearances.r1.size"][[1, 3]])
    assert "contact lost" in [text.get_text() for text in ax.get_legend().get_texts()]


def test_ranges_in_degrees_have_their_sign():
    data = sweep_data()
    angles = {"drives.crank.angle": ("value", np.arange(5.0), units("deg"))}
    data = data.assign_coords(angles).assign_attrs(varied="drives.crank.angle")
    assert bifurcation_figure(data).axes[0].get_xlabel() == "angle of crank [°]"


def test_varied_angles_are_drawn_in_degrees():
    data = sweep_data(exponent=True)
    angles = {"drives.crank.angle": ("value", np.radians([0.0, 90, 180, 270, 360]), units("rad"))}
    data = data.assign_coords(angles).assign_attrs(varied="drives.crank.angle")
    points, exponent = bifurcation_figure(data).axes
    assert exponent.get_xlabel() == "angle of crank [°]"
    assert points.get_xlim() == exponent.get_xlim() == pytest.approx((-45, 405))
    dots = [line for line in points.lines if line.get_marker() == "o"]
    np.testing.assert_allclose(np.unique(dots[1].get_xdata()), [0, 90, 180, 270, 360])
    assert points.patches[0].get_x() == pytest.approx(315)
    assert {0, 90, 180, 270, 360} <= set(ticks(points))


def test_headings_of_panels_keep_clear_of_the_panel_above():
    one, other = sweep_data(exponent=True), sweep_data(exponent=True)
    data = xr.concat([one, other.assign_coords(clearance=["r2"])], "clearance", data_vars="minimal")
    figure = bifurcation_figure(data)
    figure.canvas.draw()
    for above, below in zip(figure.axes, figure.axes[1:], strict=False):
        heading = below._right_title.get_window_extent()
        assert above.get_window_extent().y0 > heading.y1


def test_values_that_could_not_be_computed_are_shaded():
    (ax,) = bifurcation_figure(sweep_data()).axes
    (span,) = ax.patches
    # the last of 0.1, 0.2, …, 0.5; the one that one start reaches is no gap
    assert span.get_x() == pytest.approx(0.45)
    assert span.get_width() == pytest.approx(0.1)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["initial condition 1", "initial condition 2", "not computed (1)"]


def test_names_of_starts_stand_in_the_legend():
    data = sweep_data().assign_coords(start=["forward", "backward"])
    (ax,) = bifurcation_figure(data).axes
    assert [t.get_text() for t in ax.get_legend().get_texts()][:2] == ["forward", "backward"]


def test_exponents_stand_below_with_a_band_of_two_errors():
    _, below = bifurcation_figure(sweep_data(exponent=True)).axes
    assert below.get_ylabel() == "largest Lyapunov exponent [1/s]"
    band = below.collections[1].get_paths()[0].vertices
    assert band[:, 1].min() == pytest.approx(0.3)
    assert band[:, 1].max() == pytest.approx(0.7)
    zero = below.lines[0].get_ydata()
    assert list(zero) == [0, 0]


def test_rates_get_a_figure_of_their_own():
    (ax,) = bifurcation_figure(sweep_data(exponent=True), rates=True).axes
    assert ax.get_ylabel() == "clearance speed [rad/s]"


# exponents, spectra


def exponent_data(history):
    count = history.shape[1]
    return xr.Dataset(
        {
            "exponent": ("index", history[-1]),
            "error": ("index", np.full(count, 0.02)),
            "history": (("time", "index"), history),
        },
        {"time": 2.0 * np.arange(1, len(history) + 1), "index": np.arange(1, count + 1)},
        {
            "name": "Pendulum",
            "settled": 1,
            "warning": "",
            "source": "p.yaml",
            "sum": -0.5,
            "lost": 0,
        },
    )


def test_history_of_exponents_with_bands_and_zero():
    n = np.arange(1, 101)
    data = exponent_data(np.column_stack([0.3 + 50 / n**2, -0.8 - 50 / n**2]))
    ax = exponents(data)
    assert [line.get_ydata()[-1] for line in ax.lines[1:]] == pytest.approx([0.305, -0.805])
    band = ax.patches[0]
    assert band.get_y() == pytest.approx(0.305 - 0.04)
    assert band.get_height() == pytest.approx(0.08)
    # what came before they settled does not squeeze the picture: 50 of it
    assert ax.get_ylim()[1] < 2
    assert ax.get_legend().get_texts()[0].get_text() == "λ₁ = 0.305 ± 0.020 1/s"


def test_lines_of_a_spectrum_are_marked_where_they_are():
    time = np.arange(4000) * 0.01
    noise = np.random.default_rng(0).normal(size=time.size)
    found = power_spectrum(np.sin(2 * np.pi * 3.0 * time) + 1e-3 * noise, 0.01)
    (ax,) = spectrum_figure({"arm": found}, "Pendulum").axes
    (marks,) = [line for line in ax.lines if line.get_marker() == "v"]
    np.testing.assert_allclose(marks.get_xdata(), [3.0], atol=found.resolution)
    assert marks.get_label() == "1 line"
    power = ax.lines[0].get_ydata()
    assert power.max() == pytest.approx(0.0)  # decibels below the peak


def test_no_spectra_no_figure():
    assert spectrum_figure({}) is None


# maps


def map_data(values, words="libration"):
    values = np.asarray(values, dtype=float)
    reason = np.where(np.isnan(values), "cannot be assembled", "").astype(object)
    kinds = np.full((*values.shape, 1), words, dtype=object)
    kinds[np.isnan(values)] = ""
    return xr.Dataset(
        {
            "indicator": (("y", "x"), values, {"units": "1/s", "long_name": "exponent"}),
            "rotation": (("y", "x", "coordinate"), kinds),
            "reason": (("y", "x"), reason),
        },
        {
            "a.b": ("x", np.arange(values.shape[1], dtype=float), {"units": "mm"}),
            "c.d": ("y", np.arange(values.shape[0], dtype=float), {"units": ""}),
            "coordinate": ["arm"],
        },
        {"name": "Press", "kind": "exponent", "x": "a.b", "y": "c.d"},
    )


def test_map_has_a_colour_bar_and_shows_what_is_missing():
    ax, bar = map_figure(map_data([[0.1, 0.2, 0.3], [0.4, np.nan, 0.6]])).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("a.b [mm]", "c.d")
    assert bar.get_ylabel() == "exponent [1/s]"
    image = ax.collections[0]
    assert image.get_array().mask.sum() == 1
    assert (image.norm.vmin, image.norm.vmax) == pytest.approx((0, 0.6))  # white is zero
    assert ax.get_legend().get_texts()[0].get_text() == "not computed (1)"


def test_angles_of_a_map_are_drawn_in_degrees():
    data = map_data([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    angles = np.radians([-180.0, 0.0, 180.0])
    data = data.assign_coords({"a.b": ("x", angles, {"units": "rad"})})
    ax, _ = map_figure(data).axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("a.b [°]", "c.d")
    assert ax.get_xlim() == pytest.approx((-270, 270))
    borders = ax.collections[0].get_coordinates()[0, :, 0]
    np.testing.assert_allclose(borders, [-270, -90, 90, 270])


def test_zero_is_in_the_middle_of_colours_for_both_signs():
    ax, _ = map_figure(map_data([[-0.5, 0.2], [0.1, 0.3]])).axes
    norm = ax.collections[0].norm
    assert norm.vmin == -norm.vmax


@pytest.mark.parametrize(
    ("stored", "shown"), [*((str(kind), str(kind)) for kind in Kind), ("swing", "libration")]
)
def test_every_kind_of_motion_has_a_colour(stored, shown):
    """Also as maps stored it before 'swing' was called libration."""
    data = map_data(np.ones((2, 3)), stored)
    ax = rotation_map(data, "arm")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [shown]
    assert not np.ma.getmaskarray(ax.collections[0].get_array()).any()
    assert class_figure(data, "arm") is None  # of one colour


def test_a_map_of_one_colour_is_not_drawn():
    assert map_figure(map_data(np.ones((2, 3)))) is None
    untold = map_data([[0.1, 0.2], [0.3, 0.4]]).assign(sign=(("y", "x"), np.zeros((2, 2))))
    assert map_figure(untold) is None


def test_exponents_that_cannot_be_told_from_zero_are_white():
    signs = [[-1, 0], [0, 1]]
    data = map_data([[-0.5, 0.2], [0.1, 0.3]]).assign(sign=(("y", "x"), signs))
    ax, _ = map_figure(data).axes
    image = ax.collections[0]
    colours = image.cmap(image.norm(image.get_array())).reshape(2, 2, 4)
    white = (colours > 0.99).all(axis=-1)
    assert white.tolist() == [[False, True], [True, False]]
    (text,) = ax.get_legend().get_texts()
    assert text.get_text() == "exponent zero within error (50 % of points)"


def test_a_chart_of_zeros_alone_is_white():
    """Drawn into given axes, where a figure of its own would be left out."""
    signs = ("y", "x"), np.zeros((2, 2))
    data = map_data([[0.1, 0.2], [0.3, 0.4]]).assign(sign=signs)
    ax = Figure().add_subplot()
    image = indicator_map(data, ax).collections[0]
    assert (image.cmap(image.norm(image.get_array())) > 0.99).all()


def test_steps_of_colours_are_even():
    """Half of the way to the largest exponent is half of the way through the colours."""
    ax, _ = map_figure(map_data([[-0.5, 0.25], [0.1, 0.3]])).axes
    norm = ax.collections[0].norm
    assert norm([-0.5, -0.25, 0, 0.25, 0.5]).tolist() == [0, 0.25, 0.5, 0.75, 1]


def test_points_without_contact_are_hatched():
    data = map_data([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    lost = np.array([[0, 0.1, 0.2], [0, 0, np.nan]])[..., None]
    data = data.assign(contact_lost=(("y", "x", "clearance"), lost))
    ax, _ = map_figure(data).axes
    hatched = [c for c in ax.collections if c.get_hatch()]
    boxes = [path.get_extents() for c in hatched for path in c.get_paths()]
    assert [(b.x0, b.x1, b.y0, b.y1) for b in boxes] == [(0.5, 2.5, -0.5, 0.5)]
    assert ax.get_legend().get_texts()[0].get_text() == "contact lost (2)"


def test_gali_is_shown_by_its_logarithm_and_data_stay_as_they_are():
    data = map_data([[1.0, 1e-4], [1e-8, 0.1]])
    data.attrs["kind"] = "gali"
    before = data.copy(deep=True)
    ax, _ = map_figure(data).axes
    np.testing.assert_allclose(ax.collections[0].get_array().ravel(), [0, -4, -8, -1], atol=1e-12)
    xr.testing.assert_identical(data, before)


# contact


def force_data(values, time):
    return xr.DataArray(
        np.asarray(values)[:, None], {"time": time, "clearance": ["r1"]}, ("time", "clearance")
    )


def test_lost_contact_is_shaded_between_zeros():
    time = np.linspace(0, 1, 1001)
    (ax,) = contact_figure(force_data(np.cos(2 * np.pi * time), time), "Press").axes
    (span,) = ax.patches
    # the cosine is negative from a quarter to three quarters; linear between samples: to h²
    assert span.get_x() == pytest.approx(0.25, abs=1e-6)
    assert span.get_width() == pytest.approx(0.5, abs=2e-6)
    assert "50 %" in ax.get_title(loc="right")


@pytest.mark.parametrize("sign", [1, -1])
def test_spans_reach_the_ends(sign):
    spans = lost_spans(np.arange(5.0), sign * np.array([1.0, 1, -1, -1, 1]))
    assert spans == ([(1.5, 3.5)] if sign > 0 else [(0.0, 1.5), (3.5, 4.0)])


def test_contact_throughout():
    (ax,) = contact_figure(force_data(np.ones(5), np.arange(5.0))).axes
    assert not ax.patches
    assert ax.get_title(loc="right") == "contact throughout"


# the page


def report(name="Press", **changes):
    time = np.linspace(0.0, 200.0, 4001)
    force = force_data(np.where(abs(time - 50) < 1, -1.0, 2.0), time)
    found = {
        "name": name,
        "source": "press.yaml",
        "verdict": "chaotic",
        "reasons": ("Because.",),
        "exponents": exponent_data(np.ones((100, 2))),
        "spectra": {"arm": power_spectrum(np.sin(time), 0.05)},
        "section": section_data(np.linspace(-1, 1, 50), np.linspace(0, 1, 50)),
        "contact": (contact_check("r1", time, force.to_numpy()[:, 0]),),
        "force": force,
        "notes": (),
        "power": 12.0,
        "zero_one": {"arm": (0.98, 0.02)},
        "period": None,
        "curves": None,
        "tighter": {"how": "rtol 1e-11", "verdict": "chaotic"},
        "phases": (),
        "rates": {"arm": (1.0, "rad/s")},
        "rotation": {},
        "certificate": (),
        "dimension": None,
        "horizon": None,
        "conservative": False,
        "run": {
            "periods": 100, "period": 2.0, "other_periods": [], "skip": 0, "skipped": "",
            "method": "dop853", "how": "rtol 1e-10",
        },
        "to_dict": dict,
    }  # fmt: skip
    return SimpleNamespace(**{**found, **changes})


def test_page_needs_no_other_file_and_has_all_figures():
    found = report()
    figures = chaos_figures(found)
    text = page(verdict_report(found, load("pendulum"), figures), load("pendulum"))
    assert list(figures) == ["chaos_section", "chaos_exponents", "chaos_spectrum", "chaos_contact"]
    assert text.count('src="data:image/png;base64,iVBOR') == len(figures) + 1  # and the drawing
    assert not re.search(r"""(src|href|url\()\s*=?\s*["']?(https?:|//|\.|/)""", text)
    assert "<script" not in text
    assert "Tests and their thresholds" in text
    assert load("pendulum").to_yaml() in unescape(text)


def test_everything_from_the_file_is_escaped():
    evil = '<script>alert("x")</script> & $title ${reasons}'
    found = Report(
        name=evil,
        summary=evil,
        parts=[
            evil,
            Items([evil]),
            Notes([evil]),
            Table(evil, [evil], [[evil]]),
            Section(evil, [Definition(evil), Picture(Figure(), evil)]),
        ],
    )
    text = page(found, load("pendulum"))
    assert "<script" not in text
    assert text.count("&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt; &amp; $title") == 13


def test_thresholds_are_beside_what_tests_gave():
    """The exponent is 1 ± 0.02 1/s, and chaos begins at four errors."""
    found = {row[0]: row[1:] for row in threshold_rows(report())}
    assert found["largest Lyapunov exponent"] == [
        "1.000 ± 0.020 1/s", "up to 0.08 1/s", "above 0.08 1/s",
    ]  # fmt: skip
    assert found["growth of tangents"] == ["t^12", "below t^2.5", "above t^8"]
    assert found["0–1 test, arm"] == ["0.980 ± 0.02", "below 0.3", "above 0.6"]
    assert found["Poincaré section repeats"][0] == "no"
    periodic = {row[0]: row[1] for row in threshold_rows(report(period=2, zero_one={}))}
    assert periodic["Poincaré section repeats"] == "after 2 points"
    assert "0–1 test, arm" not in periodic


def test_no_exponent_is_left_where_contacts_take_all_neighbours():
    nothing = report(exponents=exponent_data(np.ones((10, 0))), power=-np.inf)
    first, second, *_ = threshold_rows(nothing)
    assert (first[1], second[1]) == ("−∞", "none left")


def test_forces_are_shown_where_contact_is_lost_first():
    time = shown_forces(report())["time"].to_numpy()
    # a section point every 2 s; four of them from half a period before 49 s on
    assert time[0] == pytest.approx(48.0, abs=0.1)
    assert time[-1] == pytest.approx(56.0, abs=0.1)


def test_forces_at_the_end_where_contact_is_never_lost():
    steady = report(contact=())
    assert shown_forces(steady)["time"].to_numpy()[-1] == 200.0
    assert "chaos_contact" not in chaos_figures(report(force=None))
