"""The equations of motion as a function: against `simulate`, differences and SciPy."""

import pickle

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from solution_mechanisms import DOUBLE_ROCKER

import linkages
from linkages.kernel.system import System

NAMES = ["pendulum", "double-pendulum", "five-bar-free", "ninebar"]
STATES = {"double-pendulum": {"upper": (1.0, 0.5), "lower": (-0.3, 2.0)}}


def mechanism(name):
    found = linkages.load(name)
    return found.with_state(STATES[name]) if name in STATES else found


@pytest.mark.slow_except("[!n]*")
@pytest.mark.parametrize("name", NAMES)
def test_integrated_by_scipy_it_is_the_motion_of_simulate(name):
    end = 0.1 if name == "ninebar" else 1.0
    rhs = linkages.compile(mechanism(name))
    solution = linkages.simulate(mechanism(name), end=end, samples=11, rtol=1e-12, outputs=OUTPUTS)
    own = solve_ivp(
        rhs, (0, end), rhs.state, "DOP853", solution.data.time.to_numpy(), rtol=1e-12, atol=1e-12
    )
    found = rhs.outputs(OUTPUTS, own.t, own.y)
    for output in OUTPUTS:
        expected = solution.data[output]
        # errors of 1e-12 per step add up over some 1000 steps, and forces scale with stiffness
        scale = 1e-8 * float(abs(expected).max())
        assert float(abs(found[output] - expected).max()) <= scale, output
        assert found[output].attrs == expected.attrs


OUTPUTS = ["joint_position", "joint_acceleration", "joint_reaction", "kinetic_energy"]


@pytest.mark.parametrize("name", [*NAMES, "class-three"])
def test_accelerations_are_those_of_the_graph(name):
    """The scalar graph, evaluated by NumPy, is the other way from a state to its derivative."""
    system, rhs = System(mechanism(name)), linkages.compile(mechanism(name))
    random = np.random.default_rng(3)
    states = rhs.state[:, None] + 0.01 * random.standard_normal((len(rhs.state), 7))
    times = random.uniform(0, 0.01, 7)
    nodes = system.model.integrated_accelerations(system.model.changes)
    expected = system.evaluate(nodes, times, states)
    found = rhs.batch(times, states)
    n = len(nodes)
    assert np.array_equal(found[:n], states[n:])
    assert found[n:] == pytest.approx(expected, rel=1e-10, abs=1e-9)  # round-off of a solution
    for time, state, column in zip(times, states.T, found.T, strict=True):
        assert np.array_equal(rhs(time, state), column)


@pytest.mark.slow_except("[!n]*")
@pytest.mark.parametrize("name", NAMES)
def test_the_jacobian_is_that_of_differences(name):
    rhs = linkages.compile(mechanism(name))
    time, state = 0.01, rhs.state + 0.02
    step = 1e-6  # central: truncation 1e-12 of third derivatives, round-off 1e-10 of the values
    ahead, behind = (
        rhs.batch(time, state[:, None] + sign * step * np.eye(len(state))) for sign in (1, -1)
    )
    found = rhs.jacobian(time, state)
    size = abs(rhs(time, state)).max() + abs(found).max()
    assert abs(found - (ahead - behind) / (2 * step)).max() < 1e-7 * size


def test_a_stiff_method_of_scipy_takes_the_jacobian():
    rhs = linkages.compile(linkages.load("pendulum"))
    exact = solve_ivp(rhs, (0, 2), rhs.state, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    stiff = solve_ivp(rhs, (0, 2), rhs.state, "Radau", jac=rhs.jacobian, rtol=1e-8, atol=1e-10)
    assert stiff.njev > 0
    assert stiff.y[:, -1] == pytest.approx(exact, abs=1e-6)
    whole = solve_ivp(rhs, (0, 2), rhs.state, "DOP853", rtol=1e-12, atol=1e-12, vectorized=True)
    assert np.array_equal(whole.y[:, -1], exact)


def test_names_units_and_shapes():
    rhs = linkages.compile(linkages.load("ninebar"))
    assert rhs.names == ("r1.angle", "r1.speed")
    assert rhs.units == ("rad", "rad/s")
    assert repr(rhs) == "Equations('Nine-bar press mechanism', y = [r1.angle, r1.speed])"
    assert rhs.batch([0.0, 0.1], np.stack([rhs.state, rhs.state], axis=1)).shape == (2, 2)
    assert rhs.outputs(["bar_angle"], 0.0, rhs.state).sizes["time"] == 1


def test_binding_values_is_compiling_with_them():
    mechanism = linkages.load("pendulum")
    rhs = linkages.compile(mechanism)
    bound = rhs.bind({"bars.rod.length": "2 m"})
    own = linkages.compile(mechanism.with_values({"bars.rod.length": 2.0}))
    assert np.array_equal(bound(0.0, rhs.state), own(0.0, rhs.state))
    assert not np.array_equal(bound(0.0, rhs.state), rhs(0.0, rhs.state))


def test_it_goes_to_other_processes():
    rhs = linkages.compile(linkages.load("ninebar"))
    again = pickle.loads(pickle.dumps(rhs))
    assert np.array_equal(again(0.1, rhs.state), rhs(0.1, rhs.state))


def test_a_state_that_cannot_be_assembled_names_its_block_and_time():
    rhs = linkages.compile(linkages.loads(DOUBLE_ROCKER))
    good = rhs(0.0, rhs.state)
    beyond = [np.pi, 0.0]  # B is 1.3 m from O, and crank and coupler are 1.1 m long
    with pytest.raises(linkages.ComputationError, match=r"at t = 0.5 s, joint A, block \d"):
        rhs.batch([0.2, 0.5], np.stack([rhs.state, beyond], axis=1))
    with pytest.raises(linkages.ComputationError, match="crank and coupler"):
        rhs(0.0, beyond)
    assert np.array_equal(rhs(0.0, rhs.state), good)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda rhs: rhs(0.0, [1.0]), r"states of 2 entries \(rod.angle, rod.speed\).*\(1,\)"),
        (lambda rhs: rhs.batch([0.0, 1.0], rhs.state), "one for each of 1 states"),
        (lambda rhs: rhs.outputs(["energy_residual"], 0.0, rhs.state), "follows from a whole"),
        (lambda rhs: rhs.outputs(["bar_angel"], 0.0, rhs.state), "did you mean 'bar_angle'"),
        (lambda rhs: rhs.flow(tangents=3), "tangents must be from 0 to 2"),
        (lambda rhs: rhs.flow(events={"rod.sped": "up"}), "rod has no 'sped'; did you mean"),
    ],
)
def test_arguments_that_make_no_sense_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call(linkages.compile(linkages.load("pendulum")))


def test_where_drives_determine_everything_nothing_is_compiled():
    with pytest.raises(linkages.InputError, match="nothing is free to move"):
        linkages.compile(linkages.load("slider-crank"))
