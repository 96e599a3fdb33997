"""JavaScript in a browser, against the compiled kernel and NumPy."""

import json

import numpy as np
import pytest
from browser import Browser, needs_browser
from exported_states import NAMES, assert_near, cases, kernel, system

from linkages.exports.kernels.javascript import javascript_integrator, javascript_module

pytestmark = needs_browser


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "empty.html"
    file.write_text("<!doctype html><title>empty</title>", encoding="utf-8")
    with Browser() as browser:
        found = browser.page()
        found.open(file)
        yield found


def run(page, text, expression):
    """The value of an expression after the text of modules."""
    plain = text.replace("export ", "")
    return page.evaluate(f"(() => {{ {plain}\nreturn ({expression}); }})()")


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


@pytest.mark.parametrize("name", NAMES)
def test_rates_and_outputs_are_those_of_numpy(name, page):
    given = [{"time": case.time, "state": case.state.tolist()} for case in cases(name)]
    text = javascript_module(system(name)) + f"\nconst cases = {json.dumps(given)};"
    groups = [quantity.variable for quantity in kernel(name).quantities]
    for found, case in zip(run(page, text, EVALUATED), cases(name), strict=True):
        assert found["status"] == [0, 0, 0]
        half = len(case.rates) // 2
        assert_near(found["own"], case.state)
        assert_near(found["rates"][half:], case.rates[half:])
        assert_near(found["rates"][:half], case.rates[:half])
        assert_near(found["outputs"], case.outputs, groups)
