"""Mechanisms that grow joint by joint, each at a known place, so that they can be assembled.

Joints are placed first, lengths follow from the places. What to place where is asked of a `Draw`:
hypothesis draws numbers that can shrink, a random generator draws many quickly.
"""

import cmath
from dataclasses import dataclass, field
from typing import Any, Protocol


class Draw(Protocol):
    """Where random numbers come from."""

    def number(self, low: float, high: float) -> float: ...

    def choice(self, options: list) -> Any: ...


def xy(place: complex) -> tuple[float, float]:
    return (place.real, place.imag)


@dataclass
class Growing:
    """A mechanism so far: its definition, and where everything is at t = 0.

    Parameters
    ----------
    definition
        In the form of a definition file, all numbers SI.
    places, angles
        Joints (displaced ends of bars too) and bodies that turn at t = 0.
    """

    draw: Draw
    clearance_share: float = 0.15
    definition: dict[str, Any] = field(default_factory=lambda: {"joints": {}, "bars": {}})
    places: dict[str, complex] = field(default_factory=dict)
    angles: dict[str, float] = field(default_factory=dict)

    def section(self, name: str) -> dict[str, Any]:
        return self.definition.setdefault(name, {})

    def name(self, letter: str, section: str) -> str:
        return f"{letter}{len(self.section(section)) + 1}"

    def chance(self, share: float) -> bool:
        return self.draw.number(0.0, 1.0) > 1.0 - share

    def ground_pin(self, place: complex) -> str:
        name = self.name("G", "joints")
        self.section("joints")[name] = xy(place)
        self.places[name] = place
        return name

    def joint(self, place: complex, hint: bool = True) -> str:
        """A new joint; a hint is right to about a tenth of a millimetre."""
        name = f"J{sum(label.startswith('J') and '.' not in label for label in self.places) + 1}"
        self.places[name] = place
        if hint:
            self.section("assembly")[name] = (round(place.real, 4), round(place.imag, 4))
        return name

    def some_joint(self) -> str:
        return self.draw.choice([label for label in self.places if "." not in label])

    def moving_joint(self) -> str:
        """One that is not on the ground (welds hold some of them still nevertheless)."""
        ground = self.definition["joints"]
        return self.draw.choice([n for n in self.places if "." not in n and n not in ground])

    def second_joint(self, first: str) -> str:
        """A joint at some distance from another one: an old one, or a new pin on the ground."""
        near = self.places[first]
        old = [n for n, p in self.places.items() if "." not in n and 0.4 < abs(p - near) < 2.0]
        if old and not self.chance(0.3):
            return self.draw.choice(old)
        return self.ground_pin(near + self.polar(0.6, 1.5))

    def polar(self, low: float, high: float) -> complex:
        """A vector of a length within bounds, in any direction."""
        return cmath.rect(self.draw.number(low, high), self.draw.number(-3.0, 3.0))

    def end(self, bar: str, joint: str) -> complex:
        """Where a bar that comes to a joint has its end: there, or a clearance away from it."""
        place = self.places[joint]
        if not self.chance(self.clearance_share):
            return place
        name = self.name("c", "clearances")
        size = self.draw.choice([0.02, 0.001, 0.0001])
        entry = {"joint": joint, "bar": bar, "size": size}
        entry |= {"angle": self.draw.number(-3.0, 3.0), "speed": self.draw.number(-4.0, 4.0)}
        self.section("clearances")[name] = entry
        self.angles[name] = entry["angle"]
        self.places[f"{joint}.{name}"] = place + cmath.rect(size, entry["angle"])
        return self.places[f"{joint}.{name}"]

    def bar(
        self,
        first: str,
        second: str,
        *,
        shared: tuple[bool, bool] = (True, False),
        mass: bool = True,
    ) -> str:
        """A new bar or plate between two joints.

        Where other bodies are at a joint already (`shared`), it may have a clearance there.
        """
        name = f"b{len(self.definition['bars']) + 1}"
        self.definition["bars"][name] = {}
        ends = [
            self.end(name, joint) if taken else self.places[joint]
            for joint, taken in zip((first, second), shared, strict=True)
        ]
        joints = [first, second]
        if self.chance(0.3):
            joints, ends = joints[::-1], ends[::-1]
        vector = ends[1] - ends[0]
        heavy = {"mass": self.draw.number(0.2, 3.0)} if mass else {}
        if self.chance(0.3):
            self.definition["bars"][name] = self._plate(name, joints, ends, heavy)
            return name
        if heavy and self.chance(0.5):
            offset = self.draw.number(0.2, 0.8), self.draw.number(-0.3, 0.3)
            heavy["center"] = tuple(abs(vector) * part for part in offset)
            heavy["inertia"] = heavy["mass"] * self.draw.number(0.02, 0.2)
        self.definition["bars"][name] = {"joints": joints, "length": abs(vector), **heavy}
        self.angles[name] = cmath.phase(vector)
        return name

    def _plate(self, name: str, joints: list[str], ends: list[complex], heavy: dict) -> dict:
        """A plate with one point more, in a frame that lies anywhere."""
        angle = self.draw.number(-3.0, 3.0)
        origin = ends[0] if self.chance(0.5) else ends[0] + self.polar(0.1, 0.5)
        part = complex(self.draw.number(0.2, 0.8), self.draw.number(0.2, 0.6))
        extra = ends[0] + (ends[1] - ends[0]) * part
        local = [xy((place - origin) * cmath.exp(-1j * angle)) for place in (*ends, extra)]
        points = dict(zip((*joints, self.joint(extra, hint=False)), local, strict=True))
        if heavy:
            heavy["center"] = tuple(sum(values) / 3 for values in zip(*local, strict=True))
            heavy["inertia"] = heavy["mass"] * self.draw.number(0.02, 0.2)
        self.angles[name] = angle
        return {"points": points, **heavy}
