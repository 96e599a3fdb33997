"""What the page does besides: traces, the crank, walls, sections, files, comparison."""

import base64
import csv
import io
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import needs_browser
from test_viewer_live import change, number

import linkages
from linkages.chaos.common_period import common_period

pytestmark = [needs_browser, pytest.mark.slow_except()]

DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
ON_SCREEN = """
((at) => {
  const box = v.stage.canvas.getBoundingClientRect(), [x, y] = v.stage.camera.place(at);
  return [x + box.left, y + box.top];
})
"""


def spot(page, x, y):
    return tuple(page.evaluate(f"{ON_SCREEN}([{x}, {y}])"))


def test_a_click_traces_a_point_and_another_one_does_not(opened):
    page = opened("four-bar")
    a, b = (np.array(page.evaluate(f"v.stage.scene(0).joint({one!r})")) for one in "AB")
    third = spot(page, *(a + (b - a) / 3))
    page.drag(third, third)
    (trace,) = page.evaluate("v.stage.traces.map((one) => one.weights)")
    # a pixel of some 250 between both joints
    assert trace == pytest.approx({"A": 2 / 3, "B": 1 / 3}, abs=0.01)
    page.drag(third, third)
    assert page.evaluate("v.stage.traces") == []
    inside = spot(page, *(0.4 * a + 0.3 * b + 0.3 * np.array(page.evaluate(
        "v.stage.scene(0).joint('P')"))))  # fmt: skip
    page.drag(inside, inside)
    (trace,) = page.evaluate("v.stage.traces.map((one) => one.weights)")
    assert trace == pytest.approx({"A": 0.4, "B": 0.3, "P": 0.3}, abs=0.02)
    assert page.evaluate("v.player.time") == 0.0


def test_a_crank_is_turned_round_and_round(opened):
    """One revolution is all that the motion has: further on it begins again."""
    page = opened("four-bar")
    first = np.degrees(page.evaluate("v.recorded.byName.get('crank.angle').values[0]"))
    turns = np.radians(first + np.arange(0.0, 800.0, 16.0))
    page.drag(*[spot(page, 0.04 * np.cos(one), 0.04 * np.sin(one)) for one in turns])
    angle = page.evaluate("v.recorded.at(v.recorded.byName.get('crank.angle'), v.player.place)")
    # a pixel is 0.4° of the crank
    away = np.exp(1j * (angle - turns[-1]))
    assert abs(np.degrees(np.angle(away))) < 1.0
    assert page.evaluate("v.stage.traces") == []


def test_the_distribution_of_force_on_the_wall_sums_to_its_mean(opened, solved):
    page = opened("ninebar")
    rose = np.array(page.evaluate("Array.from(v.stage.glasses[0].rose)"))
    data = solved("ninebar", samples=20001).data
    force = data["clearance_force"].to_numpy()[:, 0].clip(0.0)
    angle = data["clearance_angle"].to_numpy()[:, 0]
    # frames are some 7 a swing: means over 180 swings agree to a per cent or so
    assert rose.sum() == pytest.approx(force.mean(), rel=0.02)
    middle = np.angle((rose * np.exp(2j * np.pi * (np.arange(72) + 0.5) / 72)).sum())
    expected = np.angle((-force * np.exp(1j * angle)).sum())  # from pin to bearing
    assert middle == pytest.approx(expected, abs=np.radians(2.5))  # half a sector


ENGINE = "impact-oscillator"


def test_points_once_per_period_are_those_of_simulate(opened):
    page, mechanism = opened(ENGINE), linkages.load(ENGINE)
    period = common_period(mechanism)
    names = page.evaluate("CONTENT.mechanism.state")
    found = np.array(page.evaluate(
        "CONTENT.mechanism.state.map((name) => Array.from("
        "v.recorded.section.byName.get(name).values))"
    ))  # fmt: skip
    time = page.evaluate("Array.from(v.recorded.section.time)")
    assert names == ["mass.position", "mass.velocity"]
    np.testing.assert_allclose(time, period * np.arange(len(time)), rtol=1e-12)
    data = linkages.simulate(mechanism, times=np.array(time)).data
    own = [data[name].to_numpy()[:, 0] for name in ("slider_position", "slider_velocity")]
    # cubic splines of samples, in 24 binary digits
    for values, expected in zip(found, own, strict=True):
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-3)
    page.evaluate(f"v.player.seek({2.5 * period})")
    page.evaluate(DRAWN)
    drawn = page.evaluate("v.panels.panels.map(({ plot }) => Boolean(plot.points))")
    assert any(drawn)
    page.evaluate("document.querySelector('.once:not([hidden])').click()")
    assert page.evaluate("[...document.querySelectorAll('.panel .note')].some((one) =>"
                         " one.textContent === 'points: once per period')")  # fmt: skip
    change(page, **{"sliders.mass.mass": 1.02 * number(page, "sliders.mass.mass")})
    assert page.evaluate("v.stage.motion.section.time.length") == len(time)
    assert page.complaints == []


