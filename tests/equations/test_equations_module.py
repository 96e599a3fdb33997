"""Printed Python modules of all kinds of mechanisms against the kernel.

Tolerances: round-off times the inverse of the margins of all blocks, as in `lagrange_equations`.
"""

import numpy as np
import pytest
from lagrange_mechanisms import MORE_MECHANISMS
from printed_modules import GeneratedProgram, topology_of

RELATIVE = 5e-12

# printing and reading a mechanism takes a second
pytestmark = pytest.mark.slow_except(
    "fixed-sun", "cam", "rack", "crossed-sliders", "scotch-yoke", "geared-five-bar-free"
)


@pytest.fixture(scope="module", params=MORE_MECHANISMS)
def printed(request):
    return GeneratedProgram(topology_of(MORE_MECHANISMS[request.param]), count=8)


def close(found, expected, scale=1.0):
    np.testing.assert_allclose(found, expected, rtol=RELATIVE, atol=RELATIVE * scale)


def test_loops_are_closed(printed):
    for state in printed.states:
        closure = printed.module["closure"](printed.of(state.position), printed.parameters(state))
        np.testing.assert_allclose(closure, 0.0, atol=1e-13)  # lengths of order 1


def test_drives_are_laws(printed):
    orders = (
        ("drives", "position"),
        ("drive_rates", "rate"),
        ("drive_accelerations", "acceleration"),
    )
    for state in printed.states:
        p = printed.parameters(state)
        for name, field in orders:
            expected = [getattr(state, field)[body] for body in printed.topology.driven]
            close(printed.module[name](state.time, p), expected)


def test_velocity_coefficients_are_partial_velocities(printed):
    for state in printed.states:
        q, p = printed.of(state.position), printed.parameters(state)
        coefficients = printed.module["velocity_coefficients"](q, p)
        largest = np.abs(coefficients).max()
        close(coefficients, printed.coefficients(state), largest)
        slip = printed.module["closure_jacobian"](q, p) @ coefficients
        np.testing.assert_allclose(slip, 0.0, atol=1e-12 * (1 + largest))


def test_inertia_and_energies(printed):
    for state in printed.states:
        q, dq, p = printed.of(state.position), printed.of(state.rate), printed.parameters(state)
        expected = printed.inertia(state)
        close(printed.module["inertia"](q, p), expected, np.abs(expected).max())
        kinetic, potential = state.energy["kinetic"], state.energy["potential"]
        close(printed.module["kinetic_energy"](q, dq, p), kinetic, kinetic)
        close(printed.module["potential_energy"](q, p), potential, 1 + abs(potential))


@pytest.mark.slow_except("par*")
def test_generalised_forces_and_gradient(printed):
    for state in printed.states:
        q, dq, p = printed.of(state.position), printed.of(state.rate), printed.parameters(state)
        none = np.zeros(len(printed.topology.driven))
        acting = printed.module["generalised_forces"](state.time, q, dq, none, p)
        gradient = printed.module["potential_gradient"](q, p)
        coefficients = printed.module["velocity_coefficients"](q, p)
        parts = np.abs(coefficients).T @ (np.abs(acting) + np.abs(gradient))
        found = coefficients.T @ (acting - gradient)
        # the kernel's is a difference from the force that the motion needs
        close(
            found,
            printed.row(state, "force"),
            (1 + parts + np.abs(printed.row(state, "effort"))).max(),
        )


def test_efforts_act_on_driven_coordinates(printed):
    state, module = printed.states[0], printed.module
    q, dq, p = printed.of(state.position), printed.of(state.rate), printed.parameters(state)
    count = len(printed.topology.driven)
    none = module["generalised_forces"](state.time, q, dq, np.zeros(count), p)
    some = module["generalised_forces"](state.time, q, dq, 1e3 * np.arange(1, count + 1), p)
    driven = [printed.bodies.index(name) for name in printed.topology.driven]
    expected = np.zeros(len(q))
    expected[driven] = 1e3 * np.arange(1, count + 1)
    np.testing.assert_allclose(some - none, expected, rtol=1e-9, atol=1e-9)


def test_gradient_is_the_derivative_of_the_energy(printed):
    step = 1e-4  # truncation of the fourth-order formula 1e-16, rounding 1e-12
    for state in printed.states[:2]:
        q, p = printed.of(state.position), printed.parameters(state)
        energy = printed.module["potential_energy"]
        slopes = [
            (
                8 * (energy(q + k, p) - energy(q - k, p))
                - (energy(q + 2 * k, p) - energy(q - 2 * k, p))
            )
            / (12 * step)
            for k in step * np.eye(len(q))
        ]
        gradient = printed.module["potential_gradient"](q, p)
        scale = 1 + np.abs(gradient).max() + abs(energy(q, p))
        np.testing.assert_allclose(gradient, slopes, atol=1e-8 * scale)
