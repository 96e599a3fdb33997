"""A block that slides on an axis of the ground or of another body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field, model_validator

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import ZERO, Body, Guide, Origin, Parameter, Path
from linkages.spec.quantities import Angle, Inertia, Mass, Name, Point


@component
class Slider(Component):
    """A block that moves along a straight axis, and turns only with the body that carries it.

    Parameters
    ----------
    name
        Slider name.
    joint
        The joint carried by the block; it lies on the axis.
    through
        A point that the axis goes through; positions count from there. On the ground: a ground
        joint or [x, y]. On a body: a joint of it, or [x, y] in its frame; its origin if not given.
    angle
        Direction of the axis in radians, in the frame of what carries it.
    on
        The bar, plate or slider that carries the axis; the ground if not given.
    mass
        Kilograms, at the joint.
    inertia
        About the joint in kg·m².
    points
        Further joints of the block, in metres along and across its axis, from its joint.
    """

    section: ClassVar[str] = "sliders"
    misplaced: ClassVar[Mapping[str, str]] = {
        "length": "a slider has no length; for a cylinder write its barrel as a bar and its rod as "
        "a slider 'on' it, whose 'position' under 'drives' is the distance of its two joints"
    }

    name: Name
    joint: Name
    through: Name | Point | None = None
    angle: Angle = 0.0
    on: Name | None = None
    mass: Mass = 0.0
    inertia: Inertia = 0.0
    points: dict[Name, Point] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _has_an_axis(self) -> Any:
        if self.on is None and self.through is None:
            message = "expected a ground joint or a point [x, y] that the axis goes through"
            raise ValueError(f"missing key 'through': {message}")
        return self

    def problems(self) -> tuple[tuple[Path, str], ...]:
        """Points apart from each other."""
        found: list[tuple[Path, str]] = []
        places = {(0.0, 0.0): self.joint}
        for joint, place in self.points.items():
            where = (*self.path, "points", joint)
            if joint == self.joint:
                found.append((where, f"{joint!r} is the slider's joint, at [0, 0]"))
            elif place in places:
                found.append((where, f"{joint!r} lies on {places[place]!r}; expected two places"))
            places.setdefault(place, joint)
        return tuple(found)

    def references(self) -> References:
        """What carries the axis, and the joint that the axis goes through."""
        through = (*self.path, "through")
        carrier = ((*self.path, "on"), self.on, ("bar", "plate", "slider")) if self.on else None
        joint = self.through if isinstance(self.through, str) else None
        return References(
            ground=((through, joint),) if joint and not self.on else (),
            bodies=(carrier,) if carrier else (),
            points=((through, self.on, joint),) if joint and self.on else (),
        )

    def terms(self) -> tuple[Body, ...]:
        """One body that slides."""
        origin: Origin = (ZERO, ZERO)
        if isinstance(self.through, str):
            origin = self.through
        elif self.through is not None:
            origin = self.pair(self.through, "through")
        further = {name: self.pair(place, "points", name) for name, place in self.points.items()}
        return (
            Body(
                name=self.name,
                kind="slider",
                path=self.path,
                points={self.joint: (ZERO, ZERO), **further},
                mass=self.number("mass"),
                inertia=self.number("inertia"),
                guide=Guide(origin, Parameter((*self.path, "angle"), self.angle), self.on),
            ),
        )
