"""A definition that grows body by body, from programs that know points and distances."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from linkages.components.mechanisms.definition import loads
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.reading.document import Document
from linkages.reading.writing import as_yaml

Point = tuple[float, float]


@dataclass
class Draft:
    """Bodies, joints and what else a definition has, in SI.

    Parameters
    ----------
    name
        Of the mechanism.
    joints
        Fixed ones, with their places.
    bodies
        Name → joints with their places in the body's own frame; the first two are on its x axis.
    weights
        Body → what else stands in its entry: mass, center, inertia.
    sliders, drives, assembly, welds, clearances
        Entries of these sections.
    loads
        Entries.
    gravity
        If there is any.
    """

    name: str
    joints: dict[str, Point] = field(default_factory=dict)
    bodies: dict[str, dict[str, Point]] = field(default_factory=dict)
    weights: dict[str, dict[str, Any]] = field(default_factory=dict)
    sliders: dict[str, dict[str, Any]] = field(default_factory=dict)
    drives: dict[str, dict[str, Any]] = field(default_factory=dict)
    assembly: dict[str, Point] = field(default_factory=dict)
    clearances: dict[str, dict[str, Any]] = field(default_factory=dict)
    loads: list[dict[str, Any]] = field(default_factory=list)
    gravity: Point | None = None

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
        """Give joints clearances of some radial sizes, in metres; the last body there has the hole.

        Raises
        ------
        ValueError
            If there is no such joint.
        """
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
        found: dict[str, Any] = {
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
        return {key: value for key, value in found.items() if value}

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
