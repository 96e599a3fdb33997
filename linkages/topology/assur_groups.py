"""Assur groups and the loops that close them.

A loop runs from the known end of its first link to the other known end, and vectors count in that
direction. A dyad's loop starts at the unknown that stands first in the definition file.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from linkages.components.contributed.terms import Body, point_words
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.topology.decomposition import Group, Orientation

CLOSED_FORMS = {"RRR": "RRR dyad", "RRP": "RRP dyad", "RPR": "RPR dyad", "PP": "PP dyad"}
"""Kinds of blocks that are solved in closed form: their unknowns are two angles; the angle of a
link and the displacement of a slider; the angle of a guide and the displacement along it; two
displacements."""

ITERATED = "N"
"""The kind of all other blocks: solved by Newton's iteration."""


@dataclass(frozen=True)
class Step:
    """A loop's way along one body, from one of its points to another."""

    body: str
    start: str
    end: str

    @property
    def reversed(self) -> Step:
        """The same way back."""
        return Step(self.body, self.end, self.start)


@dataclass(frozen=True)
class Loop:
    """A chain of bodies between two places that are known already."""

    apex: str  # the point at which the two sides of the loop meet
    steps: tuple[Step, ...]  # the bodies of this block that the chain runs through
    start: str
    end: str

    @property
    def reversed(self) -> Loop:
        """The same loop run the other way."""
        steps = tuple(step.reversed for step in reversed(self.steps))
        return Loop(self.apex, steps, self.end, self.start)


@dataclass(frozen=True)
class Block:
    """Bodies placed together."""

    # Number among the blocks with unknowns, from 0; -1 for bodies that are merely placed
    index: int
    # The bodies in the order in which they are placed, with the point that each is placed from and
    # the points that it places
    placements: tuple[tuple[str, str, tuple[str, ...]], ...]
    # The bodies whose coordinate this block determines; of a dyad in the order of its loop
    unknowns: tuple[str, ...]
    loops: tuple[Loop, ...]  # the loops that determine them: two equations each
    kind: str  # one of `CLOSED_FORMS`, `ITERATED`, or ``""`` where there is nothing to solve

    @property
    def surplus(self) -> int:
        """Number of equations beyond the unknowns: redundant constraints."""
        return 2 * len(self.loops) - len(self.unknowns)

    @property
    def title(self) -> str:
        """What messages call it."""
        if self.kind in CLOSED_FORMS:
            return CLOSED_FORMS[self.kind]
        loops = len(self.loops)
        title = f"group of {loops} loop{'s' if loops > 1 else ''}"
        plural = "s" if self.surplus > 1 else ""
        return f"{title} with {self.surplus} redundant equation{plural}" if self.surplus else title

    @property
    def label(self) -> str:
        """The title and where it is."""
        return f"{self.title} at {point_words(self.loops[0].apex)}"


