"""What a component contributes: plain data that equations and kernels are built from.

Lengths are metres, angles radians (counter-clockwise from +x), masses kilograms.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from linkages.reading.paths import KeyPath

if TYPE_CHECKING:
    from linkages.components.contributed.functions import Function, Table
    from linkages.components.contributed.wear_laws import Rubbing

Path = KeyPath  # for plug-ins of the release before


@dataclass(frozen=True)
class Parameter:
    """A number of the definition file: an argument of the kernel, never a part of its text."""

    path: KeyPath  # where it stands in the definition file, e.g. ``("bars", "crank1", "length")``
    value: float  # in SI units
    # Whether an exact zero is structure that removes terms (a massless bar, no gravity)
    structural: bool = False
    # Whether it stays an argument of the kernel whatever its value: sensitivities to it are asked
    # for
    kept: bool = False

    @property
    def absent(self) -> bool:
        """Whether everything multiplied by this number is left out of the kernel."""
        return self.structural and self.value == 0.0 and not self.kept


ZERO, ONE = Parameter((), 0.0, structural=True), Parameter((), 1.0, structural=True)

PARAMETERS = "parameters"
"""The section of numbers that formulas share."""


def named_number(name: str, value: float = math.nan) -> Parameter:
    """A number that formulas share; only the whole mechanism knows its value."""
    return Parameter((PARAMETERS, name), value)


@dataclass(frozen=True)
class NamedNumber:
    """A number that formulas share by its name."""

    number: Parameter


Place = tuple[Parameter, Parameter]
Origin = str | Place


@dataclass(frozen=True)
class Guide:
    """A straight axis that a body slides along.

    `origin`: the point of the axis that displacements count from: a joint, or coordinates in the
    frame of `body`. A joint that moves carries the axis along, which keeps its direction.
    """

    origin: Origin
    angle: Parameter  # direction of the axis in the frame of `body`
    # The body whose frame the direction counts from, and that carries the axis unless a moving
    # joint does; None for the ground
    body: str | None = None


def axis_label(slider: str) -> str:
    """Return what the point is called that a slider's displacement counts from.

    It is a point of the body that carries the axis; no name of a definition file contains a dot.
    """
    return f"{slider}.axis"


def point_words(point: str, joint: str = "joint ") -> str:
    """What messages call a point: a joint, or the axis of a slider, which has no name in files."""
    slider = point.removesuffix(".axis")
    return f"{joint}{point}" if slider == point else f"the axis of {slider}"


@dataclass(frozen=True, kw_only=True)
class Body:
    """A rigid body with one coordinate: an angle, or a displacement along ``guide``.

    `name`, `kind`, `path`: name, what it is called in reports (``"bar"``, ``"plate"``, …), place in
    the file.
    `mass`, `inertia`: ``inertia`` is about the centre of mass.
    """

    name: str
    kind: str
    path: KeyPath
    # Joint name → coordinates in the body's own frame. The frame of a sliding body has its first
    # axis along its guide and its origin at its first joint
    points: Mapping[str, tuple[Parameter, Parameter]]
    mass: Parameter = ZERO
    inertia: Parameter = ZERO
    centre: tuple[Parameter, Parameter] = (ZERO, ZERO)  # centre of mass in the body's own frame
    guide: Guide | None = None  # the axis of a sliding body; None for a body that turns

    @property
    def rotates(self) -> bool:
        """Whether the coordinate is an angle."""
        return self.guide is None

    @property
    def afloat(self) -> bool:
        """Whether a joint carries its axis, in a mechanism that has resolved all other origins."""
        return self.guide is not None and isinstance(self.guide.origin, str)

    @property
    def axis(self) -> str:
        """The point that the displacement of a sliding body of a mechanism counts from."""
        origin = None if self.guide is None else self.guide.origin
        return origin if isinstance(origin, str) else axis_label(self.name)


def crossed(
    names: tuple[str, str], kind: str, path: KeyPath, origin: Origin, point: str
) -> tuple[Body, Body]:
    """Massless bodies: one slides along x from an origin, one along y on it, which has a point."""
    along, across = names
    upright = Guide((ZERO, ZERO), Parameter((), math.pi / 2), along)
    place = {point: (ZERO, ZERO)}
    return (
        Body(name=along, kind=kind, path=path, points={}, guide=Guide(origin, ZERO)),
        Body(name=across, kind=kind, path=path, points=place, guide=upright),
    )


@dataclass(frozen=True)
class GroundPin:
    """A joint fixed to the ground."""

    joint: str
    position: tuple[Parameter, Parameter]


@dataclass(frozen=True)
class Displacement:
    """At ``joint``, the point of ``body`` is called ``renamed`` and reached along ``links``.

    `joint`, `body`, `renamed`: the point of `body` at `joint` is called `renamed`.
    `links`: massless bodies from the joint to that point: one that turns while journal and bearing
    stay in contact, or two that slide along x and y where they may part.
    """

    name: str  # of the clearance
    joint: str
    body: str
    renamed: str
    links: tuple[Body, ...]
    rubbing: Rubbing | None = None  # of a massless link that wears


PLAYING = ("clearance", "offset", "tilt")
"""Kinds of bodies whose coordinates are those of clearances: they are always free."""

GUIDED = "guided"
"""The kind of massless bodies whose coordinates are those of a point that a drive moves."""

UNSEEN = (*PLAYING, GUIDED)
"""Kinds of massless bodies that stand for coordinates, and for no part of the mechanism."""


@dataclass(frozen=True)
class Play:
    """A slider that moves across its guide and turns in it.

    What the slider carries is then the block's, a body of its own; the slider is the place of the
    block along the guide.
    """

    name: str  # of the clearance
    slider: str  # what has room in its guide
    path: KeyPath  # where it stands in the definition file

    @property
    def offset(self) -> str:
        """The massless body that slides across the guide."""
        return f"{self.name}.offset"

    @property
    def tilt(self) -> str:
        """The massless body whose angle is that of the block in the guide."""
        return f"{self.name}.tilt"

    @property
    def block(self) -> str:
        """The body with the mass of the slider."""
        return f"{self.name}.block"


@dataclass(frozen=True)
class Relation:
    """The coordinate of a body follows from others: q = offset + f(Σ ratio·q_other).

    Welds and gears tie angles, racks an angle and a displacement; there f is the sum itself.
    """

    body: str  # a body that turns or slides
    # Other bodies with their ratios. Between angles a ratio of exactly 1 is structure
    parts: tuple[tuple[str, Parameter], ...]
    offset: Parameter  # in radians or metres
    path: KeyPath  # where it stands in the definition file
    # The same for another body, which is taken where something else gives that of `body`
    inverse: Relation | None = None
    # f of a body that slides, a spline over `X`, the sum; None if it is the sum
    profile: Table | None = None


def oriented(relations: Iterable[Relation], known: Collection[str]) -> list[Relation]:
    """Relations as they are taken where the coordinates of some bodies are driven or free.

    One that has an inverse gives the coordinate that nothing else gives, as far as there is one.
    """
    result = list(relations)
    given = {*known, *(relation.body for relation in result if relation.inverse is None)}
    left = [place for place, relation in enumerate(result) if relation.inverse is not None]
    while left:
        place = next((p for p in left if {result[p].body, _back(result[p]).body} & given), left[0])
        left.remove(place)
        own, back = result[place], _back(result[place])
        result[place] = back if own.body in given else replace(own, inverse=None)
        given.add(result[place].body)
    return result


def _back(relation: Relation) -> Relation:
    assert relation.inverse is not None
    return relation.inverse


@dataclass(frozen=True)
class CamSize:
    """What the pressure angle of a cam's follower depends on besides its lift.

    `base`, `roller`: radii of the base circle (None: not known) and of the roller (m).
    """

    slider: str  # the follower, which translates
    base: Parameter | None
    roller: Parameter
    eccentricity: Parameter  # distance of the follower's axis from the cam's pivot (m)
    flat: bool  # whether the follower has a flat face, and neither roller nor knife edge


@dataclass(frozen=True)
class PointMass:
    """A mass concentrated at a joint (kg)."""

    joint: str
    mass: Parameter
    path: KeyPath


@dataclass(frozen=True)
class Prescribed:
    """A coordinate (angle or displacement) that is a given function of time.

    `deviation`: what another program adds to the law, if it does: the names of two internal states,
    the deviation and its rate, and the acceleration that it gives.
    """

    body: str
    law: Function
    path: KeyPath
    deviation: tuple[str, str, Parameter] | None = None


@dataclass(frozen=True)
class Initial:
    """A free coordinate and its state at t = 0, with the paths of both numbers below `path`."""

    body: str
    position: float
    speed: float
    path: KeyPath
    keys: tuple[KeyPath, KeyPath]


@dataclass(frozen=True)
class Gravity:
    """Uniform gravitational acceleration (m/s²)."""

    x: Parameter
    y: Parameter


@dataclass(frozen=True)
class Hint:
    """Where a joint is at t = 0: about there, or on which side."""

    joint: str
    position: tuple[float, float] | None
    side: int | None
    path: KeyPath