def test_a_changed_drive_has_no_section_of_the_old_period(opened):
    page = opened("slider-crank-contact")
    assert page.evaluate("v.recorded.section.time.length") >= 2
    change(page, **{"drives.crank.speed": 1.01 * number(page, "drives.crank.speed")})
    assert page.evaluate("v.stage.motion.section") is None


def saved(page, what):
    """What an export writes, as bytes."""
    text = page.evaluate(
        f"(async () => {{ const blob = await ({what}); const bytes = new Uint8Array(await"
        " blob.arrayBuffer()); let text = ''; for (const byte of bytes) text +="
        " String.fromCharCode(byte); return btoa(text); })()"
    )
    return base64.b64decode(text)


def test_pictures_and_curves_are_exported_as_they_are_shown(opened, solved):
    page = opened("four-bar")
    page.evaluate("v.stage.trace({ weights: { A: 0.5, B: 0.5 } }); v.player.seek(0.4)")
    page.evaluate(DRAWN)
    size = page.evaluate("v.exports.pictureSize")
    png = saved(
        page, "v.exports.png('picture', v.exports.pictureSize, (c) => v.exports.picture(c))"
    )
    assert png.startswith(b"\x89PNG")
    assert [int.from_bytes(png[k : k + 4], "big") for k in (16, 20)] == [2 * one for one in size]
    for which in ("picture", "diagrams"):
        text = page.evaluate(
            f"v.exports.svg('{which}', v.exports.{which}Size, (c) => v.exports.{which}(c))"
        )
        root = ElementTree.fromstring(text)
        words = {one.text for one in root.iter("{http://www.w3.org/2000/svg}text")}
        assert ("rocker" in words) if which == "picture" else ("driving torque of crank" in words)
        paths = [one.get("d") for one in root.iter("{http://www.w3.org/2000/svg}path")]
        assert len(paths) > 20
        assert not any("NaN" in one for one in paths)
    rows = list(csv.reader(io.StringIO(page.evaluate("v.exports.csv"))))
    table = dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))
    assert "crank.effort [N m]" in table
    data = solved("four-bar").data
    time = table["time [s]"]
    own = np.interp(time, data["time"], data["bar_angle"].sel(bar="rocker"))
    # frames are samples of a denser solution: straight lines between samples err by 1e-5
    np.testing.assert_allclose(table["rocker.angle [rad]"], own, rtol=0, atol=2e-5)
    mean = data["joint_position"].sel(joint=["A", "B"], axis="x").mean("joint")
    np.testing.assert_allclose(
        table["point 1 (0.5 A + 0.5 B) x [m]"], np.interp(time, data["time"], mean), atol=1e-6
    )
    assert page.complaints == []


def test_a_film_is_recorded_until_the_motion_ends(opened):
    page = opened("four-bar")
    page.evaluate("(() => { const select = document.getElementById('speed'); select.value = '1';"
                  " select.dispatchEvent(new Event('change')); })()")  # fmt: skip
    page.evaluate("v.exports.record.click(); window.film = v.exports.film.done")
    webm = saved(page, "film")
    assert webm.startswith(b"\x1a\x45\xdf\xa3")  # EBML, https://www.rfc-editor.org/rfc/rfc8794
    assert len(webm) > 5000
    assert not page.evaluate("v.player.playing")
    assert page.evaluate("v.exports.record.textContent") == "Film, WebM"


def opened_beside(page, text, name="other.html"):
    page.evaluate(
        f"v.compare.open(new File([decodeURIComponent(escape(atob({encoded(text)!r})))], {name!r}))"
    )
    page.evaluate(DRAWN)


def encoded(text):
    return base64.b64encode(text.encode()).decode()


