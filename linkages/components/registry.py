"""Which component stands in which section of a definition file: one line each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from linkages.components.assembly import AssemblyHint
from linkages.components.bar import Bar
from linkages.components.clearance import Clearance
from linkages.components.component import Component
from linkages.components.drive import Drive
from linkages.components.free import FreeAngle, FreePosition
from linkages.components.gravity import UniformGravity
from linkages.components.ground import GroundJoint
from linkages.components.load import SliderForce
from linkages.components.plate import Plate
from linkages.components.simulation import SimulationDefaults
from linkages.components.slider import Slider


@dataclass(frozen=True)
class Section:
    """How a section of the definition file is read.

    Parameters
    ----------
    form
        ``"mapping"`` of names to entries, ``"list"`` of entries, or a single ``"value"``.
    choose
        Entry as found → the component class that describes it.
    field
        The field that takes an entry which is not a mapping of keys (a position, a vector).
    example
        What an entry looks like, for messages.
    """

    form: Literal["mapping", "list", "value"]
    choose: Callable[[Any], type[Component]]
    example: str
    field: str | None = None


def _has(key: str, raw: object) -> bool:
    return isinstance(raw, dict) and key in raw


SECTIONS: dict[str, Section] = {
    "gravity": Section("value", lambda _: UniformGravity, "[9.81, 0]", field="acceleration"),
    "joints": Section("mapping", lambda _: GroundJoint, "O: [0, 0]", field="position"),
    "bars": Section(
        "mapping",
        lambda raw: Plate if _has("points", raw) else Bar,
        "crank: {joints: [O, A], length: 0.3}",
    ),
    "sliders": Section("mapping", lambda _: Slider, "piston: {joint: B, through: O}"),
    "clearances": Section("mapping", lambda _: Clearance, "r1: {joint: A, bar: rod, size: 0.1 mm}"),
    "drives": Section("mapping", lambda _: Drive, "crank: {angle: 0, speed: 60 rpm}"),
    "free": Section(
        "mapping",
        lambda raw: FreePosition if _has("position", raw) else FreeAngle,
        "crank: {angle: 0.1, speed: 0}",
    ),
    "assembly": Section("mapping", lambda _: AssemblyHint, "B: left", field="where"),
    "loads": Section("list", lambda _: SliderForce, "{slider: piston, force: -100}"),
    "simulate": Section("value", lambda _: SimulationDefaults, "{end: 2, samples: 2001}"),
}
