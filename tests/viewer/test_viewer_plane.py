"""The page of an isoperiodic plane: points that are chosen play the motion of `simulate`."""

import re

import numpy as np
import pytest
import xarray as xr
from browser import needs_browser

import linkages
from linkages.errors import InputError
from linkages.kernel.system import System
from linkages.options.analysis_options import OrbitOptions
from linkages.orbits.plane_orbits import plane_orbits
from linkages.solution.run_options import options_of
from linkages.solution.series import available, data_series
from linkages.sweeps.axes import parse_range
from linkages.viewer.plane import RTOL, plane_page, require_playable, shown_order, state_paths
from linkages.viewer.recorded import Packed

PLANES = {
    # periods 1 and 2, silent and with impacts; a range that decreases
    "impact-oscillator": ("parameters.A=0.9:0.1:5", "parameters.w=0.7:0.9:3"),
    # periods 1 and 2 and chaos, in units of the file
    "contact-slider-crank": (
        "clearances.gap.size=0.1184mm:0.1214mm:4", "drives.crank.speed=4800rpm:5000rpm:3",
    ),
}  # fmt: skip
COMPARED = ("joint_position", "clearance_force", "load_force", "bar_angle")


def plane(name, x, y):
    mechanism, x, y = linkages.load(name), parse_range(x), parse_range(y)
    data = linkages.chaos_map(mechanism, x, y, indicator="period", states=True)
    data = plane_orbits(mechanism, x, y, data, options_of(OrbitOptions, mechanism, {}))
    return mechanism, x, y, data


@pytest.fixture(scope="module")
def planes(tmp_path_factory):
    """Name → mechanism, axes, data and the file of the page."""
    known = {}

    def made(name):
        if name not in known:
            mechanism, x, y, data = plane(name, *PLANES[name])
            file = tmp_path_factory.mktemp("planes") / "map.html"
            file.write_text(plane_page(mechanism, x, y, data, (), {}), encoding="utf-8")
            known[name] = mechanism, x, y, data, file
        return known[name]

    return made


def opened(browser, file):
    page = browser.page(1300, 900)
    page.open(file)
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    return page


def at(mechanism, x, y, data, row, column):
    """The mechanism of a point on its orbit."""
    own = mechanism.with_values({**y.at(row), **x.at(column)})
    state = data.state[row, column].to_numpy()
    free = System(own).topology.free
    values, rates = state[: len(free)].tolist(), state[len(free) :].tolist()
    return own.with_state(dict(zip(free, zip(values, rates, strict=True), strict=True)))


def facts(page):
    """Text beside a name → text, of the table of the point."""
    rows = page.evaluate(
        "[...document.querySelectorAll('#plane-facts tr')].map((row) =>"
        " [...row.children].map((cell) => cell.textContent))"
    )
    return dict(rows)


def number(text):
    """A real or complex number as the page writes it."""
    plain = text.replace("−", "-").replace("i", "j")
    raised = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    plain = re.sub(r"·10([⁻⁰-⁹¹²³]+)", lambda found: "e" + found[1].translate(raised), plain)
    return complex(plain.replace(" ", ""))


@needs_browser
@pytest.mark.slow
@pytest.mark.parametrize("name", PLANES)
def test_a_chosen_point_plays_the_motion_of_simulate(browser, planes, name):
    """All points with a motion: series, period and multipliers."""
    mechanism, x, y, data, file = planes(name)
    page = opened(browser, file)
    periodic = 0
    for row, column in np.argwhere(np.isfinite(data.drive_period.to_numpy())).tolist():
        page.evaluate(f"v.plane.choose({row}, {column})")
        assert page.evaluate("document.getElementById('message').hidden")
        time, series = page.evaluate(
            "[Array.from(v.stage.motion.time), v.stage.motion.series.map((one) =>"
            " [one.name, Array.from(one.values)])]"
        )
        own = at(mechanism, x, y, data, row, column)
        outputs = [one for one in COMPARED if one in available(System(own))]
        simulated = linkages.simulate(own, times=np.array(time), outputs=outputs, rtol=RTOL).data
        known = data_series(simulated)
        count = data.indicator[row, column].item()
        # where distances grow, by about e in a period, so do errors of 1e-12
        tolerance = 1e-9 if np.isfinite(count) else 1e-8
        compared = [(known[label], values) for label, values in series if label in known]
        assert len(compared) >= 3
        for one, values in compared:
            expected = one.of(simulated).to_numpy()
            shown = np.array(values, dtype=float)
            if one.angle:
                expected, shown = np.exp(1j * expected), np.exp(1j * shown)
            size = np.abs(expected).max(initial=1e-3)
            np.testing.assert_allclose(shown, expected, rtol=0, atol=tolerance * size)
        said = facts(page)
        if np.isnan(count):
            assert "from its last state" in said["motion"]
            continue
        periodic += 1
        span = count * data.drive_period[row, column].item()
        assert time[-1] == pytest.approx(span, rel=1e-12)
        assert said["period"].startswith(f"{count:.0f} period")
        texts = said["multipliers"].split("; ")
        multipliers = data.multiplier[row, column].to_numpy() @ [1, 1j]
        for text, value in zip(texts, multipliers, strict=True):
            if text.startswith("<"):
                assert abs(value) < 1e-5
            else:
                assert number(text) == pytest.approx(value, abs=1e-6)
    assert periodic >= 4
    assert page.complaints == []
    assert [one for one in page.requests if not one.startswith(("file:", "blob:"))] == []


