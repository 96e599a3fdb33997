"""Derivatives of outputs by numbers of a definition, as nodes of the graph of the outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Path
from linkages.design.sensitivity.numbers import Effects
from linkages.kernel.graph.differentiation import derivative_along
from linkages.kernel.graph.scalars import Level, Scalar
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.solution.moving.motion import Piece
from linkages.solution.values.series import TIME, Series

Floats = NDArray[np.float64]


class Derivatives:
    """Series and their derivatives along numbers, evaluated in pieces of motions.

    Nodes of derivatives are made once for the equations that they are of.
    """

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], list[list[Scalar]]] = {}

    def evaluated(
        self, piece: Piece, series: Sequence[Series], effects: Effects
    ) -> tuple[Floats, Floats]:
        """Values and derivatives at the times of a piece, shapes (series, n) and (series, P, n).

        Raises
        ------
        ValueError
            For a series that has no derivative.
        """
        model, count = piece.system.model, len(effects.parameters)
        nodes = [_node(each, model) for each in series]
        key = (model, *(node.index for node in nodes), effects.parameters)
        if key not in self._known:
            along = directions(model, effects.parameters)
            self._known[key] = derivative_along(nodes, along)
        slopes = [slope for row in self._known[key] for slope in row]
        found = piece.system.evaluate(
            [*nodes, *slopes],
            piece.time,
            piece.state,
            piece.acceleration,
            flipped=piece.flipped,
            held=piece.held,
            further={"slope": effects.slopes[:, None]},
        )
        values = found[: len(series)]
        slopes_found = found[len(series) :].reshape(len(series), count, len(piece.time))
        for row, each in enumerate(series):
            if _without_sign(each):
                slopes_found[row] *= np.where(values[row] < 0.0, -1.0, 1.0)
                values[row] = np.abs(values[row])
        return values, slopes_found


def directions(model: Model, parameters: Sequence[Sequence[Path]]) -> list[Mapping[int, Scalar]]:
    """Rates of the inputs of a model along numbers: of the parameters that each of them feeds."""
    found: list[Mapping[int, Scalar]] = []
    slot = 0
    for paths in parameters:
        moved = {}
        for path in paths:
            place = model.inputs.parameters[path]
            node = model.graph.input("p", place, Level.PARAMETERS)
            moved[node.index] = model.graph.input("slope", slot, Level.PARAMETERS)
            slot += 1
        found.append(moved)
    return found


def _node(series: Series, model: Model) -> Scalar:
    if series.variable == TIME:
        return model.inputs.time
    variable = VARIABLES[series.variable]
    if variable.whole or not (variable.reduced is None or _without_sign(series)):
        raise ValueError(f"{series.name}: no derivative is known of this output")
    return series.node(model)


def _without_sign(series: Series) -> bool:
    """Whether a series is the size of its node."""
    if series.variable == TIME:
        return False
    found: object = VARIABLES[series.variable].reduced
    return found is np.abs
