"""Event functions of a motion, surfaces of sections and their names, and states as one array."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES, coordinate_of, labels
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.reading.wording import listed, suggestion
from linkages.solution.evaluation import evaluate_nodes, evaluate_variables
from linkages.solution.motion import Motion, Piece
from linkages.solution.plan import Plan
from linkages.solution.series import Series, example_series, find_series, system_series
from linkages.solvers.trajectory import Event

Floats = NDArray[np.float64]

AT_ONCE = 10_000
"""Crossings for which there is room at first, where no number is wanted."""

PLACES = 65
"""Where a guard is looked at within a passage through a change point, which is short."""

GRID = math.radians(1.0)
"""Most that a drive turns between two places of a driven motion at which a guard is looked at."""

HALVINGS = 60
"""Of the interval between two places: more than a number has digits."""


@dataclass(frozen=True, kw_only=True)
class Guard:
    """A function of position and velocity that is watched for crossings of zero."""

    # The model → the function and its rate, which may depend on accelerations
    nodes: Callable[[Model], tuple[Scalar, Scalar]]
    # 1: where it grows with time; −1: where it falls; 0: both. Backward in time it is seen along
    # the integration
    direction: int = 0
    wanted: int = 0  # number of crossings at which the motion ends; 0: it does not
    # Which crossings count, of those of a piece; all if None
    counts: Callable[[Piece], NDArray[np.bool_]] | None = None
    # Equal for guards with the same nodes, which are generated once for a structure
    key: Hashable = None
    name: str = ""  # under which the motion has the crossings

    def counting(self, piece: Piece) -> NDArray[np.bool_]:
        """Which crossings of a piece count, shape (m,)."""
        if self.counts is None or not len(piece.time):
            return np.ones(len(piece.time), dtype=bool)
        return self.counts(piece)


class GuardCrossings:
    """Crossings of a guard, as they come in."""

    def __init__(self, guard: Guard) -> None:
        self.guard = guard
        self._pieces: list[Piece] = []
        self._wider = 1

    @property
    def _count(self) -> int:
        return sum(len(piece.wanted) for piece in self._pieces)

    @property
    def done(self) -> bool:
        """Whether it was crossed as often as it wants."""
        return 0 < self.guard.wanted <= self._count

    @property
    def motion(self) -> Motion:
        """The states at the crossings."""
        return Motion(pieces=tuple(self._pieces)).part(last=self.guard.wanted or None)

    def event(self, plan: Plan, system: System, flipped: tuple[int, ...]) -> Event:
        """What the next integration of a system is to watch."""
        wanted = self.guard.wanted
        room = self._wider * (wanted - self._count if wanted else AT_ONCE)
        return Event(
            function=plan.watch(system, self.guard.nodes, self.guard.key, flipped),
            direction=self.guard.direction,
            terminal=room,
            capacity=room,
        )

    def widen(self) -> None:
        """Make room for twice as many crossings."""
        self._wider *= 2

    def enough(self, piece: Piece) -> bool:
        """Whether it is done with the crossings of another piece."""
        wanted = self.guard.wanted
        return 0 < wanted <= self._count + int(self.guard.counting(piece).sum())

    def add(self, piece: Piece) -> None:
        """Take the crossings that an integration met."""
        self._pieces.append(piece.part(self.guard.counting(piece)))

    def add_within(self, piece: Piece) -> None:
        """Take those of a step through a change point, from what is interpolated there."""
        self._pieces.append(passed_piece(self.guard, piece))


def passed_piece(guard: Guard, piece: Piece) -> Piece:
    """Crossings within a passage through a change point, where values are interpolated."""
    grid = np.linspace(piece.time[0], piece.time[-1], PLACES)
    node, _ = guard.nodes(piece.system.model)
    values = evaluate_nodes(piece, [node])

    def function(times: Floats) -> Floats:
        return np.asarray(replace(piece, samples=times).interpolated(values)[0])

    result = replace(piece, samples=located(function, grid, guard.direction))
    there = guard.counting(result.direct())
    return replace(result, samples=result.wanted[there])


def driven_piece(guard: Guard, like: Piece, first: float, last: float, fastest: float) -> Piece:
    """Crossings of a driven motion between two times; `fastest` drive in rad/s."""
    node, _ = guard.nodes(like.system.model)

    def at(times: Floats) -> Piece:
        return Piece.driven(like.system, times, [*like.flipped])

    def function(times: Floats) -> Floats:
        return np.asarray(evaluate_nodes(at(times), [node])[0])

    count = 2 + math.ceil(abs(last - first) * fastest / GRID)
    result = at(located(function, np.linspace(first, last, count), guard.direction))
    return result.part(guard.counting(result))


def located(function: Callable[[Floats], Floats], grid: Floats, sign: int) -> Floats:
    """Where a function crosses zero, between two places of a grid at least, by bisection."""
    values = function(grid)
    before, after = values[:-1], values[1:]
    up, down = (before < 0) & (after >= 0), (before > 0) & (after <= 0)
    chosen = {1: up, -1: down, 0: up | down}[sign]
    way = np.where(up, 1.0, -1.0)[chosen]
    return bisected(grid[:-1][chosen], grid[1:][chosen], lambda at: ~(function(at) * way >= 0))[1]


def bisected(
    near: Floats, far: Floats, early: Callable[[Floats], NDArray[np.bool_]]
) -> tuple[Floats, Floats]:
    """Both sides of a change between two places each; places before it are `early`."""
    for _ in range(HALVINGS if len(near) else 0):
        middle = 0.5 * (near + far)
        before = early(middle)
        near, far = np.where(before, middle, near), np.where(before, far, middle)
    return near, far


def free_vectors(
    system: System,
    motion: Motion,
    *,
    names: tuple[str, ...] | None = None,
    turns: bool = True,
) -> Floats:
    """Free coordinates, rates and internal states, (samples, 2n + s), whatever was integrated."""
    names = system.topology.free if names is None else names
    result = [_of_piece(system, piece, names, turns) for piece in motion.pieces]
    return np.concatenate(result, axis=1).T


def _of_piece(system: System, piece: Piece, names: tuple[str, ...], turns: bool) -> Floats:
    """Shape (2n + s, samples)."""
    layout = piece.system.layout
    if layout.bodies[: len(names)] != names or piece.samples is not None:
        return np.concatenate([evaluated_vectors(system, piece, names), _internal(piece)])
    places = [layout.coordinates.index(name) for name in names]
    result = np.concatenate([piece.state[places], piece.state[len(piece.turns) :][places]])
    if turns:
        result[: len(names)] += 2 * np.pi * piece.turns[places]
    return np.concatenate([result, _internal(piece)])


def _internal(piece: Piece) -> Floats:
    """Internal states, shape (s, samples)."""
    return piece.interpolated(piece.state[piece.system.layout.internal_rows])


def evaluated_vectors(system: System, piece: Piece, names: tuple[str, ...]) -> Floats:
    """Coordinates of bodies within one turn, then their rates, from outputs; shape (2n, …)."""
    bodies = system.mechanism.bodies
    coordinates = {name: coordinate_of(bodies[name].kind) for name in names}
    rates = {name: VARIABLES[output].rate for name, output in coordinates.items()}
    wanted = list(dict.fromkeys([*coordinates.values(), *rates.values()]))
    values = evaluate_variables(Motion(pieces=(piece,)), wanted)
    rows = []
    for outputs in (coordinates, rates):
        for name, output in outputs.items():
            index = labels(system.model, VARIABLES[output].dims[0]).index(name)
            rows.append(values[output][:, index])
    return np.array(rows)


TOUCH = "touch"
"""Quantity of what touches: journal and bearing of a clearance that opens, or a body and its stop;
with direction down, they part."""


@dataclass(frozen=True)
class Surface:
    """Where a section is taken: one series of an output has a value."""

    series: Series  # of position or velocity
    level: float  # in SI
    # The clearance whose journal touches its bearing there, or the end of a way that a body
    # touches; empty for other surfaces
    touch: str = ""
    # Whether it is an end of a way: that has no series, and `series` is its name alone
    end: bool = False

    @property
    def turns(self) -> bool:
        """Whether it is an angle, which has a value again after every turn."""
        return not self.end and self.series.angle

    @property
    def key(self) -> tuple[str, str, float]:
        """What tells it from others of a mechanism."""
        return self.series.variable, self.series.name, self.level

    @property
    def rate(self) -> Series:
        """The rate of the series."""
        return replace(self.series, variable=VARIABLES[self.series.variable].rate)

    def nodes(self, model: Model) -> tuple[Scalar, Scalar]:
        """What crosses zero there, and its rate; an angle half a turn away, too, the other way."""
        if self.end:
            (gap,) = (nodes.gap for nodes in model.ends if nodes.name == self.touch)
            return gap.indentation, gap.rate(model.velocities)
        difference, rate = self.series.node(model) - self.level, self.rate.node(model)
        if not self.turns:
            return difference, rate
        return model.graph.sin(difference), model.graph.cos(difference) * rate

    def guard(self, direction: int, *, wanted: int = 0, name: str = "") -> Guard:
        """What a motion watches to find where it is crossed; arguments as `Guard` has them."""
        if self.end and direction != DIRECTIONS["up"]:
            raise ValueError(
                f"{self.series.name!r} is where a body arrives; expected direction 'up'"
            )
        arrives = bool(self.touch) and direction == DIRECTIONS["up"]
        return Guard(
            nodes=self._arrival if arrives else self.nodes,
            direction=direction,
            wanted=wanted,
            counts=self.reached if self.turns else None,
            key=(*self.key, arrives),
            name=name,
        )

    def _arrival(self, model: Model) -> tuple[Scalar, Scalar]:
        """The same; a closed rigid contact stays beyond zero, where it is but round-off."""
        difference, rate = self.nodes(model)
        for contact in model.rigid:
            if contact.name == self.touch:
                difference = model.graph.select(contact.touching, contact.gap.size, difference)
        return difference, rate

    def reached(self, piece: Piece) -> NDArray[np.bool_]:
        """Which zeros of `nodes` of an angle are not half a turn away, shape (m,)."""
        (angle,) = evaluate_nodes(piece, [self.series.node(piece.system.model)])
        return np.asarray(np.cos(angle - self.level) > 0)


DIRECTIONS = {"up": 1, "down": -1, "both": 0}
"""How a surface is crossed → sign of the rate there; 0 for either."""


EXTREMA = {"max": -1, "min": 1, "both": 0}
"""An extremum → sign of the second derivative there; 0 for either."""


def parse_events(system: System, events: Mapping[str, str]) -> tuple[Guard, ...]:
    """Read ``{"piston.velocity": "up", "crank.angle=90 deg": "both"}``; no value means zero.

    ``gap.touch`` rises at contact and falls at separation, as ``stops[0].lower.touch`` does.
    """
    if not isinstance(events, Mapping):
        expected = 'events must be a mapping such as {"piston.velocity": "up"}'
        raise TypeError(f"{expected}, found {events!r}")
    for name, direction in events.items():
        if direction not in DIRECTIONS:
            raise ValueError(f"event {name!r}: expected up, down or both, found {direction!r}")
    return tuple(
        _surface(system, name, "event", "=0").guard(DIRECTIONS[direction], name=name)
        for name, direction in events.items()
    )


def parse_extrema(system: System, extrema: Mapping[str, str]) -> tuple[Guard, ...]:
    """Read ``{"gap.indentation": "max"}``, of series that are functions of the positions.

    Raises ValueError for others, and TypeError for no mapping.
    """
    if not isinstance(extrema, Mapping):
        expected = 'extrema must be a mapping such as {"gap.indentation": "max"}'
        raise TypeError(f"{expected}, found {extrema!r}")
    result = []
    for name, which in extrema.items():
        if which not in EXTREMA:
            raise ValueError(f"extremum of {name!r}: expected max, min or both, found {which!r}")
        surface = _surface(system, name, "extremum", "=0")
        if surface.end or VARIABLES[surface.series.variable].units not in ("rad", "m"):
            raise ValueError(f"extremum of {name!r}: expected a position, an angle or a distance")

        def nodes(model: Model, rate: Series = surface.rate) -> tuple[Scalar, Scalar]:
            own = rate.node(model)
            accelerations = model.integrated_accelerations(model.changes)
            return own, model.switches.rates([own], accelerations)[0]

        key = (*surface.key, "extremum")
        result.append(Guard(nodes=nodes, direction=EXTREMA[which], key=key, name=name))
    return tuple(result)


def parse_section(system: System, text: str) -> Surface:
    """Read ``"slider9.velocity=0"``, ``"crank.angle=90 deg"``, ``"gap.touch"``, and the like.

    Raises ValueError if it names nothing of the mechanism; the message says what is expected.
    """
    return _surface(system, text, "section")


def example_section(system: System) -> str:
    """A section of this mechanism, for messages."""
    return f"{example_series(system, rate=True)}=0"


def _surface(system: System, text: str, what: str, value: str = "") -> Surface:
    """What a text names; `value` is added where it has none."""
    element, dot, quantity = text.strip().rpartition(".")
    if dot and quantity == TOUCH:
        return _touch(system, element, what)
    if "=" not in text:
        text += value
    from linkages.spec.conversion import QuantityError, parse_quantity
    from linkages.spec.units import ANGLE, ANGULAR_SPEED, LENGTH, SPEED

    # accelerations have a rate, too, but a section is a function of position and velocity
    measured = {
        "rad": ANGLE,
        "rad/s": ANGULAR_SPEED,
        "m": LENGTH,
        "m/s": SPEED,
    }
    match = re.fullmatch(r"\s*(.+?\.[^.=]+?)\s*=\s*(.+?)\s*", text)
    if match is None:
        raise ValueError(f"expected a {what} such as {example_section(system)!r}, found {text!r}")
    name, level = match.groups()
    known = {
        other: series
        for other, series in system_series(system).items()
        if series.variable in VARIABLES
        and VARIABLES[series.variable].rate
        and VARIABLES[series.variable].units in measured
    }
    try:
        series = find_series(known, name)
        return Surface(series, parse_quantity(level, measured[VARIABLES[series.variable].units]))
    except (QuantityError, ValueError) as error:
        raise ValueError(f"{what} {text!r}: {error}") from None


def _touch(system: System, name: str, what: str) -> Surface:
    """Where the journal of a clearance touches its bearing, or a body the end of its way."""
    opening = [contact.name for contact in system.mechanism.contacts]
    if name in opening:
        return Surface(system_series(system)[f"{name}.indentation"], 0.0, name)
    ends = [end.name for end in system.mechanism.ends]
    alone = [end for end in ends if name in (end, end.rpartition(".")[0])]
    if len(alone) == 1:
        return Surface(Series(f"{alone[0]}.{TOUCH}", TOUCH, {}), 0.0, alone[0], end=True)
    known = [*opening, *ends]
    told = suggestion(name, known) or (f"; expected {listed(known)}" if known else "")
    if alone:
        told = f", but of {len(alone)}; expected {listed(alone)}"
    raise ValueError(
        f"{what} '{name}.{TOUCH}': {name!r} is no clearance that opens (with the key 'contact') "
        f"and no end of a stop with 'restitution'{told}"
    )
