"""Named inputs and outputs of linear equations."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.load_measures import (
    Coordinate,
    Load,
    Measure,
    Slide,
    Turn,
)
from linkages.components.contributed.state_laws import NOTHING
from linkages.design.derived import changing_reactions, differentiable
from linkages.equilibria.resting import Rest
from linkages.equilibria.statics import Statics
from linkages.equilibria.vibration import LinearModel
from linkages.errors import ComputationError
from linkages.kernel.differentiation import derivative
from linkages.kernel.forces.generalised_forces import LoadNodes, load_nodes
from linkages.kernel.inputs import Effects
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.options.option import OptionError
from linkages.reading.wording import suggestion
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.joint_reactions import row_of, statics_of
from linkages.solution.measure_names import series_unit
from linkages.solution.motion import Piece
from linkages.solution.series import REACTIONS, find_series, system_series

Floats = NDArray[np.float64]

EFFORT = ".effort"

JUMPS = 1e-9
"""Part of an output that may follow the rate of an input: round-off."""


@dataclass(frozen=True, eq=False)
class Channels:
    """Inputs: forces first, then accelerations of drives."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    loads: list[LoadNodes]  # a unit of each force
    drives: tuple[int, ...]  # rows of coordinates of drives that accelerate

    def forces(self, statics: Statics, rest: Rest) -> Floats:
        """Generalised forces for a unit of each force, shape (n, forces)."""
        nodes = [load.rate(partial) for load in self.loads for partial in statics.model.partials]
        values = statics.values(nodes, rest.place)
        return np.ascontiguousarray(values.reshape(-1, statics.n).T)


def input_channels(statics: Statics, names: Sequence[str]) -> Channels:
    """Inputs by their names, or those that every mechanism has.

    Raises OptionError for a name that is none.
    """
    known = {each[0]: each for each in _inputs(statics)}
    usual = [name for name, *_, shown in known.values() if shown]
    chosen = [known[found_input(known, usual, name)] for name in dict.fromkeys(names) or usual]
    pushes = [(name, unit, along) for name, unit, along, _ in chosen if not isinstance(along, int)]
    drives = [(name, unit, row) for name, unit, row, _ in chosen if isinstance(row, int)]
    model = statics.model
    loads = [load_nodes(model, Load(along, NOTHING, ()), 0) for _, _, along in pushes]
    for load in loads:
        load.given_force = model.graph.one
    return Channels(
        names=tuple(each[0] for each in (*pushes, *drives)),
        units=tuple(each[1] for each in (*pushes, *drives)),
        loads=loads,
        drives=tuple(row for _, _, row in drives),
    )


def found_input(known: Iterable[str], usual: Sequence[str], name: str) -> str:
    """The name of an input; OptionError if it is none, with a near one or `usual` ones."""
    if name in known:
        return name
    near = suggestion(name, known) or f"; expected a name such as {', '.join(usual)}"
    raise OptionError("inputs", f"found no input {name!r}{near}")


def _inputs(statics: Statics) -> Iterator[tuple[str, str, Measure | int, bool]]:
    """Name, unit, what it acts along or the row of a drive, and whether it is usual."""
    system = statics.system
    yield from force_channels(system, statics.own_names)
    for name, row in zip(statics.driven, statics.held.tolist(), strict=True):
        unit = "rad/s^2" if system.mechanism.bodies[name].rotates else "m/s^2"
        yield f"{name}.acceleration", unit, row, True


def force_channels(
    system: System, free: Collection[str]
) -> Iterator[tuple[str, str, Measure, bool]]:
    """Forces and torques that may push: name, unit, along what, and whether on `free` bodies."""
    mechanism = system.mechanism
    for name, body in mechanism.bodies.items():
        if body.kind in ("bar", "plate"):
            yield f"{name}.torque", Turn.unit, Turn(name, None), name in free
        if body.kind == "slider":
            yield f"{name}.force", Slide.unit, Slide(name), name in free
    for joint in system.topology.joints:
        for axis, word in enumerate("xy"):
            yield f"{joint}.{word} force", Coordinate.unit, Coordinate(joint, axis), False
    for load in system.model.loads:
        if not load.load.passive:
            yield load.label, load.load.measure.unit, load.load.measure, False


