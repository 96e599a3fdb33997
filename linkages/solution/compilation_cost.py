"""How long it takes until a motion begins: expected from the structure, before anything is made.

Terms are nodes of the scalar graph. Their number is estimated from what each free coordinate moves,
and the time from their number by measurements (`docs/kernel.md`).
"""

from __future__ import annotations

import logging
from collections.abc import Iterable

from linkages.kernel.articulated_bodies import hangs
from linkages.topology.topology import Topology

LOGGER = logging.getLogger(__name__)

PATIENCE = 10.0
"""Seconds from which on a computation says what to expect before it begins."""

PER_MEMBER = 110
"""Terms of a body of a tree that is eliminated body by body."""

PER_BODY, PER_MOVED, PER_PAIR = 50, 20, 5
"""Terms of other bodies; of a point and a coordinate that moves it; of a point and two of these."""

PER_TANGENT = 2
"""Terms of a derivative, for each that is differentiated."""

EACH = 6e-5
"""Seconds for generating and compiling a term."""


def expected_terms(topology: Topology) -> float:
    """About how many terms the accelerations of the free coordinates have."""
    bodies = len(topology.mechanism.bodies)
    if hangs(topology):
        return float(PER_MEMBER * bodies)
    moving = [moved.bit_count() for moved in _moved(topology).values()]
    pairs = sum(count * (count + 1) / 2 for count in moving)
    solved = sum(size**3 / 3 for size in _coupled(_moved(topology).values()))
    return PER_BODY * bodies + PER_MOVED * sum(moving) + PER_PAIR * pairs + solved


def _moved(topology: Topology) -> dict[str, int]:
    """Point → bits of the free coordinates that move it."""
    turning = {name: 1 << place for place, name in enumerate(topology.free)}
    at: dict[str, int] = {}

    def turned(body: str) -> int:
        result = turning.get(body, 0)
        for master in (*topology.orientations[body].masters, *topology.orientations[body].moved):
            result |= turning.get(master, 0)
        return result

    for block in topology.blocks:
        if block.unknowns:
            ends = [point for loop in block.loops for point in (loop.start, loop.end)]
            bodies = [step.body for loop in block.loops for step in loop.steps]
            known = 0
            for moved in (*(at.get(point, 0) for point in ends), *map(turned, bodies)):
                known |= moved
            turning |= dict.fromkeys(block.unknowns, known)
        for body, entry, labels in block.placements:
            at |= dict.fromkeys(labels, at.get(entry, 0) | turned(body))
    return at


def _coupled(moved: Iterable[int]) -> list[int]:
    """Sizes of the sets of coordinates that are solved together."""
    sets: list[int] = []
    for bits in dict.fromkeys(moved):
        apart = []
        for other in sets:
            if bits & other:
                bits |= other
            else:
                apart.append(other)
        sets = [*apart, bits]
    return [bits.bit_count() for bits in sets]


def expected_seconds(terms: float) -> float:
    """About how long it takes to generate and compile so many terms."""
    return EACH * terms


def announce(terms: float, what: str) -> None:
    """Say what to expect of something that takes long to begin."""
    seconds = expected_seconds(terms)
    if seconds > PATIENCE:
        LOGGER.warning(
            "%s: about %s terms, which take about %.2g %s to generate and compile; the result is "
            "kept for the next run",
            what,
            f"{float(f'{terms:.2g}'):,.0f}",
            *((seconds, "s") if seconds < 120 else (seconds / 60, "min")),
        )