@needs_browser
@pytest.mark.slow
def test_a_click_and_keys_choose_points(browser, planes):
    *_, file = planes("impact-oscillator")
    page = opened(browser, file)
    row, column = page.evaluate("CONTENT.plane.first")
    assert page.evaluate("v.tabs.chosen") == "plane"
    page.evaluate("v.plane.canvas.focus()")
    page.press("ArrowLeft")  # the range decreases: to the left are larger values
    assert page.evaluate("[v.plane.row, v.plane.column]") == [row, min(column + 1, 4)]
    page.press("ArrowDown")
    page.press("ArrowDown")
    page.press("ArrowDown")
    assert page.evaluate("v.plane.row") == 0
    assert page.evaluate("document.activeElement === v.plane.canvas")
    spot = page.evaluate(
        "(() => { const box = v.plane.canvas.getBoundingClientRect();"
        " return [box.left + v.plane.x.pixel(v.plane.known.x.values[1]) + 3,"
        " box.top + v.plane.y.pixel(v.plane.known.y.values[2]) - 3]; })()"
    )
    page.drag(tuple(spot), tuple(spot))
    assert page.evaluate("[v.plane.row, v.plane.column]") == [2, 1]
    page.evaluate("v.live.shown")
    place = 'v.live.model.numbers.findIndex((one) => one.path === "parameters.A")'
    assert page.evaluate(f"v.live.numbers.values[{place}]") == pytest.approx(0.7)
    assert page.evaluate("v.plane.note.hidden")
    page.evaluate("v.live.numbers.reset.click()")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert not page.evaluate("v.plane.note.hidden")


@pytest.mark.slow
def test_a_page_of_a_large_plane_is_small(planes):
    """160 × 160 points with four free coordinates and rates: numbers that cannot be compressed."""
    *_, file = planes("contact-slider-crank")
    count, rng = 160 * 160, np.random.default_rng(1)
    packed = Packed()
    packed.add(rng.integers(-2, 9, count))
    packed.add(rng.integers(1, 9, count))
    for size in (1, 4):
        packed.add_exact(rng.normal(size=size * count))
    packed.add(rng.normal(size=8 * count))
    assert file.stat().st_size + len(packed.text()) < 3e6


def test_state_paths_are_numbers_of_the_definition():
    crank = linkages.load("contact-slider-crank")
    paths = state_paths(crank, np.array([1e-5, 0.0, 0.0, 0.1]))
    own = [f"clearances.gap.{name}[{k}]" for name in ("offset", "rate") for k in (0, 1)]
    assert paths == own == state_paths(crank, np.zeros(4))
    oscillator = linkages.load("impact-oscillator")
    assert state_paths(oscillator, np.zeros(2)) == ["free.mass.position", "free.mass.speed"]


def test_a_page_begins_with_a_periodic_point_near_the_middle():
    there, repeated = np.full((3, 5), 1.0), np.full((3, 5), np.nan)
    repeated[0, 4], there[1, 2] = 2.0, np.nan
    data = xr.Dataset({"drive_period": (("y", "x"), there), "indicator": (("y", "x"), repeated)})
    order = shown_order(data)
    assert order[0] == (0, 4)
    assert sorted(order[1:5]) == [(0, 2), (1, 1), (1, 3), (2, 2)]
    assert len(order) == 14
    assert shown_order(data.assign(drive_period=(("y", "x"), there * np.nan))) == []


def test_a_page_begins_where_a_definition_can(planes):
    """A definition may not begin deep in a wall: that point is passed over."""
    mechanism, x, y, data, _ = planes("contact-slider-crank")
    (row, column), *_ = shown_order(data)
    deep = data.copy(deep=True)
    deep.state[row, column, 0] = 1.0  # metres
    text = plane_page(mechanism, x, y, deep, (), {})
    assert f'"first":[{row},{column}]' not in text
    deep.state[:, :, 0] = 1.0
    assert plane_page(mechanism, x, y, deep, (), {}) is None


@pytest.mark.parametrize(
    ("name", "x", "says"),
    [
        ("impact-oscillator", "simulate.end=1:2:2", "cannot change simulate.end"),
        ("slider-crank-contact", "drives.crank.speed=1:2:2", "remembers the rate"),
        ("four-bar", "drives.crank.speed=1:2:2", "nothing is free to move"),
    ],
)
def test_what_a_page_cannot_play_is_refused(name, x, says):
    mechanism = linkages.load(name)
    with pytest.raises(InputError, match=says):
        require_playable(mechanism, parse_range(x), parse_range("gravity[1]=-9:-8:2"))
