"""Motions that the page computes itself, for numbers that somebody changes there."""

import base64
import json
import re
import zlib

import numpy as np
import pytest
import quickjs
from browser import needs_browser

import linkages
from linkages.kernel.system import System
from linkages.solution.series import available, data_series
from linkages.viewer.content import page_content

FACTOR = 1.03

# A fully driven loop, an iterated group, clearances, free coordinates with loads, sliders alone.
CHANGED = [
    ("four-bar", "bars.rocker.length"),
    ("class-three", "bars.leg2.length"),
    ("ninebar", "bars.link3.length"),
    ("ninebar", "clearances.r1.size"),
    ("andrews", "springs[0].stiffness"),
    ("double-pendulum", "gravity[1]"),
    ("scotch-yoke", "bars.crank.length"),
    ("toggle-press", "drives.crank.speed"),
    ("slider-crank-contact", "bars.rod.mass"),
]


COMPUTED = (
    "joint_position", "bar_angle", "drive_effort", "joint_reaction", "pin_reaction",
    "transmission_angle",
)  # fmt: skip
COMPARED = ("slider_position_error", "slider_acceleration_error")
"""With the ideal mechanism, by the page."""


def change(page, **numbers):
    """Set numbers by their path, in SI, and wait until the motion is there."""
    return page.evaluate(
        f"(async () => {{ const set = {json.dumps(numbers)}; const {{ model, change }} = v.live;"
        " const all = model.numbers.map((one) => set[one.path] ?? one.value);"
        " v.live.numbers.set(all); await v.live.shown; })()"
    )


def number(page, path):
    return page.evaluate(
        f"v.live.model.numbers.find((one) => one.path === {json.dumps(path)}).value"
    )


def motion(page):
    """Time, and name → values, of what is shown."""
    time, series = page.evaluate(
        "[Array.from(v.stage.motion.time), v.stage.motion.series.map((one) =>"
        " [one.name, Array.from(one.values)])]"
    )
    return np.array(time), {name: np.array(values, dtype=float) for name, values in series}


def assert_simulated(name, changes, time, found, asked=(*COMPUTED, *COMPARED)):
    """Compare values by name with those of a mechanism with other numbers."""
    mechanism = linkages.load(name, set=changes)
    outputs = [one for one in asked if one in available(System(mechanism))]
    data = linkages.simulate(mechanism, times=time, outputs=outputs).data
    known = data_series(data)
    compared = [label for label in found if label in known]
    assert {known[label].variable for label in compared} == set(outputs)
    # what is integrated has the tolerances of the file, about 1e-10, and a motion on which errors
    # grow, at each impact by some times; a motion that drives alone determine differs by round-off
    impacts = 1e-4 if mechanism.contacts else 1e-5
    tolerance = impacts if data.attrs.get("free") else 1e-11
    for label in compared:
        own = known[label].of(data).to_numpy()
        shown = found[label]
        if known[label].angle:  # whole turns of angles that are not integrated are not counted
            own, shown = np.exp(1j * own), np.exp(1j * shown)
        size = np.abs(own).max(initial=1e-3)
        np.testing.assert_allclose(shown, own, rtol=0, atol=tolerance * size)


class Worker:
    """The worker of a page without the page, in QuickJS."""

    def __init__(self, file):
        page = file.read_text(encoding="utf-8")
        packed = re.search(r'<script type="text/plain" id="worker">(.*?)</script>', page)[1]
        self.content = json.loads(re.search(r'id="content">(.*?)</script>', page)[1])
        self.context = quickjs.Context()
        self.context.eval("const list = (values) => [...values];")
        self.context.eval("let told, onmessage; const postMessage = (one) => { told = one; };")
        self.context.eval(zlib.decompress(base64.b64decode(packed)).decode())
        self.model = json.loads(self.context.eval("JSON.stringify(told.model)"))

    def number(self, path):
        """The number at a path, in SI."""
        return next(one["value"] for one in self.model["numbers"] if one["path"] == path)

    def motion(self, changes, times):
        """Why a motion with other numbers stopped, and name → values up to there."""
        numbers = [changes.get(one["path"], one["value"]) for one in self.model["numbers"]]
        asked = json.dumps({**self.content["tolerances"], "numbers": numbers})
        times = f"Float64Array.from({times.tolist()})"
        self.context.eval(f"onmessage({{ data: {{ ...{asked}, times: {times} }} }});")
        found = json.loads(
            self.context.eval("JSON.stringify({...told, rows: told.rows.map(list)})")
        )
        names = [one["name"] for one in self.model["series"]]
        rows = np.array(found["rows"], dtype=float)[:, : found["reached"]]
        why = self.model["statuses"].get(str(found["status"]))
        return why, dict(zip(names, rows, strict=True))


