"""Where joints and centres of mass are, as sums of vectors from the origin."""

from __future__ import annotations

import math
from collections.abc import Iterable

import sympy as sp

from linkages.components.terms import Body, Guide
from linkages.equations.polar import Polar, Terms, in_frame
from linkages.equations.symbols import Symbols
from linkages.topology.blocks import Step
from linkages.topology.topology import Topology


class Places:
    """Positions along the bodies that place each joint.

    Parameters
    ----------
    topology
        Says which body places a joint.
    symbols
        Of the same mechanism.
    """

    def __init__(self, topology: Topology, symbols: Symbols) -> None:
        self._topology = topology
        self._symbols = symbols

    def _body(self, name: str) -> Body:
        return self._topology.mechanism.bodies[name]

    def joint(self, joint: str) -> Terms:
        """Position of a joint."""
        steps, start = self._topology.path(joint)
        return (*self.start(start, steps), *self.along(steps))

    def start(self, joint: str | None, steps: Iterable[Step]) -> Terms:
        """Where a chain begins: a joint, or the axis point of the slider that it begins with."""
        if joint is None:
            return self._axis_point(next(iter(steps)).body)
        if joint in self._topology.mechanism.ground:
            return in_frame(sp.S.Zero, *self._symbols.pair(self._topology.mechanism.ground[joint]))
        return self.joint(joint)

    def along(self, steps: Iterable[Step]) -> Terms:
        """Sum of the vectors along bodies."""
        return tuple(term for step in steps for term in self._step(step))

    def centre(self, name: str) -> Terms:
        """Position of a centre of mass."""
        body = self._body(name)
        if body.guide is not None:
            return (*self._axis_point(name), self._displacement(name, body.guide))
        entry = self._topology.entry[name]
        assert entry is not None
        return (*self.start(entry, ()), *self._within(name, body.points[entry], body.centre))

    def _step(self, step: Step) -> Terms:
        body = self._body(step.body)
        if body.guide is not None:
            along = self._displacement(step.body, body.guide)
            return (along,) if step.start is None else (-along,)
        assert step.start is not None
        assert step.end is not None
        return self._within(step.body, body.points[step.start], body.points[step.end])

    def _within(self, name: str, start: tuple, end: tuple) -> Terms:
        (x0, y0), (x, y) = self._symbols.pair(start), self._symbols.pair(end)
        return in_frame(self._symbols.coordinates[name], x - x0, y - y0)

    def _axis_point(self, name: str) -> Terms:
        guide = self._body(name).guide
        assert guide is not None
        assert not isinstance(guide.origin, str)
        return in_frame(sp.S.Zero, *self._symbols.pair(guide.origin))

    def _displacement(self, name: str, guide: Guide) -> Polar:
        """Along the axis; exact multiples of 90° are structure, as a zero is elsewhere."""
        quarters = guide.angle.value / (math.pi / 2)
        if quarters == round(quarters):
            angle = (round(quarters) % 4) * sp.pi / 2
        else:
            angle = self._symbols.parameter(guide.angle)
        return Polar(self._symbols.coordinates[name], angle)