def test_another_page_is_shown_beside_on_the_same_clock_and_none_of_it_runs(opened, written):
    page = opened("four-bar")
    text = written("slider-crank").read_text(encoding="utf-8")
    opened_beside(page, text.replace("</body>", "<script>window.ran = 1</script></body>"))
    assert page.evaluate("typeof window.ran") == "undefined"
    page.evaluate("v.player.seek(0.03)")
    page.evaluate(DRAWN)
    found = page.evaluate(
        "(({ stage }) => stage.scene(stage.motion.where(v.player.time)).joint('B'))(v.second)"
    )
    data = linkages.simulate(linkages.load("slider-crank"), times=[0.0, 0.03]).data
    np.testing.assert_allclose(found, data["joint_position"].sel(joint="B")[-1], atol=1e-6)
    widths = page.evaluate("[v.stage.canvas.clientWidth, v.second.canvas.clientWidth]")
    assert abs(widths[0] - widths[1]) <= 2  # a line parts them
    page.evaluate("document.getElementById('close-other').click()")
    assert page.evaluate("v.second") is None
    assert page.evaluate("document.getElementById('second')") is None
    opened_beside(page, "<p>nothing", "letter.html")
    said = page.evaluate("document.getElementById('message').textContent")
    assert said.startswith("letter.html is no page of a motion")
    assert page.complaints == []


def test_the_same_mechanism_with_other_numbers_is_compared_in_diagrams(opened, tmp_path):
    page = opened("four-bar")
    other = linkages.load("four-bar", set={"bars.rocker.length": "85 mm"})
    text = linkages.view(other, tmp_path / "other.html").read_text(encoding="utf-8")
    opened_beside(page, text)
    pale = page.evaluate("v.panels.panels[0].plot.others.map(({ lines }) => lines.map((one) =>"
                         " Array.from(one.values).at(-1)))")  # fmt: skip
    data = linkages.simulate(other).data
    assert pale[0][0] == pytest.approx(float(data["bar_angle"].sel(bar="rocker")[-1]), rel=1e-6)


def test_arrow_keys_change_a_number_by_a_hundredth(opened):
    page = opened("four-bar")
    page.evaluate("v.tabs.open('numbers')")
    page.evaluate("document.querySelector('[aria-label=\"length of rocker\"]').focus()")
    page.press("ArrowRight")
    page.evaluate("v.live.shown")
    path = "bars.rocker.length"
    now = f"v.live.numbers.values[v.live.model.numbers.findIndex((one) => one.path === {path!r})]"
    assert page.evaluate(now) == pytest.approx(0.0808, rel=1e-12)
    page.press("PageDown")
    page.evaluate("v.live.shown")
    assert page.evaluate(now) == pytest.approx(0.0808 * 0.9, rel=1e-12)
    assert page.evaluate("document.activeElement.type") == "range"
    assert page.evaluate("v.player.place") == 0


def test_curves_do_not_overshoot_where_a_load_jumps(opened):
    """A cubic through 0, 0, 1, 1 leaves the range by 7 %; one through a sine does not err."""
    page = opened("four-bar")
    found = np.array(page.evaluate(
        "(() => { const values = Float64Array.from([0, 0.01, 0, 0.01, 1, 1.01, 1, 1.01]);"
        " const motion = new Motion(Float64Array.from(values.keys()), []);"
        " return Array.from({ length: 701 }, (_, k) => motion.at({ values }, k / 100)); })()"
    ))  # fmt: skip
    assert found.min() >= -2e-3
    assert found.max() <= 1.012
    error = page.evaluate(
        "(() => { const time = Float64Array.from({ length: 41 }, (_, k) => (k / 40) ** 1.1);"
        " const values = time.map((t) => Math.sin(8 * Math.PI * t));"
        " const motion = new Motion(time, []); return Math.max(...Array.from({ length: 999 },"
        " (_, k) => Math.abs(motion.at({ values }, motion.where(k / 999))"
        " - Math.sin(8 * Math.PI * k / 999)))); })()"
    )
    assert error < 0.03  # ten frames a swing, unevenly spaced


