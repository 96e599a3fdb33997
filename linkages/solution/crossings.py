"""Events of a simulation: outputs where and when quantities cross their values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from linkages.kernel.outputs import VARIABLES
from linkages.solution.moving.evaluation import evaluate_variables
from linkages.solution.moving.motion import Motion, Piece
from linkages.solution.values.labelled import labelled
from linkages.solution.values.reactions import reactions
from linkages.solution.values.requests import REACTIONS

if TYPE_CHECKING:
    import xarray as xr


def labelled_events(crossings: Mapping[str, Motion], names: Sequence[str]) -> dict[str, xr.Dataset]:
    """Event → outputs at its crossings, as a solution has them at its samples.

    Parameters
    ----------
    crossings
        Event → states at its crossings.
    names
        Outputs; those that compare a motion with its past, or with another one, are left out.
    """
    plain = [name for name in names if not VARIABLES[name].whole]
    found = {}
    for event, met in crossings.items():
        motion = Motion(pieces=tuple(accelerated(piece) for piece in met.pieces))
        values = evaluate_variables(motion, plain)
        if not {*REACTIONS}.isdisjoint(names):
            values |= reactions(motion)
        system = motion.pieces[0].system
        kept = {name: values[name] for name in names if name in values}
        found[event] = labelled(system, motion, kept).assign_attrs(event=event)
    return found


def accelerated(piece: Piece) -> Piece:
    """A piece with the accelerations that follow from its states."""
    if piece.samples is not None or not len(piece.acceleration):
        return piece
    model = piece.system.model
    nodes = model.integrated_accelerations(model.changes)
    values = piece.system.evaluate(
        nodes, piece.time, piece.state, flipped=piece.flipped, held=piece.held
    )
    return replace(piece, acceleration=values)
