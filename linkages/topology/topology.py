"""The topology of a mechanism: graph, coordinates, mobility, blocks in their order of solution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module

import networkx as nx

from linkages.components.contributed.terms import Relation, point_words
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.topology.blocks import ITERATED, Block, BlockBuilder, Loop, Step
from linkages.topology.decomposition import StructureError, solution_order
from linkages.topology.explanation import explained, undetermined, wrong_mobility
from linkages.topology.graph import (
    bodies_at,
    gruebler_mobility,
    loop_count,
    single_joints,
    topology_graph,
    unreachable_bodies,
)
from linkages.topology.orientation import (
    Orientation,
    orientations,
    slaves,
    turned_bodies,
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
    slaves
        Body → the weld or gear that its angle follows from.
    orientations
        Body → what its orientation depends on.
    turned
        Bodies whose angle counts with its whole turns.
    blocks
        In an order in which positions can be solved.
    placing
        Point → the body that places it (points of the ground are missing).
    entry
        Body → the point that it is placed from.
    mobility
        By the Chebychev–Grübler–Kutzbach criterion.
    loops
        Number of independent loops.
    redundant
        Joints at which constraints repeat others (or contradict them).
    """

    mechanism: Mechanism
    graph: nx.MultiGraph
    driven: tuple[str, ...]
    free: tuple[str, ...]
    dependent: tuple[str, ...]
    slaves: dict[str, Relation]
    orientations: dict[str, Orientation]
    turned: frozenset[str]
    blocks: tuple[Block, ...]
    placing: dict[str, str]
    entry: dict[str, str]
    mobility: int
    loops: int
    redundant: tuple[str, ...]

    def _repr_html_(self) -> str:
        """What notebooks show: mobility, and blocks in their order of solution."""
        return str(import_module("linkages.plots.notebook").topology_html(self))  # stands above

    @property
    def redundant_places(self) -> str:
        """What messages call the places where constraints repeat others."""
        return ", ".join(point_words(joint, "") for joint in self.redundant)

    @property
    def iterated(self) -> tuple[str, ...]:
        """Bodies whose coordinate comes out of an iteration, which needs a value to start from."""
        return tuple(u for b in self.blocks if b.kind == ITERATED for u in b.unknowns)

    @property
    def carried(self) -> tuple[str, ...]:
        """Dependent bodies whose coordinate is carried along by an integration.

        An iteration starts from it, and whole turns are counted by it.
        """
        masters, bodies = self.counting, self.mechanism.bodies
        turned = (n for n in self.dependent if n in masters and bodies[n].rotates)
        return tuple(dict.fromkeys([*self.iterated, *turned]))

    @property
    def internal(self) -> tuple[str, ...]:
        """Names of the internal states."""
        return tuple(self.mechanism.internal)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """What is integrated twice: free coordinates, internal states, coordinates carried along.

        An internal state is the rate of its coordinate, which itself means nothing.
        """
        return (*self.free, *self.internal, *self.carried)

    @property
    def counted(self) -> tuple[str, ...]:
        """Dependent bodies whose whole turns are to be counted along a motion.

        All that turn, but for those whose angle is carried along, or follows from angles that have
        their turns.
        """
        bodies, carried = self.mechanism.bodies, self.carried
        follow = {name for name in self.slaves if name in self.turned}
        return tuple(
            name
            for name in self.dependent
            if bodies[name].rotates and name not in carried and name not in follow
        )

    def unwrapped(self, name: str) -> bool:
        """Whether an integrated coordinate is not to be kept within one turn."""
        return name in self.counting

    @property
    def counting(self) -> set[str]:
        """Bodies with a coordinate of their own that angles with whole turns depend on."""
        return {m for name in self.turned for m in self.orientations[name].masters}

    @property
    def solved_blocks(self) -> tuple[Block, ...]:
        """The blocks that determine dependent coordinates."""
        return tuple(block for block in self.blocks if block.unknowns)

    @property
    def closing(self) -> tuple[Loop, ...]:
        """All loops: those that determine coordinates first, then those that are redundant."""
        idle = [block for block in self.blocks if not block.unknowns]
        return tuple(loop for block in (*self.solved_blocks, *idle) for loop in block.loops)

    @property
    def joints(self) -> tuple[str, ...]:
        """All joints, the ground's first, then in the order of the file."""
        return tuple(bodies_at(self.mechanism))

    @property
    def free_ends(self) -> tuple[str, ...]:
        """Points that only one body has; a ground joint that none uses is not one."""
        return tuple(single_joints(self.mechanism))

    def path(self, joint: str) -> tuple[list[Step], str]:
        """Way from the ground to a point along the bodies that place it, and where it starts."""
        steps: list[Step] = []
        place = joint
        while place in self.placing:
            body = self.placing[place]
            steps.append(Step(body, self.entry[body], place))
            place = self.entry[body]
        return steps[::-1], place


def build_topology(mechanism: Mechanism, whole: bool = False) -> Topology:
    """Analyse a mechanism whose free coordinates are all named.

    Parameters
    ----------
    mechanism
        What to analyse.
    whole
        As `linkages.topology.decomposition.solution_order` takes it.

    Raises
    ------
    InputError
        For bodies without connection to the ground, and coordinates that nothing determines.
    """
    graph = topology_graph(mechanism)
    loose = unreachable_bodies(graph)
    if loose:
        message = "not connected to the ground by any chain of joints"
        found = [(mechanism.bodies[body].path, message) for body in loose]
        raise explained(mechanism, mechanism.error(found))
    known = (*mechanism.prescribed, *mechanism.initial)
    mobility = gruebler_mobility(mechanism)
    if mobility > len(known):
        raise explained(mechanism, wrong_mobility(mechanism, mobility))
    followers = slaves(mechanism)
    turned = orientations(mechanism, followers)
    try:
        order = solution_order(mechanism, (*known, *followers), turned, whole)
    except StructureError as error:
        raise explained(mechanism, undetermined(mechanism, error)) from None
    sliding = [name for group in order.groups for name in group.sliding]
    builder = BlockBuilder(mechanism, turned, sliding)
    blocks = tuple(builder.add(group) for group in order.groups)
    if not whole and any(block.surplus < 0 for block in blocks):
        # bodies that repeat each other: one would be turned before it is placed
        return build_topology(mechanism, whole=True)
    loose = _outside_loops(blocks, turned)
    if loose:
        raise explained(mechanism, undetermined(mechanism, StructureError(loose, ())))
    return Topology(
        mechanism=mechanism,
        graph=graph,
        driven=tuple(b for b in mechanism.bodies if b in mechanism.prescribed),
        free=tuple(b for b in mechanism.bodies if b in mechanism.initial),
        dependent=tuple(b for b in mechanism.bodies if b not in known),
        slaves=followers,
        orientations=turned,
        turned=frozenset(turned_bodies(mechanism)),
        blocks=blocks,
        placing=builder.placing,
        entry=builder.entry,
        mobility=mobility,
        loops=loop_count(graph),
        redundant=order.redundant,
    )


def _outside_loops(blocks: Sequence[Block], turned: Mapping[str, Orientation]) -> list[str]:
    """Unknowns that no loop of their block moves: bodies that repeat each other hide them."""
    found = []
    for block in blocks:
        steps = [step.body for loop in block.loops for step in loop.steps]
        followed = (m for body in steps for m in (*turned[body].masters, *turned[body].moved))
        moving = {*steps, *followed}
        found += [unknown for unknown in block.unknowns if unknown not in moving]
    return found
