"""Derivatives of outputs and joint reactions by numbers of a definition."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Parameter
from linkages.kernel.differentiation import derivative_along
from linkages.kernel.inputs import Effects, Fed, slots
from linkages.kernel.layout import Layout
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Level, Scalar
from linkages.reading.paths import KeyPath
from linkages.solution.joint_reactions import Statics, reaction_nodes, row_of
from linkages.solution.motion import Piece
from linkages.solution.series import REACTIONS, TIME, Series

Floats = NDArray[np.float64]
OfNodes = Callable[[Piece, Sequence[Scalar]], tuple[Floats, Floats]]
"""Values of nodes in a piece, and their derivatives, shapes (nodes, n) and (nodes, P, n)."""

_STEP = 1e-40
"""Into the complex plane: A and b are polynomials, so imaginary parts are derivatives [1]_.

.. [1] W. Squire, G. Trapp, SIAM Review 40 (1998) 110.
"""

_CHUNK = 1024


def changing_reactions(piece: Piece, of_nodes: OfNodes, effects: Effects) -> tuple[Floats, Floats]:
    """Reactions and their derivatives, shapes (r, n) and (r, P, n), in the order of `row_of`."""
    starts = range(0, len(piece.time), _CHUNK) or [0]
    parts = [_of_chunk(piece.part(slice(k, k + _CHUNK)), of_nodes, effects) for k in starts]
    values, changes = zip(*parts, strict=True)
    return np.concatenate(values, axis=1), np.concatenate(changes, axis=2)


def _of_chunk(piece: Piece, of_nodes: OfNodes, effects: Effects) -> tuple[Floats, Floats]:
    known: dict[tuple[int, ...], tuple[Floats, Floats]] = {}

    def evaluated(nodes: Sequence[Scalar]) -> tuple[Floats, Floats]:
        key = tuple(node.index for node in nodes)
        if key not in known:
            known[key] = of_nodes(piece, nodes)
        return known[key]

    asked = piece.system.model, piece.system.topology, len(piece.time)
    statics = Statics(*asked, lambda nodes: evaluated(nodes)[0])
    matrix, right = statics.equations()
    if matrix.shape[1] != matrix.shape[2]:
        raise ValueError(
            "joint reactions: constraints are redundant, so that rigid bodies do not determine "
            "them; no derivative is known"
        )
    forces = np.linalg.solve(matrix, right[..., None])[..., 0]
    columns = []
    for number, slopes in enumerate(_slopes(effects)):

        def along(nodes: Sequence[Scalar], number: int = number) -> NDArray[np.complex128]:
            values, changes = evaluated(nodes)
            return values + 1j * _STEP * changes[:, number]

        def moved(parameter: Parameter, slopes: dict[KeyPath, float] = slopes) -> complex:
            return parameter.value + 1j * _STEP * slopes.get(parameter.path, 0.0)

        equations = Statics(*asked, along, moved).equations()
        beside, push = (part.imag / _STEP for part in equations)
        columns.append(push - (beside @ forces[..., None])[..., 0])
    result = np.linalg.solve(matrix, np.stack(columns, axis=-1)) if columns else None
    count = len(piece.time)
    values = statics.at_places(forces).reshape(count, -1).T
    changes = np.empty((len(values), len(effects), count))
    for number in range(len(effects)):
        assert result is not None
        changes[:, number] = statics.at_places(result[..., number]).reshape(count, -1).T
    return values, changes


def _slopes(effects: Effects) -> list[dict[KeyPath, float]]:
    """For each number the parameters that it feeds, with their derivatives."""
    result: list[dict[KeyPath, float]] = [{} for _ in range(len(effects))]
    for (number, path), slope in zip(slots(effects.fed), effects.slopes.tolist(), strict=True):
        result[number][path] = slope
    return result


def moved_by(slopes: Floats) -> Floats:
    """How a zero moves: from derivatives of its function by numbers and, last, by time, (P,)."""
    with np.errstate(divide="ignore", invalid="ignore"):  # without bound where it is only touched
        return np.where(slopes[:-1] == 0.0, 0.0, -slopes[:-1] / slopes[-1])


class Derivatives:
    """Series and their derivatives by numbers, whose nodes are made once for their equations."""

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], list[list[Scalar]]] = {}

    def evaluated(
        self, piece: Piece, series: Sequence[Series], effects: Effects
    ) -> tuple[Floats, Floats]:
        """Values and derivatives at the times of a piece, shapes (series, n) and (series, P, n)."""
        reacting = [row for row, each in enumerate(series) if each.variable in REACTIONS]
        plain = [row for row, each in enumerate(series) if each.variable not in REACTIONS]
        values = np.empty((len(series), len(piece.time)))
        changes = np.empty((len(series), len(effects), len(piece.time)))
        nodes = [differentiable(series[row], piece.system.model) for row in plain]
        values[plain], changes[plain] = self.of_nodes(piece, nodes, effects)
        if reacting:
            rows = [row_of(series[row], piece.system.model) for row in reacting]
            result = changing_reactions(piece, partial(self.of_nodes, effects=effects), effects)
            values[reacting], changes[reacting] = (each[rows] for each in result)
        return values, changes

    def of_nodes(
        self, piece: Piece, nodes: Sequence[Scalar], effects: Effects
    ) -> tuple[Floats, Floats]:
        """Values of nodes and their derivatives, shapes (nodes, n) and (nodes, P, n)."""
        model, times = piece.system.model, len(piece.time)
        key = (model, *(node.index for node in nodes), effects.fed)
        if key not in self._known:
            self._known[key] = derivative_along(nodes, _directions(model, effects.fed))
        slopes = [slope for row in self._known[key] for slope in row]
        result = _values(piece, [*nodes, *slopes], self._further(piece, effects))
        changes = result[len(nodes) :].reshape(len(nodes), len(effects), times)
        return result[: len(nodes)], changes

    def crossings(self, piece: Piece, names: Sequence[str], effects: Effects) -> Floats:
        """How numbers move the time at which switches change, shape (switches, P)."""
        assert piece.held is not None
        model = piece.system.model
        own = [each.name for each in model.switches.switches]
        key = (model, "crossings", effects.fed)
        if key not in self._known:
            inputs, switches = model.inputs, model.switches
            along = _directions(model, effects.fed, modes=False)
            accelerations = [inputs.acceleration(i) for i in range(len(model.changes))]
            rows = derivative_along(switches.watched, along)
            rates = switches.rates(switches.watched, accelerations)
            self._known[key] = [[*row, rate] for row, rate in zip(rows, rates, strict=True)]
        chosen = [self._known[key][own.index(name)] for name in names]
        further = self._further(piece, effects) | {"mode": piece.held[: len(own)]}
        slopes = _values(piece, [slope for row in chosen for slope in row], further)
        return np.array([moved_by(row) for row in slopes.reshape(len(names), -1)])

    def _further(self, piece: Piece, effects: Effects) -> dict[str, Floats]:
        """Inputs that stand for directions."""
        result = {"slope": effects.slopes[:, None]}
        if piece.tangents is not None:
            times = len(piece.time)
            result["tangent"] = piece.tangents.state.reshape(-1, times)
            result["memory_tangent"] = piece.tangents.memories.reshape(-1, times)
        if piece.held is not None and piece.system.model.switches.equivalent:
            result["mode_tangent"] = self._stuck(piece, effects, result)
        return result

    def _stuck(self, piece: Piece, effects: Effects, further: dict[str, Floats]) -> Floats:
        """Derivatives of what modes of 0 stand for, those of one number after the other."""
        assert piece.held is not None
        model, times = piece.system.model, len(piece.time)
        switches = model.switches
        modes = piece.held[: len(switches.switches)]
        result = np.zeros((len(effects), len(modes), times))
        if (modes[list(switches.equivalent)] == 0.0).any():
            key = (model, "stuck", effects.fed)
            if key not in self._known:
                along = _directions(model, effects.fed, modes=False)
                self._known[key] = derivative_along([*switches.equivalent.values()], along)
            values = piece.system.evaluate(
                [slope for row in self._known[key] for slope in row],
                piece.time,
                piece.state,
                flipped=piece.flipped,
                held=piece.held,
                further=further | {"mode": modes},
            ).reshape(len(switches.equivalent), len(effects), times)
            for number, rows in zip(switches.equivalent, values, strict=True):
                result[:, number] = np.where(modes[number] == 0.0, rows, 0.0)
        return result.reshape(-1, times)


def _values(piece: Piece, nodes: Sequence[Scalar], further: Mapping[str, Floats]) -> Floats:
    return piece.system.evaluate(
        nodes, piece.time, piece.state, piece.acceleration,
        flipped=piece.flipped, held=piece.held, further=further,
    )  # fmt: skip


def _directions(model: Model, fed: Fed, modes: bool = True) -> list[Mapping[int, Scalar]]:
    """Derivatives of the inputs of a model by numbers, with those of modes if these are held."""
    inputs, layout = model.inputs, Layout.of(model.topology)
    result: list[dict[int, Scalar]] = inputs.fed(fed)
    if not layout.moved:
        return [*result]
    changes = model.changes
    memories, count = len(model.switches.memories), len(layout.free)
    for k, moved in enumerate(result):
        rows = [
            model.graph.input("tangent", row * len(result) + k, Level.STATE)
            for row in range(layout.directions)
        ]
        moved |= {inputs.coordinate(i).index: rows[i] for i in range(count)}
        moved |= {inputs.rate(i).index: rows[count + i] for i in range(layout.moved)}
        moved |= {
            inputs.memory(r).index: inputs.memory_tangent(k * memories + r) for r in range(memories)
        }
        if modes:
            switched = len(model.switches.switches)
            moved |= {
                inputs.mode(s).index: model.graph.input(
                    "mode_tangent", k * switched + s, Level.STATE
                )
                for s in model.switches.equivalent
            }
    for i, row in enumerate(derivative_along(changes[:count], result)):
        for moved, rate in zip(result, row, strict=True):
            moved[inputs.acceleration(i).index] = rate
    return [*result]


def nodes_of(series: Series, model: Model) -> list[Scalar]:
    """All nodes that a series follows from; raises as `differentiable` does."""
    if series.variable in REACTIONS:
        return reaction_nodes(model)
    return [differentiable(series, model)]


def differentiable(series: Series, model: Model) -> Scalar:
    """The node of a series."""
    if series.variable == TIME:
        return model.inputs.time
    variable = VARIABLES[series.variable]
    if variable.whole or variable.reduced is not None:
        raise ValueError(f"{series.name}: no derivative is known of this output")
    return series.node(model)