@pytest.mark.slow_except("four-bar-*", "scotch*")
@pytest.mark.parametrize(("name", "path"), CHANGED)
def test_a_worker_computes_the_motion_of_simulate(written, name, path):
    """The beginning of a motion: the engine is an interpreter, some dozen times as slow."""
    worker = Worker(written(name))
    value = FACTOR * worker.number(path)
    times = np.linspace(0.0, 0.02 * linkages.load(name).simulation.end, 26)
    why, found = worker.motion({path: value}, times)
    assert why is None
    assert_simulated(name, {path: value}, times, found, COMPUTED)


def test_a_worker_says_why_a_motion_stops(written):
    """A rocker that is far too short, and one with which the crank cannot turn round."""
    worker, times = Worker(written("four-bar")), np.linspace(0.0, 1.0, 101)
    why, found = worker.motion({"bars.rocker.length": 0.01}, times)
    assert why.startswith("the mechanism cannot be assembled: joint B, RRR dyad of coupler and")
    assert found["B.x position"].size == 0
    why, found = worker.motion({"bars.rocker.length": 0.058}, times)
    mechanism = linkages.load("four-bar", set={"bars.rocker.length": 0.058})
    stop = linkages.simulate(mechanism, throw=False).motion.stop_time
    assert "joint B" in why
    assert found["B.x position"].size == np.searchsorted(times, stop)


@needs_browser
@pytest.mark.slow
@pytest.mark.parametrize(("name", "path"), CHANGED)
def test_a_changed_motion_is_that_of_simulate(opened, name, path):
    page = opened(name)
    value = FACTOR * number(page, path)
    change(page, **{path: value})
    assert_simulated(name, {path: value}, *motion(page))
    assert page.complaints == []


@needs_browser
@pytest.mark.slow
def test_what_cannot_be_assembled_is_said_and_nothing_else_happens(opened):
    page = opened("four-bar")
    before = motion(page)[1]["B.x position"]
    change(page, **{"bars.rocker.length": 0.01})
    message = page.evaluate("document.getElementById('message').textContent")
    assert message.startswith("The mechanism cannot be assembled: joint B, RRR dyad of coupler and")
    np.testing.assert_array_equal(motion(page)[1]["B.x position"], before)
    change(page)
    assert page.evaluate("document.getElementById('message').hidden")


@needs_browser
@pytest.mark.slow
def test_a_motion_that_stops_is_shown_up_to_there(opened):
    """With so short a rocker the crank cannot turn round."""
    page = opened("four-bar")
    change(page, **{"bars.rocker.length": 0.058})
    message = page.evaluate("document.getElementById('message').textContent")
    mechanism = linkages.load("four-bar", set={"bars.rocker.length": 0.058})
    solution = linkages.simulate(mechanism, throw=False)
    stop = solution.motion.stop_time
    assert not solution.completed
    assert message.startswith("Stops at t = 0.")
    assert "joint B" in message
    assert message.endswith(".")
    assert not message.endswith("..")
    assert "change_points" not in message
    last = page.evaluate("v.stage.motion.end")
    step = page.evaluate("v.recorded.time[1]")
    assert stop - 1.01 * step < last <= stop
    assert page.evaluate("v.player.time") <= last


@needs_browser
@pytest.mark.slow
def test_the_definition_that_is_downloaded_has_what_was_changed(opened):
    page = opened("ninebar")
    change(page, **{"clearances.r1.size": 2e-4, "drives.crank4.speed": 4.0})
    mechanism = linkages.loads(page.evaluate("v.live.numbers.yaml"))
    wanted = linkages.load("ninebar", set={"clearances.r1.size": 2e-4, "drives.crank4.speed": 4.0})
    assert mechanism.name == wanted.name
    assert mechanism.components == wanted.components


@pytest.mark.parametrize("name", ["ninebar", "jansen", "andrews", "slider-crank-contact"])
def test_a_definition_without_changes_is_that_of_the_file(name):
    from linkages.viewer.content import template

    mechanism = linkages.load(name)
    parts = template(mechanism)
    text = "".join(part if isinstance(part, str) else part["text"] for part in parts)
    assert linkages.loads(text) == mechanism
    assert sum(isinstance(part, dict) for part in parts) > 10


