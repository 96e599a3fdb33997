"""Generalised forces and elastic energies against results written by hand."""

import pytest
import sympy as sp
from printed_modules import topology_of

from linkages.equations import derive

PENDULUM = """
joints: {O: [0, 0], H: [0, 1]}
bars: {bar: {joints: [O, P], length: 0.5, mass: 1}}
free: {bar: {angle: 0.2, speed: 0}}
"""
CART = """
joints: {O: [0, 0]}
bars: {arm: {joints: [C, P], length: 0.5, mass: 1}}
sliders: {cart: {joint: C, through: O, angle: ANGLE, mass: 1}}
free: {cart: {position: 0.2, speed: 0}, arm: {angle: 0, speed: 0}}
"""
L, angle, rate, t = sp.symbols("L_bar theta_bar dtheta_bar t", real=True)


def force_on(text, name):
    equations = derive(topology_of(text))
    return equations.expanded(equations.forces[equations.symbols.coordinates[name]])


def equal(first, second):
    return sp.simplify(sp.expand_trig(first - second)) == 0


def test_force_at_a_joint_has_its_lever_arm():
    x, y = sp.symbols("F_1_x F_1_y", real=True)
    force = force_on(PENDULUM + "loads: [{joint: P, force: [3, 4]}]", "bar")
    assert equal(force, L * (y * sp.cos(angle) - x * sp.sin(angle)))


def test_force_as_a_law():
    force = force_on(PENDULUM + 'loads: [{joint: P, force: [0, "7*t"]}]', "bar")
    assert equal(force, L * sp.Symbol("F_1_2_1", real=True) * t * sp.cos(angle))


def test_torque_between_bodies_acts_on_both():
    bars = "bars: {bar: {joints: [O, P], length: 0.5, mass: 1}, tip: {joints: [P, Q], length: 1}}"
    text = PENDULUM.replace(PENDULUM.splitlines()[2], bars)
    text = text.replace("free: {", "free: {tip: {angle: 0, speed: 0}, ")
    text += "loads: [{bars: [bar, tip], torque: 5}]"
    torque = sp.Symbol("M_1", real=True)
    assert force_on(text, "tip") == torque
    assert force_on(text, "bar") == -torque


def test_spring_between_joints():
    text = PENDULUM + "springs: [{between: [H, P], stiffness: 9, length: 0.4}]"
    energy = derive(topology_of(text)).potential_energy
    k, free_length, height = sp.symbols("k_1 L_1 y_H", real=True)
    distance = sp.sqrt(L**2 + height**2 - 2 * L * height * sp.sin(angle))
    assert equal(energy, k * (distance - free_length) ** 2 / 2)


def test_spring_without_length_has_no_root():
    text = PENDULUM + "springs: [{between: [H, P], stiffness: 9, length: 0}]"
    equations = derive(topology_of(text))
    slope = equations.lagrange.slopes[angle]
    k, height = sp.symbols("k_1 y_H", real=True)
    assert equal(slope, -k * L * height * sp.cos(angle))


def test_damper_between_joints():
    text = PENDULUM + "dampers: [{between: [H, P], damping: 2}]"
    damping, height = sp.symbols("b_1 y_H", real=True)
    distance = sp.sqrt(L**2 + height**2 - 2 * L * height * sp.sin(angle))
    slope = sp.diff(distance, angle)
    assert equal(force_on(text, "bar"), -damping * slope**2 * rate)


def test_torsional_spring_and_damper():
    text = PENDULUM + "springs: [{bar: bar, stiffness: 3, angle: 0.1, damping: 0.2}]"
    equations = derive(topology_of(text))
    k, free_angle, damping = sp.symbols("k_1 phi_1 d_1", real=True)
    assert equal(equations.potential_energy, k * (angle - free_angle) ** 2 / 2)
    assert equal(force_on(text, "bar"), -damping * rate)


@pytest.mark.parametrize("direction", ["0", "0.3"])
def test_loads_on_a_slider_act_along_its_axis(direction):
    text = CART.replace("ANGLE", direction)
    text += "loads: [{slider: cart, force: 3}]\ndampers: [{slider: cart, damping: 4}]"
    force, damping, speed = sp.symbols("F_1 b_1 ds_cart", real=True)
    assert equal(force_on(text, "cart"), force - damping * speed)


def test_mass_at_a_joint_moves_with_it():
    equations = derive(topology_of(PENDULUM + "masses: {P: 2}"))
    mass = equations.lagrange.masses[angle, angle].value
    bob, m, c, J = sp.symbols("m_P m_bar c_bar J_bar", real=True)
    assert equal(mass, bob * L**2 + m * c**2 + J)


def test_block_turns_with_what_carries_it():
    text = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 0.5}}
sliders: {block: {joint: B, on: arm, mass: 2, inertia: 0.1}}
free: {arm: {angle: 0, speed: 0}, block: {position: 0.2, speed: 0}}
"""
    equations = derive(topology_of(text))
    arm, way = (equations.symbols.coordinates[name] for name in ("arm", "block"))
    m, J = sp.symbols("m_block J_block", real=True)
    masses = equations.lagrange.masses
    assert equal(masses[arm, arm].value, J + m * way**2)
    assert equal(masses[way, way].value, m)
    assert (arm, way) not in masses
