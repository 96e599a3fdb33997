"""Where joints and centres of mass are, as sums of vectors from the origin."""

from __future__ import annotations

import math
from collections.abc import Iterable

import sympy as sp

from linkages.components.contributed.terms import Body, Parameter, Relation
from linkages.equations.laws import law_of
from linkages.equations.polar import Polar, Terms, in_frame
from linkages.equations.symbols import Symbols
from linkages.topology.blocks import Step
from linkages.topology.topology import Topology


class Places:
    """Positions along the bodies that place each joint, and how bodies are turned.

    Parameters
    ----------
    topology
        Says which body places a joint, and which bodies welds and gears turn.
    symbols
        Of the same mechanism.
    """

    def __init__(self, topology: Topology, symbols: Symbols) -> None:
        self._topology = topology
        self._mechanism = topology.mechanism
        self._symbols = symbols

    def _body(self, name: str) -> Body:
        return self._mechanism.bodies[name]

    def joint(self, label: str) -> Terms:
        """Position of a joint, or of the axis point of a slider."""
        steps, start = self._topology.path(label)
        anchor = self._symbols.pair(self._mechanism.anchors[start])
        return (*in_frame(sp.S.Zero, *anchor), *self.along(steps))

    def along(self, steps: Iterable[Step]) -> Terms:
        """Sum of the vectors along bodies."""
        return tuple(term for step in steps for term in self._step(step))

    def centre(self, name: str) -> Terms:
        """Position of a centre of mass; a slider's is its first joint."""
        body = self._body(name)
        first = next(iter(body.points))
        if body.guide is None:
            entry = self._topology.entry[name]
            start = self._mechanism.attachments[name][entry]
            return (*self.joint(entry), *self._within(name, start, body.centre))
        if body.guide.body is None:
            axis = body.axis
            return (*self.joint(axis), *self._step(Step(name, axis, first)))
        return self.joint(first)

    def orientation(self, name: str) -> sp.Expr:
        """The angle of a body's frame in radians; that of a guide up to whole turns."""
        guide = self._body(name).guide
        if guide is not None:
            carrier = sp.S.Zero if guide.body is None else self.orientation(guide.body)
            return carrier + self._angle(guide.angle, whole_turns=False)
        return self.coordinate(name)

    def turning(self, name: str | None) -> sp.Expr:
        """Angular speed of a body (None: the ground)."""
        if name is None:
            return sp.S.Zero
        angle = self.orientation(name)
        return sp.Add(*(sp.diff(angle, q) * rate for q, rate in self._symbols.rates.items()))

    def coordinate(self, name: str) -> sp.Expr:
        """A body's own coordinate: its angle in radians, or its displacement in metres."""
        if name in self._topology.slaves:
            return self._following(name)
        return self._symbols.coordinates[name]

    def _following(self, name: str) -> sp.Expr:
        """It is offset + Σ ratio·q_other, or offset + f(Σ ratio·q_other)."""
        relation, turns = self._topology.slaves[name], self._body(name).rotates
        offset = (self._angle if turns else self._symbols.parameter)(relation.offset)
        if relation.profile is None:
            return self._summed(relation) + offset
        return law_of(relation.profile, self._symbols, lambda _: self._summed(relation)) + offset

    def _summed(self, relation: Relation) -> sp.Expr:
        total = sp.S.Zero
        for other, ratio in relation.parts:
            factor = sp.S.One if ratio.value == 1.0 else self._symbols.parameter(ratio)
            total += factor * self.coordinate(other)
        return total

    def _angle(self, angle: Parameter, whole_turns: bool = True) -> sp.Expr:
        """A constant angle; exact multiples of 90° are structure, as a zero is elsewhere."""
        quarters = angle.value / (math.pi / 2)
        if quarters != round(quarters):
            return self._symbols.parameter(angle)
        count = round(quarters)
        return (count if whole_turns else count % 4) * sp.pi / 2

    def _step(self, step: Step) -> Terms:
        """Along a body; a slider's axis point lies at its first joint, less the displacement."""
        places, own = self._mechanism.attachments[step.body], self._body(step.body).axis
        slid: Terms = ()
        if own in (step.start, step.end):
            along = Polar(self.coordinate(step.body), self.orientation(step.body))
            slid = (along if step.start == own else -along,)
        origin = next(iter(places.values()))
        within = self._within(
            step.body, places.get(step.start, origin), places.get(step.end, origin)
        )
        return (*slid, *within)

    def _within(
        self, name: str, start: tuple[Parameter, Parameter], end: tuple[Parameter, Parameter]
    ) -> Terms:
        (x0, y0), (x, y) = self._symbols.pair(start), self._symbols.pair(end)
        return in_frame(self.orientation(name), x - x0, y - y0)
