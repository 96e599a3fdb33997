import numpy as np
import pytest
from matplotlib.figure import Figure
from plot_data import SERIES, press, press_data

from linkages.plots.motion.curves import DENSE, envelope, span_words
from linkages.plots.motion.time_figures import draw, drawable, time_figure
from linkages.plots.style import scale_of


def axes():
    return Figure().add_subplot()


@pytest.mark.parametrize(
    ("variable", "label"),
    [
        ("slider_position", "position [m]"),
        ("slider_acceleration", "acceleration [m/s²]"),
        ("slider_position_error", "position error [µm]"),
        ("slider_velocity_error", "velocity error [mm/s]"),
        ("drive_effort", "driving torque [N·m]"),
        ("clearance_force", "clearance force [kN]"),
    ],
)
def test_labels_name_the_quantity_and_its_units(variable, label):
    ax = draw(axes(), press_data(), variable)
    assert ax.get_ylabel() == label
    assert ax.get_xlabel() == "time [s]"


@pytest.mark.parametrize("variable", [name for name in SERIES if drawable(name)])
def test_curve_has_the_values_in_shown_units(variable):
    data = press_data()
    size = SERIES[variable][2]
    curve = draw(axes(), data, variable).lines[0]
    factor = np.abs(curve.get_ydata()).max() / np.abs(data[variable][:, 0]).max().item()
    if SERIES[variable][1] == "rad":
        assert factor == pytest.approx(180 / np.pi)
        return
    assert np.log10(factor) == pytest.approx(round(np.log10(factor)), abs=1e-12)
    assert 0.1 <= size * factor < 1000


def test_one_line_is_named_in_the_title_and_its_peak_in_place():
    data = press_data()
    ax = draw(axes(), data, "drive_effort", "Press")
    assert ax.get_title(loc="left") + ax.get_title() == "Press: crank"
    assert ax.get_legend() is None
    (text,) = [t.get_text() for t in ax.texts]
    assert text == "peak 30 N·m at 0.2244 s"  # 30 sin(7t) has its first top at t = π/14, no sample
    # a parabola through samples θ = 0.07 apart is off by θ⁴/32 of the amplitude, its top by θ³/10
    (x, y), *_ = ax.lines[-1].get_xydata()
    assert x == pytest.approx(np.pi / 14, abs=0.07**3 / 10 / 7)
    assert y == pytest.approx(30.0, abs=30 * 0.07**4 / 32)


def test_several_lines_have_a_legend_with_names_and_different_looks():
    names = [f"drive {i}" for i in range(9)]
    ax = draw(axes(), press_data(drive=names), "drive_effort", "Press")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == names
    looks = {(line.get_color(), str(line._dash_pattern)) for line in ax.lines[:-1]}
    assert len(looks) == len(names)
    assert ax.get_title() == ax.get_title(loc="left") == ""


def test_legend_stands_above_the_axes_within_the_figure():
    figure = time_figure("drive_effort")(press_data(drive=list("abcdefg")), press())
    figure.draw_without_rendering()
    (ax,) = figure.axes
    box = ax.get_legend().get_window_extent()
    assert box.y0 >= ax.get_window_extent().y1
    assert box.y1 <= figure.bbox.y1
    assert box.x1 <= figure.bbox.x1


def test_names_are_text_and_not_mathematics():
    figure = time_figure("drive_effort")(press_data(drive=["_$a$", "b"]), press())
    (ax,) = figure.axes
    texts = ax.get_legend().get_texts()
    assert texts[0].get_text().startswith("_$a$")
    assert not any(text.get_parse_math() for text in texts)


def test_round_off_is_not_magnified():
    data = press_data()
    data["drive_effort"].values[:] = 5.0
    data["drive_effort"].values[::2] += 1e-12
    low, high = draw(axes(), data, "drive_effort").get_ylim()
    assert high - low > 0.5


def test_backward_motion_is_drawn_with_time_to_the_right():
    data = press_data()
    ax = draw(axes(), data.assign_coords(time=-data["time"]), "slider_velocity")
    assert ax.get_xlim() == (-2.0, 0.0)


@pytest.mark.parametrize("samples", [1, 2])
def test_short_data(samples):
    figure = time_figure("slider_velocity")(press_data(samples), press())
    assert figure.axes[0].lines


def test_forces_and_torques_of_drives_have_no_common_axis():
    data = press_data(drive=["crank", "ram"])
    (torque,) = time_figure("drive_effort")(data, press()).axes
    (force,) = time_figure("drive_force")(data, press()).axes
    assert torque.get_ylabel() == "driving torque [N·m]"
    assert force.get_ylabel() == "driving force [N]"
    assert (torque.get_title(loc="left"), force.get_title(loc="left")) == (
        "Press: crank", "Press: ram",
    )  # fmt: skip
    np.testing.assert_array_equal(force.lines[0].get_ydata(), data["drive_effort"].values[:, 1])
    assert time_figure("drive_force")(press_data(), press()) is None


def test_nothing_to_draw():
    function = time_figure("slider_velocity")
    assert function(press_data().isel(time=slice(0)), press()) is None
    assert function(press_data().drop_vars("slider_velocity"), press()) is None
    assert function(press_data() * np.nan, press()) is not None


@pytest.mark.parametrize(("end", "other"), [(0, -1), (-1, 0)])
def test_the_text_of_a_peak_at_an_end_stands_inside(end, other):
    time = np.linspace(0.0, 2.0, 201)
    values = np.cos(np.pi * time)[:, None]
    values[[other, 100]] *= 0.5
    data = press_data().assign(slider_velocity=(("time", "slider"), values, {"units": "m/s"}))
    figure = time_figure("slider_velocity")(data, press())
    figure.draw_without_rendering()
    (ax,) = figure.axes
    (text,) = (t for t in ax.texts if t.get_text().startswith("peak"))
    assert text.xy[0] == pytest.approx(time[end])
    box, frame = text.get_window_extent(), ax.get_window_extent()
    assert frame.x0 < box.x0 < box.x1 < frame.x1