class Outputs:
    """Outputs by their names, as functions of coordinates, rates, accelerations and states.

    Raises ValueError for a name that is none, or of which no derivative is known.
    """

    def __init__(self, statics: Statics, names: Sequence[str]) -> None:
        self._statics = statics
        system, model, n = statics.system, statics.model, statics.n
        own, units = statics.listed(statics.own.tolist())
        entries = [*statics.own, *(n + statics.own), *range(2 * n, 2 * n + statics.m)]
        inputs = [model.inputs.coordinate(i) for i in range(n)] + statics.nodes.rates
        self._inputs = [*inputs, *map(model.inputs.acceleration, range(n)), *model.internal]
        plain = [*inputs, *model.internal]
        known = {name: (plain[k], unit) for name, unit, k in zip(own, units, entries, strict=True)}
        forces = dict(zip(statics.driven, statics.held.tolist(), strict=True))
        for name, row in forces.items():
            known[name + EFFORT] = -statics.nodes.forces[row], statics.units_of_effort(name)
        series = system_series(system)
        self.names = tuple(dict.fromkeys(names)) or own[: len(statics.own)]
        self.units: list[str] = []
        self._nodes: list[Scalar | None] = []
        self._reactions: dict[int, int] = {}
        self._efforts: dict[int, int] = {}
        for place, name in enumerate(self.names):
            if name in known:
                node, unit = known[name]
                if name.endswith(EFFORT):
                    self._efforts[place] = forces[name.removesuffix(EFFORT)]
            else:
                found = find_series(series, name)
                unit = series_unit(system, found)
                reacts = found.variable in REACTIONS
                node = None if reacts else differentiable(found, model)
                if reacts:
                    self._reactions[place] = row_of(found, model)
            self._nodes.append(node)
            self.units.append(unit)

    def rows(self, piece: Piece, model: LinearModel, channels: Channels, forces: Floats) -> Floats:
        """C and D beside each other, shape (outputs, states + inputs).

        `forces`: generalised forces of the inputs.
        Raises ComputationError if an output follows the rate of an input.
        """
        slopes = np.zeros((len(self.names), len(self._inputs)))
        plain = [k for k, node in enumerate(self._nodes) if node is not None]
        slopes[plain] = self._slopes(piece, [n for n in self._nodes if n is not None])[1][..., 0]
        if self._reactions:
            count = len(self._inputs)
            none = np.zeros(0)
            effects = Effects(((),) * count, none, np.zeros((0, count)), none.astype(bool))
            changes = changing_reactions(piece, self._slopes, effects)[1]
            for place, row in self._reactions.items():
                slopes[place] = changes[row, :, 0]
        n = self._statics.n
        rate, acceleration = slopes[:, n : 2 * n], slopes[:, 2 * n : 3 * n]
        jumps = np.abs(rate) @ np.abs(model.jumps[0]) + np.abs(acceleration) @ model.jumps[1]
        moved = np.vstack([model.coordinates, model.rates, model.accelerations, model.internal])
        result = slopes @ moved
        pushed = slice(len(model.a), len(model.a) + len(channels.loads))
        for place, row in self._efforts.items():
            result[place, pushed] -= forces[row]
        if self._reactions and channels.loads:
            bodies = statics_of(piece)
            direct = np.stack([bodies.changed_by(load).ravel() for load in channels.loads], axis=1)
            for place, row in self._reactions.items():
                result[place, pushed] += direct[row]
        least = JUMPS * np.abs(result).max(axis=1, initial=0.0, keepdims=True)
        if (jumps > least).any():
            which, source = np.argwhere(jumps > least)[0]
            raise ComputationError(
                f"output {self.names[which]} follows the rate of input {channels.names[source]}, "
                "because no mass moves with it; expected another output, or a mass there",
                time=self._statics.time,
            )
        return np.asarray(result)

    def _slopes(self, piece: Piece, nodes: Sequence[Scalar]) -> tuple[Floats, Floats]:
        """Values of nodes, and their derivatives, shapes (nodes, 1) and (nodes, directions, 1)."""
        rows = derivative(list(nodes), self._inputs)
        flat = [*nodes, *(slope for row in rows for slope in row)]
        values = evaluate_nodes(piece, flat)
        return values[: len(nodes)], values[len(nodes) :].reshape(len(nodes), -1, 1)
