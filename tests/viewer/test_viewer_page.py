"""The page in a browser: what it shows, and what mouse, keys and time do to it."""

import numpy as np
import pytest
from browser import needs_browser

import linkages
from linkages.solution.series import data_series

pytestmark = [needs_browser, pytest.mark.slow_except()]

# Pictures, drives, clearances of both kinds, free coordinates, loads, and a stop before the end.
SHOWN = ["ninebar", "four-bar", "scotch-yoke", "jansen", "slider-crank-contact", "andrews"]

DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
FRAME = "Math.round(v.player.place)"


@pytest.mark.slow_except("four-bar")
@pytest.mark.parametrize("name", SHOWN)
def test_a_page_asks_for_nothing_and_complains_of_nothing(opened, name):
    page = opened(name)
    page.evaluate(DRAWN)
    page.press(" ")
    page.evaluate("new Promise((done) => { const look = () => v.player.time !== v.recorded.start"
                  " ? done() : requestAnimationFrame(look); look(); })")  # fmt: skip
    assert page.complaints == []
    asked = [address for address in page.requests if not address.startswith(("blob:", "data:"))]
    assert len(asked) == 1
    assert asked[0].startswith("file:")


def test_signs_are_read_as_they_were_written_whatever_stands_in_the_head(
    browser, written, tmp_path
):
    """Browsers look for the encoding of a file in its first 1024 bytes."""
    text = written("four-bar").read_text(encoding="utf-8")
    file = tmp_path / "page.html"
    file.write_text(text.replace("<head>", f"<head><!-- {'x' * 5000} -->", 1), encoding="utf-8")
    page = browser.page()
    page.open(file)
    assert page.evaluate("document.characterSet") == "UTF-8"
    assert page.evaluate("document.compatMode") == "CSS1Compat"
    assert page.evaluate("document.documentElement.lang") == "en"


def test_the_page_may_not_reach_anything(opened):
    page = opened("four-bar")
    got = page.evaluate("fetch('https://example.org/').then(() => 'got it', () => 'refused')")
    assert got == "refused"
    assert any("Content Security Policy" in text for text in page.complaints)


def at_times(solved, name, times):
    """Data with the times of a page, which has its own where drives determine the motion."""
    own = solved(name)
    return (own if own.motion.method else solved(name, times=tuple(times))).data


@pytest.mark.parametrize("name", SHOWN)
def test_all_numbers_are_those_of_the_data(opened, solved, name):
    """Where samples do not show every swing the page has others, computed for the same motion."""
    page = opened(name)
    found = page.evaluate(
        "[Array.from(v.recorded.time), v.recorded.series.map((one) => [one.name, one.unit,"
        " Array.from(one.values, (value) => Number.isFinite(value) ? value : null)])]"
    )
    time, series = np.array(found[0]), {name: (unit, values) for name, unit, values in found[1]}
    data = at_times(solved, name, time)
    known = data_series(data)
    samples = data.indexes["time"].get_indexer(time, method="nearest")
    same = np.isclose(data["time"].to_numpy()[samples], time, rtol=0, atol=1e-12)
    assert same.sum() > 50
    assert set(series) == {n for n, s in known.items() if s.variable in data and n != "time"} - {
        n for n, s in known.items() if "flag_values" in data.get(s.variable, data["time"]).attrs
    }
    for label, (unit, values) in series.items():
        own = known[label].of(data)
        assert unit == own.attrs["units"]
        if label == "closure_residual":
            continue  # nothing but round-off
        shown = np.array(values, dtype=float)[same]
        scale = np.abs(own.to_numpy()[np.isfinite(own.to_numpy())]).max(initial=0.0)
        # 32 bits have 24 binary digits; a solution at other samples is the same to round-off
        np.testing.assert_allclose(shown, own.to_numpy()[samples[same]], rtol=2e-7,
                                   atol=1e-9 * scale + 1e-12, equal_nan=True)  # fmt: skip


def test_the_table_shows_the_frame_under_the_cursor(opened, solved):
    page = opened("four-bar")
    page.evaluate("v.tabs.open('values')")
    page.press("End")
    for _ in range(3):
        page.press("ArrowLeft")
    page.evaluate(DRAWN)
    time = page.evaluate(f"v.recorded.time[{FRAME}]")
    rows = dict(page.evaluate(
        "[...document.querySelectorAll('#values tr')].filter((row) => row.cells.length === 3)"
        ".map((row) => [row.cells[0].title, row.cells[1].textContent + ' ' + "
        "row.cells[2].textContent])"
    ))  # fmt: skip
    at = at_times(solved, "four-bar", [0.0, time]).sel(time=time, method="nearest")
    assert float(at["time"]) == pytest.approx(time, abs=1e-12)
    angle = float(np.degrees(at["bar_angle"].sel(bar="rocker")))
    effort = float(at["drive_effort"].sel(drive="crank"))
    value, unit = rows["rocker.angle"].replace("−", "-").split()
    assert unit == "°"
    assert float(value) == pytest.approx(angle, rel=1e-4)  # five digits are shown
    value, unit = rows["crank.effort"].replace("−", "-").split()
    factor = {"N·m": 1.0, "mN·m": 1e-3}[unit]
    assert factor * float(value) == pytest.approx(effort, rel=1e-4, abs=1e-7)


