"""Journals in bearings, and blocks against a wall: clearances as short driven bars."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from linkages.components.clearance import Clearance
from linkages.components.contact_clearance import ContactClearance
from linkages.components.guide_clearance import GuideClearance
from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.paths import dotted
from linkages.spec.tolerance_zones import ToleranceZone

Floats = NDArray[np.float64]
Room: TypeAlias = Clearance | ContactClearance | GuideClearance

TURN = f"uniform(0.0, {2.0 * math.pi!r})"
"""How the direction of a journal in its bearing is distributed."""


@dataclass(frozen=True)
class HeldClearance:
    """A clearance whose journal or block rests in one direction during a motion.

    Parameters
    ----------
    name
        Of the clearance.
    size
        Radial, in metres.
    zone
        Of the size, if it has a tolerance.
    across
        Direction across the guide of a block, in radians; None for a pin, which rests anywhere.
    """

    name: str
    size: float
    zone: ToleranceZone | None
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
        """Of the displacement along a direction that it can take, in m².

        The mean square of the size for a block, and half of that for a pin.
        """
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
    found = []
    for each in with_room(mechanism):
        across = None
        if isinstance(each, GuideClearance):
            guide = mechanism.definition.value(("sliders", each.slider))
            if guide.get("on") is not None:
                continue  # what carries the guide turns, and the wall with it
            body = mechanism.bodies[each.slider].guide
            assert body is not None
            across = body.angle.value + math.pi / 2
        zone = mechanism.tolerances.get(dotted((*each.path, "size")))
        found.append(HeldClearance(each.name, each.size, zone, across))
    return tuple(found)


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
    found = dict(entry)
    if isinstance(found.get("joints"), Sequence):
        found["joints"] = [end if name == joint else name for name in found["joints"]]
    if isinstance(found.get("points"), Mapping):
        found["points"] = {end if k == joint else k: at for k, at in found["points"].items()}
    return found


def _moved(entry: Any, body: str, joint: str, end: str) -> Any:
    """A load that acts on the body at the joint acts on its hole."""
    acts = isinstance(entry, dict) and entry.get("joint") == joint and entry.get("on") == body
    return {**entry, "joint": end} if acts else entry
