"""Share links of PMKS+, and definitions that grow body by body.

All of a mechanism stands in the query of its link, in sections that end with a point::

    flags . decimals . whole numbers . units . joints … . . links … . . forces … . . selection check

Numbers are whole, to the base 64 of `DIGITS`, a zero before those that are negative, and
thousandths where they are decimal. The last character is the length of what is before it, to the
base 62.

References
----------
.. [1] https://app.pmksplus.com, source and share links of its templates at
   https://github.com/PMKS-Web/PMKSWeb.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote, urlsplit

from linkages.components.mechanisms.definition import loads
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.reading.document import Document
from linkages.reading.overrides import as_yaml
from linkages.spec.units import unit

Point = tuple[float, float]


@dataclass
class Draft:
    """Bodies, joints and what else a definition has, in SI.

    `sliders`, `drives`, `assembly`, `welds`, `clearances`: entries of these sections.
    """

    name: str  # of the mechanism
    joints: dict[str, Point] = field(default_factory=dict)  # fixed ones, with their places
    # Name → joints with their places in the body's own frame; the first two are on its x axis
    bodies: dict[str, dict[str, Point]] = field(default_factory=dict)
    # Body → what else stands in its entry: mass, center, inertia
    weights: dict[str, dict[str, Any]] = field(default_factory=dict)
    sliders: dict[str, dict[str, Any]] = field(default_factory=dict)
    drives: dict[str, dict[str, Any]] = field(default_factory=dict)
    assembly: dict[str, Point] = field(default_factory=dict)
    clearances: dict[str, dict[str, Any]] = field(default_factory=dict)
    loads: list[dict[str, Any]] = field(default_factory=list)  # entries
    gravity: Point | None = None  # if there is any

    def body_with(self, *joints: str) -> str | None:
        """The first body that has all of some joints, if there is one."""
        return next((b for b, own in self.bodies.items() if set(joints) <= set(own)), None)

    def fix(self, body: str, joint: str, first: str, second: str, polar: Point) -> None:
        """Add a joint to a body, by distance and angle from one of its joints towards another."""
        own = self.bodies[body]
        (x, y), (u, v) = own[first], own[second]
        direction = math.atan2(v - y, u - x) + polar[1]
        own[joint] = x + polar[0] * math.cos(direction), y + polar[0] * math.sin(direction)

    def weigh(self, mass_per_length: float) -> None:
        """Give bodies the mass of uniform rods: bars are such, plates have them as outlines."""
        for name, points in self.bodies.items():
            self.weights[name] = _rods([*points.values()], mass_per_length)

    def loosen(self, sizes: Mapping[str, float]) -> None:
        """Give joints clearances of radial sizes in metres; the last body there has the hole."""
        for joint, size in sizes.items():
            holders = [name for name, own in self.bodies.items() if joint in own]
            if not holders:
                known = sorted({name for own in self.bodies.values() for name in own})
                raise ValueError(f"no bar has a joint {joint!r}; expected one of {known}")
            name = f"clearance {joint}"
            self.clearances[name] = {"joint": joint, "bar": holders[-1], "size": size}

    def content(self) -> dict[str, Any]:
        """The content of a definition file."""
        bars = {name: self._bar(name) for name in self.bodies}
        result: dict[str, Any] = {
            "name": self.name,
            "gravity": None if self.gravity is None else list(self.gravity),
            "joints": {name: list(place) for name, place in self.joints.items()},
            "bars": bars,
            "sliders": self.sliders,
            "clearances": self.clearances,
            "drives": self.drives,
            "assembly": {name: list(place) for name, place in self.assembly.items()},
            "loads": self.loads,
        }
        return {key: value for key, value in result.items() if value}

    def mechanism(self) -> Mechanism:
        """The mechanism; raises InputError with what does not fit together."""
        return loads(as_yaml(Document(self.name, self.content(), {})))

    def _bar(self, name: str) -> dict[str, Any]:
        points = self.bodies[name]
        weight = self.weights.get(name, {})
        if len(points) == 2:
            (first, one), (second, other) = points.items()
            return {"joints": [first, second], "length": math.dist(one, other), **weight}
        return {"points": {joint: list(place) for joint, place in points.items()}, **weight}


def named(wanted: str, fallback: str, taken: Iterable[str]) -> str:
    """A name that definitions allow and that nothing else has: of what is wanted, or another."""
    cleaned = re.sub(r"[^\w -]+", " ", wanted).strip(" -_")[:48] or fallback
    names = {*taken, "ground"}
    candidates = [cleaned, *(f"{cleaned} {number}" for number in range(2, len(names) + 3))]
    return next(name for name in candidates if name not in names)


def refused(source: str, message: str) -> InputError:
    """What cannot be expressed."""
    return InputError(source, [Problem(message=message)])


def _rods(points: Sequence[Point], density: float) -> dict[str, Any]:
    """Mass, centre and inertia of uniform rods along an outline."""
    if len(points) == 2:
        return {"mass": density * math.dist(*points)}
    rods = [(p, q, math.dist(p, q)) for p, q in zip(points, [*points[1:], points[0]], strict=True)]
    whole = sum(length for _, _, length in rods)
    x, y = (sum(s * 0.5 * (p[k] + q[k]) for p, q, s in rods) / whole for k in (0, 1))
    inertia = sum(
        s * (s * s / 12 + (0.5 * (p[0] + q[0]) - x) ** 2 + (0.5 * (p[1] + q[1]) - y) ** 2)
        for p, q, s in rods
    )
    return {"mass": density * whole, "center": [x, y], "inertia": density * inertia}


DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-"
CHECKS = DIGITS[:62]

UNITS = (("inch", "lb", "lb*inch**2"), ("cm", "g", "kg*cm**2"), ("m", "kg", "kg*m**2"))
"""Of length, mass and inertia, as PMKS+ shows them, in the order of its settings."""

FORCES = ("lbf", "N")
NAME = "PMKS+ mechanism"

CLOCKWISE, GRAVITY = 1, 2
PRISMATIC, INPUT, GROUNDED, WELDED = 1, 2, 4, 8
ROOTS = "YAMG0123"
"""First characters of links that are no part of another."""


@dataclass(frozen=True)
class _Joint:
    id: str
    name: str
    flags: int
    place: Point
    angle: float
    slot: tuple[str, ...]

    def has(self, flag: int) -> bool:
        return bool(self.flags & flag)


@dataclass(frozen=True)
class _Link:
    id: str
    name: str
    block: bool
    mass: float
    inertia: float
    centre: Point
    joints: tuple[str, ...]


def from_pmks(
    link: str,
    *,
    masses: bool = True,
    mass_per_length: float = 0.0,
    clearances: Mapping[str, float] | None = None,
) -> Mechanism:
    """A mechanism from a share link of PMKS+; the text of the link is all that is needed.

    Parameters
    ----------
    link
        The whole link, or what stands behind its question mark.
    masses
        Whether to take the masses of the link; PMKS+ gives every link one.
    mass_per_length
        Of bars and outlines of plates instead, in kg/m.
    clearances
        Name of a joint → radial size in metres.

    Raises
    ------
    InputError
        If it is no such link, is not whole, or has what a definition cannot express.
    """
    text = _query(link)
    try:
        draft = _Decoded(text).draft(masses=masses)
    except (ValueError, KeyError, IndexError) as fault:
        message = f"a record of the link is not as those of PMKS+ are: {fault}"
        raise refused(NAME, message) from None
    if mass_per_length:
        draft.weigh(mass_per_length)
    draft.loosen(clearances or {})
    return draft.mechanism()


def _query(link: str) -> str:
    text = unquote(urlsplit(link).query or link).strip()
    body, check = text[:-1], text[-1:]
    if text.count(".") < 6:
        raise refused(
            NAME, "expected a share link of PMKS+, such as https://app.pmksplus.com/?2P.…"
        )
    if CHECKS[len(body) % len(CHECKS)] != check:
        raise refused(NAME, "the link is not whole: its last character does not fit its length")
    return body


class _Decoded:
    """What stands in a link, in SI."""

    def __init__(self, text: str) -> None:
        settings, _, rest = text.partition(".")
        decimals, _, rest = rest.partition(".")
        whole, _, rest = rest.partition(".")
        enums, _, rest = rest.partition(".")
        sections = _sections(rest)
        self.flags = _number(settings)
        chosen = UNITS[min(_number(enums[:1] or "2"), len(UNITS) - 1)]
        self.length, self.mass, self.inertia = (unit(text).convert for text in chosen)
        self.force = unit(FORCES[min(_number(enums[2:3] or "1"), 1)]).convert
        self.rpm = float(_number(whole.split(",")[0]))
        steps = decimals.split(",")
        self.linear = self.length(_decimal(steps[1])) if len(steps) > 1 else 0.0
        self.joints = {each.id: each for each in map(self._joint, sections[0])}
        self.links = [each for each in map(self._link, sections[1]) if each is not None]
        self.forces = sections[2]

    def _joint(self, record: str) -> _Joint:
        name, label, x, y, angle, *more = record[1:].split(",")
        place = self.length(_decimal(x)), self.length(_decimal(y))
        slot = tuple(more[:3]) if len(more) >= 3 and all(more[:3]) else ()
        return _Joint(name, label, _number(record[:1]), place, _decimal(angle), slot)

    def _link(self, record: str) -> _Link | None:
        if record[:1] not in ROOTS:
            return None  # a part of a link that is listed itself
        name, label, mass, inertia, x, y, _, *rest = record[2:].split(",")
        joints = tuple(rest[: rest.index("")]) if "" in rest else tuple(rest)
        centre = self.length(_decimal(x)), self.length(_decimal(y))
        return _Link(
            name, label, record[1:2] == "P", self.mass(_decimal(mass)),
            self.inertia(_decimal(inertia)), centre, joints,
        )  # fmt: skip

    def draft(self, masses: bool) -> Draft:
        """The definition."""
        result = Draft(NAME, gravity=(0.0, -9.81) if self.flags & GRAVITY else None)
        names: dict[str, str] = {}
        for each in self.joints.values():
            names[each.id] = named(each.name, each.id, names.values())
            if each.has(GROUNDED) and not each.has(PRISMATIC):
                result.joints[names[each.id]] = each.place
        bodies = _Bodies(self, result, names)
        for link in self.links:
            if not link.block:
                bodies.add(link, masses)
        for link in self.links:
            if link.block:
                bodies.slide(link, masses)
        bodies.drive()
        for record in self.forces:
            bodies.load(record)
        shared = [name for own in result.bodies.values() for name in own]
        shared += [str(each["joint"]) for each in result.sliders.values()]
        for each in self.joints.values():
            name = names[each.id]
            if not each.has(GROUNDED | PRISMATIC) and shared.count(name) > 1:
                result.assembly[name] = each.place
        return result


class _Bodies:
    """Links, sliders, drives and forces on their way into a draft."""

    def __init__(self, decoded: _Decoded, draft: Draft, names: Mapping[str, str]) -> None:
        self._from, self._draft, self._names = decoded, draft, names
        self._frames: dict[str, tuple[str, Point, float]] = {}
        self._blocks: dict[str, str] = {}

    def add(self, link: _Link, masses: bool) -> None:
        """A bar or plate; its x axis goes through its first two joints."""
        joints = [self._from.joints[name] for name in link.joints]
        if len(joints) < 2:
            raise refused(NAME, f"link {link.name} has {len(joints)} joint; expected two or more")
        first, second = joints[0].place, joints[1].place
        angle = math.atan2(second[1] - first[1], second[0] - first[0])
        body = named(link.name, link.id, self._draft.bodies)
        self._frames[link.id] = body, first, angle
        places = {self._names[each.id]: self._local(link.id, each.place) for each in joints}
        self._draft.bodies[body] = places
        if masses and link.mass:
            centre = list(self._local(link.id, link.centre))
            weight = {"mass": link.mass, "center": centre, "inertia": link.inertia}
            self._draft.weights[body] = weight

    def _local(self, link: str, place: Point) -> Point:
        _, (x, y), angle = self._frames[link]
        dx, dy = place[0] - x, place[1] - y
        c, s = math.cos(angle), math.sin(angle)
        return c * dx + s * dy, c * dy - s * dx

    def slide(self, link: _Link, masses: bool) -> None:
        """A block between a pin and a guide on the ground or on a link."""
        pair = [self._from.joints[name] for name in link.joints]
        guides = [each for each in pair if each.has(PRISMATIC)]
        pins = [each for each in pair if not each.has(PRISMATIC)]
        if len(guides) != 1 or len(pins) != 1:
            raise refused(NAME, f"block {link.name}: expected a pin and a guide")
        (guide,), (pin,) = guides, pins
        if pin.has(WELDED):
            message = f"joint {pin.name} is welded to its block; a block with a pin can be imported"
            raise refused(NAME, message)
        taken = [*self._draft.bodies, *self._draft.sliders]
        block = named(f"slider {self._names[pin.id]}", "slider", taken)
        entry: dict[str, Any] = {"joint": self._names[pin.id]}
        if guide.slot:
            carrier, one, other = guide.slot
            body = self._frames[carrier][0]
            (x, y), (u, v) = (
                self._local(carrier, self._from.joints[name].place) for name in (one, other)
            )
            angle = math.atan2(v - y, u - x)
            entry |= {"on": body, "through": self._names[one], "angle": angle}
        else:
            entry |= {"through": list(guide.place), "angle": guide.angle}
        if masses and link.mass:
            entry["mass"] = link.mass
        self._draft.sliders[block] = entry
        self._blocks[guide.id] = block

    def drive(self) -> None:
        """The input: a grounded pin that turns its link, or a guide along which a block moves."""
        inputs = [each for each in self._from.joints.values() if each.has(INPUT)]
        for each in inputs:
            if each.has(PRISMATIC):
                at = 0.0
                if each.slot:
                    at = math.dist(each.place, self._from.joints[each.slot[1]].place)
                speed = self._from.linear * self._sign
                self._draft.drives[self._blocks[each.id]] = {"position": at, "speed": speed}
                continue
            driven = [link for link in self._from.links if each.id in link.joints]
            if not each.has(GROUNDED) or len(driven) != 1:
                raise refused(
                    NAME,
                    f"joint {each.name} drives {len(driven)} links against each other; expected "
                    "an input on the ground, with one link",
                )
            body, _, angle = self._frames[driven[0].id]
            speed = self._sign * self._from.rpm * 2.0 * math.pi / 60.0
            self._draft.drives[body] = {"angle": angle, "speed": speed}

    @property
    def _sign(self) -> float:
        return -1.0 if self._from.flags & CLOCKWISE else 1.0

    def load(self, record: str) -> None:
        """A force at a point of a link."""
        flags, fields = _number(record[:1]), record[1:].split(",")
        name, link, label = fields[:3]
        x, y, u, v, size = map(_decimal, fields[3:8])
        length, outwards = math.hypot(u - x, v - y), 1.0 if flags & 2 else -1.0
        if not length > 0.0:
            raise refused(NAME, f"force {label or name} has no direction")
        factor = outwards * self._from.force(size) / length
        body, _, angle = self._frames[link]
        place = self._local(link, (self._from.length(x), self._from.length(y)))
        own = self._draft.bodies[body]
        point = next((joint for joint, at in own.items() if math.dist(at, place) < 1e-9), None)
        if point is None:
            point = named(label, name, [*self._names.values(), *own])
            own[point] = place
        force = factor * (u - x), factor * (v - y)
        if flags & 1:  # it turns with the link
            c, s = math.cos(angle), math.sin(angle)
            force = c * force[0] + s * force[1], c * force[1] - s * force[0]
            self._draft.loads.append({"joint": point, "on": body, "force": list(force)})
        else:
            self._draft.loads.append({"joint": point, "force": list(force)})


def _sections(text: str) -> list[list[str]]:
    """Records of joints, links and forces: each ends with a point, each section with another."""
    result: list[list[str]] = []
    for _ in range(3):
        records: list[str] = []
        while text and not text.startswith("."):
            record, _, text = text.partition(".")
            records.append(record)
        result.append(records)
        text = text[1:]
    return result


def _number(text: str) -> int:
    negative = text.startswith("0") and len(text) > 1
    value = 0
    for letter in text:
        digit = DIGITS.find(letter)
        if digit < 0:
            raise refused(NAME, f"{text!r} is no number of a share link")
        value = value * len(DIGITS) + digit
    return -value if negative else value


def _decimal(text: str) -> float:
    return _number(text) / 1000
