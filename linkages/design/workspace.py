"""The workspace of a point: where two drives can move it, and the singular curves of it.

Curves are level sets over the two driven coordinates: of what must not be negative for a loop to
close, and of the determinant of the velocities of the point by those of the drives.

References
----------
.. [1] C. Gosselin, J. Angeles, "Singularity analysis of closed-loop kinematic chains", *IEEE
   Transactions on Robotics and Automation* 6 (1990) 281-290: singularities of both kinds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import GUIDED
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.point_drives import axis_names
from linkages.kernel.inputs import SIDED
from linkages.kernel.model import determinant
from linkages.kernel.scalars import Scalar, components
from linkages.kernel.system import System
from linkages.reading.paths import KeyPath, dotted
from linkages.reading.wording import listed, suggestion
from linkages.solution.remarks import longest
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.units import ANGLE, LENGTH

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

INVERSE, FORWARD, LIMIT = "inverse", "forward", "limit"
"""Kinds of curves: where the point cannot leave in some direction, where it moves with drives at
rest, and where a range ends."""

MOST_BRANCHES = 64
VANISHING = 1e-9
"""Size of a function at its zero, beside that at the nearest nodes."""

ROUNDED = 1e-12
"""What is zero, in radians or metres."""

OPEN = 1e-6
"""Part of its size by which a radicand may be negative on a curve: it may follow from the root of
another one that vanishes there."""

HALVINGS = 60
"""Of a cell of the grid: to round-off."""

BESIDE = 1e-9
"""Of a cell: how far inside of what can be assembled a point of its border is evaluated."""


@dataclass(frozen=True)
class _Curve:
    kind: str
    branch: int
    drives: Floats  # driven coordinates, shape (points, 2)
    places: Floats  # of the point, shape (points, 2)


def workspace(
    mechanism: Mechanism,
    point: str | None = None,
    *,
    ranges: Mapping[str, tuple[float, float]] | Sequence[str] = (),
    samples: int = 181,
    own: bool = False,
) -> xr.Dataset:
    """Where two drives can move a point, and the singular curves on which it is hard to move.

    Parameters
    ----------
    mechanism
        Drives determine its motion; two of them move, others stand where they are at t = 0. What
        moves may also be the point itself, see `PointDrive`; then actuators have the ranges.
    point
        A joint; if not given, the one that a drive moves, or the only free end.
    ranges
        Drive (or actuator) → least and greatest value in SI, or texts such as ``"crank=0:90
        deg"``; default: a whole turn. The two of a mechanism with more drives are those with a
        range. A slider needs one; with sliders a point that a drive moves needs those of its
        coordinates, ``"P.x=0:0.5"``.
    samples
        Values of each coordinate from which curves are located; a curve that is smaller than a cell
        of their grid is missed.
    own
        Whether to take the assembly branch of the definition alone, instead of all of them.

    Returns
    -------
    Dataset with the curves, one point after the other (`node`): `curve`, its number; `kind`, which
    is inverse (the point cannot leave in some direction, for which drives would be infinitely
    fast), forward (the point can move with drives that stand still, so that efforts are
    unbounded), or limit (a range ends); `curve_branch`; `curve_x`, `curve_y`; and the driven
    coordinates, `curve_drive`. Positions over the grid are `x` and `y` (branch, first, second), nan
    where the mechanism cannot be assembled or a range is left.

    Raises
    ------
    InputError
        If the mechanism cannot be assembled, or something else than two drives moves it.
    ValueError
        If a name or a range makes no sense.
    """
    if samples < 5:
        raise ValueError(f"samples must be at least 5, found {samples}")
    field = _Field(mechanism, point, _read(mechanism, ranges), own)
    if field.guided:
        field.shrink(samples)
    curves = [
        curve for number in range(len(field.branches)) for curve in field.curves(number, samples)
    ]
    return _dataset(field, curves, samples)


Ranges = dict[str, tuple[float, float]]


def _read(
    mechanism: Mechanism, ranges: Mapping[str, tuple[float, float]] | Sequence[str]
) -> Ranges:
    """Ranges by name, of drives or actuators."""
    names = [*mechanism.prescribed, *mechanism.actuations]
    result: Ranges = {}
    pairs = ranges.items() if isinstance(ranges, Mapping) else map(_parts, ranges)
    for name, (low, high) in pairs:
        if name not in names:
            near = suggestion(name, names) or f"; expected one of {listed(names)}"
            raise ValueError(f"ranges: unknown drive or actuator {name!r}{near}")
        dimension = ANGLE if mechanism.twisting(name) else LENGTH
        try:
            ends = parse_quantity(low, dimension), parse_quantity(high, dimension)
        except QuantityError as error:
            raise ValueError(f"ranges: {name}: {error}") from None
        if not ends[0] < ends[1]:
            raise ValueError(f"ranges: {name}: expected increasing ends, found {low} and {high}")
        result[name] = ends
    return result


def _parts(text: str) -> tuple[str, tuple[Any, Any]]:
    name, equals, ends = text.partition("=")
    low, colon, high = ends.partition(":")
    if not (equals and colon):
        raise ValueError(f"expected a range such as 'crank=0:90 deg', found {text!r}")
    if low.strip().replace(".", "").lstrip("+-−").isdigit():  # both ends may share their unit
        low += high.lstrip(" +-−.0123456789")
    return name.strip(), (low.strip(), high.strip())


class _Field:
    """What is a function of two driven coordinates, in all branches."""

    def __init__(self, mechanism: Mechanism, point: str | None, ranges: Ranges, own: bool) -> None:
        self.mechanism = mechanism
        guided = [b for b in mechanism.bodies.values() if b.kind == GUIDED]
        joints = list(dict.fromkeys(joint for body in guided for joint in body.points))
        system = System(mechanism)
        self._require(system, joints)
        self.point = _chosen(system, point, joints)
        self.guided = self.point in joints
        names = [*axis_names(self.point)] if self.guided else self._two(system, ranges)
        if self.guided and not {*names} <= {*system.topology.driven}:
            raise ValueError(f"expected a drive of both x and y of {self.point}")
        self.drives = (names[0], names[1])
        moving = {*names, *(mechanism.actuations if self.guided else ())}
        if idle := [name for name in ranges if name not in moving]:
            what = f"{idle[0]} has a range, and does not move {self.point} here"
            raise ValueError(f"ranges: {what}; expected {listed(sorted(moving))}")
        self.limits: Ranges = {}
        self._ended = {name for name in names if name in ranges}
        if self.guided:
            self.limits = {n: r for n, r in ranges.items() if n in mechanism.actuations}
            self.box = self._box_of_point(ranges)
        else:
            self.box = tuple(self._range(name, ranges) for name in self.drives)
        self._build(system, own)

    def _require(self, system: System, joints: Sequence[str]) -> None:
        topology, error = system.topology, self.mechanism.error
        if topology.free or len(topology.driven) < 2:
            what = f"{', '.join(topology.free) or 'nothing'} is free and "
            what += f"{', '.join(topology.driven) or 'nothing'} is driven"
            raise error([((), f"a workspace is that of two drives or more, found that {what}")])
        if topology.iterated:
            bodies = ", ".join(topology.iterated)
            message = f"positions of {bodies} come out of an iteration, which a workspace"
            raise error([((), f"{message} does not follow; expected dyads")])
        if len(joints) > 1:
            raise error([((), f"drives move {', '.join(joints)}; expected one point")])

    def _two(self, system: System, ranges: Ranges) -> list[str]:
        driven = list(system.topology.driven)
        asked = [name for name in driven if name in ranges] if len(driven) > 2 else driven
        if len(asked) != 2:
            names = listed(driven, "and")
            raise ValueError(f"{names} are driven; expected ranges of the two that move")
        return asked

    def _range(self, name: str, ranges: Ranges) -> tuple[float, float]:
        if name in ranges:
            return ranges[name]
        if not self.mechanism.twisting(name):
            raise ValueError(f"expected a range of {name}, such as '{name}=0:0.5 m'")
        return -np.pi, np.pi

    def _box_of_point(self, ranges: Ranges) -> tuple[tuple[float, float], ...]:
        """What no point can leave: all bodies in a row, from any ground joint; or what is given."""
        bodies = [body for body in self.mechanism.bodies.values() if body.kind != GUIDED]
        missing = [name for name in self.drives if name not in ranges]
        if missing and not all(body.rotates for body in bodies):
            what = f"expected ranges of {listed(missing, 'and')}, such as '{missing[0]}=0:0.5 m'"
            raise ValueError(f"{what}, since sliders may go anywhere")
        grounds = np.array([[n.value for n in place] for place in self.mechanism.ground.values()])
        reach = sum(map(longest, bodies))
        low, high = grounds.min(axis=0) - reach, grounds.max(axis=0) + reach
        largest = dict(zip(self.drives, zip(low.tolist(), high.tolist(), strict=True), strict=True))
        return tuple((largest | ranges)[name] for name in self.drives)

    def _build(self, system: System, own: bool) -> None:
        """The same mechanism with drives that stand still, at numbers that may vary."""
        topology, model = system.topology, system.model
        standing: dict[str, dict[str, float]] = {}
        paths: dict[str, KeyPath] = {}
        bodies = self.mechanism.bodies
        for name in topology.driven:
            law = model.positions.laws[name].value
            start = float(system.evaluate([law])[0, 0])
            if bodies[name].kind == GUIDED:
                key, entry = name.rpartition(".")[2], {}
            else:
                key, entry = "angle" if bodies[name].rotates else "position", {"speed": 0.0}
            place = self.mechanism.prescribed[name].path
            standing.setdefault(dotted(place), entry)[key] = start
            paths[name] = (*place, key)
        still = self.mechanism.with_values(standing)
        kept = [dotted(paths[name]) for name in self.drives]
        self.system = System(still.keeping(kept), near=system.places())
        model = self.system.model
        places = model.inputs.parameters
        self._rows = [places[paths[name]] for name in self.drives]
        sides = [b for b in self.system.topology.solved_blocks if b.kind in SIDED]
        if 2 ** len(sides) > MOST_BRANCHES:
            message = f"{len(sides)} dyads have {2 ** len(sides)} branches"
            raise self.mechanism.error([((), f"{message}; expected at most {MOST_BRANCHES}")])
        self._blocks = [block.index for block in sides]
        self._sides = [places["side", index] for index in self._blocks]
        self.branches = list(product((1.0, -1.0), repeat=len(sides)))
        if own:
            self.branches = [tuple(self.system.parameters[self._sides].tolist())]
        words = ({1.0: "left", -1.0: "right"}, {1.0: "forward", -1.0: "backward"})
        self.labels = [
            ", ".join(words[b.kind != "RRR"][side] for b, side in zip(sides, branch, strict=True))
            for branch in self.branches
        ]
        self._place = components([model.positions.joints[self.point]])
        self._reaches = [reach.radicand for reach in model.reaches]
        ways = [model.partial(name) for name in self.drives]
        if not self.guided:
            moves = [way.joints[self.point] for way in ways]
            self._determinant: Scalar | None = determinant(
                [[m.x for m in moves], [m.y for m in moves]]
            )
        elif self.mechanism.actuations:
            self._determinant = model.actuated.dexterity
        else:
            self._determinant = None
        self._actuators = dict(zip(self.mechanism.actuations, model.actuators, strict=True))

    def values(
        self,
        nodes: Sequence[Scalar],
        branch: int,
        drives: Floats,
        sides: Sequence[float] | None = None,
    ) -> Floats:
        """Values of nodes at driven coordinates of shape (points, 2), shape (nodes, points)."""
        count = len(drives)
        numbers = np.repeat(self.system.parameters[:, None], count, axis=1)
        numbers[self._rows] = drives.T
        numbers[self._sides] = np.array(self.branches[branch] if sides is None else sides)[:, None]
        state = np.repeat(self.system.state[:, None], count, axis=1)
        if not nodes:
            return np.zeros((0, count))
        with np.errstate(all="ignore"):
            return self.system.evaluate(nodes, np.zeros(count), state, further={"p": numbers})

    def grid(self, samples: int) -> tuple[Floats, Floats]:
        """Values of both coordinates; numbers of them differ, so that no symmetry hits nodes."""
        (a, b), (c, d) = self.box
        return np.linspace(a, b, samples), np.linspace(c, d, samples + 2)

    def places(self, branch: int, samples: int) -> Floats:
        """The point over the grid, shape (2, samples, samples + 2); nan out of range."""
        u, v = self.grid(samples)
        drives = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
        kept = np.isfinite(self._kept(branch, drives, 0.0)[:, 0])
        place = np.where(kept, self.values(self._place, branch, drives), np.nan)
        return place.reshape(2, len(u), len(v))

    def shrink(self, samples: int) -> None:
        """Choose a box about what can be reached, with a margin of two cells."""
        reached = np.zeros((samples, samples + 2), dtype=bool)
        for branch in range(len(self.branches)):
            reached |= np.isfinite(self.places(branch, samples)[0])
        if not reached.any():
            raise ValueError(f"{self.point} reaches nothing; expected wider ranges")
        box = []
        for axis, values in enumerate(self.grid(samples)):
            hit = np.flatnonzero(reached.any(axis=1 - axis))
            step = values[1] - values[0]
            box.append((float(values[hit[0]] - 2 * step), float(values[hit[-1]] + 2 * step)))
        pairs = zip(self.drives, self.box, box, strict=True)
        self.box = tuple(given if n in self._ended else around for n, given, around in pairs)

    def curves(self, branch: int, samples: int) -> Iterator[_Curve]:
        """All curves of a branch."""
        closing, moving = (INVERSE, FORWARD) if self.guided else (FORWARD, INVERSE)
        for reach in self.system.model.reaches:
            function = self._function(branch, reach.radicand)
            yield from self._zeros(closing, branch, samples, function, reach.block)
        if self._determinant is not None:
            function = self._function(branch, self._determinant)
            yield from self._zeros(moving, branch, samples, function)
        for name, ends in self.limits.items():
            for end in ends:
                yield from self._zeros(LIMIT, branch, samples, self._beyond(branch, name, end))
        yield from self._edges(branch, samples)

    def _function(self, branch: int, node: Scalar) -> Callable[[Floats], Floats]:
        return lambda drives: self.values([node], branch, drives)[0]

    def _beyond(self, branch: int, name: str, end: float) -> Callable[[Floats], Floats]:
        return lambda drives: self._position(branch, name, drives) - end

    def _position(self, branch: int, name: str, drives: Floats) -> Floats:
        """Of an actuator; an angle is taken in the turn about the middle of its range."""
        (value,) = self.values([self._actuators[name].displacement], branch, drives)
        if not self.mechanism.twisting(name):
            return value
        least = 0.5 * sum(self.limits[name]) - np.pi
        return least + np.mod(value - least, 2.0 * np.pi)

    def _zeros(
        self,
        kind: str,
        branch: int,
        samples: int,
        of: Callable[[Floats], Floats],
        block: int | None = None,
    ) -> Iterator[_Curve]:
        """Where a function vanishes, or a block can no longer be assembled, and branches meet."""
        from contourpy import contour_generator

        u, v = self.grid(samples)
        drives = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
        values = np.ma.masked_invalid(of(drives).reshape(len(u), len(v)).T)
        lines: Any = contour_generator(u, v, values).lines(0.0)
        for line in lines:
            first, last = _edges_of(line, u, v)
            inside, outside = _refined(of, first, last)
            middle = 0.5 * (inside + outside)
            if self.guided:
                place = self._kept(branch, inside, OPEN)
            elif block is not None:  # the mean of branches has no square root in it
                away = BESIDE * np.sign(inside - outside) * (u[1] - u[0], v[1] - v[0])
                place = self._mean(branch, block, inside + away)
            else:
                place = self.values(self._place, branch, middle).T
            if block is None:  # through infinity, or at a jump, it changes its sign as well
                largest = np.maximum(*np.abs((of(first), of(last))))
                place = np.where(
                    (np.abs(of(middle)) <= VANISHING * largest)[:, None], place, np.nan
                )
            yield from _pieces(kind, branch, middle, place)

    def _kept(self, branch: int, drives: Floats, part: float) -> Floats:
        """Driven coordinates, shape (points, 2); nan where loops are open, or out of range.

        `part`: of its size by which the radicand of a loop may be below zero.
        """
        kept = np.ones(len(drives), dtype=bool)
        for radicand in self.values(self._reaches, branch, drives):
            kept &= radicand >= -part * np.nanmax(np.abs(radicand), initial=0.0)
        for name, (low, high) in self.limits.items():
            value = self._position(branch, name, drives)
            kept &= (value >= low - ROUNDED) & (value <= high + ROUNDED)
        return np.where(kept[:, None], drives, np.nan)

    def _mean(self, branch: int, block: int, drives: Floats) -> Floats:
        """Of the point in this branch and in the one that meets it where a block opens."""
        sides = list(self.branches[branch])
        other = self.values(self._place, branch, drives)
        place = self._blocks.index(block)
        sides[place] = -sides[place]
        return np.asarray(0.5 * (other + self.values(self._place, branch, drives, sides)).T)

    def _edges(self, branch: int, samples: int) -> Iterator[_Curve]:
        """Images of ends of ranges that are no whole turns."""
        for axis, name in enumerate(self.drives):
            low, high = self.box[axis]
            turn = self.mechanism.twisting(name) and np.isclose(high - low, 2 * np.pi)
            if turn or (self.guided and name not in self._ended):
                continue
            other = np.linspace(*self.box[1 - axis], 4 * samples)
            for end in (low, high):
                drives = np.stack([np.full_like(other, end), other], axis=1)
                drives = drives[:, ::-1] if axis else drives
                place = self.values(self._place, branch, drives).T
                place = self._kept(branch, drives, 0.0) if self.guided else place
                yield from _pieces(LIMIT, branch, drives, place)


def _pieces(kind: str, branch: int, drives: Floats, places: Floats) -> Iterator[_Curve]:
    """Parts of a curve between points that do not exist."""
    sound = np.isfinite(places[:, 0])
    for part in np.split(np.arange(len(sound)), np.flatnonzero(~sound)):
        kept = part[sound[part]]
        if len(kept) > 1:
            yield _Curve(kind, branch, drives[kept], places[kept])


def _chosen(system: System, point: str | None, guided: Sequence[str]) -> str:
    joints = [j for j in system.topology.joints if j not in system.mechanism.ground]
    if point is not None:
        if point not in joints:
            near = suggestion(point, joints) or f"; expected one of {listed(joints)}"
            raise ValueError(f"unknown point {point!r}{near}")
        return point
    ends = [*guided] or list(system.topology.free_ends)
    if len(ends) != 1:
        raise ValueError(f"expected a point, one of {listed(joints)}")
    return ends[0]


def _edges_of(line: Floats, u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Ends of the edges of a grid on which the points of a contour lie, shape (points, 2) each."""
    lows, highs = [], []
    for values, places in ((u, line[:, 0]), (v, line[:, 1])):
        at = (places - values[0]) / (values[1] - values[0])
        on = np.abs(at - np.round(at)) < 1e-9
        low = np.clip(np.where(on, np.round(at), np.floor(at)).astype(int), 0, len(values) - 1)
        lows.append(values[low])
        highs.append(values[np.clip(np.where(on, low, low + 1), 0, len(values) - 1)])
    return np.stack(lows, axis=1), np.stack(highs, axis=1)


