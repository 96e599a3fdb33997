"""Tables of loads and drives: what joins their values, and what is refused."""

import numpy as np
import pytest
from component_reading import complaints, mechanism

from linkages.components.contributed.functions import extremes
from linkages.kernel.inputs import law_values

LOADED = (
    "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 0.3}}\n"
    "sliders: {block: {joint: A, through: O}}\nloads:\n"
    "  - {slider: block, force: {table: {TABLE}}}\n"
)
DRIVEN = (
    "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 0.3}}\n"
    "drives:\n  crank: {law: {table: {TABLE}}}\n"
)
# the rod of a pump: it lifts 40 kN and lowers 20 kN
PUMP = (
    "times: [0, 1.5, 1.6, 4.5, 4.6, 6], values: [-20 kN, -20 kN, -40 kN, -40 kN, -20 kN, -20 kN], "
    "periodic: true"
)
PLAIN = "times: [0, 1, 3], values: [0, 2, 1]"


def load_law(table):
    (load,) = mechanism(_movable(LOADED).replace("TABLE", table)).loads
    return load.force


def _movable(text):
    return text.replace("sliders:", "free: {crank: {angle: 1, speed: 0}}\nsliders:")


def drive_law(table):
    return mechanism(DRIVEN.replace("TABLE", table)).prescribed["crank"].law


def test_a_load_that_steps_stays_within_its_values():
    """As a spline it went from -187.8 to +20.9 kN."""
    law = load_law(PUMP)
    assert extremes(law, 0, 6) == (-40e3, -20e3)
    values = law_values(law, np.linspace(-7, 20, 5001))
    assert values.min() == pytest.approx(-40e3, rel=1e-14)
    assert values.max() == pytest.approx(-20e3, rel=1e-14)
    bent = extremes(load_law(f"{PUMP}, interpolation: spline"), 0, 6)
    assert bent == pytest.approx((-187.8e3, 20.9e3), rel=2e-3)  # as printed, to four digits


@pytest.mark.parametrize("interpolation", ["linear", "pchip", "spline"])
def test_loads_keep_their_last_value_and_drives_their_last_speed(interpolation):
    law = load_law(f"{PLAIN}, interpolation: {interpolation}")
    assert (law.interpolation, law.held) == (interpolation, True)
    assert law_values(law, np.array([-5.0, 0.0, 1.0, 3.0, 9.0])).tolist() == [0, 0, 2, 1, 1]
    if interpolation == "linear":
        return
    law = drive_law(f"{PLAIN}, interpolation: {interpolation}")
    inside, at, later, last = law_values(law, np.array([3.0 - 1e-6, 3.0, 4.0, 5.0]))
    assert later - at == pytest.approx((at - inside) / 1e-6, abs=1e-5)  # the second derivative
    assert last - later == pytest.approx(later - at, rel=1e-12)


def test_what_joins_values_unasked():
    assert load_law(PLAIN).interpolation == "pchip"
    assert drive_law(PLAIN).interpolation == "spline"


def test_two_points_make_a_line():
    law = load_law("times: [0, 2], values: [1, 5], interpolation: linear")
    assert law_values(law, np.array([-1.0, 0.5, 2.0, 3.0])).tolist() == [1, 2, 5, 5]


@pytest.mark.parametrize(
    ("text", "table", "found"),
    [
        (
            DRIVEN,
            f"{PLAIN}, interpolation: linear",
            "make the speed of a drive jump",
        ),
        (LOADED, f"{PLAIN}, interpolation: cubic", "expected 'linear', 'pchip' or 'spline', found"),
        (LOADED, "times: [0, 1], values: [1, 2]", "expected at least three times, found 2"),
        (LOADED, "times: [0], values: [1], interpolation: linear", "expected at least two times"),
        (LOADED, "times: [0, 1, 2]", "missing key 'values': expected 'times' and 'values', or"),
        (LOADED, "columns: [1, 2]", "missing key 'file': expected 'times' and 'values', or 'file'"),
    ],
)
def test_tables_that_are_none(text, table, found):
    (problem,) = complaints(_movable(text).replace("TABLE", table))
    assert found in problem
    assert problem.startswith("line ")


@pytest.mark.parametrize("interpolation", ["linear", "pchip", "spline"])
def test_polynomials_that_overflow_have_a_line(interpolation):
    """The spline's own solver said 'dydx must contain only finite values', without a place."""
    table = f"times: [0, 1, 2], values: [1e308, -1e308, 1e308], interpolation: {interpolation}"
    (problem,) = complaints(_movable(LOADED).replace("TABLE", table))
    assert problem.startswith("line 6, column 29, loads[0].force.table: the polynomials between ")
    assert f"({interpolation}) overflow; expected smaller values" in problem
