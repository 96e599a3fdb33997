"""Outputs compiled for measures, against those that NumPy evaluates from the same nodes."""

import copy

import numpy as np
import pytest

import linkages
from linkages.kernel.code.program import write_functions_of
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.evaluation import (
    SampledFunctions,
    accelerated,
    compiled_accelerated,
    compiled_values,
    variable_values,
)
from linkages.solution.series import available

RUBBING = {"clearances.gap.friction_law": "coulomb", "clearances.gap.friction": 0.1}
MECHANISMS = {
    "double-pendulum": {},
    "five-bar-free": {},
    "ninebar": {},
    "andrews": {},
    "slider-crank-contact": {},
    "slider-crank-contact rubbing": RUBBING,
}
"""Their names, and what is set otherwise; the last ones have modes, and remember."""


def called(functions, system, times, states):
    which = np.zeros(len(times), dtype=int)
    return functions(functions.prepared(system.parameters[None]), which, times, states, None)


def piece_of(name, samples=41):
    mechanism = linkages.load(name.split()[0], set=MECHANISMS.get(name, {}))
    return linkages.simulate(mechanism, end=0.02, samples=samples).motion.pieces[0]


def evaluated(system):
    """Those from the motion at one time; residuals of the closure are round-off themselves."""
    names = [name for name in available(system) if not VARIABLES[name].whole]
    return [name for name in names if name != "closure_residual"]


@pytest.mark.slow_except("double-pendulum")
@pytest.mark.parametrize("name", MECHANISMS)
def test_compiled_outputs_are_those_of_numpy_to_round_off(name):
    """Each element within 1e-11 of the size of its variable: sums of forces lose some digits."""
    piece = piece_of(name)
    for output in evaluated(piece.system):
        expected = variable_values(piece, [output])
        found = compiled_values(piece, [output])
        finite = np.isfinite(expected)  # an advantage may be infinite
        assert (found[~finite] == expected[~finite]).all(), output
        expected, found = expected[finite], found[finite]
        size = np.abs(expected).max(initial=1e-12)
        assert np.abs(found - expected).max(initial=0.0) <= 1e-11 * size, output


@pytest.mark.slow_except("double-pendulum", "ninebar", "slider-crank-contact")
@pytest.mark.parametrize("name", MECHANISMS)
def test_compiled_accelerations_are_those_of_the_integration(name):
    """Round-off of a linear system: 1e-10 of the largest acceleration."""
    piece = piece_of(name)
    found = compiled_accelerated(piece).acceleration
    size = np.abs(piece.acceleration).max()
    assert found == pytest.approx(accelerated(piece).acceleration, abs=1e-10 * size)


def test_bits_depend_neither_on_lanes_nor_on_neighbours():
    piece = piece_of("ninebar", samples=23)
    model = Model(piece.system.topology)
    program = write_functions_of(model, VARIABLES["drive_effort"].evaluated(model), "efforts")
    states = np.concatenate([piece.state, piece.acceleration])
    one = called(SampledFunctions(program, 1), piece.system, piece.time, states)
    for lanes in (4, 8):
        functions = SampledFunctions(program, lanes)
        assert (called(functions, piece.system, piece.time, states) == one).all()
        few = called(functions, piece.system, piece.time[5:8], states[:, 5:8])
        assert (few == one[:, 5:8]).all()
    none = called(SampledFunctions(program, 8), piece.system, piece.time[:0], states[:, :0])
    assert none.shape == (2, 0)


def test_states_of_several_motions_may_stand_in_any_order():
    """As those of each motion by itself, also of one that has no state among them."""
    pieces = [piece_of("ninebar", samples=count) for count in (5, 23, 12)]
    model = Model(pieces[0].system.topology)
    program = write_functions_of(model, VARIABLES["drive_effort"].evaluated(model), "efforts")
    functions = SampledFunctions(program, 8)
    stretched = linkages.load("ninebar").with_values({"bars.link2.length": 0.9})
    systems = [pieces[0].system, System(stretched), pieces[2].system]
    order = np.random.default_rng(1).permutation(17)
    which = np.array([0] * 5 + [2] * 12)[order]
    both = [np.concatenate([piece.state, piece.acceleration]) for piece in (pieces[0], pieces[2])]
    times = np.concatenate([pieces[0].time, pieces[2].time])[order]
    states = np.concatenate(both, axis=1)[:, order]
    prepared = functions.prepared(np.array([system.parameters for system in systems]))
    for own in (which, np.where(which == 2, 1, which)):
        found = functions(prepared, own, times, states, None)
        for motion in np.unique(own):
            alone = called(
                functions, systems[motion], times[own == motion], states[:, own == motion]
            )
            assert np.array_equal(found[:, own == motion], alone)


def test_a_state_that_cannot_be_assembled_has_no_value():
    piece = piece_of("five-bar-free")
    model = Model(piece.system.topology)
    program = write_functions_of(model, VARIABLES["joint_position"].evaluated(model), "places")
    system = copy.copy(piece.system)
    system.parameters = parameters = piece.system.parameters.copy()
    row = model.inputs.parameters
    bars = [place for path, place in row.items() if path[-1] == "length"]
    parameters[bars[-1]] *= 100.0
    states = np.concatenate([piece.state, piece.acceleration])
    assert np.isnan(called(SampledFunctions(program, 8), system, piece.time, states)).all()


def test_driven_motions_are_left_to_numpy():
    piece = piece_of("slider-crank")
    expected = variable_values(piece, ["drive_effort"])
    assert (compiled_values(piece, ["drive_effort"]) == expected).all()


def test_friction_that_holds_is_left_to_numpy():
    """What it exerts is not in its mode: zero stands for whatever is needed."""
    mechanism = linkages.loads(
        """
        gravity: [0, -9.81]
        joints: {O: [0, 0]}
        bars: {rod: {joints: [O, A], length: 0.5, mass: 1}}
        free: {rod: {angle: 10 deg, speed: 0}}
        loads: [{bar: rod, torque: "-0.6*sign(rod.speed)"}]
        """
    )
    solution = linkages.simulate(mechanism, end=4.0, samples=41)
    (piece,) = solution.motion.pieces
    expected = variable_values(piece, ["load_torque"])
    assert expected[0, -1] == pytest.approx(9.81 * 0.25 * np.cos(piece.state[0, -1]), rel=1e-9)
    assert (compiled_values(piece, ["load_torque"]) == expected).all()
    assert linkages.measure(solution, "final(loads[0].torque)") == expected[0, -1]
