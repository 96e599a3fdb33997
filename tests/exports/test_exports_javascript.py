"""JavaScript in QuickJS and a browser, against the compiled kernel and NumPy."""

import json

import numpy as np
import pytest
import quickjs
from browser import Browser, needs_browser
from exported_states import (
    CHANGES,
    NAMES,
    PARALLELOGRAM,
    PASSING,
    SWITCHED,
    assert_near,
    cases,
    changes,
    compared_parameters,
    followed_rows,
    kernel,
    switched,
    system,
)

import linkages
from linkages.exports.writers.source_code import javascript_module
from linkages.kernel.system import System


def run(text, expression):
    """The value of an expression after the text of a module; numbers that are not finite are None.

    The engine is an interpreter: a motion takes it dozens of times as long as a browser.
    """
    context = quickjs.Context()
    context.module(f"{text}\nglobalThis.evaluate = () => JSON.stringify({expression});")
    return json.loads(context.eval("evaluate()"))


EVALUATED = """
cases.map(({ time, state }) => {
  const rates = new Float64Array(2 * model.coordinates.length);
  const outputs = new Float64Array(model.series.length);
  const own = Float64Array.from(state);
  const status = [
    model.settled(time, own, model.parameters),
    model.rates(time, own, model.parameters, rates),
    model.outputs(time, own, model.parameters, outputs),
  ];
  return { status, own: [...own], rates: [...rates], outputs: [...outputs].map(String) };
})
"""


@pytest.mark.slow_except(
    "four-bar", "ninebar", "bounce", "rub", "slider-crank-contact", "five-bar-free", "tables"
)
@pytest.mark.parametrize("name", NAMES)
def test_rates_and_outputs_are_those_of_numpy(name):
    given = [{"time": case.time, "state": case.state.tolist()} for case in cases(name)]
    text = javascript_module(system(name)) + f"\nconst cases = {json.dumps(given)};"
    groups = [quantity.variable for quantity in kernel(name).quantities]
    for found, case in zip(run(text, EVALUATED), cases(name), strict=True):
        assert found["status"] == [0, 0, 0]
        half = len(case.rates) // 2
        assert_near(found["own"], case.state)
        assert_near(found["rates"][half:], case.rates[half:])
        assert_near(found["rates"][:half], case.rates[:half])
        assert_near(found["outputs"], case.outputs, groups)


def nine_bar(end, samples):
    """Its module with times, what `linkages.simulate` finds then, and places of that in outputs."""
    own, times = system("ninebar"), np.linspace(0.0, end, samples)
    data = linkages.simulate(own.mechanism, times=times, rtol=1e-12, outputs=FOLLOWED).data
    expected = np.hstack([data[name].values.reshape(samples, -1) for name in FOLLOWED])
    quantities = kernel("ninebar").quantities
    rows = [k for name in FOLLOWED for k, q in enumerate(quantities) if q.variable == name]
    text = javascript_module(own) + f"\nconst times = {json.dumps(times.tolist())};"
    return text, expected, rows


def assert_moved(ended, expected, rows):
    """Tolerances of 1e-12 and below are far beneath 1e-9 of every output's size."""
    assert ended["status"] == 0
    found = np.array(ended["values"], dtype=float)[:, rows]  # none where one is infinite
    assert found.shape == expected.shape
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_the_nine_bar_moves_as_in_simulate():
    text, expected, rows = nine_bar(0.05, 21)
    assert_moved(run(text, MOVED), expected, rows)


@needs_browser
@pytest.mark.slow
def test_two_seconds_of_the_nine_bar_in_a_browser(tmp_path):
    text, expected, rows = nine_bar(2.0, 41)
    file = tmp_path / "empty.html"
    file.write_text("<!doctype html><title>empty</title>", encoding="utf-8")
    with Browser() as browser:
        page = browser.page()
        page.open(file)
        plain = text.replace("export ", "")
        ended = page.evaluate(f"(() => {{ {plain}\nreturn ({MOVED}); }})()")
    assert_moved(ended, expected, rows)


FOLLOWED = ("joint_position", "slider_position", "clearance_angle")
MOVED = """
(() => {
  const values = [], state = model.state.slice(), out = new Float64Array(model.series.length);
  const parameters = model.parameters.slice();
  const ended = model.integrate(parameters, state, times, { rtol: 1e-12, atol: 1e-14 },
    (i, t, reached) => {
      model.outputs(t, reached, parameters, out);
      values.push([...out]);
    });
  return { ...ended, values };
})()
"""


FED = """
numbers.map((given) => {
  const parameters = model.parameters.slice(), state = model.state.slice();
  const status = model.feed(Float64Array.from(given), parameters, state);
  return { status, parameters: [...parameters], state: [...state] };
})
"""


@pytest.mark.slow_except("four-bar", "ninebar", "rub", "slider-crank-contact")
@pytest.mark.parametrize("name", NAMES)
def test_numbers_of_the_file_lead_to_its_parameters_and_state(name):
    """A component carried out with nodes is what the changed file says, one number at a time."""
    given = [numbers for numbers, *_ in changes(name)]
    text = javascript_module(system(name)) + f"\nconst numbers = {json.dumps(given)};"
    rows = compared_parameters(name)
    for found, (_, parameters, state) in zip(run(text, FED), changes(name), strict=True):
        assert found["status"] == 0
        np.testing.assert_allclose(
            np.array(found["parameters"], dtype=float)[rows],
            parameters[rows],
            rtol=1e-14,
            atol=1e-15,
        )
        np.testing.assert_allclose(found["state"], state, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("tolerances", ["{}", "{rtol: 1e-7, atol: 0}", "{rtol: 1e-7, atol: null}"])
def test_what_stays_zero_has_no_error(tolerances):
    """A bar at rest in its balance: no tolerance is asked of zeros."""
    text = "joints: {O: [0, 0]}\nbars: {b: {joints: [O, P], length: 1, mass: 1}}\n"
    of = System(linkages.loads(text + "free: {b: {angle: 0, speed: 0}}"))
    still = f"model.integrate(model.parameters, model.state, [0, 1], {tolerances}, () => 0)"
    ended = run(javascript_module(of), still)
    assert (ended["status"], ended["time"]) == (0, 1)


@pytest.mark.slow_except("bounce", "rub", "free")
@pytest.mark.parametrize("name", [*SWITCHED, *PASSING])
def test_contacts_and_friction_are_those_of_simulate(name):
    """Touches, impacts, sticking, change points: all are located far below 1e-9."""
    times, expected = switched(name)
    rows = followed_rows(name)
    text = javascript_module(system(name))
    ended = run(text + f"\nconst times = {json.dumps(times.tolist())};", MOVED)
    assert ended["status"] == 0
    found = np.array(ended["values"], dtype=float)[:, rows]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)


def test_change_points_end_driven_motions():
    of = System(linkages.loads(PARALLELOGRAM))
    times = "[0, 0.4 / 3, 0.8 / 3, 0.4]"
    followed = f"model.integrate(model.parameters, model.state, {times}, {{}}, () => 0)"
    said = f"[{followed}].map((e) => [e.time, model.statuses[e.status]])[0]"
    time, text = run(javascript_module(of), said)
    assert time == pytest.approx(CHANGES, abs=1e-5)
    assert "singular" in text
    assert "joint B" in text