def test_a_fast_phase_plane_has_samples_of_the_last_swings(browser, tmp_path):
    """Frames are too few for 90 swings a second over a minute."""
    mechanism = linkages.load("ninebar", set={"simulate.end": "16 s", "simulate.samples": 201})
    page = browser.page()
    page.open(linkages.view(mechanism, tmp_path / "long.html"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    page.evaluate(DRAWN)
    assert page.evaluate("v.recorded.detail.time.length") == 2000
    notes = page.evaluate("[...document.querySelectorAll('.panel .note')].map((one) =>"
                          " one.textContent)")  # fmt: skip
    assert any(one.startswith("last ") and one.endswith(" of the motion") for one in notes)
    close = page.evaluate(
        "(() => { const { detail } = v.recorded; return ['r1.angle', 'r1.speed'].map((name) =>"
        " Array.from(detail.byName.get(name).values)).concat([Array.from(detail.time)]); })()"
    )
    angle, speed, time = map(np.array, close)
    rate = np.gradient(angle, time)
    # differences of samples, of which a swing has ten or more
    assert np.abs(rate[1:-1] - speed[1:-1]).max() < 0.15 * np.abs(speed).max()


@pytest.mark.parametrize("tab", ["plots", "values", "numbers", "about"])
def test_fingers_find_all_that_can_be_used(opened, tab):
    """44 pixels, as https://www.w3.org/TR/WCAG22/#target-size-enhanced has it."""
    page = opened("ninebar", size=(390, 844))
    page.evaluate(f"v.tabs.open({tab!r}); document.getElementById('export').open = true")
    small = page.evaluate(
        "[...document.querySelectorAll('button, select, summary, .chip, .button,"
        " input[type=range], input[type=number], input[type=search]')].filter((one) =>"
        " one.checkVisibility()).map((one) => [one.outerHTML.slice(0, 80),"
        " one.getBoundingClientRect().height]).filter(([, height]) => height < 43.5)"
    )
    assert small == []
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_it_fits_into_a_frame_of_the_landing_page(opened):
    page = opened("ninebar", size=(736, 600))
    page.evaluate(DRAWN)
    assert page.evaluate("document.documentElement.scrollWidth") <= 736
    play = page.evaluate("document.getElementById('play').getBoundingClientRect().bottom")
    assert play <= 600
    assert page.evaluate("v.stage.canvas.clientHeight") > 300


def test_a_link_is_copied_with_six_digits_and_says_so(opened):
    page = opened("four-bar")
    page.evaluate("v.player.seek(0.12345678901)")
    x, y = page.evaluate(
        "(({ left, top, width, height }) => [left + width / 2, top + height / 2])"
        "(document.getElementById('share').getBoundingClientRect())"
    )
    page.drag((x, y), (x, y))  # only a hand may copy
    page.evaluate("new Promise((done) => { const look = () => /opied/.test("
                  "document.getElementById('share').textContent) ? done() :"
                  " requestAnimationFrame(look); look(); })")  # fmt: skip
    assert page.evaluate("document.getElementById('share').textContent") == "Copied"
    address = page.evaluate("document.getElementById('address').value")
    assert address.endswith("#t=0.123457")


def test_a_bearing_on_the_ground_is_drawn_before_slotted_bars(opened):
    page = opened("quick-return")
    order = page.evaluate("CONTENT.shapes.map((one) => `${one.kind} ${one.name}`)")
    slot = max(k for k, one in enumerate(order) if one == "line block")
    assert min(k for k, one in enumerate(order) if one == "line P") > slot


@pytest.mark.parametrize("size", [(736, 600), (1280, 800)], ids=str)
def test_names_keep_clear_of_hatching_and_of_each_other(opened, size):
    page = opened("ninebar", size=size)
    page.evaluate(DRAWN)
    boxes = page.evaluate(
        "(() => { const { words, camera, point } = v.stage, scene = v.stage.scene(0);"
        " const ctx = v.stage.canvas.getContext('2d'); const found = [];"
        " words.words.forEach((word, k) => { if (!words.places[k]) return;"
        " ctx.font = words.font(word, point); const size = [ctx.measureText(word.text).width, 13];"
        " const box = words.box(word, scene, camera, point, words.places[k], size);"
        " found.push([word.text, box]); });"
        " return found; })()"
    )
    names = dict(boxes)
    assert {"O", "A", "B", "D", "E", "F", "slider9", "r1"} <= set(names)
    hatched = page.evaluate(
        "CONTENT.shapes.filter((one) => one.kind === 'line' && one.strokes.length > 4)"
        ".flatMap((shape) => { const scene = v.stage.scene(0), { camera, point } = v.stage;"
        " const angle = scene.direction(shape.direction); return shape.strokes.map((stroke) =>"
        " stroke.map((one) => scene.anchor(one, angle, camera, point))); })"
    )
    for text, (left, top, right, bottom) in names.items():
        inside = [one for one in hatched for x, y in one if left < x < right and top < y < bottom]
        assert inside == [], text


def test_cells_of_a_row_of_values_are_on_one_line(opened):
    page = opened("four-bar")
    page.evaluate("v.tabs.open('values')")
    page.evaluate(DRAWN)
    sides = np.array(page.evaluate(
        "[...document.querySelectorAll('#values tr')].filter((row) => row.cells.length === 3)"
        ".map((row) => [...row.cells].flatMap((cell) => { const { top, bottom } ="
        " cell.getBoundingClientRect(); return [top, bottom]; }))"
    ))  # fmt: skip
    assert len(sides) > 20
    assert np.ptp(sides[:, ::2], axis=1).max() < 0.5
    assert np.ptp(sides[:, 1::2], axis=1).max() < 0.5
    assert page.evaluate("document.getElementById('values').textContent.includes('driving torque')")
