"""Pins that rest against their holes: clearances as short driven bars of any direction."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from linkages.components.clearance import Clearance
from linkages.components.contact_clearance import ContactClearance
from linkages.components.mechanisms.definition import from_document
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.paths import dotted
from linkages.spec.tolerance_zones import ToleranceZone

TURN = f"uniform(0.0, {2.0 * math.pi!r})"
"""How the direction of a pin in its hole is distributed."""


@dataclass(frozen=True)
class HeldClearance:
    """A clearance whose pin rests against the hole in one direction during a motion.

    Parameters
    ----------
    name
        Of the clearance.
    size
        Radial, in metres.
    zone
        Of the size, if it has a tolerance.
    """

    name: str
    size: float
    zone: ToleranceZone | None

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
        """Of the displacement along one direction, in m²: half the mean square of the size."""
        if self.zone is None:
            return 0.5 * self.size**2
        return 0.5 * (self.zone.middle**2 + self.zone.deviation**2)


def clearances_of(mechanism: Mechanism) -> tuple[HeldClearance, ...]:
    """The clearances of pins in holes that a mechanism has."""
    return tuple(
        HeldClearance(each.name, each.size, mechanism.tolerances.get(dotted((*each.path, "size"))))
        for each in mechanism.clearances
    )


def holding(mechanism: Mechanism) -> Mechanism:
    """The mechanism with a driven bar, of the size of the clearance, for every clearance."""
    definition = mechanism.ideal().definition
    content: dict[str, Any] = dict(definition.content)
    for each in mechanism.clearances:
        content = _with_bar(content, each)
    name = {"name": mechanism.name}
    return from_document(replace(definition, content=name | content | name))


def _with_bar(
    content: Mapping[str, Any], clearance: Clearance | ContactClearance
) -> dict[str, Any]:
    name, joint, body = clearance.name, clearance.joint, clearance.bar
    end = f"{joint} {name}"
    bars = dict(content["bars"])
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
