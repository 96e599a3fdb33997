"""The kernel satisfies Lagrange's equations of the first kind, derived with SymPy.

See `lagrange_equations` for the symbolic road and `lagrange_states` for the states.
"""

from functools import cache

import numpy as np
import pytest
from lagrange_equations import Lagrange, agree, assert_agrees
from lagrange_mechanisms import MORE_MECHANISMS
from lagrange_states import Kernel, analysed

from linkages.components.mechanisms.definition import from_document
from linkages.reading.document import parse

__all__ = ["Kernel", "Lagrange", "agree"]

COUNT = 100

NINE_BAR = """
gravity: [9.81, 0]
joints: {O: [0, 0], D: [1.100, 0]}
bars:
  crank1:  {joints: [O, A], length: 0.300, mass: 0.985, inertia: 8.390e-3}
  link2:   {joints: [A, B], length: 0.893, mass: 2.836, inertia: 1.957e-1}
  link3:   {joints: [C, B], length: 0.962, mass: 3.051, inertia: 2.437e-1}
  crank4:  {joints: [D, C], length: 0.100, mass: 0.361, inertia: 4.774e-4}
  rocker6: {joints: [O, E], length: 0.850, mass: 2.701, inertia: 1.693e-1}
  link7:   {joints: [E, B], length: 0.623, mass: 1.993, inertia: 6.818e-2}
  link8:   {joints: [E, F], length: 0.850, mass: 2.701, inertia: 1.693e-1}
sliders: {slider9: {joint: F, through: O, angle: 0, mass: 4.288}}
clearances: {r1: {joint: C, bar: link3, size: 0.15 mm}}
drives: {crank1: {angle: 0.5, speed: -pi}, crank4: {angle: 1.0, speed: pi}}
loads: [{slider: slider9, force: -100}]
"""

SLIDER_CRANK = """
gravity: [1.2, -9.81]
joints: {{O: [0.1, -0.2]}}
bars:
  crank: {{joints: [O, A], length: 0.2, mass: 0.8, center: 0.07}}
  rod: {{joints: [B, A], length: 0.5, mass: 1.3, center: [0.2, 0.06], inertia: 0.04}}
sliders: {{piston: {{joint: B, through: [0.3, 0.02], angle: 0.3, mass: 0.9}}}}
clearances: {{{clearances}}}
drives: {{crank: {{angle: 0.5, speed: 12}}}}
loads: [{{slider: piston, force: -40}}]
"""
CLEARANCES = {
    "O": "rO: {joint: O, bar: crank, size: 1 mm}",
    "A": "rA: {joint: A, bar: rod, size: 0.8 mm}",
    "B": "rB: {joint: B, bar: rod, size: 0.5 mm}",
}

FOUR_BAR = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.5, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.15, mass: 0.5}
  coupler: {joints: [A, B], length: 0.55, mass: 1.1, center: 0.4}
  rocker: {joints: [C, B], length: 0.35, mass: 0.7, center: [0.1, -0.03]}
clearances:
  rA: {joint: A, bar: coupler, size: 0.5 mm}
  rC: {joint: C, bar: rocker, size: 0.3 mm}
drives: {crank: {angle: 0, speed: 9}}
"""

PLATES = """
gravity: [2, -9]
joints: {{O: [0, 0], C: [0.6, 0]}}
bars:
  crank:
    points: {{O: [0.02, 0.01], A: [0.15, -0.05]}}
    mass: 0.4
    center: [0.1, 0.06]
    inertia: 3e-3
  plate:
    points: {{P: [0.1, 0.2], A: [0.01, 0.02], B: [0.45, 0]}}
    mass: 1.4
    center: [0.2, 0.15]
    inertia: 0.05
  rocker: {{joints: [B, C], length: 0.4, mass: 0.6}}
  rod: {{joints: [P, F], length: 0.7, mass: 0.3, center: [0.1, 0.02]}}
sliders: {{slider: {{joint: F, through: [-0.2, 0.4], angle: 40 deg, mass: 0.9}}}}
loads: [{{slider: slider, force: 25}}, {{slider: slider, force: -7}}]
{known}
"""

DOUBLE_PENDULUM = """
gravity: [0.3, -9.81]
joints: {O: [0.2, 0]}
bars:
  upper: {joints: [O, A], length: 0.6, mass: 1.2, center: [0.2, 0.05]}
  lower: {joints: [A, tip], length: 0.4, mass: 0.7}
