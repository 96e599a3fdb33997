"""Surfaces of sections and events, and their names."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.reading.wording import listed, suggestion
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.guards import Guard
from linkages.solution.motion import Piece
from linkages.solution.series import Series, example_series, find_series, system_series

TOUCH = "touch"
"""Quantity of what touches: journal and bearing of a clearance that opens, or a body and its stop;
with direction down, they part."""


@dataclass(frozen=True)
class Surface:
    """Where a section is taken: one series of an output has a value.

    Parameters
    ----------
    series
        Of position or velocity.
    level
        In SI.
    touch
        The clearance whose journal touches its bearing there, or the end of a way that a body
        touches; empty for other surfaces.
    end
        Whether it is an end of a way: that has no series, and `series` is its name alone.
    """

    series: Series
    level: float
    touch: str = ""
    end: bool = False

    @property
    def turns(self) -> bool:
        """Whether it is an angle, which has a value again after every turn."""
        return not self.end and self.series.angle

    @property
    def key(self) -> tuple[str, str, float]:
        """What tells it from others of a mechanism."""
        return self.series.variable, self.series.name, self.level

    @property
    def rate(self) -> Series:
        """The rate of the series."""
        return replace(self.series, variable=VARIABLES[self.series.variable].rate)

    def nodes(self, model: Model) -> tuple[Scalar, Scalar]:
        """What crosses zero there, and its rate; an angle half a turn away, too, the other way."""
        if self.end:
            (gap,) = (nodes.gap for nodes in model.ends if nodes.name == self.touch)
            return gap.indentation, gap.rate(model.velocities)
        difference, rate = self.series.node(model) - self.level, self.rate.node(model)
        if not self.turns:
            return difference, rate
        return model.graph.sin(difference), model.graph.cos(difference) * rate

    def guard(self, direction: int, *, wanted: int = 0, name: str = "") -> Guard:
        """What a motion watches to find where it is crossed; arguments as `Guard` has them."""
        if self.end and direction != DIRECTIONS["up"]:
            raise ValueError(
                f"{self.series.name!r} is where a body arrives; expected direction 'up'"
            )
        arrives = bool(self.touch) and direction == DIRECTIONS["up"]
        return Guard(
            nodes=self._arrival if arrives else self.nodes,
            direction=direction,
            wanted=wanted,
            counts=self.reached if self.turns else None,
            key=(*self.key, arrives),
            name=name,
        )

    def _arrival(self, model: Model) -> tuple[Scalar, Scalar]:
        """The same; a closed rigid contact stays beyond zero, where it is but round-off."""
        difference, rate = self.nodes(model)
        for contact in model.walls.contacts:
            if contact.name == self.touch:
                difference = model.graph.select(contact.touching, contact.gap.size, difference)
        return difference, rate

    def reached(self, piece: Piece) -> NDArray[np.bool_]:
        """Which zeros of `nodes` of an angle are not half a turn away, shape (m,)."""
        (angle,) = evaluate_nodes(piece, [self.series.node(piece.system.model)])
        return np.asarray(np.cos(angle - self.level) > 0)


DIRECTIONS = {"up": 1, "down": -1, "both": 0}
"""How a surface is crossed → sign of the rate there; 0 for either."""


def parse_events(system: System, events: Mapping[str, str]) -> tuple[Guard, ...]:
    """Read ``{"piston.velocity": "up", "crank.angle=90 deg": "both"}``; no value means zero.

    ``gap.touch`` is where a journal touches its bearing (up) or leaves it (down), and
    ``stops[0].lower.touch`` where a body touches its stop.
    """
    if not isinstance(events, Mapping):
        expected = 'events must be a mapping such as {"piston.velocity": "up"}'
        raise TypeError(f"{expected}, found {events!r}")
    for name, direction in events.items():
        if direction not in DIRECTIONS:
            raise ValueError(f"event {name!r}: expected up, down or both, found {direction!r}")
    return tuple(
        _surface(system, name, "event", "=0").guard(DIRECTIONS[direction], name=name)
        for name, direction in events.items()
    )


def parse_section(system: System, text: str) -> Surface:
    """Read ``"slider9.velocity=0"``, ``"crank.angle=90 deg"``, ``"gap.touch"``, and the like.

    Raises
    ------
    ValueError
        If it names nothing of the mechanism; the message says what is expected.
    """
    return _surface(system, text, "section")


def example_section(system: System) -> str:
    """A section of this mechanism, for messages."""
    return f"{example_series(system, rate=True)}=0"


def _surface(system: System, text: str, what: str, value: str = "") -> Surface:
    """What a text names; `value` is added where it has none."""
    element, dot, quantity = text.strip().rpartition(".")
    if dot and quantity == TOUCH:
        return _touch(system, element, what)
    if "=" not in text:
        text += value
    from linkages.spec.conversion import QuantityError, parse_quantity
    from linkages.spec.units import ANGLE, ANGULAR_SPEED, LENGTH, SPEED

    # accelerations have a rate, too, but a section is a function of position and velocity
    measured = {
        "rad": ANGLE,
        "rad/s": ANGULAR_SPEED,
        "m": LENGTH,
        "m/s": SPEED,
    }
    match = re.fullmatch(r"\s*(.+?\.[^.=]+?)\s*=\s*(.+?)\s*", text)
    if match is None:
        raise ValueError(f"expected a {what} such as {example_section(system)!r}, found {text!r}")
    name, level = match.groups()
    known = {
        other: series
        for other, series in system_series(system).items()
        if series.variable in VARIABLES
        and VARIABLES[series.variable].rate
        and VARIABLES[series.variable].units in measured
    }
    try:
        series = find_series(known, name)
        return Surface(series, parse_quantity(level, measured[VARIABLES[series.variable].units]))
    except (QuantityError, ValueError) as error:
        raise ValueError(f"{what} {text!r}: {error}") from None


def _touch(system: System, name: str, what: str) -> Surface:
    """Where the journal of a clearance touches its bearing, or a body the end of its way."""
    opening = [contact.name for contact in system.mechanism.contacts]
    if name in opening:
        return Surface(system_series(system)[f"{name}.indentation"], 0.0, name)
    ends = [end.name for end in system.mechanism.ends]
    alone = [end for end in ends if name in (end, end.rpartition(".")[0])]
    if len(alone) == 1:
        return Surface(Series(f"{alone[0]}.{TOUCH}", TOUCH, {}), 0.0, alone[0], end=True)
    known = [*opening, *ends]
    told = suggestion(name, known) or (f"; expected {listed(known)}" if known else "")
    if alone:
        told = f", but of {len(alone)}; expected {listed(alone)}"
    raise ValueError(
        f"{what} '{name}.{TOUCH}': {name!r} is no clearance that opens (with the key 'contact') "
        f"and no end of a stop with 'restitution'{told}"
    )