class BlockBuilder:
    """Places bodies group by group and closes a loop wherever a point is reached twice."""

    def __init__(
        self,
        mechanism: Mechanism,
        orientations: Mapping[str, Orientation],
        sliding: Collection[str] = (),
    ) -> None:
        self._mechanism = mechanism
        self._orientations = orientations
        self._sliding = frozenset(sliding)
        self._solved = 0
        self._number = {body: index for index, body in enumerate(mechanism.bodies)}
        self._before = set(mechanism.anchors)
        self.placing: dict[str, str] = {}
        self.entry: dict[str, str] = {}

    def add(self, group: Group) -> Block:
        """The block that solves a group, given all groups added before."""
        closings, placements = self._place(group)
        loops = tuple(self._loop(last) for last in closings)
        self._before.update(point for _, _, points in placements for point in points)
        unknowns = group.unknowns
        kind = ""
        if unknowns:
            kind = self._kind(unknowns, loops)
            if kind in CLOSED_FORMS:
                unknowns, loops = self._oriented(unknowns, loops[0])
        index = self._solved if unknowns else -1
        self._solved += bool(unknowns)
        return Block(index, placements, unknowns, loops, kind)

    def _body(self, name: str) -> Body:
        return self._mechanism.bodies[name]

    def _points(self, group: Group) -> dict[str, tuple[str, ...]]:
        """Points that can be placed now, body by body."""
        points = {body: self._mechanism.labels(body) for body in group.bodies}
        for body in self._sliding & points.keys():
            points[body] = points[body][1:]
        for body in group.sliding:
            points[body] = self._mechanism.labels(body)[:2]
        return points

    def _place(
        self, group: Group
    ) -> tuple[list[Step], tuple[tuple[str, str, tuple[str, ...]], ...]]:
        """Breadth first from what is known."""
        points, before = self._points(group), self._before
        at: dict[str, list[str]] = {}
        for body in points:
            for point in points[body]:
                at.setdefault(point, []).append(body)
        sliding = [body for body in points if not self._body(body).rotates]
        front = [(points[b][0], b) for b in sliding if points[b][0] in before]
        front += [(point, body) for body in points for point in points[body] if point in before]
        closings: list[Step] = []
        placed: dict[str, tuple[str, tuple[str, ...]]] = {}
        reached = {point for point in at if point in before}
        while front:
            following: list[tuple[str, str]] = []
            for entry, body in front:
                if body in placed:
                    continue
                self.entry.setdefault(body, entry)
                others = [point for point in points[body] if point != entry]
                closings += [Step(body, entry, point) for point in others if point in reached]
                fresh = tuple(point for point in others if point not in reached)
                reached.update(fresh)
                self.placing |= dict.fromkeys(fresh, body)
                placed[body] = (entry, fresh)
                following += [(point, other) for point in fresh for other in at[point]]
            front = following
        return closings, tuple((body, *item) for body, item in placed.items())

    def _loop(self, last: Step) -> Loop:
        """From the known end on the placing side over the last step's end to that of its start."""
        joint = last.end
        out, start = self._chain(joint)
        back, end = self._chain(last.start)
        back = [*back, last]
        while out and back and out[0] == back[0]:  # the part that both sides share cancels
            start = end = out[0].end
            out, back = out[1:], back[1:]
        return Loop(joint, (*out, *(step.reversed for step in reversed(back))), start, end)

    def _chain(self, joint: str) -> tuple[list[Step], str]:
        steps: list[Step] = []
        while joint not in self._before:
            body = self.placing[joint]
            steps.append(Step(body, self.entry[body], joint))
            joint = self.entry[body]
        return steps[::-1], joint

    def _masters(self, body: str, unknowns: Sequence[str]) -> list[str]:
        return [m for m in self._orientations[body].masters if m in unknowns]

    def _kind(self, unknowns: Sequence[str], loops: Sequence[Loop]) -> str:
        if len(loops) != 1 or len(unknowns) != 2:
            return ITERATED
        for step in loops[0].steps:
            orientation, own = self._orientations[step.body], step.body in unknowns
            slides = not (own or self._body(step.body).rotates)
            if self._masters(step.body, unknowns) and not orientation.rigid:
                return ITERATED
            if slides and {*orientation.moved} & {*unknowns}:
                return ITERATED
        sliding = [u for u in unknowns if not self._body(u).rotates]
        guided = any(self._masters(slider, unknowns) for slider in sliding)
        kinds = {0: "RRR", 1: "RPR" if guided else "RRP", 2: ITERATED if guided else "PP"}
        return kinds[len(sliding)]

    def _oriented(
        self, unknowns: Sequence[str], loop: Loop
    ) -> tuple[tuple[str, ...], tuple[Loop, ...]]:
        """Run so that the first bar of the file comes first; unknowns in that order."""
        number = self._number

        def moves(unknown: str, body: str) -> bool:
            return body == unknown or unknown in self._masters(body, unknowns)

        def first_place(unknown: str, loop: Loop) -> int:
            places = (i for i, step in enumerate(loop.steps) if moves(unknown, step.body))
            return next(places, len(loop.steps))

        def first_bar(unknown: str) -> int:
            """Place in the file; with welds and gears it need not be the unknown itself."""
            bars = (s.body for s in loop.steps if self._body(s.body).rotates)
            return min((number[b] for b in bars if moves(unknown, b)), default=len(number))

        turning = [u for u in unknowns if self._body(u).rotates]
        first = min(turning, key=first_bar) if turning else unknowns[0]
        second = next(u for u in unknowns if u != first)
        if first_place(first, loop) > first_place(second, loop):
            loop = loop.reversed
        return (first, second), (loop,)
