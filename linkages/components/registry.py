"""Which component stands in which section of a definition file: one line each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from linkages.components.assembly import AssemblyHint
from linkages.components.bar import Bar
from linkages.components.clearance import Clearance
from linkages.components.component import Component
from linkages.components.damper import GuideDamper, LineDamper
from linkages.components.drive import Drive, SliderDrive
from linkages.components.free import FreeAngle, FreePosition
from linkages.components.gear import Gear
from linkages.components.gravity import UniformGravity
from linkages.components.ground import GroundJoint
from linkages.components.load import JointForce, SliderForce
from linkages.components.mass import JointMass
from linkages.components.plate import Plate
from linkages.components.simulation import SimulationDefaults
from linkages.components.slider import Slider
from linkages.components.spring import JointSpring
from linkages.components.torque import BarTorque, TorqueBetweenBars
from linkages.components.torsional_damper import (
    ClearanceDamper,
    DamperBetweenBars,
    JointDamper,
)
from linkages.components.torsional_spring import BarSpring, SpringBetweenBars
from linkages.components.weld import Weld


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
    for_sliders
        The component of an entry that bears the name of a slider, where keys do not tell.
    """

    form: Literal["mapping", "list", "value"]
    choose: Callable[[Any], type[Component]]
    example: str
    field: str | None = None
    for_sliders: type[Component] | None = None

    @property
    def given(self) -> tuple[str, ...]:
        """Fields of a component that do not stand in its entry."""
        return {"mapping": ("name",), "list": ("index",), "value": ()}[self.form]

    @property
    def models(self) -> tuple[type[Component], ...]:
        """All components that an entry may be."""
        choose = self.choose
        return choose.models if isinstance(choose, _ByKey) else (choose(None),)


def _has(key: str, raw: object) -> bool:
    return isinstance(raw, dict) and key in raw


class _ByKey:
    """Chooses the component of the first key that an entry has."""

    def __init__(self, otherwise: type[Component], *choices: tuple[str, type[Component]]) -> None:
        self.otherwise = otherwise
        self.choices = choices

    def __call__(self, raw: object) -> type[Component]:
        return next((model for key, model in self.choices if _has(key, raw)), self.otherwise)

    @property
    def models(self) -> tuple[type[Component], ...]:
        return (self.otherwise, *(model for _, model in self.choices))


SECTIONS: dict[str, Section] = {
    "gravity": Section("value", lambda _: UniformGravity, "[9.81, 0]", field="acceleration"),
    "joints": Section("mapping", lambda _: GroundJoint, "O: [0, 0]", field="position"),
    "bars": Section(
        "mapping", _ByKey(Bar, ("points", Plate)), "crank: {joints: [O, A], length: 0.3}"
    ),
    "sliders": Section("mapping", lambda _: Slider, "piston: {joint: B, through: O}"),
    "clearances": Section("mapping", lambda _: Clearance, "r1: {joint: A, bar: rod, size: 0.1 mm}"),
    "masses": Section("mapping", lambda _: JointMass, "A: 2 kg", field="mass"),
    "welds": Section("mapping", lambda _: Weld, "A: {bars: [crank, rod], angle: 30 deg}"),
    "gears": Section("list", lambda _: Gear, "{bars: [crank, rod], ratio: -2}"),
    "drives": Section(
        "mapping",
        _ByKey(Drive, ("position", SliderDrive)),
        "crank: {angle: 0, speed: 60 rpm}",
        for_sliders=SliderDrive,
    ),
    "free": Section(
        "mapping", _ByKey(FreeAngle, ("position", FreePosition)), "crank: {angle: 0.1, speed: 0}"
    ),
    "assembly": Section("mapping", lambda _: AssemblyHint, "B: left", field="where"),
    "loads": Section(
        "list",
        _ByKey(
            SliderForce,
            ("joint", JointForce),
            ("bars", TorqueBetweenBars),
            ("bar", BarTorque),
        ),
        "{slider: piston, force: -100}",
    ),
    "springs": Section(
        "list",
        _ByKey(JointSpring, ("between_bars", SpringBetweenBars), ("bar", BarSpring)),
        "{between: [O, B], stiffness: 4530, length: 0.08}",
    ),
    "dampers": Section(
        "list",
        _ByKey(
            LineDamper,
            ("joint", JointDamper),
            ("bars", DamperBetweenBars),
            ("slider", GuideDamper),
            ("clearance", ClearanceDamper),
        ),
        "{joint: A, damping: 0.1}",
    ),
    "simulate": Section("value", lambda _: SimulationDefaults, "{end: 2, samples: 2001}"),
}
