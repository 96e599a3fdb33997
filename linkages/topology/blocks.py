"""Blocks: groups of bodies solved together, and the loops that close them.

Signs: a loop runs from the known end of its first unknown link through the links to the other
known end. The vector of every link is counted positive in that direction. The first unknown link
is the one that stands first in the definition file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from linkages.components.mechanism import Mechanism
from linkages.components.terms import Body


@dataclass(frozen=True)
class Step:
    """A loop's way along one body, from one joint to another.

    A slider is entered or left at its guide: that end is None.
    """

    body: str
    start: str | None
    end: str | None

    @property
    def reversed(self) -> Step:
        """The same way back."""
        return Step(self.body, self.end, self.start)


@dataclass(frozen=True)
class Loop:
    """A chain of bodies between two places that are known already.

    Parameters
    ----------
    apex
        The joint at which the two sides of the loop meet.
    steps
        The bodies of this block that the chain runs through.
    start, end
        Known joints at its ends; None for the guide of a slider.
    """

    apex: str
    steps: tuple[Step, ...]
    start: str | None
    end: str | None

    @property
    def reversed(self) -> Loop:
        """The same loop run the other way."""
        steps = tuple(step.reversed for step in reversed(self.steps))
        return Loop(self.apex, steps, self.end, self.start)


@dataclass(frozen=True)
class Block:
    """Bodies placed together.

    Parameters
    ----------
    index
        Number among the blocks with unknowns, from 0; -1 for bodies that are merely placed.
    placements
        The bodies in the order in which they are placed, with the joint (None: the guide) that
        each is placed from.
    unknowns
        The bodies whose coordinate this block determines, in the order of the file.
    loops
        The loops that determine them.
    kind
        ``"RRR"``, ``"RRP"``, ``"PP"``; ``""`` where there is nothing to solve.
    """

    index: int
    placements: tuple[tuple[str, str | None], ...]
    unknowns: tuple[str, ...]
    loops: tuple[Loop, ...]
    kind: str

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"{self.kind} dyad at joint {self.loops[0].apex}"


class UnsupportedBlockError(Exception):
    """A group of bodies that has no closed-form solution."""

    def __init__(self, bodies: Sequence[str], loops: int) -> None:
        super().__init__(bodies, loops)
        self.bodies = tuple(bodies)
        self.loops = loops


class BlockBuilder:
    """Places bodies group by group and closes a loop wherever a joint is reached twice.

    Parameters
    ----------
    mechanism
        The bodies and their joints.
    known
        Bodies whose coordinate is driven or free.
    """

    def __init__(self, mechanism: Mechanism, known: Sequence[str]) -> None:
        self._mechanism = mechanism
        self._known = frozenset(known)
        self._solved = 0
        self.placing: dict[str, str] = {}
        self.entry: dict[str, str | None] = {}

    def add(self, group: Sequence[str]) -> Block:
        """The block that solves a group, given all groups added before."""
        before = set(self._mechanism.ground) | set(self.placing)
        closings = self._place(group, before)
        unknowns = tuple(body for body in group if body not in self._known)
        loops = tuple(self._loop(joint, body, before) for joint, body in closings)
        if len(unknowns) != 2 * len(loops) or len(loops) > 1:
            raise UnsupportedBlockError(group, len(loops))
        kind = ""
        if unknowns:
            loops = (self._oriented(loops[0], unknowns),)
            kind = self._kind(unknowns)
        index = self._solved if unknowns else -1
        self._solved += bool(unknowns)
        placements = tuple((body, self.entry[body]) for body in self.entry if body in group)
        return Block(index, placements, unknowns, loops, kind)

    def _body(self, name: str) -> Body:
        return self._mechanism.bodies[name]

    def _place(self, group: Sequence[str], before: set[str]) -> list[tuple[str, str]]:
        """Breadth first from what is known; returns the (joint, body) that close loops."""
        front: list[tuple[str | None, str]] = [
            (None, b) for b in group if not self._body(b).rotates
        ]
        front += [(j, b) for b in group for j in self._body(b).points if j in before]
        closings: list[tuple[str, str]] = []
        reached = set(before)
        while front:
            following: list[tuple[str | None, str]] = []
            for joint, body in front:
                if body not in self.entry:
                    self.entry[body] = joint
                    following += self._reach(body, joint, group, reached, closings)
            front = following
        return closings

    def _reach(
        self,
        body: str,
        entry: str | None,
        group: Sequence[str],
        reached: set[str],
        closings: list[tuple[str, str]],
    ) -> list[tuple[str | None, str]]:
        """Place the other joints of a body; returns what they give access to."""
        access: list[tuple[str | None, str]] = []
        for joint in self._body(body).points:
            if joint == entry:
                continue
            if joint in reached:
                closings.append((joint, body))
                continue
            reached.add(joint)
            self.placing[joint] = body
            access += [(joint, other) for other in group if joint in self._body(other).points]
        return access

    def _loop(self, joint: str, closing: str, before: set[str]) -> Loop:
        """From the known end on the placing side over `joint` to that of the closing side."""
        out, start = self._chain(joint, before)
        last = Step(closing, self.entry[closing], joint)
        back, end = self._chain(self.entry[closing], before)
        return Loop(joint, (*out, *(step.reversed for step in reversed([*back, last]))), start, end)

    def _chain(self, joint: str | None, before: set[str]) -> tuple[list[Step], str | None]:
        """Steps from a known place to a joint, and that place."""
        steps: list[Step] = []
        while joint is not None and joint not in before:
            body = self.placing[joint]
            steps.append(Step(body, self.entry[body], joint))
            joint = self.entry[body]
        return steps[::-1], joint

    def _oriented(self, loop: Loop, unknowns: Sequence[str]) -> Loop:
        """Run so that the first unknown turning body of the file comes first."""
        order = [step.body for step in loop.steps if step.body in unknowns]
        turning = [body for body in unknowns if self._body(body).rotates]
        first = turning[0] if turning else unknowns[0]
        return loop if order[0] == first else loop.reversed

    def _kind(self, unknowns: Sequence[str]) -> str:
        turning = sum(self._body(body).rotates for body in unknowns)
        return {2: "RRR", 1: "RRP", 0: "PP"}[turning]