def test_keys_step_and_the_clock_follows(opened):
    page = opened("four-bar")
    assert page.evaluate(FRAME) == 0
    page.press("ArrowRight")
    page.press("ArrowRight")
    assert page.evaluate(FRAME) == 2
    page.press("ArrowLeft")
    assert page.evaluate(FRAME) == 1
    page.press("End")
    assert page.evaluate("v.player.time === v.recorded.end")
    assert page.evaluate("document.getElementById('clock').textContent") == "t = 1.000\u202fs"
    page.press("Home")
    assert page.evaluate(FRAME) == 0
    page.press(" ")
    assert page.evaluate("v.player.playing")
    page.press(" ")
    assert not page.evaluate("v.player.playing")


def test_the_slider_of_time_leads(opened):
    page = opened("four-bar")
    left, y, width = page.evaluate(
        "(({ left, top, width, height }) => [left, top + height / 2, width])"
        "(document.getElementById('scrub').getBoundingClientRect())"
    )
    page.drag((left + 8, y), (left + 0.5 * width, y))
    assert page.evaluate("v.player.time") == pytest.approx(0.5, abs=0.03)  # a thumb is 16 px wide


def test_all_that_can_be_used_has_a_name_and_all_text_can_be_read(opened):
    """Names that screen readers say; 12 pixels are the least that is easily read on a telephone."""
    page = opened("four-bar", size=(390, 844))
    roles = {"button", "slider", "checkbox", "combobox", "textbox", "searchbox", "spinbutton",
             "tab", "tabpanel", "img", "image"}  # fmt: skip
    for tab in ("plots", "values", "numbers", "about"):
        page.evaluate(f"v.tabs.open({tab!r})")
        nodes = page.call("Accessibility.getFullAXTree")["nodes"]
        used = [one for one in nodes if one.get("role", {}).get("value") in roles]
        assert len(used) > 10
        assert [one for one in used if not one.get("name", {}).get("value")] == []
        small = page.evaluate(
            "[...document.querySelectorAll('body *')].filter((one) => one.checkVisibility()"
            " && [...one.childNodes].some((text) => text.nodeType === 3 && text.data.trim())"
            " && parseFloat(getComputedStyle(one).fontSize) < 12).map((one) => one.outerHTML)"
        )
        assert small == []
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


@pytest.mark.parametrize("reduced", [False, True])
def test_an_address_can_play_at_once_unless_motion_is_unwanted(browser, written, reduced):
    page = browser.page(900, 700)
    feature = {"name": "prefers-reduced-motion", "value": "reduce" if reduced else ""}
    page.call("Emulation.setEmulatedMedia", features=[feature])
    page.call("Page.navigate", url=f"{written('four-bar').as_uri()}#autoplay")
    page.evaluate(
        "new Promise(done => document.readyState == 'complete'"
        " ? done() : addEventListener('load', () => done()))"
    )
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    assert page.evaluate("v.player.playing") is not reduced


