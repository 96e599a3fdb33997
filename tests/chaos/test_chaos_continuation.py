"""A chain of values goes on from state to state: a chain of equal values is one long motion."""

import numpy as np
import pytest
from shared_definitions import DRIVEN_PENDULUM

import linkages
from linkages.components.mechanisms.definition import from_document
from linkages.reading.document import parse

PENDULUM = DRIVEN_PENDULUM.replace('"1.15*cos(2*t/3)"', '"0.7*cos(2*t/3)"')
PENDULUM += "simulate: {end: 10, samples: 11, rtol: 1e-9}\n"

# the spring is wound up by several turns
WOUND = PENDULUM.replace("dampers:", "springs: [{bar: arm, stiffness: 0.02}]\ndampers:").replace(
    "0.7*cos", "1.5 + 0.7*cos"
)

HARMONIC = "{mean: 0.05, amplitude: 0.1, angular_frequency: 6.283185307179586}"
FREE = """\
name: Free four-bar
joints: {O: [0, 0], C: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.1}
  coupler: {joints: [A, B], length: 120 mm, mass: 0.3}
  rocker: {joints: [C, B], length: 80 mm, mass: 0.2}
dampers: [{joint: O, damping: 0.004}]
free: {crank: {angle: 1, speed: 0}}
loads: [{bar: crank, torque: {harmonic: HARMONIC}}]
assembly: {B: PLACE}
simulate: {end: 1, rtol: 1e-9}
"""

# two cranks that turn all the way; the second one depends on the first and winds a spring up
DRAG = """\
name: Drag link with a spring
joints: {O: [0, 0], C: [0.03, 0]}
bars:
  crank: {joints: [O, A], length: 100 mm, mass: 0.1}
  coupler: {joints: [A, B], length: 90 mm, mass: 0.3}
  follower: {joints: [C, B], length: 100 mm, mass: 0.2}
springs: [{bar: follower, stiffness: 0.001}]
dampers: [{joint: O, damping: 0.004}]
free: {crank: {angle: 1, speed: 0}}
loads: [{bar: crank, torque: "0.05 + 0.01*cos(2*pi*t)"}]
assembly: {B: right}
simulate: {end: 1, rtol: 1e-9}
"""


def mechanism(text, **changes):
    document = parse(text, "m.yaml")
    return from_document(document).with_values(changes)


def run_on(text, path, value, **section):
    """Speeds at both of two equal values, and those of one motion over the same time."""
    run = {"periods": 4, "skip": 3, **section}
    data = linkages.bifurcation(
        mechanism(text), {path: [value, value]}, start="forward", **run
    ).bar_speed[0, :, :, 0]
    second = {**run, "skip": 2 * run["skip"] + run["periods"] - (not section)}
    long = linkages.poincare(mechanism(text, **{path: value}), **second).bar_speed[:, 0]
    return data.to_numpy(), long.to_numpy()


@pytest.mark.slow_except("phase 0-*")
@pytest.mark.parametrize("text", [PENDULUM, WOUND, DRAG], ids=["no spring", "free", "dependent"])
@pytest.mark.parametrize("section", [{}, {"phase": 0.5}], ids=["phase 0", "phase 0.5"])
def test_chain_of_equal_values_is_one_motion(text, section):
    """Without a phase the next value begins at the last point; with one, half a period later."""
    (_, second), long = run_on(
        text, "dampers[0].damping", 0.004 if text is DRAG else 0.5, **section
    )
    assert second == pytest.approx(long, abs=1e-6)


def test_crossings_hand_on_a_whole_number_of_periods():
    first, second = 0.5, 0.6
    run = {"periods": 3, "skip": 2, "section": "arm.speed=0"}
    data = linkages.bifurcation(
        mechanism(PENDULUM), {"dampers[0].damping": [first, second]}, start="forward", **run
    )
    before = mechanism(PENDULUM, **{"dampers[0].damping": first})
    last = float(linkages.poincare(before, **run).time[-1])
    whole = linkages.poincare(before, periods=1, skip=int(np.ceil(last / (3 * np.pi))))
    state = (float(whole.bar_angle[0, 0]), float(whole.bar_speed[0, 0]))
    after = mechanism(PENDULUM, **{"dampers[0].damping": second}).with_state({"arm": state})
    expected = linkages.poincare(after, **run).bar_angle
    assert data.bar_angle[0, 1].to_numpy() == pytest.approx(expected.to_numpy(), abs=1e-6)


def test_crossings_without_drives_go_on_from_the_last_one():
    text = PENDULUM.replace("0.7*cos(2*t/3)", "0")
    path, run = "dampers[0].damping", {"section": "arm.angle=-90 deg", "direction": "both"}
    data = linkages.bifurcation(
        mechanism(text), {path: [0.01, 0.01]}, periods=3, skip=0, start="forward", **run
    )
    long = linkages.poincare(mechanism(text, **{path: 0.01}), periods=6, end=100, **run)
    expected = long.bar_speed[:, 0].to_numpy()
    last = data.bar_speed[0, 1, :, 0].to_numpy()
    assert last[np.isfinite(last)][-1] == pytest.approx(expected[-1], abs=1e-6)


@pytest.mark.slow_except("None")
@pytest.mark.parametrize("section", [None, "crank.speed=0"])
def test_assembly_mode_stays_with_a_rough_place(section):
    run = {"periods": 2, "skip": 7, "start": "forward"}
    if section is not None:
        run |= {"periods": 2, "skip": 3, "section": section}
    left, rough = (
        linkages.bifurcation(
            mechanism(FREE.replace("PLACE", place).replace("HARMONIC", HARMONIC)),
            {"loads[0].torque.harmonic.amplitude": np.linspace(0.1, 0.2, 5)},
            **run,
        )
        for place in ("left", "[0.17, 0]")
    )
    assert set(left.reason.to_numpy().ravel()) == {""}
    assert rough.bar_speed.to_numpy() == pytest.approx(
        left.bar_speed.to_numpy(), abs=1e-9, nan_ok=True
    )
