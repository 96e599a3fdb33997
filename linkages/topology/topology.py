"""The topology of a mechanism: graph, coordinates, mobility, blocks in their order of solution."""

from __future__ import annotations

from dataclasses import dataclass

import networkx as nx

from linkages.components.mechanism import Mechanism
from linkages.components.revolute import GROUND
from linkages.components.terms import Path
from linkages.errors import InputError
from linkages.topology.blocks import Block, BlockBuilder, Step, UnsupportedBlockError
from linkages.topology.decomposition import StructureError, solution_order
from linkages.topology.graph import (
    bodies_at,
    gruebler_mobility,
    loop_count,
    topology_graph,
    unreachable_bodies,
)


@dataclass(frozen=True)
class Topology:
    """How the bodies of a mechanism hang together.

    Parameters
    ----------
    mechanism
        The mechanism.
    graph
        Bodies are nodes, joints are edges.
    driven, free, dependent
        Bodies by what determines their coordinate: a drive, the motion, the closure.
    blocks
        In an order in which positions can be solved.
    placing
        Joint → the body that places it (ground joints are missing).
    entry
        Body → the joint that it is placed from; None for the guide of a slider.
    mobility
        By Grübler's formula.
    loops
        Number of independent loops.
    """

    mechanism: Mechanism
    graph: nx.MultiGraph
    driven: tuple[str, ...]
    free: tuple[str, ...]
    dependent: tuple[str, ...]
    blocks: tuple[Block, ...]
    placing: dict[str, str]
    entry: dict[str, str | None]
    mobility: int
    loops: int

    @property
    def solved_blocks(self) -> tuple[Block, ...]:
        """The blocks that determine dependent coordinates."""
        return tuple(block for block in self.blocks if block.unknowns)

    @property
    def joints(self) -> tuple[str, ...]:
        """All joints, the ground's first, then in the order of the file."""
        return tuple(bodies_at(self.mechanism))

    @property
    def free_ends(self) -> tuple[str, ...]:
        """Points that only one body has; a ground joint that none uses is not one."""
        meeting = bodies_at(self.mechanism)
        return tuple(j for j, (first, *others) in meeting.items() if not others and first != GROUND)

    def path(self, joint: str) -> tuple[list[Step], str | None]:
        """Way from the ground to a joint along the bodies that place it, and where it starts."""
        steps: list[Step] = []
        place: str | None = joint
        while place is not None and place in self.placing:
            body = self.placing[place]
            steps.append(Step(body, self.entry[body], place))
            place = self.entry[body]
        return steps[::-1], place


def build_topology(mechanism: Mechanism) -> Topology:
    """Analyse a mechanism whose free coordinates are all named.

    Raises
    ------
    InputError
        For bodies without connection to the ground, a mobility that drives and free coordinates
        do not match, constraints that contradict or repeat each other, and groups of bodies that
        have no closed-form solution.
    """
    graph = topology_graph(mechanism)
    loose = unreachable_bodies(graph)
    if loose:
        message = "not connected to the ground by any chain of joints"
        raise mechanism.error([(mechanism.bodies[body].path, message) for body in loose])
    known = (*mechanism.prescribed, *mechanism.initial)
    mobility = gruebler_mobility(graph)
    if mobility != len(known):
        raise _wrong_mobility(mechanism, mobility)
    builder = BlockBuilder(mechanism, known)
    try:
        blocks = tuple(builder.add(group) for group in solution_order(mechanism, known))
    except StructureError as error:
        raise _undetermined(mechanism, error) from None
    except UnsupportedBlockError as error:
        raise _no_closed_form(mechanism, error) from None
    return Topology(
        mechanism=mechanism,
        graph=graph,
        driven=tuple(b for b in mechanism.bodies if b in mechanism.prescribed),
        free=tuple(b for b in mechanism.bodies if b in mechanism.initial),
        dependent=tuple(b for b in mechanism.bodies if b not in known),
        blocks=blocks,
        placing=builder.placing,
        entry=builder.entry,
        mobility=mobility,
        loops=loop_count(graph),
    )


def _wrong_mobility(mechanism: Mechanism, mobility: int) -> InputError:
    driven, free = len(mechanism.prescribed), len(mechanism.initial)
    found = f"mobility is {mobility}, but {driven} coordinates are driven and {free} free"
    if driven + free > mobility:
        remedy = "expected as many as the mobility: remove a drive or a free coordinate"
    else:
        remedy = (
            "expected as many as the mobility: add a drive, or name a bar under 'free' with its "
            "initial angle"
        )
    path: Path = ("drives",) if mechanism.prescribed else ("free",) if mechanism.initial else ()
    return mechanism.error([(path, f"{found}; {remedy}")])


def _undetermined(mechanism: Mechanism, error: StructureError) -> InputError:
    found = [
        (mechanism.bodies[body].path, f"nothing determines the coordinate of {body!r}")
        for body in error.surplus
    ]
    if error.contested:
        joints = ", ".join(error.contested)
        message = (
            f"more constraints than coordinates at {joints}; expected the drives and free "
            "coordinates to be independent of each other"
        )
        found.append(((), message))
    return mechanism.error(found)


def _no_closed_form(mechanism: Mechanism, error: UnsupportedBlockError) -> InputError:
    bodies = ", ".join(error.bodies)
    message = (
        f"{bodies} form a group of {error.loops} loops that must be solved together (Assur group "
        "of class III or higher); expected a mechanism made of dyads"
    )
    return mechanism.error([(mechanism.bodies[error.bodies[0]].path, message)])
