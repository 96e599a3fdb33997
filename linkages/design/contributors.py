"""Sources of variation: tolerances, journals in bearings, blocks in guides."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from linkages.components.joint_clearances import Clearance, ContactClearance, GuideClearance
from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.registry import unit_at
from linkages.reading.paths import dotted
from linkages.spec.conversion import ToleranceZone

Floats = NDArray[np.float64]
Room: TypeAlias = Clearance | ContactClearance | GuideClearance

TURN = f"uniform(0.0, {2.0 * math.pi!r})"
"""How the direction of a journal in its bearing is distributed."""


@dataclass(frozen=True)
class HeldClearance:
    """A clearance whose journal or block rests in one direction during a motion."""

    name: str  # of the clearance
    size: float  # radial, in metres
    zone: ToleranceZone | None  # of the size, if it has a tolerance
    # Direction across the guide of a block, in radians; None for a pin, which rests anywhere
    across: float | None = None

    @property
    def path(self) -> str:
        """Where the definition has the clearance."""
        return dotted(("clearances", self.name))

    @property
    def size_path(self) -> str:
        """Where the mechanism that is varied has the size."""
        return dotted(("bars", self.name, "length"))

    @property
    def angle_path(self) -> str:
        """Where it has the direction, from the pin to the middle of the hole."""
        return dotted(("drives", self.name, "angle"))

    @property
    def largest(self) -> float:
        """The largest size, in metres."""
        return self.size if self.zone is None else self.zone.high

    @property
    def variance(self) -> float:
        """In m², along a direction: the mean square of the size for a block, half for a pin."""
        share = 0.5 if self.across is None else 1.0
        if self.zone is None:
            return share * self.size**2
        return share * (self.zone.middle**2 + self.zone.deviation**2)

    @property
    def turned(self) -> str:
        """How its direction is distributed: over the full circle, or to one wall or the other."""
        if self.across is None:
            return TURN
        return f"either({self.across!r}, {self.across + math.pi!r})"

    def felt(self, pushes: Floats) -> Floats:
        """The part of derivatives by displacements, shape (…, 2), along what it can take."""
        if self.across is None:
            return pushes
        way = np.array([math.cos(self.across), math.sin(self.across)])
        return (pushes @ way)[..., None] * way


def with_room(mechanism: Mechanism) -> tuple[Room, ...]:
    """All clearances of a mechanism, of pins and of blocks."""
    guides = (each for each in mechanism.opening if isinstance(each, GuideClearance))
    return (*mechanism.clearances, *guides)


def clearances_of(mechanism: Mechanism) -> tuple[HeldClearance, ...]:
    """The clearances that a mechanism has: of journals, and of blocks in guides that stand."""
    result = []
    for each in with_room(mechanism):
        if isinstance(each, ContactClearance) and each.profile is not None:
            message = "a journal held in a bearing that is not round is no bar; expected no profile"
            raise mechanism.error([((*each.path, "profile"), message)])
        across = None
        if isinstance(each, GuideClearance):
            guide = mechanism.definition.value(("sliders", each.slider))
            if guide.get("on") is not None:
                continue  # what carries the guide turns, and the wall with it
            body = mechanism.bodies[each.slider].guide
            assert body is not None
            across = body.angle.value + math.pi / 2
        zone = mechanism.tolerances.get(dotted((*each.path, "size")))
        result.append(HeldClearance(each.name, each.size, zone, across))
    return tuple(result)


def holding(mechanism: Mechanism) -> Mechanism:
    """The mechanism with a driven bar, of the size of the clearance, for every clearance."""
    definition = mechanism.ideal().definition
    content: dict[str, Any] = dict(definition.content)
    held = {each.name for each in clearances_of(mechanism)}
    for each in with_room(mechanism):
        if each.name in held:
            content = _with_bar(content, each)
    name = {"name": mechanism.name}
    return from_document(replace(definition, content=name | content | name))


def _with_bar(content: Mapping[str, Any], clearance: Room) -> dict[str, Any]:
    name, bars = clearance.name, dict(content["bars"])
    if isinstance(clearance, GuideClearance):
        body = clearance.slider
        joint = content["sliders"][body]["joint"]
        end = f"{joint} {name}"
        sliders = {**content["sliders"], body: {**content["sliders"][body], "joint": end}}
        content = {**content, "sliders": sliders}
    else:
        joint, body = clearance.joint, clearance.bar
        end = f"{joint} {name}"
        bars[body] = _renamed(bars[body], joint, end)
    bars[name] = {"joints": [joint, end], "length": clearance.size}
    drives = {**(content.get("drives") or {}), name: {"angle": 0.0, "speed": 0.0}}
    lists = {
        key: [_moved(entry, body, joint, end) for entry in entries]
        for key, entries in content.items()
        if isinstance(entries, list) and key != "gravity"
    }
    return {**content, **lists, "bars": bars, "drives": drives}


def _renamed(entry: Mapping[str, Any], joint: str, end: str) -> dict[str, Any]:
    """A bar or plate whose point has another name."""
    result = dict(entry)
    if isinstance(result.get("joints"), Sequence):
        result["joints"] = [end if name == joint else name for name in result["joints"]]
    if isinstance(result.get("points"), Mapping):
        result["points"] = {end if k == joint else k: at for k, at in result["points"].items()}
    return result


def _moved(entry: Any, body: str, joint: str, end: str) -> Any:
    """A load that acts on the body at the joint acts on its hole."""
    acts = isinstance(entry, dict) and entry.get("joint") == joint and entry.get("on") == body
    return {**entry, "joint": end} if acts else entry


@dataclass(frozen=True)
class Contributors:
    """What varies from one copy of a mechanism to the next."""

    mechanism: Mechanism  # as it is defined
    # Path → zone of its numbers with a tolerance; not those of clearances
    zones: dict[str, ToleranceZone]
    # Journals that rest against their bearings, and blocks against the walls of their guides
    clearances: tuple[HeldClearance, ...]

    @property
    def names(self) -> list[str]:
        """Paths of the definition: numbers, then clearances."""
        return [*self.zones, *(each.path for each in self.clearances)]

    @property
    def units(self) -> list[str]:
        """SI unit of each."""
        own = [unit_at(self.mechanism.definition, path) for path in self.zones]
        return own + ["m"] * len(self.clearances)

    @cached_property
    def nominal(self) -> Mechanism:
        """The mechanism that errors are against: without clearances."""
        return self.mechanism.ideal() if self.clearances else self.mechanism

    @cached_property
    def varied(self) -> Mechanism:
        """The mechanism that is varied."""
        return holding(self.mechanism) if self.clearances else self.mechanism

    @property
    def distributions(self) -> dict[str, str]:
        """Path of `varied` → distribution of its number, in SI."""
        result = {path: distribution(zone) for path, zone in self.zones.items()}
        for each in self.clearances:
            result[each.angle_path] = each.turned
            if each.zone is not None:
                result[each.size_path] = distribution(each.zone)
        return result

    @cached_property
    def middles(self) -> Floats:
        """Means of the numbers less what they are nominally, shape (numbers,)."""
        return np.array([zone.middle - zone.nominal for zone in self.zones.values()])

    @cached_property
    def halves(self) -> Floats:
        """Half of each zone, and the largest size of each clearance, shape (contributors,)."""
        return np.array(
            [
                *(zone.half for zone in self.zones.values()),
                *(each.largest for each in self.clearances),
            ]
        )

    @cached_property
    def deviations(self) -> Floats:
        """Standard deviations; of the displacement along a direction for clearances."""
        zones = [zone.deviation for zone in self.zones.values()]
        return np.array([*zones, *(each.variance**0.5 for each in self.clearances)])

    def overrides(self, offsets: Floats, shifts: Floats) -> dict[str, float]:
        """Numbers of `varied` for offsets, (numbers,), and shifts of pins, (clearances, 2)."""
        result = {
            path: zone.nominal + float(offset)
            for (path, zone), offset in zip(self.zones.items(), offsets, strict=True)
        }
        for each, (x, y) in zip(self.clearances, shifts, strict=True):
            result[each.size_path] = float(np.hypot(x, y))
            result[each.angle_path] = float(np.arctan2(y, x))
        return result

    def drawn(self, values: dict[str, Floats]) -> tuple[Floats, Floats]:
        """Deviations of draws as `overrides` takes them, (draws, …), from values by path."""
        count = len(next(iter(values.values())))
        offsets = [values[path] - zone.nominal for path, zone in self.zones.items()]
        shifts = np.empty((count, len(self.clearances), 2))
        for k, each in enumerate(self.clearances):
            size = values.get(each.size_path, np.full(count, each.size))
            angle = values[each.angle_path]
            shifts[:, k] = np.stack([size * np.cos(angle), size * np.sin(angle)], axis=1)
        return np.array(offsets).reshape(len(self.zones), count).T, shifts


def contributors_of(mechanism: Mechanism) -> Contributors:
    """All that varies of a mechanism."""
    clearances = clearances_of(mechanism)
    sections = [dotted(each.path) for each in with_room(mechanism)]
    zones = {
        path: zone
        for path, zone in mechanism.tolerances.items()
        if not any(path.startswith(f"{section}.") for section in sections)
    }
    if not zones and not clearances:
        raise ValueError(
            "nothing varies: no number of the definition has a tolerance; expected for example "
            "length: 140 ± 0.05 mm, or a clearance"
        )
    return Contributors(mechanism, zones, clearances)


def distribution(zone: ToleranceZone) -> str:
    """A zone in the words of sweeps."""
    match zone.distribution:
        case "normal":
            return f"normal({zone.middle!r}, {zone.deviation!r})"
        case "uniform":
            return f"uniform({zone.low!r}, {zone.high!r})"
        case _:
            return f"triangular({zone.low!r}, {zone.middle!r}, {zone.high!r})"
