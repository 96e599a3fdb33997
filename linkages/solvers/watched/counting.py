"""Count the whole turns of dependent angles along with an integration.

The kernel writes the unit vector and the speed of each. The speeds, added up with the weights of a
step as if the angle were integrated, say to much less than half a turn where it is; the unit vector
says where exactly within the turn, so that errors do not add up over the steps.
"""

from __future__ import annotations

import math

import numpy as np

from linkages.solvers.steps.compiled import compiled, floats, fused, integers
from linkages.solvers.steps.stages import address_of
from linkages.solvers.steps.views import TWO_PI, Nodes, Record, SystemView, TableView


@compiled
def first_cosine(system: SystemView) -> int:
    """Place within a row of the unit vectors of dependent angles; their speeds follow."""
    return 3 * system.n + 2 * system.blocks + 2 * system.carried


@compiled
def counted_angle(system: SystemView, record: Record, row: int, i: int) -> float:
    """A dependent angle in a row, with the turns that bring it closest to where it is expected."""
    values, first = floats(address_of(system, row)), first_cosine(system)
    angle = math.atan2(values[first + system.counted + i], values[first + i])
    return fused(TWO_PI, np.rint((floats(record.ahead)[i] - angle) / TWO_PI), angle)


@compiled
def arrive(system: SystemView, record: Record, row: int) -> None:
    """Take the angles in a row as those that the next step starts from."""
    for i in range(system.counted):
        floats(record.angles)[i] = counted_angle(system, record, row, i)


@compiled
def start_angles(system: SystemView, record: Record) -> None:
    """Begin with the angles in row 0, closest to where a run says that they are."""
    for i in range(system.counted):
        floats(record.ahead)[i] = floats(record.angles)[i]
    arrive(system, record, 0)


@compiled
def expect_end(system: SystemView, table: TableView, record: Record, h: float) -> None:
    """Where dependent angles are at the end of an explicit step of length h."""
    rows, starts, places = floats(system.rows), integers(table.starts), integers(table.places)
    # `places` are those of the speeds that begin at n.
    shift = first_cosine(system) + 2 * system.counted - system.n
    for i in range(system.counted):
        mean = 0.0
        for j in range(starts[table.end], starts[table.end + 1]):
            mean += floats(table.weights)[j] * rows[places[j] + shift + i]
        floats(record.ahead)[i] = floats(record.angles)[i] + h * mean


@compiled
def expect_between(
    system: SystemView, table: TableView, record: Record, h: float, theta: float
) -> None:
    """Where dependent angles are at the fraction theta of a step, by its dense output."""
    rows, dense, degree = floats(system.rows), floats(table.dense), table.degree
    first = first_cosine(system) + 2 * system.counted
    for i in range(system.counted):
        mean = 0.0
        for j in range(table.rows):
            weight = 0.0
            for power in range(degree - 1, -1, -1):
                weight = (weight + dense[j * degree + power]) * theta
            mean += weight * rows[j * system.width + first + i]
        floats(record.ahead)[i] = floats(record.angles)[i] + h * mean


@compiled
def expect_by_nodes(system: SystemView, nodes: Nodes, record: Record, first: int, h: float) -> None:
    """Where dependent angles are at the end of a collocation step with stages from `first` on."""
    rows, place = floats(system.rows), first_cosine(system) + 2 * system.counted
    for i in range(system.counted):
        mean = 0.0
        for j in range(nodes.stages):
            mean += floats(nodes.b)[j] * rows[(first + j) * system.width + place + i]
        floats(record.ahead)[i] = floats(record.angles)[i] + h * mean
