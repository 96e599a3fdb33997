"""Free coordinates and their rates as labelled arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.outputs import VARIABLES, coordinate_of, labels
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.motion import TANGENT_ATOL, Motion, absolute_tolerances

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

PAIRS = {
    kind: (value := coordinate_of(kind), VARIABLES[value].rate)
    for kind in ("clearance", "offset", "tilt", "bar", "slider")
}
"""Kind of free coordinate → outputs of its value and its rate."""


def require_free(system: System) -> None:
    """Only a mechanism with a free coordinate can be regular or chaotic."""
    if not system.topology.free:
        message = (
            "nothing is free to move: drives determine the whole motion, which is neither regular "
            "nor chaotic; expected a clearance, or a coordinate under 'free'"
        )
        raise system.mechanism.error([((), message)])


def free_names(system: System) -> dict[str, list[str]]:
    """Dimension (clearance, bar, slider) → free coordinates of that kind."""
    bodies = system.mechanism.bodies
    result: dict[str, list[str]] = {}
    for name in system.topology.free:
        kind = bodies[name].kind
        result.setdefault("bar" if kind in ("bar", "plate") else kind, []).append(name)
    return result


def state_outputs(system: System) -> dict[str, tuple[str, list[str]]]:
    """Output → its dimension and its elements: coordinates, rates and internal states."""
    result = {
        output: (dim, names) for dim, names in free_names(system).items() for output in PAIRS[dim]
    }
    if system.topology.internal:
        result["internal_state"] = ("internal", list(system.topology.internal))
    return result


def circular(system: System) -> NDArray[np.bool_]:
    """Which entries of a state are angles that have the same meaning a turn later, shape (x,)."""
    topology, bodies = system.topology, system.mechanism.bodies
    rotates = [bodies[n].rotates and not topology.unwrapped(n) for n in topology.free]
    return np.array([*rotates, *[False] * (system.layout.directions - len(rotates))])


def state_tolerances(system: System, run: RunOptions) -> Floats:
    """Absolute tolerances of free coordinates, rates and internal states, shape (x,)."""
    layout, names = system.layout, system.topology.free
    whole = absolute_tolerances(system.mechanism, layout, run, TANGENT_ATOL)
    places = [layout.coordinates.index(name) for name in names]
    rows = [*places, *(layout.size + place for place in places), *layout.internal_rows]
    return np.asarray(whole[rows])


def free_values(system: System, motion: Motion, wrap: bool = True) -> dict[str, Floats]:
    """Output → values of the free coordinates of its kind, shape (samples, coordinates).

    Internal states are with them.
    """
    names = free_names(system)
    outputs = [output for dim in names for output in PAIRS[dim]]
    own = ["internal_state"] if system.topology.internal else []
    values = evaluate_variables(motion, [*outputs, *own])
    result = {output: values[output] for output in own}
    for output in outputs:
        dim = VARIABLES[output].dims[0]
        columns = [labels(system.model, dim).index(name) for name in names[dim]]
        array = values[output][:, columns]
        result[output] = wrapped(array) if wrap and VARIABLES[output].angle else array
    return result


def wrapped(angles: Floats) -> Floats:
    """Angles from −π to π."""
    return np.asarray(np.remainder(angles + np.pi, 2 * np.pi) - np.pi)


def labelled_states(
    system: System,
    values: Mapping[str, Floats],
    dim: str,
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """A dataset of free coordinates with units."""
    import xarray as xr

    variables = {}
    for name, array in values.items():
        entry = VARIABLES[name]
        units, long_name = entry.described(system.model)
        attrs = {"units": units, "long_name": long_name}
        variables[name] = ((dim, entry.dims[0]), array, attrs)
    elements = {d: np.array(names, dtype=object) for d, names in free_names(system).items()}
    if "internal_state" in values:
        elements["internal"] = np.array(system.topology.internal, dtype=object)
    attrs = {"name": system.mechanism.name, "source": system.mechanism.file_name, **attributes}
    return xr.Dataset(variables, {**coordinates, **elements}, attrs)
