"""Friction of whatever slips under a normal force: journals in bearings, blocks in guides."""

from __future__ import annotations

from typing import TYPE_CHECKING

from linkages.components.contributed.functions import Function
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.numbers.laws import value_of

if TYPE_CHECKING:
    from linkages.kernel.model import Model


def friction_force(
    model: Model, name: str, law: Function, *, normal: Scalar, slip: Scalar, active: Scalar
) -> Scalar:
    """Force of friction along the direction of slip, with modes where its law has corners.

    Parameters
    ----------
    model
        Whose nodes these are.
    name
        Of what slips, as modes are called by it.
    law
        Force along the slip over the normal force, as a function of the slip `V`;
        `linkages.components.contributed.friction_laws.friction_coefficient` makes it.
    normal
        The normal force, which does not depend on friction, and is positive while `active` is +1.
    slip
        Velocity of slip.
    active
        Mode in which the normal force acts: corners are looked for in it alone.
    """

    def mode(_: Function, node: Scalar) -> Scalar:
        return model.switches.side(f"{name}: slip", node, active)

    return normal * value_of(law, model.inputs, lambda _: slip, mode)
