"""Topology and equations of a structure: all mechanisms that differ in numbers only share them."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.closure.iteration import block_size
from linkages.kernel.graph.remembered import Remembered
from linkages.kernel.model import Model
from linkages.kernel.numbers.parameters import structure_key
from linkages.topology.blocks import ITERATED
from linkages.topology.orientation import slaves
from linkages.topology.topology import Topology, build_topology

MOST_STRUCTURES = 64
"""Structures that a process remembers: a few MB each for mechanisms of twenty bodies."""


@dataclass(frozen=True, eq=False)
class Structure:
    """A topology with its equations.

    Parameters
    ----------
    key
        Equal for mechanisms that have all of this in common.
    topology
        Of the first mechanism of this structure, whose numbers do not count.
    model
        Equations to evaluate; kernels are printed from others, so that their text does not depend
        on what has been asked for before.
    """

    key: tuple[Hashable, ...]
    topology: Topology
    model: Model


_TOPOLOGIES: Remembered[Hashable, Topology] = Remembered(MOST_STRUCTURES)
_STRUCTURES: Remembered[Hashable, Structure] = Remembered(MOST_STRUCTURES)


def structure_of(mechanism: Mechanism, whole: bool = False) -> Structure:
    """The structure of a mechanism whose free coordinates are all named.

    Parameters
    ----------
    mechanism, whole
        As `linkages.topology.topology.build_topology` takes them, and what it raises.
    """
    key = (structure_key(mechanism.terms), whole)
    topology = _TOPOLOGIES.get(key, lambda: build_topology(mechanism, whole))
    sized = (*key, block_sizes(topology, mechanism))

    def made() -> Structure:
        own = topology_of(topology, mechanism)
        return Structure(sized, own, Model(own))

    return _STRUCTURES.get(sized, made)


def topology_of(topology: Topology, mechanism: Mechanism) -> Topology:
    """The same topology for another mechanism of the structure."""
    followers = slaves(mechanism) if topology.slaves else {}
    return replace(topology, mechanism=mechanism, slaves=followers)


def block_sizes(topology: Topology, mechanism: Mechanism) -> tuple[float, ...]:
    """Sizes of the groups that are solved by iteration, which stand in generated code."""
    groups = (block for block in topology.solved_blocks if block.kind == ITERATED)
    return tuple(block_size(mechanism, block) for block in groups)
