"""What every load contributes to a model: generalised force, power, potential energy, outputs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from linkages.components.measures import Load
from linkages.kernel.measures import MeasureNodes, Velocities, measure_nodes
from linkages.kernel.scalars import Scalar
from linkages.reading.paths import dotted

if TYPE_CHECKING:
    from linkages.kernel.model import Model


class LoadNodes:
    """What a load contributes to the equations of a model.

    Parameters
    ----------
    model
        Whose nodes these are.
    index
        Place of the load among those of the mechanism.
    """

    def __init__(self, model: Model, index: int) -> None:
        self.model = model
        self.load: Load = model.mechanism.loads[index]
        self.measure: MeasureNodes = measure_nodes(model, self.load, index)

    @property
    def dimension(self) -> str:
        """Dimension of the output that it belongs to: of given loads, or of springs and dampers."""
        turning = self.load.unit == "N m"
        if self.load.given:
            return "torque" if turning else "force"
        return "torsional_spring" if turning else "spring"

    @property
    def label(self) -> str:
        """What it is called in outputs: its place in the file."""
        return f"{dotted(self.load.path)}{self.measure.suffix}"

    @property
    def acting(self) -> Scalar:
        """Force or torque as outputs show it."""
        return self.measure.shown * self.measure.value(self.load.force)

    @property
    def given(self) -> list[Scalar]:
        """What of it follows from time and positions: not finite where the load has no value."""
        return self.measure.components(self.load.still)

    @property
    def undefined(self) -> str:
        """Why it may have no value, as the end of a sentence."""
        return self.measure.undefined

    def power(self, velocities: Velocities) -> Scalar:
        """Power of the load at some velocities: its generalised force if they are partial ones."""
        return self.measure.power(self.load.force, velocities)

    @property
    def potential(self) -> Scalar:
        """Energy that it stores."""
        return self.measure.value(self.load.energy)

    @property
    def working(self) -> Scalar:
        """Power of what it does not store, at the actual velocities."""
        return self.measure.power(self.load.working, self.model.velocities)
