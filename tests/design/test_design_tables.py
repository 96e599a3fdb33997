"""Derivatives by the values of tables, which coefficients of their polynomials are linear in."""

from __future__ import annotations

import numpy as np
import pytest
from design_differences import compared

import linkages
from linkages.design.differentiated import Differentiated
from linkages.errors import InputError

ROD = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{rod: {{joints: [O, B], length: 0.5, mass: 1}}}}
loads: [{{bar: rod, torque: {{table: {{{table}}}}}}}]
free: {{rod: {{angle: -1.5, speed: 0}}}}
"""
DRIVE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3, mass: 1}, rod: {joints: [A, B], length: 0.5, mass: 1}}
drives: {crank: {law: {table: {times: [0, 0.3, 0.7, 1], values: [0, 0.4, 0.6, 1.5]}}}}
free: {rod: {angle: -1, speed: 0}}
"""
CAM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {cam: {joints: [O, A], length: 0.02, mass: 1}}
sliders: {valve: {joint: V, through: [0, 0.05], angle: 90 deg, mass: 0.5}}
cams:
  - {slider: valve, bar: cam, angles: [0, 90 deg, 180 deg, 270 deg, 360 deg],
     lifts: [0, 4 mm, 10 mm, 5 mm, 0]}
drives: {cam: {angle: 0.2, speed: 10}}
"""
CASES = {
    "a drive": (DRIVE, "drives.crank.law.table.values[1]", ["crank.effort", "rod.angle"]),
    "straight lines over time": (
        ROD.format(table="times: [0, 0.3, 0.7, 1], values: [0, 1, 2, -1], interpolation: linear"),
        "loads[0].torque.table.values[2]", ["rod.angle", "rod.acceleration"],
    ),
    "straight lines over an angle": (
        ROD.format(table="over: rod.angle, at: [-2, -1, 0, 1, 2], values: [3, 1, 0, -1, -4], "
                         "interpolation: linear"),
        "loads[0].torque.table.values[1]", ["rod.angle", "rod.acceleration"],
    ),
    "what repeats": (
        ROD.format(table="times: [0, 0.3, 0.5], values: [0, 1, 0], periodic: true, "
                         "interpolation: spline"),
        "loads[0].torque.table.values[1]", ["rod.angle", "rod.acceleration"],
    ),
    "a cam": (CAM, "cams[0].lifts[1]", ["valve.position", "valve.acceleration", "cam.effort"]),
}  # fmt: skip


@pytest.mark.slow_except("a cam", "*an angle")
@pytest.mark.parametrize("name", CASES)
def test_values_of_tables_have_the_derivatives_of_differences(name):
    """Differences of 1e-3 of a value, of motions whose steps cross the places of tables.

    What is left there falls with the tolerance: at 1e-12 it is a thousand times as large.
    """
    text, path, series = CASES[name]
    run = {"end": 1.0, "samples": 101, "rtol": 1e-13}
    found = Differentiated(linkages.loads(text), [], [path], run=run)
    times = np.array([0.1, 0.4, 0.8])
    missed, attainable = compared(found, series, times, [0], 1e-3)
    assert (missed <= 3e-8 + 10 * attainable).all()
    exact = found.along(found.values, series, times).derivatives
    assert exact is not None
    assert np.abs(exact).max() > 0.1


@pytest.mark.parametrize(
    ("table", "path", "message"),
    [
        ("times: [0, 0.3, 0.5], values: [0, 1, 0]", "values[1]", "joined by pchip"),
        ("times: [0, 0.3, 0.5], values: [0, 1, 0], interpolation: spline", "times[1]", "places"),
        ("times: [0, 0.3, 0.5], values: [0, 1, 0], periodic: true, interpolation: spline",
         "values[0]", "first and the last value"),
    ],
)  # fmt: skip
def test_what_coefficients_are_not_linear_in_is_refused(table, path, message):
    mechanism = linkages.loads(ROD.format(table=table))
    with pytest.raises(InputError, match=message):
        Differentiated(mechanism, [], [f"loads[0].torque.table.{path}"])
