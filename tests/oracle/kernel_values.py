"""Results of the program under test, and how they are compared with the absolute formulation."""

from collections.abc import Mapping

import numpy as np
from absolute_bodies import State
from absolute_coordinates import AbsoluteModel
from absolute_outputs import outputs

import linkages
from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System

KINDS = ("bar", "slider", "clearance", "joint")
SUFFIXES = ("angle", "speed", "position", "velocity", "acceleration")
COMPARED = (
    *(f"{kind}_{suffix}" for kind in KINDS for suffix in SUFFIXES),
    "joint_reaction", "pin_reaction", "drive_effort", "clearance_force",
)  # fmt: skip
Values = dict[str, dict[str, np.ndarray]]


def at_start(mechanism: linkages.Mechanism) -> Values:
    """Variable → element → value at t = 0, with NumPy: nothing is compiled or integrated.

    Reactions are not among them; they need a solution.
    """
    system = System(mechanism)
    accelerations = system.evaluate(system.model.free_accelerations)
    found: Values = {}
    for name, variable in VARIABLES.items():
        elements = labels(system.model, variable.dims[0]) if variable.dims else ()
        if name in COMPARED and elements and not variable.whole:
            nodes = variable.evaluated(system.model)
            values = system.evaluate(nodes, acceleration=accelerations)[:, 0]
            shape = (len(elements), 2) if "axis" in variable.dims else (len(elements),)
            found[name] = dict(zip(elements, values.reshape(shape), strict=True))
    return found


def at_sample(data, sample: int) -> Values:
    """The same from the dataset of a solution."""
    found: Values = {}
    for name in COMPARED:
        if name in data:
            values = data[name][sample]
            elements = values[values.dims[0]].to_numpy()
            found[name] = dict(zip(map(str, elements), values.to_numpy(), strict=True))
    return found


def configuration(model: AbsoluteModel, values: Values) -> np.ndarray:
    """Absolute coordinates from joints and angles that the program found."""
    angles = {**values.get("bar_angle", {}), **values.get("clearance_angle", {})}
    return model.configuration(values["joint_position"], angles)


def state_at(model: AbsoluteModel, values: Values, time: float) -> State:
    """The state that has these coordinates and rates of the free ones."""
    group = {"slider": "slider_velocity", "clearance": "clearance_speed"}
    rates = {
        name: float(values[group.get(model.mechanism.bodies[name].kind, "bar_speed")][name])
        for name in model.mechanism.initial
    }
    return model.state(time, configuration(model, values), rates)


def differences(found: Values, expected: Values) -> Mapping[str, float]:
    """Variable → largest difference, in parts of its largest value or of 1, whichever is more.

    Angles are compared modulo whole turns.
    """
    result = {}
    for name, values in expected.items():
        if name not in found:
            continue
        assert set(found[name]) == set(values), name
        off = np.array([found[name][label] - value for label, value in values.items()])
        if name.endswith("_angle"):
            off = off - 2 * np.pi * np.round(off / (2 * np.pi))
        result[name] = np.abs(off).max() / max(1.0, np.abs(list(values.values())).max())
    return result


def disagreements(found: Values, expected: Values, tolerance: float) -> dict[str, float]:
    """The variables that differ by more than a tolerance, or that are no numbers."""
    parts = differences(found, expected)
    return {name: part for name, part in parts.items() if not part <= tolerance}


def assert_motion_agrees(model: AbsoluteModel, data, tolerance: float, balance: float) -> None:
    """Samples with the modes of each, and the balance of energy in parts of the largest energy."""
    for sample, time in enumerate(data.time.to_numpy()):
        found = at_sample(data, sample)
        expected = outputs(model, model.solve(state_at(model, found, float(time))))
        assert not disagreements(found, expected, tolerance)
    moved = max(1e-3, float(data.kinetic_energy.max()))
    assert float(np.abs(data.energy_residual).max()) < balance * moved