def test_an_address_holds_numbers_and_time(browser, written):
    page = browser.page()
    page.open(written("four-bar"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    page.evaluate(
        "(async () => { const all = v.live.model.numbers.map((one) => one.value);"
        " all[v.live.model.numbers.findIndex((one) => one.path === 'bars.rocker.length')] = 0.0815;"
        " v.live.numbers.set(all); await v.live.shown; v.player.seek(0.25); })()"
    )
    page.evaluate("document.getElementById('share').click()")
    address = page.evaluate("document.getElementById('address').value")
    assert address == f"{written('four-bar').as_uri()}#bars.rocker.length=0.0815&t=0.25"
    other = browser.page()
    other.call("Page.navigate", url=address)
    other.evaluate(
        "new Promise((done) => { const look = () => window.viewer ? viewer.then((parts) =>"
        " { window.v = parts; done(); }) : setTimeout(look, 10); look(); })"
    )
    shown = "[v.player.time, v.stage.motion.byName.get('rocker.angle').values[0]]"
    assert other.evaluate(shown) == page.evaluate(shown)
    other.evaluate(
        "(async () => { const told = new Promise((done) => addEventListener('hashchange',"
        " () => setTimeout(done))); location.hash = '#t=0.5'; await told; await v.live.shown; })()"
    )
    assert other.evaluate("[v.player.time, v.stage.motion === v.recorded]") == [0.5, True]
    assert page.complaints == other.complaints == []


def test_a_driven_link_is_led_by_the_mouse(opened):
    """The crank of 40 mm turns about the origin: its angle follows the mouse."""
    page = opened("four-bar")
    places = page.evaluate(
        "(() => { const box = v.stage.canvas.getBoundingClientRect();"
        " const at = (x, y) => { const [a, b] = v.stage.camera.place([x, y]);"
        " return [a + box.left, b + box.top]; };"
        " return [...Array(10).keys()].map((k) => { const angle = (40 + 10 * k) * Math.PI / 180;"
        " return at(0.04 * Math.cos(angle), 0.04 * Math.sin(angle)); }); })()"
    )
    page.drag(*[tuple(place) for place in places])
    angle = page.evaluate("v.stage.motion.at(v.recorded.byName.get('crank.angle'), v.player.place)")
    # a pixel is 0.4° of the crank
    assert np.degrees(angle) % 360 == pytest.approx(130.0, abs=1.0)
    assert not page.evaluate("v.player.playing")


def test_speed_follows_what_swings_fastest(opened, solved):
    """The clearance of the nine-bar swings 89.5 times a second: real time would show chance."""
    page = opened("ninebar")
    rate, speed = page.evaluate("[v.player.fastest.rate, v.player.speed]")
    angle = solved("ninebar", samples=20001).data["clearance_angle"].to_numpy()[:, 0]
    turns = np.count_nonzero(np.diff(np.sign(np.diff(angle))))
    assert rate == pytest.approx(turns / 2 / 2.0, rel=0.02)
    assert 60 / (rate * speed) >= 12  # frames of a swing
    said = page.evaluate("document.getElementById('pace').textContent")
    assert said == "20× slower than real time"
    more = page.evaluate("document.getElementById('pace').title")
    assert more.startswith("r1 swings once in ")
    page.evaluate("(() => { const select = document.getElementById('speed'); select.value = '1';"
                  " select.dispatchEvent(new Event('change')); })()")  # fmt: skip
    said = page.evaluate("document.getElementById('pace').textContent")
    assert said.startswith("Real time: r1 swings 1.5 times per shown frame, too fast to follow")
    assert page.evaluate("document.getElementById('pace').classList.contains('warn')")


def test_the_glass_shows_the_journal_where_it_is(opened):
    page = opened("ninebar")
    offsets = np.array(page.evaluate(
        "[...v.recorded.time.keys()].map((k) => v.stage.glasses[0].offset(k))"
    ))  # fmt: skip
    # in contact all the time; 32-bit places of about a metre against 0.15 mm
    np.testing.assert_allclose(np.hypot(*offsets.T), 1.0, atol=2e-3)
    caption = page.evaluate("v.stage.glasses[0].caption.textContent")
    assert caption.startswith("r1 at C ")
    assert "× larger" in caption
    assert caption.endswith("\u202fNmean force on the wall")


def test_diagrams_take_any_series_over_any_other(opened):
    page = opened("ninebar")
    page.evaluate("v.panels.add('crank1.angle', 'all bar_speed')")
    page.evaluate(DRAWN)
    panel = "v.panels.panels.at(-1)"
    assert page.evaluate(f"{panel}.lines.length") == 7
    assert page.evaluate(f"{panel}.plot.across.name") == "crank1.angle"
    page.evaluate("document.querySelectorAll('.panel')[3].querySelector('.close').click()")
    assert page.evaluate("v.panels.panels.length") == 3
    assert page.complaints == []


def test_a_cursor_in_a_phase_plane_goes_to_the_nearest_frame(opened):
    page = opened("ninebar")
    page.evaluate(DRAWN)
    found = page.evaluate(
        "(() => { const { plot, lines } = v.panels.panels[2]; const k = 700;"
        " const spot = [plot.x.pixel(plot.xAt(plot.across.values[k])),"
        " plot.y.pixel(lines[0].values[k] * plot.yScale.factor)];"
        " return plot.placeAt(spot); })()"
    )
    assert found == 700


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", [(1300, 900), (400, 800)], ids=["desk", "phone"])
def test_it_fits_and_has_the_light_of_the_system(opened, size, dark):
    page = opened("slider-crank", size=size, dark=dark)
    page.evaluate(DRAWN)
    assert page.evaluate("document.documentElement.dataset.theme") == ("dark" if dark else "light")
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    width, height = page.evaluate("[v.stage.camera.width, v.stage.camera.height]")
    assert min(width, height) > 250
    page.evaluate("document.getElementById('theme').click()")
    assert page.evaluate("document.documentElement.dataset.theme") == ("light" if dark else "dark")


def test_everything_that_can_be_used_has_a_name(opened):
    page = opened("ninebar")
    nameless = page.evaluate(
        "[...document.querySelectorAll('button, input, select, canvas[tabindex]')].filter((one) =>"
        " !one.textContent.trim() && !one.getAttribute('aria-label') && !one.labels?.length)"
        ".map((one) => one.outerHTML)"
    )
    assert nameless == []


def test_a_motion_that_stopped_says_so(browser, tmp_path):
    mechanism = linkages.load("double-pendulum")
    solution = linkages.simulate(mechanism, end=10.0, max_steps=40, throw=False)
    page = browser.page()
    page.open(linkages.view(solution, tmp_path / "stopped.html"))
    page.evaluate("viewer.then(() => true)")
    shown = page.evaluate("document.getElementById('message').textContent")
    assert shown == f"The motion stopped {solution.motion.failure}"