@needs_browser
@pytest.mark.slow
def test_fields_and_sliders_change_numbers_in_the_units_of_the_file(opened):
    page = opened("four-bar")
    page.evaluate("v.tabs.open('numbers')")
    field = "document.querySelector('[aria-label=\"length of rocker in mm\"]')"
    assert page.evaluate(f"{field}.value") == "80"
    page.evaluate(f"{field}.value = '85'; {field}.dispatchEvent(new Event('change'));"
                  "v.live.shown")  # fmt: skip
    assert page.evaluate("v.live.numbers.values.includes(0.085)")
    assert page.evaluate("document.getElementById('tab-numbers').textContent") == "Change1"
    said = page.evaluate("v.live.numbers.note.textContent")
    assert said == "One number differs from the file: length of rocker."
    rest = page.evaluate("document.querySelector('#numbers .rest').textContent")
    assert rest == "Not computed for other numbers: closure error."
    slider = "document.querySelector('[aria-label=\"length of rocker\"]')"
    page.evaluate(f"{slider}.value = '0.5'; {slider}.dispatchEvent(new Event('input'));"
                  "v.live.shown")  # fmt: skip
    assert page.evaluate(f"{field}.value") == "160"  # half way to four times as much
    page.evaluate("v.live.numbers.reset.click()")
    assert page.evaluate("v.stage.motion === v.recorded")
    assert page.evaluate("document.getElementById('tab-numbers').textContent") == "Change"


GEARED = """
joints: {O: [0, 0], C: [60 mm, 0]}
bars:
  wheel: {joints: [O, P], length: 20 mm, mass: 0.1}
  pinion: {joints: [C, Q], length: 10 mm, mass: 0.1}
gears: [{bars: [wheel, pinion], ratio: -1/2}]
drives: {wheel: {angle: 0, speed: 1}}
simulate: {end: 1, samples: 11}
"""