free: {upper: {angle: 1, speed: 0}, lower: {angle: 0, speed: 0}}
"""

CART = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  arm: {joints: [H, tip], length: 0.6, mass: 1.2, center: 0.5}
  disc: {points: {H: [0.1, 0.1]}, mass: 0.5, center: [0.15, 0.02], inertia: 0.01}
sliders: {cart: {joint: H, through: O, angle: 15 deg, mass: 2}}
free: {cart: {position: 0.1, speed: 0}, arm: {angle: 0, speed: 0}, disc: {angle: 0, speed: 0}}
loads: [{slider: cart, force: 3}]
"""

TRAMMEL = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {bar: {joints: [P, Q], length: 0.6, mass: 1.2, center: [0.25, 0.03]}}
sliders:
  across: {joint: P, through: O, angle: 10 deg, mass: 0.4}
  up: {joint: Q, through: [0.1, 0], angle: 90 deg, mass: 0.7}
clearances: {r1: {joint: Q, bar: bar, size: 2 mm}}
free: {bar: {angle: 0.4, speed: 0}}
loads: [{slider: up, force: 3}]
"""

DRIVEN = "drives: {crank: {angle: 0.5, speed: 3}}"
FREE = "free: {crank: {angle: 0.5, speed: 3}}"
LOOSE = "clearances: {rB: {joint: B, bar: plate, size: 0.6 mm}}\n" + DRIVEN

MECHANISMS = {
    "nine-bar": NINE_BAR,
    **{
        f"slider-crank-{'-'.join(joints) or 'ideal'}": SLIDER_CRANK.format(
            clearances=", ".join(CLEARANCES[joint] for joint in joints)
        )
        for joints in ("", "O", "A", "B", "OAB")
    },
    "four-bar-two-clearances": FOUR_BAR,
    "plates-driven": PLATES.format(known=DRIVEN),
    "plates-free": PLATES.format(known=FREE),
    "plates-loose": PLATES.format(known=LOOSE),
    "double-pendulum": DOUBLE_PENDULUM,
    "cart-with-pendulum-and-disc": CART,
    "trammel": TRAMMEL,
    **MORE_MECHANISMS,
}


@cache
def roads(name):
    topology = analysed(from_document(parse(MECHANISMS[name], f"{name}.yaml")))
    return Kernel(topology), Lagrange(topology)


@pytest.mark.slow_except(
    "cart-with-pendulum-and-disc",
    "crossed-sliders",
    "fixed-sun",
    "four-bar-two-clearances",
    "geared-five-bar-free",
    "scotch-yoke",
    "trammel",
)
@pytest.mark.parametrize("name", MECHANISMS)
def test_kernel_satisfies_lagrange_equations(name):
    kernel, lagrange = roads(name)
    states = kernel.random_states(COUNT)
    assert len(states) == COUNT
    for state in states:
        assert_agrees(lagrange, state)


@pytest.mark.slow
def test_assembly_modes_and_drives_differ_between_states():
    kernel, _ = roads("nine-bar")
    states = kernel.states(1)
    first = {round(state.rate["crank1"], 9) for state in states}
    assert len(first) == len(states)
    # both sides of E: E is left or right of the line from O to B
    sides = {np.sign(s.x["B"] * s.y["E"] - s.y["B"] * s.x["E"]) for s in states}
    assert sides == {-1.0, 1.0}


@pytest.mark.slow
def test_states_of_iterated_groups_are_far_from_each_other():
    kernel, _ = roads("class-three")
    states = kernel.random_states(COUNT)
    angles = {name: [state.position[name] for state in states] for name in ("crank", "leg1")}
    assert np.ptp(angles["crank"]) > 2.0
    assert np.ptp(angles["leg1"]) > 0.8  # the crank is a third of its length


@pytest.mark.slow
@pytest.mark.parametrize("what", ["effort", "acceleration", "energy"])
def test_a_wrong_value_is_found(what):
    kernel, lagrange = roads("class-three")
    state = kernel.random_states(1)[0]
    values = getattr(state, what)
    values |= {name: value * (1 + 1e-6) + 1e-6 for name, value in values.items()}
    with pytest.raises(AssertionError):
        assert_agrees(lagrange, state)
