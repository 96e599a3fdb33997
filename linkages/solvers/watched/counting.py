"""Count the whole turns of dependent angles along with an integration.

The kernel writes the unit vector and the speed of each. The speeds, added up with the weights of a
step as if the angle were integrated, say to much less than half a turn where it is; the unit vector
says where exactly within the turn, so that errors do not add up over the steps.
"""

from __future__ import annotations

from typing import Any

from linkages.kernel.code.operands import Real, Whole, elementary, floats, fused, integers, rounded
from linkages.kernel.code.printed import printed
from linkages.kernel.code.procedure import Procedure
from linkages.solvers.steps.stages import address_of
from linkages.solvers.steps.views import TWO_PI, Nodes, Record, SystemView, TableView


def first_cosine(system: SystemView) -> Any:
    """Place within a row of the unit vectors of dependent angles; their speeds follow."""
    return 3 * system.n + 2 * system.blocks + 2 * system.carried


@printed
def counted_angle(
    _code: Procedure, system: SystemView, record: Record, row: Whole, i: Whole
) -> Real:
    """A dependent angle in a row, with the turns that bring it closest to where it is expected."""
    values, first = floats(address_of(system, row)), first_cosine(system)
    angle = elementary("atan2", values[first + system.counted + i], values[first + i])
    whole = rounded((floats(record.ahead)[i] - angle) / TWO_PI)
    return fused(whole, TWO_PI, angle)


@printed
def arrive(code: Procedure, system: SystemView, record: Record, row: Whole) -> None:
    """Take the angles in a row as those that the next step starts from."""
    with code.count(system.counted) as i:
        floats(record.angles)[i] = counted_angle(system, record, row, i)


@printed
def start_angles(code: Procedure, system: SystemView, record: Record) -> None:
    """Begin with the angles in row 0, closest to where a run says that they are."""
    with code.count(system.counted) as i:
        floats(record.ahead)[i] = floats(record.angles)[i]
    arrive(system, record, 0)


@printed
def expect_end(
    code: Procedure, system: SystemView, table: TableView, record: Record, h: Real
) -> None:
    """Where dependent angles are at the end of an explicit step of length h."""
    rows, starts, places = floats(system.rows), integers(table.starts), integers(table.places)
    # `places` are those of the speeds that begin at n.
    shift = first_cosine(system) + 2 * system.counted - system.n
    with code.count(system.counted) as i:
        mean, first = code.variable(0.0), starts[table.end]
        with code.count(starts[table.end + 1] - first) as k:
            j = first + k
            mean.set(fused(floats(table.weights)[j], rows[places[j] + shift + i], mean))
        floats(record.ahead)[i] = fused(h, mean, floats(record.angles)[i])


@printed
def expect_between(
    code: Procedure, system: SystemView, table: TableView, record: Record, h: Real, theta: Real
) -> None:
    """Where dependent angles are at the fraction theta of a step, by its dense output."""
    rows, dense, degree = floats(system.rows), floats(table.dense), table.degree
    first = first_cosine(system) + 2 * system.counted
    with code.count(system.counted) as i:
        mean = code.variable(0.0)
        with code.count(table.rows) as j:
            weight = code.variable(0.0)
            with code.count(degree) as k:
                weight.set((weight + dense[j * degree + (degree - 1 - k)]) * theta)
            mean.set(fused(weight, rows[j * system.width + first + i], mean))
        floats(record.ahead)[i] = fused(h, mean, floats(record.angles)[i])


@printed
def expect_by_nodes(
    code: Procedure, system: SystemView, nodes: Nodes, record: Record, first: Whole, h: Real
) -> None:
    """Where dependent angles are at the end of a collocation step with stages from `first` on."""
    rows, place = floats(system.rows), first_cosine(system) + 2 * system.counted
    with code.count(system.counted) as i:
        mean = code.variable(0.0)
        with code.count(nodes.stages) as j:
            speed = rows[(first + j) * system.width + place + i]
            mean.set(fused(floats(nodes.b)[j], speed, mean))
        floats(record.ahead)[i] = fused(h, mean, floats(record.angles)[i])
