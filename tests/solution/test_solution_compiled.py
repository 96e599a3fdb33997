"""Outputs compiled for measures, against those that NumPy evaluates from the same nodes."""

import numpy as np
import pytest

import linkages
from linkages.kernel.code.program import write_functions_of
from linkages.kernel.code.sampling import SampledFunctions
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.solution.crossings import accelerated
from linkages.solution.measuring import compiled
from linkages.solution.moving.evaluation import variable_values
from linkages.solution.values.requests import available

MECHANISMS = ["double-pendulum", "five-bar-free", "ninebar", "andrews"]


def piece_of(name, samples=41):
    motion = linkages.simulate(linkages.load(name), end=0.02, samples=samples).motion
    return motion.pieces[0]


def evaluated(system):
    """Those from the motion at one time; residuals of the closure are round-off themselves."""
    names = [name for name in available(system) if not VARIABLES[name].whole]
    return [name for name in names if name != "closure_residual"]


@pytest.mark.parametrize("name", MECHANISMS)
def test_compiled_outputs_are_those_of_numpy_to_round_off(name):
    """Each element within 1e-11 of the size of its variable: sums of forces lose some digits."""
    piece = piece_of(name)
    for output in evaluated(piece.system):
        expected = variable_values(piece, [output])
        found = compiled.compiled_values(piece, [output])
        finite = np.isfinite(expected)  # an advantage may be infinite
        assert (found[~finite] == expected[~finite]).all(), output
        expected, found = expected[finite], found[finite]
        size = np.abs(expected).max(initial=1e-12)
        assert np.abs(found - expected).max(initial=0.0) <= 1e-11 * size, output


@pytest.mark.parametrize("name", MECHANISMS)
def test_compiled_accelerations_are_those_of_the_integration(name):
    """Round-off of a linear system: 1e-10 of the largest acceleration."""
    piece = piece_of(name)
    found = compiled.compiled_accelerated(piece).acceleration
    size = np.abs(piece.acceleration).max()
    assert found == pytest.approx(accelerated(piece).acceleration, abs=1e-10 * size)


def test_bits_depend_neither_on_lanes_nor_on_neighbours():
    piece = piece_of("ninebar", samples=23)
    model = Model(piece.system.topology)
    program = write_functions_of(model, VARIABLES["drive_effort"].evaluated(model), "efforts")
    states = np.concatenate([piece.state, piece.acceleration])
    given = piece.system.parameters, piece.time, states
    one = SampledFunctions(program, 1)(*given)
    for lanes in (4, 8):
        functions = SampledFunctions(program, lanes)
        assert (functions(*given) == one).all()
        few = functions(given[0], piece.time[5:8], states[:, 5:8])
        assert (few == one[:, 5:8]).all()
    assert SampledFunctions(program, 8)(given[0], piece.time[:0], states[:, :0]).shape == (2, 0)


def test_a_state_that_cannot_be_assembled_has_no_value():
    piece = piece_of("five-bar-free")
    model = Model(piece.system.topology)
    program = write_functions_of(model, VARIABLES["joint_position"].evaluated(model), "places")
    parameters = piece.system.parameters.copy()
    row = model.inputs.parameters
    bars = [place for path, place in row.items() if path[-1] == "length"]
    parameters[bars[-1]] *= 100.0
    states = np.concatenate([piece.state, piece.acceleration])
    assert np.isnan(SampledFunctions(program, 8)(parameters, piece.time, states)).all()


@pytest.mark.parametrize("name", ["slider-crank", "slider-crank-contact"])
def test_driven_motions_and_modes_are_left_to_numpy(name):
    piece = piece_of(name)
    expected = variable_values(piece, ["drive_effort"])
    assert (compiled.compiled_values(piece, ["drive_effort"]) == expected).all()
