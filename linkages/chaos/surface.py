"""Surfaces at which geometric sections are taken, and their names."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.solution.evaluation import ANGLES
from linkages.solution.series import Series, find_series, system_series

SECTION = "slider9.velocity=0"
RATES = {
    "angle": "speed",
    "speed": "acceleration",
    "position": "velocity",
    "velocity": "acceleration",
}
"""Quantities in which sections are taken, and what their rates are called."""


@dataclass(frozen=True)
class Surface:
    """Where a section is taken: one series of an output has a value.

    Parameters
    ----------
    series
        Of position or velocity.
    level
        In SI.
    """

    series: Series
    level: float

    @property
    def turns(self) -> bool:
        """Whether it is an angle, which has a value again after every turn."""
        return self.series.variable in ANGLES

    @property
    def key(self) -> tuple[str, str, float]:
        """What tells it from others of a mechanism."""
        return self.series.variable, self.series.name, self.level

    @property
    def rate(self) -> Series:
        """The rate of the series."""
        kind, _, quantity = self.series.variable.rpartition("_")
        return replace(self.series, variable=f"{kind}_{RATES[quantity]}")

    def nodes(self, model: Model) -> tuple[Scalar, Scalar]:
        """What crosses zero there, and its rate; an angle half a turn away, too, the other way."""
        difference, rate = self.series.node(model) - self.level, self.rate.node(model)
        if not self.turns:
            return difference, rate
        return model.graph.sin(difference), model.graph.cos(difference) * rate


def parse_section(system: System, text: str) -> Surface:
    """Read ``"slider9.velocity=0"``, ``"crank.angle=90 deg"``, ``"B.y position=0.1"``.

    Raises
    ------
    ValueError
        If it names nothing of the mechanism; the message says what is expected.
    """
    from linkages.spec import dimensions
    from linkages.spec.conversion import QuantityError, parse_quantity

    measured = {
        "rad": dimensions.ANGLE,
        "rad/s": dimensions.ANGULAR_SPEED,
        "m": dimensions.LENGTH,
        "m/s": dimensions.SPEED,
    }
    match = re.fullmatch(r"\s*(.+?\.[^.=]+?)\s*=\s*(.+?)\s*", text)
    if match is None:
        raise ValueError(f"expected a section such as {SECTION!r}, found {text!r}")
    name, level = match.groups()
    known = {
        other: series
        for other, series in system_series(system).items()
        if series.variable.rpartition("_")[2] in RATES and "dyad" not in series.place
    }
    try:
        series = find_series(known, name)
        return Surface(series, parse_quantity(level, measured[VARIABLES[series.variable].units]))
    except (QuantityError, ValueError) as error:
        raise ValueError(f"section {text!r}: {error}") from None
