"""Motors that prescribe the angle of a bar or the position of a slider."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import model_validator

from linkages.components.contributed.component import Component, component
from linkages.components.contributed.functions import Function, linear
from linkages.components.contributed.references import References
from linkages.components.contributed.terms import Parameter, Path, Prescribed
from linkages.components.laws.law import AngleLaw, Law, LengthLaw, function_of
from linkages.spec.quantities import Angle, AngularSpeed, Length, Name, Speed


@component
class Drive(Component):
    """Turns a bar or plate: θ = angle + speed·t, or by another law of time.

    Parameters
    ----------
    name
        The bar or plate that is driven against the ground.
    angle
        Angle at t = 0 in radians.
    speed
        Angular speed in rad/s.
    law
        Angle as a function of time, in the place of angle and speed.
    """

    section: ClassVar[str] = "drives"

    name: Name
    angle: Angle | None = None
    speed: AngularSpeed | None = None
    law: AngleLaw | None = None

    @model_validator(mode="after")
    def _one_law(self) -> Any:
        _check("angle", self.angle, self.speed, self.law)
        return self

    def references(self) -> References:
        """The driven bar."""
        return References(bodies=((self.path, self.name, ("bar", "plate")),))

    def terms(self) -> tuple[Prescribed, ...]:
        """One prescribed coordinate."""
        law = _function(self.path, "angle", self.angle, self.speed, self.law)
        return (Prescribed(self.name, law, self.path),)


@component
class SliderDrive(Component):
    """Moves a slider along its axis: s = position + speed·t, or by another law of time.

    Parameters
    ----------
    name
        The slider that is driven against the body that carries its axis.
    position
        Displacement at t = 0 in metres.
    speed
        In m/s.
    law
        Displacement as a function of time, in the place of position and speed.
    """

    section: ClassVar[str] = "drives"
    told_by: ClassVar[str] = "position"
    names_slider: ClassVar[bool] = True

    name: Name
    position: Length | None = None
    speed: Speed | None = None
    law: LengthLaw | None = None

    @model_validator(mode="after")
    def _one_law(self) -> Any:
        _check("position", self.position, self.speed, self.law)
        return self

    def references(self) -> References:
        """The driven slider."""
        return References(bodies=((self.path, self.name, ("slider",)),))

    def terms(self) -> tuple[Prescribed, ...]:
        """One prescribed coordinate."""
        law = _function(self.path, "position", self.position, self.speed, self.law)
        return (Prescribed(self.name, law, self.path),)


def _check(key: str, start: float | None, speed: float | None, law: Law | None) -> None:
    given = [k for k, v in ((key, start), ("speed", speed)) if v is not None]
    forms = f"either {key!r} and 'speed', or 'law'"
    if law is not None and given:
        raise ValueError(f"'law' and {given[0]!r} are both given; expected {forms}")
    if law is None and not given:
        raise ValueError(f"missing keys: expected {forms}")
    if law is None and len(given) == 1:
        missing = "speed" if given == [key] else key
        raise ValueError(f"missing key {missing!r}: expected {forms}")


def _function(
    path: Path, key: str, start: float | None, speed: float | None, law: Law | None
) -> Function:
    if law is not None:
        return function_of(law, (*path, "law"))
    # A drive that happens to start at 0 or to stand still needs no kernel of its own.
    return linear(Parameter((*path, key), start or 0.0), Parameter((*path, "speed"), speed or 0.0))