def _refined(of: Callable[[Floats], Floats], first: Floats, last: Floats) -> tuple[Floats, Floats]:
    """Places on both sides of a zero, next to each other; that where it is positive comes first."""
    positive = (of(first) >= 0.0)[:, None]
    inside, outside = np.where(positive, first, last), np.where(positive, last, first)
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        above = (of(middle) >= 0.0)[:, None]
        inside, outside = np.where(above, middle, inside), np.where(above, outside, middle)
    return inside, outside


def _dataset(field: _Field, curves: Sequence[_Curve], samples: int) -> xr.Dataset:
    import xarray as xr

    u, v = field.grid(samples)
    grids = np.array([field.places(k, samples) for k in range(len(field.branches))])
    units = [
        "rad" if field.mechanism.twisting(n) and not field.guided else "m" for n in field.drives
    ]

    def joined(values: Iterator[Any], shape: tuple[int, ...] = ()) -> Any:
        parts = list(values)
        return np.concatenate(parts) if parts else np.zeros((0, *shape))

    numbers = enumerate(curves, 1)
    labels = np.array([label or "only" for label in field.labels], dtype=object)
    variables = {
        "curve": ("node", joined(np.full(len(c.places), k) for k, c in numbers).astype(int),
                  {"units": "1", "long_name": "number of the curve"}),
        "kind": ("node", np.array([c.kind for c in curves for _ in c.places], dtype=object),
                 {"units": "1", "long_name": "kind of the curve"}),
        "curve_branch": ("node", np.array([labels[c.branch] for c in curves for _ in c.places],
                                          dtype=object),
                         {"units": "1", "long_name": "assembly branch"}),
        "curve_x": ("node", joined(c.places[:, 0] for c in curves),
                    {"units": "m", "long_name": f"x of {field.point}"}),
        "curve_y": ("node", joined(c.places[:, 1] for c in curves),
                    {"units": "m", "long_name": f"y of {field.point}"}),
        "curve_drive": (("node", "drive"), joined((c.drives for c in curves), (2,)),
                        {"units": " or ".join(dict.fromkeys(units)),
                         "long_name": "driven coordinate"}),
        "x": (("branch", "first", "second"), grids[:, 0],
              {"units": "m", "long_name": f"x of {field.point}"}),
        "y": (("branch", "first", "second"), grids[:, 1],
              {"units": "m", "long_name": f"y of {field.point}"}),
    }  # fmt: skip
    coordinates = {
        "drive": np.array(field.drives, dtype=object),
        "branch": labels,
        "first": ("first", u, {"units": units[0], "long_name": field.drives[0]}),
        "second": ("second", v, {"units": units[1], "long_name": field.drives[1]}),
    }
    about = {
        "name": field.mechanism.name,
        "source": field.mechanism.file_name,
        "point": field.point,
    }
    return xr.Dataset(variables, coordinates, about)
