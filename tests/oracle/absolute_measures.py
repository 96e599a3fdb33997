"""Quantities of a configuration that constraints prescribe and loads work on.

A measure maps a state to its value, its Jacobian and what its second derivative is where all
coordinates have no acceleration: ÿ = jacobian·q̈ + bias.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from absolute_bodies import Layout, Point, State, pair
from time_functions import table_jet

from linkages.components.contributed.terms import Relation


class Measured(NamedTuple):
    """Shapes (k), (k, coordinates), (k)."""

    value: np.ndarray
    jacobian: np.ndarray
    bias: np.ndarray


Measure = Callable[[State], Measured]


def gap(first: Point, second: Point) -> Measure:
    """Vector from one point to another."""

    def measure(state: State) -> Measured:
        return Measured(
            state.place(second) - state.place(first),
            state.jacobian(second) - state.jacobian(first),
            state.bias(second) - state.bias(first),
        )

    return measure


def angles(layout: Layout, parts: Sequence[tuple[str | None, float]]) -> Measure:
    """Weighted sum of angles of bodies."""

    def measure(state: State) -> Measured:
        jacobian = np.zeros((1, layout.size))
        for body, weight in parts:
            if body is not None:
                jacobian[0, layout.start[body] + 2] += weight
        value = sum(weight * state.angle(body) for body, weight in parts)
        return Measured(np.array([value]), jacobian, np.zeros(1))

    return measure


def along_axis(layout: Layout, slider: str, offset: float = 0.0) -> Measure:
    """Displacement of a slider along its axis; across it where `offset` is a right angle.

    With the direction a of the axis, its normal n, the spin ω of its carrier and the vector d from
    axis point to slider: y = a·d, ẏ = a·ḋ + ω n·d, ÿ = a·d̈ + 2 ω n·ḋ + ω̇ n·d − ω² a·d.
    """
    body = layout.bodies[slider]
    guide = body.guide
    point = Point(slider, pair(next(iter(body.points.values()))))
    vector = gap(Point(guide.body, pair(guide.origin)), point)

    def measure(state: State) -> Measured:
        angle = state.angle(guide.body) + guide.angle.value + offset
        a, n = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        d, jacobian, bias = vector(state)
        spin, rate = state.speed(guide.body), jacobian @ state.rates
        row = a @ jacobian
        if guide.body is not None:
            row[layout.start[guide.body] + 2] += n @ d
        second = a @ bias + 2 * spin * n @ rate - spin**2 * a @ d
        return Measured(np.array([a @ d]), row[None], np.array([second]))

    return measure


def coordinate(layout: Layout, body: str) -> Measure:
    """What a drive prescribes: the angle of a body that turns, the displacement of a slider."""
    if layout.bodies[body].rotates:
        return angles(layout, [(body, 1.0)])
    return along_axis(layout, body)


def related(layout: Layout, relation: Relation) -> Measure:
    """The coordinate of a body less what follows from others: q − f(Σ ratio·q_other)."""
    own = coordinate(layout, relation.body)
    parts = [(coordinate(layout, body), ratio.value) for body, ratio in relation.parts]

    def measure(state: State) -> Measured:
        found = [(one(state), ratio) for one, ratio in parts]
        value, jacobian, bias = (
            sum(ratio * one[place] for one, ratio in found) for place in range(3)
        )
        if relation.profile is not None:
            lift, slope, bend = table_jet(relation.profile, value[0])
            rate = jacobian @ state.rates
            value, jacobian, bias = lift, slope * jacobian, slope * bias + bend * rate**2
        first = own(state)
        return Measured(first.value - value, first.jacobian - jacobian, first.bias - bias)

    return measure