@needs_browser
@pytest.mark.slow
def test_shapes_that_stay_those_of_the_file_are_named(browser, tmp_path):
    page = browser.page()
    page.open(linkages.view(linkages.loads(GEARED), tmp_path / "page.html"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    page.evaluate("v.tabs.open('numbers')")
    said = page.evaluate(
        "[...document.querySelectorAll('#numbers .rest')].map((p) => p.textContent)"
    )
    assert "Pitch circles are drawn as in the file." in said


@needs_browser
@pytest.mark.slow
def test_the_newest_change_is_the_one_that_is_shown(opened):
    page = opened("ninebar")
    page.evaluate(
        "(async () => { const all = v.live.model.numbers.map((one) => one.value);"
        " const k = v.live.model.numbers.findIndex((one) => one.path === 'bars.link3.length');"
        " for (let i = 1; i <= 6; i++) { all[k] = 0.962 + 0.002 * i;"
        " v.live.numbers.set(all); } await v.live.shown; })()"
    )
    places = motion(page)[1]
    length = np.hypot(*(places[f"B.{a} position"] - places[f"C.r1.{a} position"] for a in "xy"))
    np.testing.assert_allclose(length, 0.974, rtol=1e-12)


@needs_browser
@pytest.mark.slow
def test_what_takes_too_long_is_given_up_and_the_page_goes_on(opened):
    page = opened("ninebar")
    page.evaluate("Live.limit = 0")
    change(page, **{"bars.link3.length": 0.97})
    message = page.evaluate("document.getElementById('message').textContent")
    assert message == "Not computed within 0 s. The motion before is still shown."
    assert page.evaluate("v.stage.motion === v.recorded")
    page.evaluate("Live.limit = 1000")
    change(page, **{"bars.link3.length": 0.97})
    assert page.evaluate("document.getElementById('message').hidden")
    assert page.evaluate("v.stage.motion !== v.recorded")


@needs_browser
@pytest.mark.slow
def test_the_ideal_mechanism_follows_numbers_as_well(opened):
    page = opened("ninebar")
    length = FACTOR * number(page, "bars.link3.length")
    change(page, **{"bars.link3.length": length})
    ideal = linkages.load("ninebar", set={"bars.link3.length": length}).ideal()
    time, _ = motion(page)
    data = linkages.simulate(ideal, times=time[::50], outputs=["joint_position"]).data
    own = data["joint_position"].sel(joint="E").to_numpy()
    found = page.evaluate(
        "Array.from(v.stage.motion.time).filter((_, i) => i % 50 === 0)"
        ".map((t) => v.stage.ghost.joint('E', t))"
    )
    np.testing.assert_allclose(found, own, rtol=0, atol=1e-12)


@needs_browser
@pytest.mark.slow
def test_a_page_without_workers_computes_itself(browser, written):
    """As where they are forbidden; the page stands still meanwhile, and gives up after a time."""
    page = browser.page()
    refusing = "constructor() { throw new DOMException('no workers here', 'SecurityError'); }"
    source = f"window.Worker = class {{ {refusing} }};"
    page.call("Page.addScriptToEvaluateOnNewDocument", source=source)
    page.open(written("ninebar"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    page.evaluate("Live.limit = 0")
    change(page, **{"bars.link3.length": 0.97})
    message = page.evaluate("document.getElementById('message').textContent")
    assert message == "Not computed within 0 s. The motion before is still shown."
    page.evaluate("Live.limit = 1000")
    change(page, **{"bars.link3.length": 0.97})
    places = motion(page)[1]
    length = np.hypot(*(places[f"B.{a} position"] - places[f"C.r1.{a} position"] for a in "xy"))
    np.testing.assert_allclose(length, 0.97, rtol=1e-12)
    said = page.evaluate("document.getElementById('numbers').textContent")
    assert "computed on this page itself" in said
    assert page.complaints == []


@needs_browser
@pytest.mark.slow
def test_a_motion_without_tolerances_of_its_own_starts_at_rest(browser, tmp_path):
    """Nothing moves: errors are measured against a tolerance that is none of nothing."""
    mechanism = linkages.loads(
        "{joints: {O: [0, 0]}, bars: {rod: {joints: [O, A], length: 1, mass: 1}},"
        " free: {rod: {angle: 0, speed: 0}}}"
    )
    page = browser.page()
    page.open(linkages.view(mechanism, tmp_path / "rest.html"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    change(page, **{"bars.rod.length": 2.0})
    assert page.evaluate("document.getElementById('message').hidden")
    assert set(motion(page)[1]["A.x position"]) == {2.0}


@needs_browser
@pytest.mark.slow
def test_change_points_are_passed_where_simulate_passes_them(browser, tmp_path):
    """A parallelogram in line goes on as one."""
    mechanism = linkages.loads(
        "{joints: {O: [0, 0], C: [1, 0]}, bars: {a: {joints: [O, A], length: 0.5, mass: 1},"
        " b: {joints: [A, B], length: 1, mass: 1}, c: {joints: [C, B], length: 0.5, mass: 1}},"
        " drives: {a: {angle: 60 deg, speed: -6}}, assembly: {B: [1.25, 0.4]},"
        " simulate: {end: 0.15, samples: 41, change_points: pass}}"
    )
    page = browser.page()
    file = tmp_path / "page.html"
    solution = linkages.simulate(mechanism)
    # with its own samples, not with as many as round-off in accelerations would take
    text = page_content(mechanism, solution.data, solution.options, solution.notes, None)
    file.write_text(text, encoding="utf-8")
    page.open(file)
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    change(page, **{"drives.a.speed": -9.0})
    time, found = motion(page)
    assert page.evaluate("document.getElementById('message').hidden")
    assert time[-1] == pytest.approx(0.15)
    # in line at π/27 s, which the slower motion of the file does not reach; AB stays parallel to OC
    np.testing.assert_allclose(found["B.x position"] - found["A.x position"], 1.0, atol=1e-9)


@pytest.mark.parametrize(
    "options",
    [{"end": -0.5, "samples": 51}, {"times": [0.0, 0.1, 0.3]}, {"times": [0.3]}],
    ids=["back in time", "own times", "one time"],
)
@needs_browser
@pytest.mark.slow
def test_any_times_are_shown_and_computed_again(browser, tmp_path, options):
    solution = linkages.simulate(linkages.load("double-pendulum"), **options)
    page = browser.page()
    page.open(linkages.view(solution, tmp_path / "page.html"))
    page.evaluate("viewer.then((parts) => { window.v = parts; })")
    time = solution.data["time"].to_numpy()
    assert page.evaluate("[v.recorded.start, v.recorded.end]") == pytest.approx([time[0], time[-1]])
    page.press("End")
    assert page.evaluate("v.player.time") == pytest.approx(time[-1])
    if len(time) > 1:
        change(page, **{"gravity[1]": -9.0})
        found, values = motion(page)
        again = linkages.load("double-pendulum", set={"gravity[1]": -9.0})
        data = linkages.simulate(again, end=float(time[-1]), samples=len(found)).data
        own = data["joint_position"].sel(joint="Q", axis="x").to_numpy()
        np.testing.assert_allclose(values["Q.x position"], own, atol=1e-6)
    assert page.complaints == []


@needs_browser
@pytest.mark.slow
def test_it_computes_in_the_frame_of_a_notebook(browser, solved, tmp_path):
    """A frame without an origin of its own: no storage, no access to what is around it."""
    file = tmp_path / "notebook.html"
    file.write_text(f"<!doctype html><title>n</title>{solved('four-bar')._repr_html_()}")
    page = browser.page()
    page.open(file)
    frame = page.frame()
    frame.evaluate(
        "new Promise((done) => { const look = () => window.viewer ? viewer.then(() => done())"
        " : requestAnimationFrame(look); look(); })"
    )
    assert frame.evaluate("document.querySelectorAll('#numbers .number').length") == 15
    assert page.complaints == frame.complaints == []