def test_a_curve_denser_than_the_paper_is_an_envelope_with_a_few_swings_beside():
    """A wave of 400 Hz whose size swings once: its outline is known everywhere."""
    time = np.linspace(0.0, 2.0, 40_001)
    size = 2.0 + np.cos(np.pi * time)
    values = (size * np.sin(2 * np.pi * 400 * time))[:, None]
    data = press_data(40_001).assign(slider_velocity=(("time", "slider"), values, {"units": "m/s"}))
    figure = time_figure("slider_velocity")(data.assign_coords(time=time), press())
    whole, swings = figure.axes
    (filled,) = whole.collections
    (path,) = filled.get_paths()
    middle, half = path.vertices.T[0], np.abs(path.vertices.T[1])
    inside = (middle > 0.01) & (middle < 1.99)
    # a column holds a swing and more; a sample is off a top by (2π400·5e-5/2)²/2 = 0.2 % at most
    assert half[inside] == pytest.approx(2.0 + np.cos(np.pi * middle[inside]), rel=0.01)
    shown = swings.lines[0].get_xdata()
    assert 4 / 400 < np.ptp(shown) < 8 / 400
    assert swings.lines[0].get_ydata().max() == pytest.approx(3.0, rel=2e-3)


def test_dense_series_have_panels_of_their_own():
    time = np.linspace(0.0, 2.0, 8001)
    waves = np.stack([np.sin(k * time) for k in (3.0, np.pi * DENSE, 1.5 * np.pi * DENSE)], axis=1)
    data = press_data(8001, drive=["slow", "fast", "faster"]).assign_coords(time=time)
    data["drive_effort"].values[:] = waves
    figure = time_figure("drive_effort")(data, press())
    titles = [ax.get_title(loc="left").split(", ")[0] for ax in figure.axes]
    assert titles == ["Press: slow", "Press: fast", "detail", "Press: faster", "detail"]


def test_a_detail_says_when_it_is_in_digits_that_tell():
    scale = scale_of([0.02], "s")
    assert span_words((10.21e-3, 11.49e-3), scale) == "10.2–11.5 ms"
    assert span_words((-0.5, 1.5), scale_of([2.0], "s")) == "−0.5–1.5 s"


@pytest.mark.parametrize(("offset", "word", "worst"), [(30, "least", 10), (145, "greatest", 165)])
def test_the_angle_that_transmits_worst_is_marked(offset, word, worst):
    """Of μ = offset + 20° sin 7t: where it is nearest to 0 or 180°, between samples."""
    time = np.linspace(0.0, 2.0, 201)
    angles = np.radians(offset + 20 * np.sin(7 * time))[:, None]
    about = {"units": "rad", "long_name": "transmission angle"}
    both = np.hstack([angles, np.full_like(angles, 1.5)])
    data = press_data().assign(transmission_angle=(("time", "dyad"), both, about))
    ax = draw(axes(), data.assign_coords(dyad=["A", "B"]), "transmission_angle")
    (text,) = [t.get_text() for t in ax.texts]
    at = float(text.split(" at ")[1].removesuffix(" s"))
    assert text.startswith(f"{word} {worst}° of A at ")
    assert np.sin(7 * at) == pytest.approx(-1.0 if word == "least" else 1.0, abs=1e-4)


def test_angles_that_count_turns_have_no_peak_and_keep_apart_from_others():
    data = press_data(bar=["crank", "rocker", "twin"])
    time = data["time"].to_numpy()
    swing = 0.3 * np.sin(7 * time)
    data["bar_angle"].values[:] = np.stack([7 * time + 0.1 * swing, swing, swing], axis=1)
    figure = time_figure("bar_angle")(data, press())
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles == ["Press: rocker, twin", "Press: crank"]
    assert not any(ax.texts for ax in figure.axes)


@pytest.mark.parametrize("columns", [1, 7, 1000])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_envelope_holds_every_sample(columns, sign):
    time = sign * np.linspace(0.0, 3.0, 997)
    values = np.cos(50 * time) * time
    middle, low, high = envelope(time, values, columns)
    assert (low.min(), high.max()) == (values.min(), values.max())
    assert len(middle) <= columns
    column = np.minimum((time / time[-1] * columns).astype(int), columns - 1)
    place = np.searchsorted(np.unique(column), column)
    assert (low[place] <= values).all()
    assert (values <= high[place]).all()


@pytest.mark.parametrize(("part", "turned"), [(0.5, 0.0), (0.9, 90.0), (0.99, 0.0)])
def test_the_words_of_the_horizon_stand_within_its_band_or_point_at_it(part, turned):
    data = press_data().assign_attrs(horizon=2.0 * part)
    figure = time_figure("slider_velocity")(data, press())
    figure.draw_without_rendering()
    (ax,) = figure.axes
    (text,) = (t for t in ax.texts if t.get_text() == "not predictable")
    box = text.get_window_extent()
    begin, end = ax.transData.transform([(2.0 * part, 0.0), (2.0, 0.0)]).T[0]
    assert text.get_rotation() == turned
    if text.arrow_patch is None:
        assert begin <= box.x0 < box.x1 <= end
    else:
        (tip, _) = ax.transData.transform((text.xy[0], 0.0))
        assert box.x1 < begin <= tip <= end
